# SPDX-License-Identifier: Apache-2.0
"""The study of fusion with bad fixes: GPS spoofed or broken for a while in a flight with turns.

Cases are ``ordinary/engine/fault``; the estimator is the filter. Case ``none`` is the same flight
without a fault. GPS is good again from the end of the fault on.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import nan, radians

import numpy as np
from numpy.typing import NDArray

from lodestar.channels import INPUTS
from lodestar.evaluation.comparison import compare_nav
from lodestar.evaluation.metrics import maximum
from lodestar.harness.faults import Fault, inject
from lodestar.harness.scenario import (
    ENGINES,
    Scenario,
    estimator_config,
    fly_truth,
    load_scenario,
    measure,
)
from lodestar.navigator import run
from lodestar.recordings.recording import Channel, Recording
from lodestar.simulation.earth import meridian_radius
from lodestar.studies.campaign import Cell, Result
from lodestar.studies.fault_window import Rows, Window, refused_messages
from lodestar.studies.fusion_setups import FILTERS, shipped
from lodestar.studies.sahrs import SERIES_S, chosen, describe

Array = NDArray[np.float64]

DURATION_S = 1500.0
START_S = 600.0
_NORTH_M = 1.0 / float(meridian_radius(radians(57.5)))  # rad of latitude, where the route begins


@dataclass(frozen=True)
class Case:
    """What is wrong with GPS, in words and as faults of its messages."""

    what: str
    faults: tuple[Fault, ...] = ()

    @property
    def window(self) -> Window:
        """While something is wrong; two minutes where nothing is."""
        return Window.of(self.faults) if self.faults else Window(START_S, START_S + 120.0)


def _gps(
    kind: str, length_s: float, *, start_s: float = START_S, field: str = "", value: float = 0.0
) -> Fault:
    return Fault(kind, "GPS", start_s, length_s, field=field, value=value)


def _jump(metres: float) -> Fault:
    return _gps("bias", 60.0, field="lat", value=metres * _NORTH_M)


SPOOFED = {
    "jump-200m": Case("fixes 200 m north of the truth for 60 s", (_jump(200.0),)),
    "jump-5km": Case("fixes 5 km north of the truth for 60 s", (_jump(5000.0),)),
    "drag-1": Case(
        "fixes dragged off towards east at 1 m/s for 300 s", (_gps("spoof", 300.0, value=1.0),)
    ),
    "drag-5": Case(
        "fixes dragged off towards east at 5 m/s for 300 s", (_gps("spoof", 300.0, value=5.0),)
    ),
    "drag-5-lost": Case(
        "the same, then no fix at all for 60 s",
        (
            _gps("spoof", 300.0, value=5.0),
            _gps("dropout", 60.0, start_s=START_S + 300.0),
        ),
    ),
}
BROKEN = {
    "time+2s": Case("time stamps 2 s ahead for 120 s", (_gps("time_jump", 120.0, value=2.0),)),
    "time-2s": Case("time stamps 2 s behind for 120 s", (_gps("time_jump", 120.0, value=-2.0),)),
    "time-0.5s": Case(
        "time stamps 0.5 s behind for 120 s", (_gps("time_jump", 120.0, value=-0.5),)
    ),
    "frozen": Case("the same fix again and again for 120 s", (_gps("freeze", 120.0),)),
    "scatter-50": Case(
        "white noise 50 times as strong for 120 s", (_gps("noise", 120.0, value=50.0),)
    ),
    "nan": Case("no numbers for 120 s", (_gps("nan", 120.0),)),
}
CASES: dict[str, Case] = {"none": Case("no fault"), **SPOOFED, **BROKEN}

ERRORS = {"position": "m", "velocity": "m_s", "wind": "m_s", "heading": "deg"}
"""What is judged, horizontal, and its unit."""

CHANNELS = ("GPS",)

_AIDING, _REACQUIRING = 1, 3  # NAV.mode
_PROTECTION_LEVEL = "horizontal_protection_level"


@dataclass(frozen=True)
class FusionFaultsStudy:
    """See campaign.Study."""

    scenario: Scenario
    engines: tuple[str, ...] = ("profile",)
    filters: tuple[str, ...] = FILTERS
    name: str = "fusion-faults"

    @cached_property
    def variants(self) -> dict[Cell, tuple[str, str, str]]:
        """Engine, case and filter of every cell."""
        return {
            Cell(flight, f"{flight}/{case}", filter_): (engine, case, filter_)
            for engine in self.engines
            for flight in [f"{self.scenario.name}/{engine}"]
            for case in CASES
            for filter_ in self.filters
        }

    @property
    def cells(self) -> Sequence[Cell]:
        """See campaign.Study."""
        return tuple(self.variants)

    def fly(self, cells: Sequence[Cell], seed: int) -> list[Result]:
        """See campaign.Study."""
        engine, _, _ = self.variants[cells[0]]
        sound = measure(self.scenario, fly_truth(self.scenario, seed, engine), seed)
        results = []
        for cell in cells:
            _, name, filter_ = self.variants[cell]
            case = CASES[name]
            sensed = inject(sound, case.faults, seed)
            config = estimator_config(self.scenario, sensed, shipped(filter_).tables())
            answered = run(sensed, config)
            flown = Flown.of(answered)
            figures = dict(flown.figures(case.window))
            figures |= refused_messages(answered, case.window, CHANNELS)
            results.append(Result(cell, seed, figures, dict(flown.series())))
        return results

    def inputs(self, flight: str) -> str:
        """See campaign.Study."""
        return describe(self.scenario, flight.split("/")[-1])


def fusion_faults_study(engines: Sequence[str], filters: Sequence[str]) -> FusionFaultsStudy:
    """The study with these engines (profile if none) and filters (all if none).

    Raises InputError for one that does not exist.
    """
    scenario = replace(load_scenario("ordinary"), duration_s=DURATION_S)
    return FusionFaultsStudy(
        scenario,
        chosen("engine", engines or ("profile",), ENGINES),
        chosen("filter", filters, FILTERS),
    )


@dataclass(frozen=True)
class Flown:
    """A flight that is answered, and how wrong NAV was; NaN where it is not valid."""

    nav: Channel
    gps: Channel
    health: Channel
    errors: dict[str, Array]
    """Magnitudes of ERRORS."""
    sigmas: Array
    """Horizontal position error over its published sigma, both axes together."""

    @classmethod
    def of(cls, answered: Recording) -> Flown:
        """Of a recording with NAV, GPS, HEALTH and TRUTH."""
        estimates = compare_nav(answered)
        position, wind, attitude = estimates.position, estimates.wind, estimates.attitude
        assert position is not None
        assert position.sigma is not None
        assert wind is not None
        assert attitude is not None
        errors = {
            "position": np.hypot(*position.error.T),
            "velocity": _velocity_error(answered),
            "wind": np.hypot(*wind.error.T),
            "heading": np.rad2deg(np.abs(attitude.error[:, 2])),
        }
        with np.errstate(divide="ignore", invalid="ignore"):
            sigmas = np.hypot(*(position.error / position.sigma).T)
        return cls(answered["NAV"], answered["GPS"], answered["HEALTH"], errors, sigmas)

    def figures(self, window: Window) -> Iterator[tuple[str, float]]:
        """All of the flight's figures but the reasons why messages were refused."""
        time_us = self.nav["time_us"]
        for name, rows in window.rows(time_us).items():
            for quantity, unit in ERRORS.items():
                worst = maximum(self.errors[quantity][rows])
                yield f"{name}_{quantity}_max_{unit}", worst
            yield f"{name}_position_max_sigmas", maximum(self.sigmas[rows])
            yield f"{name}_valid_share", float(np.mean(self.nav["valid"][rows]))
            yield f"{name}_not_aiding_share", float(np.mean(self.nav["mode"][rows] != _AIDING))
        yield "fixes_refused_share", self._refused(window)
        yield "detect_s", self._detected_after(window)
        yield "believe_s", self._believed_after(window)
        yield "beyond_hpl_share", self._beyond_hpl(time_us >= window.start_s * 1e6)
        count = self.nav["reset_count"]
        before = count[time_us < window.start_s * 1e6]
        yield "resets", float(count[-1] - (before[-1] if len(before) else 0))

    def series(self) -> Iterator[tuple[str, NDArray[np.float32]]]:
        """The errors every SERIES_S, with their times (s)."""
        seconds = self.nav["time_us"] * 1e-6
        kept = np.searchsorted(seconds, np.arange(seconds[0], seconds[-1] + 1e-9, SERIES_S))
        yield "time_s", seconds[kept].astype(np.float32)
        for name, unit in ERRORS.items():
            yield f"{name}_{unit}", self.errors[name][kept].astype(np.float32)

    @property
    def _last_fix_us(self) -> NDArray[np.int64]:
        """Time of the last fix that was used, to the ms; -1 before the first."""
        age = self.nav["gps_age"]
        last = np.round((self.nav["time_us"] * 1e-6 - age) * 1e3).astype(np.int64) * 1000
        return np.where(age >= 0, last, -1)

    def _refused(self, window: Window) -> float:
        """Share of the fixes that came during the fault and were not used."""
        during = window.rows(self.nav["time_us"])["during"]
        # The first is the last fix before the fault.
        used = len(np.unique(self._last_fix_us[during])) - 1
        came = int(np.sum(window.rows(self.gps["arrival_us"])["during"]))
        return max(1.0 - used / came, 0.0)

    def _detected_after(self, window: Window) -> float:
        """From the begin of the fault until GPS is told to be doubted; NaN if it never is.

        That is the second message of HEALTH in succession that counts a refused fix, for a good one
        is refused now and then; or NAV examines what comes before it uses it.
        """
        time_us, health_us = self.nav["time_us"], self.health["time_us"]
        refused = self.health["rejected"][:, INPUTS.index("GPS")].sum(axis=1)
        more = np.diff(refused, prepend=refused[0]) > 0
        twice = more & np.roll(more, 1) & window.rows(health_us)["during"]
        examined = window.rows(time_us)["during"] & (self.nav["mode"] == _REACQUIRING)
        told = np.concatenate([time_us[examined], health_us[twice]])
        return float(told.min()) * 1e-6 - window.start_s if len(told) else nan

    def _believed_after(self, window: Window) -> float:
        """From the end of the fault until a fix that was measured after it is used; NaN: never."""
        good = self.nav["time_us"][self._last_fix_us >= window.end_s * 1e6]
        return float(good[0]) * 1e-6 - window.end_s if len(good) else nan

    def _beyond_hpl(self, rows: Rows) -> float:
        """Share of the time in which the position error is larger than the protection level."""
        level, error = self.nav[_PROTECTION_LEVEL][rows], self.errors["position"][rows]
        stated = (level >= 0) & np.isfinite(error)
        return float(np.mean(error[stated] > level[stated])) if stated.any() else nan


def _velocity_error(answered: Recording) -> Array:
    nav, truth = answered["NAV"], answered["TRUTH"]
    true = [np.interp(nav["time_us"], truth["time_us"], truth["v_N"][:, axis]) for axis in (0, 1)]
    return np.where(nav["valid"], np.hypot(*(nav["v_N"][:, :2].T - true)), nan)
