# SPDX-License-Identifier: Apache-2.0
"""The results of a campaign on disk: Parquet files, each of one flight and whole.

The folder ``flights`` is one data set to every reader of Parquet: a row for each cell and
seed, a column for each figure, and lists of float32 for the series in time.
"""

from __future__ import annotations

import fcntl
import os
import zlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from lodestar.errors import InputError
from lodestar.studies.campaign import Cell, Result

_KEYS = ("flight", "case", "estimator", "seed", "origin")


class ParquetStore:
    """See campaign.Store."""

    def __init__(self, folder: Path) -> None:
        """A store in a folder, which is made. Raises InputError where it cannot be."""
        self.folder = folder / "flights"
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise InputError(f"{self.folder}: {error.strerror}") from None
        self._known: dict[Cell, dict[int, str]] | None = None

    @contextmanager
    def writing(self) -> Iterator[ParquetStore]:
        """Keep other campaigns out. Raises InputError where there is one."""
        with (self.folder / ".lock").open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                raise InputError(f"{self.folder}: another campaign is writing there") from None
            for torn in self.folder.glob(".*.part"):
                torn.unlink()
            yield self

    def seeds(self, cell: Cell, origin: str) -> set[int]:
        """See campaign.Store. Raises InputError for results of another origin."""
        if self._known is None:
            self._known = self._read_keys()
        flown = self._known.get(cell, {})
        if any(other != origin for other in flown.values()):
            raise InputError(
                f"{self.folder}: {cell.case} was flown with another build or scenario; give "
                f"another folder with --out, or --redraw to see what is there"
            )
        return set(flown)

    def add(self, results: Sequence[Result], origin: str) -> None:
        """See campaign.Store."""
        first = results[0]
        which = zlib.crc32(repr([result.cell for result in results]).encode())
        name = f"{first.cell.flight.replace('/', '-')}-{first.seed:06d}-{which:08x}.parquet"
        temporary = self.folder / f".{name}.part"
        # Not straight to the file: a writer that Ctrl-C interrupts closes it late, and complains.
        packed = pa.BufferOutputStream()
        pq.write_table(_table(results, origin), packed, compression="zstd")
        try:
            with temporary.open("wb") as file:
                file.write(packed.getvalue())
                file.flush()
                os.fsync(file.fileno())
            temporary.replace(self.folder / name)
        except OSError as error:
            raise InputError(f"{temporary}: {error.strerror}") from None

    def results(self, cells: Sequence[Cell], seeds: range) -> list[Result]:
        """What there is of these cells and seeds, in their order."""
        found: dict[tuple[Cell, int], Result] = {}
        wanted = set(cells)
        for table in self._tables(None):
            for number, key in enumerate(table.select(_KEYS).to_pylist()):
                cell = Cell(key["flight"], key["case"], key["estimator"])
                if cell in wanted and key["seed"] in seeds:
                    found[cell, key["seed"]] = _result(cell, table, number)
        return [found[cell, seed] for cell in cells for seed in seeds if (cell, seed) in found]

    def _read_keys(self) -> dict[Cell, dict[int, str]]:
        known: dict[Cell, dict[int, str]] = {}
        for table in self._tables(list(_KEYS)):
            for row in table.to_pylist():
                cell = Cell(row["flight"], row["case"], row["estimator"])
                known.setdefault(cell, {})[row["seed"]] = row["origin"]
        return known

    def _tables(self, columns: list[str] | None) -> Iterator[Any]:
        for path in sorted(self.folder.glob("*.parquet")):
            try:
                yield pq.read_table(path, columns=columns)
            except (pa.ArrowException, OSError) as error:
                reason = str(error).splitlines()[0]
                raise InputError(f"{path}: {reason}; delete it to fly it again") from None


def _table(results: Sequence[Result], origin: str) -> Any:
    keys = [(r.cell.flight, r.cell.case, r.cell.estimator, r.seed, origin) for r in results]
    columns: dict[str, Any] = {
        name: pa.array(values) for name, values in zip(_KEYS, zip(*keys, strict=True), strict=True)
    }
    for name in results[0].figures:
        columns[name] = pa.array([r.figures[name] for r in results], pa.float64())
    for name in results[0].series:
        columns[name] = pa.array([r.series[name] for r in results], pa.list_(pa.float32()))
    return pa.table(columns)


def _result(cell: Cell, table: Any, row: int) -> Result:
    figures, series = {}, {}
    for name in table.column_names:
        if name in _KEYS:
            continue
        value = table[name][row]
        if pa.types.is_list(value.type):
            series[name] = value.values.to_numpy()
        else:
            figures[name] = value.as_py()
    return Result(cell, table["seed"][row].as_py(), figures, series)
