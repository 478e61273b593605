# SPDX-License-Identifier: Apache-2.0
"""The study of the INS monitor: false alarms, and faults of the INS found in time.

Cases are ``scenario/engine/working``, in which any alarm is false, and ``scenario/engine/failing``,
in which the INS fails every two minutes, each time in another way, and works between. Errors of the
INS are small rotations about level axes, as in INS.MONITOR: along the heading, to its right, down;
in level flight roll, pitch and heading.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf, nan, radians
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodestar import rotation
from lodestar.harness.faults import Fault, inject
from lodestar.harness.scenario import (
    ENGINES,
    Scenario,
    estimator_config,
    load_scenario,
    simulate,
)
from lodestar.navigator import run
from lodestar.recordings import Recording
from lodestar.recordings.recording import Channel
from lodestar.studies.campaign import Cell, Result
from lodestar.studies.sahrs import AXES, FORMS, SCENARIOS, chosen, describe

Array = NDArray[np.float64]

RAMP_DEG_S = 0.5
KINDS = ("freeze", *(f"ramp-{axis}" for axis in AXES))
ESTIMATORS = {"velocity": "ins-monitor", "paper": "ins-monitor-paper"}
"""Name in rows by the form of SAHRS behind it."""

_NO_INS, _MISCOMPARE = 0, 3
_FIRST_FAULT_S, _BETWEEN_FAULTS_S, _FAULT_S = 150.0, 115.0, 60.0


@dataclass(frozen=True)
class Watched:
    """A flight with an INS that works."""

    hours: float
    alarms: int
    closest: Array
    """Largest difference in parts of its threshold, per axis."""


@dataclass(frozen=True)
class Detection:
    """What became of one fault of the INS."""

    fault: Fault
    time_s: float
    """From its begin to the alarm; inf if there was none while it lasted."""
    error_deg: Array
    """Largest error of the INS until then, per axis, of the solution that was told included."""
    believed_deg: Array
    """Largest error of the solutions that came before the alarm."""

    @property
    def kind(self) -> str:
        """One of KINDS."""
        return "-".join(filter(None, (self.fault.kind, self.fault.field)))


@dataclass(frozen=True)
class InsMonitorStudy:
    """See campaign.Study."""

    scenarios: tuple[Scenario, ...]
    engines: tuple[str, ...] = ("profile",)
    forms: tuple[str, ...] = tuple(FORMS)
    name: str = "ins-monitor"

    @cached_property
    def variants(self) -> dict[Cell, tuple[Scenario, str, bool, str]]:
        """Scenario, engine, whether the INS fails, and form, of every cell."""
        return {
            Cell(
                f"{scenario.name}/{engine}",
                f"{scenario.name}/{engine}/{'failing' if fails else 'working'}",
                ESTIMATORS[form],
            ): (scenario, engine, fails, form)
            for scenario in self.scenarios
            for engine in self.engines
            for fails in (False, True)
            for form in self.forms
        }

    @property
    def cells(self) -> Sequence[Cell]:
        """See campaign.Study."""
        return tuple(self.variants)

    def fly(self, cells: Sequence[Cell], seed: int) -> list[Result]:
        """See campaign.Study."""
        scenario, engine, _, _ = self.variants[cells[0]]
        flight = simulate(scenario, seed, engine)
        results = []
        for cell in cells:
            _, _, fails, form = self.variants[cell]
            overrides = {"sahrs": {"form": form}}
            figures = dict.fromkeys(_FIGURES, nan)
            if fails:
                figures |= _found(detection(scenario, flight, seed, overrides))
            else:
                figures |= _watched(false_alarms(scenario, flight, overrides))
            results.append(Result(cell, seed, figures, {}))
        return results

    def inputs(self, flight: str) -> str:
        """See campaign.Study."""
        name, engine = flight.rsplit("/", 1)
        (scenario,) = (one for one in self.scenarios if one.name == name)
        return describe(scenario, engine)


def ins_monitor_study(
    scenarios: Sequence[str], engines: Sequence[str], forms: Sequence[str]
) -> InsMonitorStudy:
    """The study with these scenarios, engines (profile if none) and forms (all if none).

    Raises InputError for one that does not exist.
    """
    return InsMonitorStudy(
        tuple(load_scenario(name) for name in scenarios or SCENARIOS),
        chosen("engine", engines or ("profile",), ENGINES),
        chosen("form", forms, tuple(FORMS)),
    )


def false_alarms(scenario: Scenario, flight: Recording, overrides: Mapping[str, Any]) -> Watched:
    """Watch a flight's own INS. ``overrides``: configuration of the flight computer, as tables."""
    monitor = run(flight, estimator_config(scenario, flight, overrides))["INS.MONITOR"]
    state, time_us = monitor["state"], monitor["time_us"]
    began = np.diff((state == _MISCOMPARE).astype(int), prepend=0) > 0
    compared = state != _NO_INS
    part = np.abs(monitor["difference"][compared]) / monitor["threshold"][compared]
    hours = float(time_us[-1] - time_us[0]) / 3.6e9 * float(np.mean(compared))
    return Watched(hours, int(began.sum()), part.max(axis=0))


def detection(
    scenario: Scenario, flight: Recording, seed: int, overrides: Mapping[str, Any]
) -> list[Detection]:
    """Watch the flight with an INS that fails again and again.

    Ramps of RAMP_DEG_S to either side in roll, pitch and heading, and frozen solutions.
    """
    faults = list(_faults(seed, scenario.duration_s))
    flown = inject(flight, faults, seed)
    monitor = run(flown, estimator_config(scenario, flight, overrides))["INS.MONITOR"]
    ins_us, error = _error(flown)
    return [_detected(fault, monitor, ins_us, error) for fault in faults]


def _faults(seed: int, duration_s: float) -> Iterator[Fault]:
    rng = np.random.default_rng(np.random.SeedSequence([seed, 5]))
    kinds = [*((axis, side) for axis in AXES for side in (-1, 1)), ("", 0), ("", 0)]
    start = _FIRST_FAULT_S + rng.uniform(0.0, _BETWEEN_FAULTS_S)
    while True:
        for number in rng.permutation(len(kinds)):
            if start + _FAULT_S >= duration_s:
                return
            axis, side = kinds[number]
            if axis:
                value = side * radians(RAMP_DEG_S)
                yield Fault("ramp", "INS", start, _FAULT_S, field=axis, value=value)
            else:
                yield Fault("freeze", "INS", start, _FAULT_S)
            start += _BETWEEN_FAULTS_S


def _error(flight: Recording) -> tuple[NDArray[np.int64], Array]:
    """Time of the INS's solutions and their true errors (deg) about level axes, (n, 3)."""
    ins, truth = flight["INS"], flight["TRUTH"]
    row = np.searchsorted(truth["time_us"], ins["time_us"]).clip(0, len(truth["time_us"]) - 1)
    C_ins = rotation.C_NB_from_euler(*(ins[axis] for axis in AXES))
    C_true = rotation.C_NB_from_euler(*(truth[axis][row] for axis in AXES))
    turn_N = rotation.log_so3(C_ins @ np.swapaxes(C_true, 1, 2))
    C_LN = np.swapaxes(rotation.rotation_z(truth["heading"][row]), 1, 2)
    return ins["time_us"], np.rad2deg((C_LN @ turn_N[..., None])[..., 0])


def _detected(fault: Fault, monitor: Channel, ins_us: NDArray[np.int64], error: Array) -> Detection:
    time_us, state = monitor["time_us"], monitor["state"]
    start, end = fault.start_s * 1e6, (fault.start_s + fault.duration_s) * 1e6
    alarm = (time_us >= start) & (time_us < end) & ((state == _MISCOMPARE) | (state == _NO_INS))
    told = float(time_us[alarm][0]) if alarm.any() else inf
    failed = (ins_us >= start) & (ins_us <= end)

    def worst(rows: NDArray[np.bool_]) -> Array:
        largest: Array = np.abs(error[failed & rows]).max(axis=0, initial=0.0)
        return largest

    time_s = (told - start) * 1e-6
    return Detection(fault, time_s, worst(ins_us <= told), worst(ins_us < told))


_OF_WORKING = ("hours", "alarms", *(f"closest_{axis}" for axis in AXES))
_OF_KIND = (
    "faults",
    "undetected",
    "time_s",
    *(f"{axis}_{which}deg" for which in ("", "believed_") for axis in AXES),
)
_FIGURES = (*_OF_WORKING, *(f"{kind}_{figure}" for kind in KINDS for figure in _OF_KIND))


def _watched(watched: Watched) -> dict[str, float]:
    values = (watched.hours, float(watched.alarms), *map(float, watched.closest))
    return dict(zip(_OF_WORKING, values, strict=True))


def _found(detections: Sequence[Detection]) -> dict[str, float]:
    """Per kind of fault how many, how many unseen, and the worst of time and of each axis."""
    figures: dict[str, float] = {}
    for kind in KINDS:
        of_kind = [one for one in detections if one.kind == kind]
        seen = [one.time_s for one in of_kind if one.time_s < inf]
        error = np.array([np.hstack([one.error_deg, one.believed_deg]) for one in of_kind])
        worst = error.max(axis=0) if len(error) else np.full(2 * len(AXES), nan)
        values = (len(of_kind), len(of_kind) - len(seen), max(seen, default=nan), *worst)
        names = (f"{kind}_{figure}" for figure in _OF_KIND)
        figures |= dict(zip(names, map(float, values), strict=True))
    return figures
