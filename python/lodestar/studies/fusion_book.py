# SPDX-License-Identifier: Apache-2.0
"""The results of the study of navigation by name, and what they are judged by."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lodestar.evaluation.fusion_requirements import PEER_SCENARIO, Goals, goals
from lodestar.studies.ensemble import Ensemble, nees_bounds
from lodestar.studies.fusion_setups import FILTERS, LIMIT

Array = NDArray[np.float64]

NEES = {"nees_heading": 1, "nees_wind": 2}
"""Each with its degrees of freedom."""
HEADING = "heading_rmse_deg"


@dataclass(frozen=True)
class Book:
    """All ensembles of the study, by case and estimator."""

    ensembles: Sequence[Ensemble]

    @cached_property
    def _by_name(self) -> dict[tuple[str, str], Ensemble]:
        return {(one.cell.case, one.cell.estimator): one for one in self.ensembles}

    @cached_property
    def cases(self) -> list[str]:
        """Scenario/engine/start, in the order of the study."""
        return list(dict.fromkeys(one.cell.case for one in self.ensembles))

    def of(self, case: str, estimator: str) -> Ensemble | None:
        """The flights of a case and estimator; None where there are none."""
        return self._by_name.get((case, estimator))

    def filters(self) -> Iterator[Ensemble]:
        """Those of the filters as they are shipped."""
        return (one for one in self.ensembles if one.cell.estimator in FILTERS)

    def limit(self, case: str) -> float | None:
        """The sigma of heading, deg, of the filter that knows the error model; rms of all flights.

        None where it was not flown.
        """
        known = self.of(case, LIMIT.name)
        return None if known is None else rms(known.figure("sigma_heading_rms_deg"))

    def over_limit(self, ensemble: Ensemble) -> float | None:
        """Rms error of heading over all flights, over the limit; None without a limit."""
        limit = self.limit(ensemble.cell.case)
        return None if limit is None else rms(ensemble.figure(HEADING)) / limit


def scenario_of(case: str) -> str:
    """The scenario's name in scenario/engine/start."""
    return case.rsplit("/", 2)[0]


def goals_of(ensemble: Ensemble) -> Goals:
    """The goals of a cell; empty where there are none."""
    case = ensemble.cell.case
    return goals(scenario_of(case), case.rsplit("/", 1)[1], ensemble.cell.estimator)


def is_judged(ensemble: Ensemble) -> bool:
    """Whether the cell has something to reach: then its sigma has to be the truth, too."""
    scenario, estimator = scenario_of(ensemble.cell.case), ensemble.cell.estimator
    return bool(goals_of(ensemble)) or (scenario == PEER_SCENARIO and estimator == "integrated")


def has(ensemble: Ensemble, metric: str) -> bool:
    """Whether any flight has the figure."""
    return bool(np.isfinite(ensemble.figure(metric)).any())


def grade(value: float, must: float, stretch: float) -> str:
    """``stretch``, ``must`` or ``missed``; a value that does not exist is missed."""
    if value <= stretch:
        return "stretch"
    return "must" if value <= must else "missed"


def is_consistent(ensemble: Ensemble, metric: str) -> bool:
    """Whether the mean NEES is within its bounds."""
    low, high = nees_bounds(ensemble.runs, NEES[metric])
    return bool(low <= np.mean(ensemble.figure(metric)) <= high)


def peer_value(metric: str, values: Array) -> float:
    """The figure over all flights as the peer's is given: median of positions, mean of rms."""
    return float(np.median(values) if metric.endswith("s_m") else np.mean(values))


def rms(values: Array) -> float:
    """Root of the mean square; NaN if any value is."""
    return float(np.sqrt(np.mean(values**2)))
