# SPDX-License-Identifier: Apache-2.0
"""The TOML map of an import: which source column becomes which field, and how.

::

    [time]
    column = "t"              # of every row
    unit = "ms"               # s (default), ms, us, ns
    start_s = 10.0            # keep rows from here ...
    end_s = 900.0             # ... to here (seconds of the source's clock)

    [channels."EFCS.LOAD_FACTOR"]
    every = 2                 # keep every second row
    n_B = { columns = ["ax", "ay", "az"], unit = "m/s^2", axes = "FLU", scale = -1.0 }
    valid = { constant = true }

    [channels.GPS]
    clock = "gps.timestamp"   # instead of the column of [time], in its unit; a ULog has many
    optional = true           # left out, and said, where the source lacks one of its columns
    new = "gps_flag"          # keep rows where this column is not zero
    require = { column = "sats", min = 4 }
    latency_s = 0.2           # time of validity = time of the row - latency
    lat = { column = "lat", unit = "deg" }

A field's value is ``scale * (source in SI units) + offset``, after its axes were brought to body
axes (forward, right, down) or north, east, down.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf, prod
from pathlib import Path
from typing import Any

from lodestar import channels as table
from lodestar import strict_toml
from lodestar.errors import InputError
from lodestar.recordings.units import TIME, quantity
from lodestar.strict_toml import Document

AXES: dict[str, tuple[str, str, str]] = {
    "FRD": ("x", "y", "z"),
    "FLU": ("x", "-y", "-z"),
    "RFU": ("y", "x", "-z"),
    "NED": ("x", "y", "z"),
    "ENU": ("y", "x", "-z"),
}
"""Named conventions as the signed source axes of our x, y, z."""

MAPPED = (*table.INPUTS, "TRUTH")
_CHANNEL_KEYS = ("clock", "optional", "every", "new", "require", "latency_s")


@dataclass(frozen=True)
class Require:
    """A row counts where ``low <= column <= high``."""

    column: str
    low: float
    high: float


@dataclass(frozen=True)
class FieldMap:
    """Where a field comes from: columns, a constant, a condition or a window of time."""

    columns: tuple[str, ...] = ()
    constant: Any = None
    condition: Require | None = None
    during_s: tuple[float, float] | None = None
    unit: str = "1"
    scale: float = 1.0
    offset: float = 0.0
    axes: tuple[tuple[int, float], ...] = ()  # source axis and sign of each of our axes
    flank: bool = False


@dataclass(frozen=True)
class ChannelMap:
    """How the messages of one channel come from the rows of the source."""

    clock: str
    fields: dict[str, FieldMap]
    optional: bool = False
    every: int = 1
    new: str | None = None
    require: Require | None = None
    latency_s: float = 0.0


@dataclass(frozen=True)
class Map:
    """A whole map file."""

    time_unit: str
    start_s: float
    end_s: float
    channels: dict[str, ChannelMap]


class _Table:
    """A table of the map, which complains about its keys with file and line."""

    def __init__(self, document: Document, at: tuple[str, ...], values: Any):
        self.document, self.at = document, at
        if not isinstance(values, dict):
            raise self.error(f"is {values!r}, must be a table")
        self.values: dict[str, Any] = dict(values)

    def error(self, what: str) -> InputError:
        return self.document.error(self.at, what)

    def only(self, allowed: tuple[str, ...]) -> None:
        for key in self.values:
            if key not in allowed:
                message = f"unknown key; allowed are {', '.join(allowed)}"
                raise self.document.error((*self.at, key), message)

    def take(self, key: str, kind: type | tuple[type, ...], default: Any = None) -> Any:
        value = self.values.get(key, default)
        if value is default:
            return default
        if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
            kinds = kind if isinstance(kind, tuple) else (kind,)
            names = " or ".join(one.__name__ for one in kinds)
            raise self.error(f"has {key} = {value!r}, must be {names}")
        return value

    def number(self, key: str, default: float) -> float:
        return float(self.take(key, (int, float), default))

    def choice(self, key: str, allowed: Mapping[str, Any], default: str) -> str:
        value = self.take(key, str, default)
        if value not in allowed:
            raise self.error(f"has {key} = {value!r}; allowed are {', '.join(allowed)}")
        return str(value)

    def table(self, key: str) -> _Table:
        return _Table(self.document, (*self.at, key), self.values[key])


def read_map(path: Path) -> Map:
    """Read and check a map file.

    Raises InputError with the file, the line, the key and what is allowed.
    """
    document = strict_toml.read(path)
    root = _Table(document, (), document.values)
    root.only(("time", "channels"))
    for key in ("time", "channels"):
        if key not in root.values:
            raise InputError(f"{path}: lacks the table [{key}]")
    time = root.table("time")
    time.only(("column", "unit", "start_s", "end_s"))
    column = time.take("column", str)
    channels = root.table("channels")
    channels.only(MAPPED)
    if not channels.values:
        raise channels.error("names no channel")
    return Map(
        time_unit=time.choice("unit", TIME, "s"),
        start_s=time.number("start_s", -inf),
        end_s=time.number("end_s", inf),
        channels={name: _channel(name, channels.table(name), column) for name in channels.values},
    )


def _channel(channel: str, source: _Table, default_clock: str | None) -> ChannelMap:
    shapes = {item.name: item.shape for item in table.fields(channel) if item.name != "time_us"}
    source.only((*_CHANNEL_KEYS, *shapes))
    every = source.take("every", int, 1)
    if every < 1:
        raise source.error(f"has every = {every}, must be at least 1")
    clock = source.take("clock", str, default_clock)
    if clock is None:
        raise source.error("lacks clock, and [time] lacks column")
    fields = {}
    for name, shape in shapes.items():
        if name not in source.values:
            raise source.error(f"lacks field {name}")
        fields[name] = _field(name, prod(shape), source.table(name))
    return ChannelMap(
        clock=clock,
        fields=fields,
        optional=source.take("optional", bool, False),
        every=every,
        new=source.take("new", str),
        require=_require(source.table("require")) if "require" in source.values else None,
        latency_s=source.number("latency_s", 0.0),
    )


def _require(source: _Table) -> Require:
    source.only(("column", "min", "max"))
    column = source.take("column", str)
    if column is None:
        raise source.error("lacks column")
    return Require(column, source.number("min", -inf), source.number("max", inf))


def _field(name: str, size: int, source: _Table) -> FieldMap:
    kinds = [key for key in ("column", "columns", "constant", "during_s") if key in source.values]
    if len(kinds) != 1:
        raise source.error("must have one of column, columns, constant, during_s")
    if "constant" in kinds:
        source.only(("constant",))
        return FieldMap(constant=source.values["constant"])
    if "during_s" in kinds:
        source.only(("during_s",))
        window = source.take("during_s", list)
        if len(window) != 2 or not all(isinstance(one, int | float) for one in window):
            raise source.error(f"has during_s = {window}, must be [start, end]")
        return FieldMap(during_s=(float(window[0]), float(window[1])))
    if "min" in source.values or "max" in source.values:
        return FieldMap(condition=_require(source))
    source.only(("column", "columns", "unit", "scale", "offset", "axes", "convention"))
    columns = [source.take("column", str)] if "column" in kinds else source.take("columns", list)
    if len(columns) != size or not all(isinstance(one, str) for one in columns):
        raise source.error(f"names {len(columns)} columns, must name {size}")
    units = quantity(name).units
    convention = source.choice("convention", {"sideslip": 0, "flank": 0}, "sideslip")
    if convention == "flank" and name != "beta":
        raise source.error("has convention = 'flank', which only beta can have")
    return FieldMap(
        columns=tuple(columns),
        unit=source.choice("unit", units, next(iter(units))),
        scale=source.number("scale", 1.0),
        offset=source.number("offset", 0.0),
        axes=_axes(source) if "axes" in source.values else (),
        flank=convention == "flank",
    )


def _axes(source: _Table) -> tuple[tuple[int, float], ...]:
    given = source.values["axes"]
    signed = AXES.get(given, ()) if isinstance(given, str) else given
    bare = [str(one).lstrip("-") for one in signed] if isinstance(signed, list | tuple) else []
    if sorted(bare) != ["x", "y", "z"]:
        raise source.error(
            f"has axes = {given!r}; allowed are {', '.join(AXES)} or a list like ['x', '-y', '-z']"
        )
    return tuple(
        ("xyz".index(axis), -1.0 if str(one).startswith("-") else 1.0)
        for axis, one in zip(bare, signed, strict=True)
    )
