# SPDX-License-Identifier: Apache-2.0
"""TOML files with a fixed set of keys, each declared once, beside the member it fills.

A table is a frozen dataclass whose fields are made by option(): type, default, range, choices and
meaning stand in one place. check() finds everything that is wrong with a file and says so with
file, line and key; build() makes the dataclass. Members may be float, int, bool, str, another such
table, a tuple of such tables (``[[name]]``), or dict (left to whoever uses it).
"""

from __future__ import annotations

import dataclasses
import math
import re
import tomllib
import typing
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from lodestar.errors import InputError

T = TypeVar("T")
KeyPath = tuple[str | int, ...]

_NAMES = {float: "a number", int: "a whole number", bool: "true or false", str: "a text"}


def option(
    default: Any = dataclasses.MISSING,
    *,
    factory: Any = dataclasses.MISSING,
    doc: str,
    low: float = -math.inf,
    high: float = math.inf,
    choices: Sequence[str] = (),
) -> Any:
    """A dataclass field that is a key of a TOML table.

    Without ``default`` or ``factory`` the key must be given.
    """
    metadata = {"doc": doc, "low": low, "high": high, "choices": tuple(choices)}
    return dataclasses.field(default=default, default_factory=factory, metadata=metadata)


@dataclass(frozen=True)
class Document:
    """A TOML file as read: its values, and the line on which each key stands."""

    source: str
    values: dict[str, Any]
    lines: dict[KeyPath, int]

    def error(self, key: KeyPath, message: str) -> InputError:
        """An error about ``key``, naming file and line."""
        known = key
        while known and known not in self.lines:
            known = known[:-1]
        line = f":{self.lines[known]}" if known else ""
        name = ".".join(str(part) for part in key if isinstance(part, str))
        return InputError(f"{self.source}{line}: {name}: {message}")


def read(path: Path) -> Document:
    """Read a file. Raises InputError where it cannot be read or is not TOML."""
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read ({error})") from error
    return parse(text, str(path))


def parse(text: str, source: str) -> Document:
    """Read a text; ``source`` is what errors call it. Raises InputError where it is not TOML."""
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        line = re.search(r"at line (\d+)", str(error))
        number = line[1] if line else len(text.splitlines())
        raise InputError(f"{source}:{number}: not TOML: {error}") from None
    return Document(source, values, _key_lines(text))


def check(document: Document, table: type[Any]) -> None:
    """Raise InputError for the first unknown key, wrong type or value that is not allowed."""
    _check_table(document, (), document.values, table)


def build(values: Mapping[str, Any], table: type[T]) -> T:
    """Make the dataclass ``table`` of values that have passed check()."""
    types = typing.get_type_hints(table)
    arguments: dict[str, Any] = {}
    for key, value in values.items():
        inner = _item_table(types[key])
        if inner is not None and isinstance(value, list):
            arguments[key] = tuple(build(item, inner) for item in value)
        elif inner is not None:
            arguments[key] = build(value, inner)
        else:
            arguments[key] = float(value) if types[key] is float else value
    return table(**arguments)


def required_keys(table: type[Any]) -> list[str]:
    """Keys of a table that have no default."""
    return [
        field.name
        for field in dataclasses.fields(table)
        if field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
    ]


def _item_table(kind: Any) -> type[Any] | None:
    """The dataclass that a member of type ``kind`` holds, alone or in a tuple."""
    if typing.get_origin(kind) is tuple:
        kind = typing.get_args(kind)[0]
    return kind if dataclasses.is_dataclass(kind) and isinstance(kind, type) else None


def _check_table(document: Document, at: KeyPath, values: Any, table: type[Any]) -> None:
    if not isinstance(values, dict):
        raise document.error(at, "must be a table")
    types = typing.get_type_hints(table)
    fields = {field.name: field for field in dataclasses.fields(table)}
    for key, value in values.items():
        if key not in fields:
            raise document.error((*at, key), f"unknown key; allowed are {', '.join(fields)}")
        _check_value(document, (*at, key), value, types[key], fields[key].metadata)


def _check_value(
    document: Document, at: KeyPath, value: Any, kind: Any, rules: Mapping[str, Any]
) -> None:
    inner = _item_table(kind)
    if inner is not None and typing.get_origin(kind) is tuple:
        if not isinstance(value, list):
            raise document.error(at, f"must be a list of tables, [[{at[-1]}]]")
        for number, item in enumerate(value):
            _check_table(document, (*at, number), item, inner)
            missing = [key for key in required_keys(inner) if key not in item]
            if missing:
                raise document.error((*at, number), f"{', '.join(missing)} missing")
    elif inner is not None:
        _check_table(document, at, value, inner)
    elif kind is dict or typing.get_origin(kind) is dict:
        if not isinstance(value, dict):
            raise document.error(at, "must be a table")
    else:
        _check_scalar(document, at, value, kind, rules)


def _check_scalar(
    document: Document, at: KeyPath, value: Any, kind: Any, rules: Mapping[str, Any]
) -> None:
    accepted = (int, float) if kind is float else (kind,)
    # A truth value counts as an int in Python; here it does not.
    if not isinstance(value, accepted) or (isinstance(value, bool) and kind is not bool):
        raise document.error(at, f"{value!r} is not {_NAMES[kind]}")
    if rules["choices"] and value not in rules["choices"]:
        raise document.error(at, f"{value!r}; allowed are {', '.join(rules['choices'])}")
    if kind in (int, float) and not rules["low"] <= value <= rules["high"]:
        allowed = f"{rules['low']:g} to {rules['high']:g}"
        raise document.error(at, f"{value:g} is out of range; allowed is {allowed}")


_TEXT_OR_COMMENT = re.compile(r"\"[^\"]*\"|'[^']*'|#.*")
_HEADER = re.compile(r"\s*(\[\[?)([^\[\]]+)\]\]?\s*(#.*)?$")
_KEY = re.compile(r"\s*((?:[A-Za-z0-9_-]+|\"[^\"]*\"|'[^']*')(?:\s*\.\s*[A-Za-z0-9_-]+)*)\s*=")


def _key_lines(text: str) -> dict[KeyPath, int]:
    """The line of each key and table header. Keys inside inline tables have that of the table."""
    lines: dict[KeyPath, int] = {}
    table: KeyPath = ()
    counts: dict[KeyPath, int] = {}
    open_brackets = 0
    for number, line in enumerate(text.splitlines(), start=1):
        header = None if open_brackets else _HEADER.match(line)
        if header:
            table = _parts(header[2])
            if header[1] == "[[":
                counts[table] = counts.get(table, -1) + 1
                lines.setdefault(table, number)
                table = (*table, counts[table])
            lines.setdefault(table, number)
            continue
        key = None if open_brackets else _KEY.match(line)
        if key:
            lines.setdefault((*table, *_parts(key[1])), number)
        bare = _TEXT_OR_COMMENT.sub("", line)
        open_brackets += sum(bare.count(c) for c in "[{") - sum(bare.count(c) for c in "]}")
    return lines


def _parts(dotted: str) -> KeyPath:
    return tuple(part.strip().strip("\"'") for part in dotted.split("."))
