# SPDX-License-Identifier: Apache-2.0
"""Columns of numbers by name, from CSV, npz and ULog files."""

from __future__ import annotations

import csv
import zipfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lodestar.errors import InputError
from lodestar.recordings import ulog

Values = NDArray[np.float64]

_MOST_NAMES = 30


class NoColumn(InputError):  # noqa: N818 - it names the thing, as InputError does
    """The source has no such column."""


@dataclass(frozen=True)
class Source:
    """Columns by name. Those of one clock are as long as it."""

    read: Callable[[str], Values]
    """A column as numbers. Raises InputError for one that is missing or holds anything else."""
    clock_of: Callable[[str], str | None] = lambda name: None
    """Name of the column that times another; None in a table, where one clock times all."""

    def at(self, name: str, clock: str) -> Values:
        """A column on another clock: its latest value holds; NaN before its first."""
        values, own = self.read(name), self.clock_of(name)
        if own is None or own == clock:
            return values
        row = np.searchsorted(self.read(own), self.read(clock), side="right") - 1
        return np.where(row >= 0, values[np.maximum(row, 0)], np.nan)


def open_source(path: Path) -> Source:
    """Open a file; what ends in neither .npz nor .ulg is read as CSV with a header line.

    A missing cell of a CSV is NaN. Raises InputError for a file that is missing or damaged.
    """
    openers = {".npz": _open_npz, ".ulg": _open_ulog}
    try:
        return openers.get(path.suffix, _open_csv)(path)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}") from None
    except (zipfile.BadZipFile, UnicodeDecodeError, csv.Error, EOFError) as error:
        raise InputError(f"{path}: damaged or foreign file ({error})") from None


def _open_npz(path: Path) -> Source:
    try:
        with np.load(path, allow_pickle=False) as archive:
            arrays = {key: archive[key] for key in archive.files}
    except ValueError as error:
        raise InputError(f"{path}: not an npz file of numbers ({error})") from None

    def column(name: str) -> Values:
        array = arrays.get(name)
        if array is None:
            raise _no_column(path, name, arrays)
        if array.shape != (rows,) or array.dtype.kind not in "fiub":
            raise InputError(f"{path}: {name} has shape {array.shape}, must be ({rows},) numbers")
        values: Values = array.astype(np.float64)
        return values

    rows = max((len(array) for array in arrays.values() if array.ndim), default=0)
    return Source(column)


def _open_csv(path: Path) -> Source:
    with path.open(newline="", encoding="utf-8-sig") as file:
        lines = list(csv.reader(file))
    if not lines:
        raise InputError(f"{path}: empty, must have a header line")
    header = [name.strip() for name in lines[0]]
    for number, line in enumerate(lines[1:], start=2):
        if len(line) != len(header):
            raise InputError(f"{path}: line {number} has {len(line)} cells, header {len(header)}")

    def column(name: str) -> Values:
        if name not in header:
            raise _no_column(path, name, header)
        cells = [line[header.index(name)].strip() for line in lines[1:]]
        try:
            return np.array([float(cell) if cell else np.nan for cell in cells])
        except ValueError:
            number = next(i for i, cell in enumerate(cells, start=2) if not _is_number(cell))
            bad = cells[number - 2]
            raise InputError(f"{path}: line {number}: {name} is {bad!r}, not a number") from None

    return Source(column)


def _open_ulog(path: Path) -> Source:
    columns = ulog.read_topics(path)

    def column(name: str) -> Values:
        if name not in columns:
            raise _no_column(path, name, columns)
        return columns[name]

    return Source(column, ulog.clock_of)


def _no_column(path: Path, name: str, known: Iterable[str]) -> NoColumn:
    names = sorted(known)
    told = f"it has {', '.join(names)}"
    if len(names) > _MOST_NAMES:
        alike = get_close_matches(name, names, n=5, cutoff=0.0)
        told = f"the most alike of its {len(names)} are {', '.join(alike)}"
    return NoColumn(f"{path}: no column {name!r}; {told}")


def _is_number(cell: str) -> bool:
    try:
        float(cell or "nan")
    except ValueError:
        return False
    return True
