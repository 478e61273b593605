# SPDX-License-Identifier: Apache-2.0
"""Monte Carlo campaigns: the cells of a study, each flown with the same seeds, into a store.

A cell is one variant of a study; cells of one ``flight`` share its simulation. What a cell gives
for a seed depends on the study and the seed alone: not on which process flies it, nor when, nor
what flew before. So a campaign that was stopped goes on where it was, and ends with the same bits.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

import lodestar
from lodestar import _core
from lodestar.errors import InputError

Progress = Callable[[int, int], None]
"""Told how many flights are done, of how many."""

_MAKES_FLIGHTS = (
    "simulation/*.py",
    "harness/scenario.py",
    "harness/faults.py",
    "evaluation/comparison.py",
    "evaluation/metrics.py",
    "studies/campaign.py",
    "studies/fault_window.py",
)


@dataclass(frozen=True)
class Cell:
    """One variant: what is simulated, what a report calls it, what estimates."""

    flight: str
    case: str
    estimator: str
    most_runs: int | None = field(default=None, compare=False, repr=False)
    """It is flown with no more than so many seeds, the first of those that are asked for."""

    def wants(self, number: int) -> bool:
        """Whether it is flown with the seed of this number, the first being 0."""
        return self.most_runs is None or number < self.most_runs


@dataclass(frozen=True)
class Result:
    """What one cell gave for one seed: numbers, and series in time."""

    cell: Cell
    seed: int
    figures: dict[str, float]
    """The same names for all cells of a study; NaN where a cell has no such figure."""
    series: dict[str, NDArray[np.float32]]


class Study(Protocol):
    """What is flown. Travels to other processes, so it can be pickled."""

    @property
    def name(self) -> str:
        """As on the command line."""
        ...

    @property
    def cells(self) -> Sequence[Cell]:
        """All variants, those of one flight together."""
        ...

    def fly(self, cells: Sequence[Cell], seed: int) -> list[Result]:
        """Simulate a flight once and run it through its cells. Raises InputError if it cannot."""
        ...

    def inputs(self, flight: str) -> str:
        """Everything a person may change that the results of a flight depend on.

        Raises InputError where a flight cannot be made at all.
        """
        ...


@dataclass(frozen=True)
class Task:
    """One flight of a study, with the cells that are still to be run through."""

    study: Study
    cells: tuple[Cell, ...]
    seed: int


class Store(Protocol):
    """Where results are kept."""

    def seeds(self, cell: Cell, origin: str) -> set[int]:
        """The seeds that the cell has been flown with."""
        ...

    def add(self, results: Sequence[Result], origin: str) -> None:
        """Keep the results of one flight: all of them or, when stopped, none."""
        ...


class Pool(Protocol):
    """Something that works on many tasks at once."""

    def work(
        self, function: Callable[[Task], list[Result]], tasks: Sequence[Task]
    ) -> Iterator[list[Result]]:
        """The results, in any order. Raises what the function raises."""
        ...


def run(
    study: Study,
    seeds: range,
    store: Store,
    pool: Pool,
    progress: Progress = lambda done, total: None,
) -> None:
    """Fly what the store does not have yet.

    Raises InputError for a flight that cannot be simulated, and where the store holds results of
    this study that were made from something else.
    """
    origins = {flight: origin(study, flight) for flight in _flights(study)}
    missing = _tasks(study, seeds, store, origins)
    total = len(origins) * len(seeds)
    done = total - len(missing)
    progress(done, total)
    for results in pool.work(_fly, missing):
        store.add(results, origins[results[0].cell.flight])
        done += 1
        progress(done, total)


def origin(study: Study, flight: str) -> str:
    """A hash of all that the results of a flight depend on: program, scenario, configuration."""
    return _hash(study.name, study.inputs(flight), _program(sys.modules[type(study).__module__]))


def _flights(study: Study) -> list[str]:
    return list(dict.fromkeys(cell.flight for cell in study.cells))


def _tasks(study: Study, seeds: range, store: Store, origins: dict[str, str]) -> list[Task]:
    """What is to be flown, one flight after the other: its truth is kept from seed to seed."""
    tasks = []
    for flight, made_from in origins.items():
        cells = [cell for cell in study.cells if cell.flight == flight]
        flown = {cell: store.seeds(cell, made_from) for cell in cells}
        for number, seed in enumerate(seeds):
            missing = tuple(c for c in cells if c.wants(number) and seed not in flown[c])
            if missing:
                tasks.append(Task(study, missing, seed))
    return tasks


def _fly(task: Task) -> list[Result]:
    try:
        return task.study.fly(task.cells, task.seed)
    except InputError as error:
        raise InputError(f"{task.cells[0].flight}, seed {task.seed}: {error}") from None


@lru_cache(maxsize=8)
def _program(study_module: object) -> str:
    """A hash of the estimators as they were built, and of the code that makes and scores flights.

    Tables and plots are no part of it: they are drawn from the results.
    """
    package = Path(str(lodestar.__file__)).parent
    files = [Path(str(_core.__file__)), Path(str(getattr(study_module, "__file__", "")))]
    for pattern in _MAKES_FLIGHTS:
        files += sorted(package.glob(pattern))
    return _hash(*(hashlib.sha256(file.read_bytes()).hexdigest() for file in files))


def _hash(*parts: str) -> str:
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:16]
