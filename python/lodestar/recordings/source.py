# SPDX-License-Identifier: Apache-2.0
"""Columns of numbers by name, from CSV and npz files."""

from __future__ import annotations

import csv
import zipfile
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lodestar.errors import InputError

Values = NDArray[np.float64]
Columns = Callable[[str], Values]


def open_source(path: Path) -> tuple[Columns, int]:
    """A function that returns a column of a file by its name, and the number of rows.

    A missing cell of a CSV is NaN. Raises InputError for a file that is missing or damaged; the
    function does so for a column that is missing or does not hold numbers.
    """
    try:
        return _open_npz(path) if path.suffix == ".npz" else _open_csv(path)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}") from None
    except (zipfile.BadZipFile, UnicodeDecodeError, csv.Error, EOFError) as error:
        raise InputError(f"{path}: damaged or foreign file ({error})") from None


def _open_npz(path: Path) -> tuple[Columns, int]:
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
    return column, rows


def _open_csv(path: Path) -> tuple[Columns, int]:
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

    return column, len(lines) - 1


def _is_number(cell: str) -> bool:
    try:
        float(cell or "nan")
    except ValueError:
        return False
    return True


def _no_column(path: Path, name: str, known: Iterable[str]) -> InputError:
    return InputError(f"{path}: no column {name!r}; it has {', '.join(sorted(known))}")
