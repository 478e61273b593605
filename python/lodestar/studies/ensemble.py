# SPDX-License-Identifier: Apache-2.0
"""The flights of one cell, and what they say together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from lodestar.studies.campaign import Cell, Result

Array = NDArray[np.float64]
CONFIDENCE = 0.95


@dataclass(frozen=True)
class Ensemble:
    """The results of one cell in the order of their seeds."""

    cell: Cell
    results: tuple[Result, ...]

    @property
    def runs(self) -> int:
        """How many flights there are."""
        return len(self.results)

    def figure(self, name: str) -> Array:
        """One figure of every flight, (runs,)."""
        return np.array([result.figures[name] for result in self.results])

    def series(self, name: str) -> Array:
        """One series of every flight, (runs, samples)."""
        return np.array([result.series[name] for result in self.results], np.float64)


def grouped(results: Sequence[Result]) -> list[Ensemble]:
    """The results by cell, in the order in which the cells first occur."""
    cells: dict[Cell, list[Result]] = {}
    for result in results:
        cells.setdefault(result.cell, []).append(result)
    return [Ensemble(cell, tuple(members)) for cell, members in cells.items()]


def mean_interval(values: Array) -> tuple[float, float, float]:
    """Mean, and the interval that holds the true mean with 95 % (Student's t); NaN for one value.

    NaN if any value is: a flight without a figure is not left out.
    """
    mean = float(np.mean(values))
    if len(values) < 2:
        return mean, float("nan"), float("nan")
    half = float(stats.t.ppf(0.5 + CONFIDENCE / 2, len(values) - 1) * stats.sem(values))
    return mean, mean - half, mean + half


def with_half(values: Array, style: str = ".2f") -> str:
    """The mean and half its 95 % interval, as a person reads them."""
    mean, low, _ = mean_interval(values)
    told = format(mean, style)
    return told if np.isnan(low) else f"{told} ± {format(mean - low, style)}"


def nees_bounds(runs: int, size: int) -> tuple[float, float]:
    """Where the mean NEES of ``runs`` flights, divided by ``size``, lies with 95 %.

    A consistent estimator's NEES is chi-squared with ``size`` degrees of freedom at any one time.
    The bounds are those of one such time: a mean over time only narrows the spread.
    """
    degrees = runs * size
    low, high = (float(stats.chi2.ppf(0.5 + s * CONFIDENCE / 2, degrees)) for s in (-1, 1))
    return low / degrees, high / degrees
