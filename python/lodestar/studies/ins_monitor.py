# SPDX-License-Identifier: Apache-2.0
"""How the INS is watched by SAHRS: false alarms and detection over simulated flights.

``python -m lodestar.studies.ins_monitor --runs N`` flies every scenario of SCENARIOS N times
without a fault, counting alarms, and N_FAULTY times with an INS that fails again and again.
Errors of the INS are small rotations about level axes, as in INS.MONITOR: along the heading, to its
right, down; in level flight roll, pitch and heading.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import inf, radians
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodestar import rotation
from lodestar.harness.faults import Fault, inject
from lodestar.harness.scenario import estimator_config, load_scenario, simulate
from lodestar.navigator import run
from lodestar.recordings import Recording
from lodestar.recordings.recording import Channel

Row = dict[str, Any]
Array = NDArray[np.float64]

SCENARIOS = ("ordinary", "turbulence", "hard")
N_FAULTY = 10
RAMP_DEG_S = 0.5
LIMITS_DEG = {"roll": 5.0, "pitch": 5.0, "heading": 10.0}
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
    """Largest error of the INS until then, per axis."""

    @property
    def name(self) -> str:
        """Kind and field."""
        return "-".join(filter(None, (self.fault.kind, self.fault.field)))


def false_alarms(
    scenario_name: str, seed: int, overrides: Mapping[str, Any] | None = None
) -> Watched:
    """Fly without a fault. ``overrides``: configuration of the flight computer, as tables."""
    scenario = load_scenario(scenario_name)
    flight = simulate(scenario, seed)
    monitor = run(flight, estimator_config(scenario, flight, overrides))["INS.MONITOR"]
    state, time_us = monitor["state"], monitor["time_us"]
    began = np.diff((state == _MISCOMPARE).astype(int), prepend=0) > 0
    compared = state != _NO_INS
    part = np.abs(monitor["difference"][compared]) / monitor["threshold"][compared]
    hours = float(time_us[-1] - time_us[0]) / 3.6e9 * float(np.mean(compared))
    return Watched(hours, int(began.sum()), part.max(axis=0))


def detection(
    scenario_name: str, seed: int, overrides: Mapping[str, Any] | None = None
) -> list[Detection]:
    """Fly with an INS that fails every two minutes, each time in another way, and works between.

    Ramps of RAMP_DEG_S to either side in roll, pitch and heading, and frozen solutions.
    """
    scenario = load_scenario(scenario_name)
    flight = simulate(scenario, seed)
    faults = list(_faults(seed, scenario.duration_s))
    flown = inject(flight, faults, seed)
    monitor = run(flown, estimator_config(scenario, flight, overrides))["INS.MONITOR"]
    ins_us, error = _error(flown)
    return [_detected(fault, monitor, ins_us, error) for fault in faults]


def _faults(seed: int, duration_s: float) -> Iterator[Fault]:
    rng = np.random.default_rng(np.random.SeedSequence([seed, 5]))
    ramps = [(field, side) for field in LIMITS_DEG for side in (-1, 1)]
    kinds = [*ramps, ("", 0), ("", 0)]
    start = _FIRST_FAULT_S + rng.uniform(0.0, _BETWEEN_FAULTS_S)
    while start + _FAULT_S < duration_s:
        for field, side in rng.permutation(np.array(kinds, dtype=object)):
            if start + _FAULT_S >= duration_s:
                return
            if field:
                value = side * radians(RAMP_DEG_S)
                yield Fault("ramp", "INS", start, _FAULT_S, field=field, value=value)
            else:
                yield Fault("freeze", "INS", start, _FAULT_S)
            start += _BETWEEN_FAULTS_S


def _error(flight: Recording) -> tuple[NDArray[np.int64], Array]:
    """Time of the INS's solutions and their true errors (deg) about level axes, (n, 3)."""
    ins, truth = flight["INS"], flight["TRUTH"]
    row = np.searchsorted(truth["time_us"], ins["time_us"]).clip(0, len(truth["time_us"]) - 1)
    angles = ("roll", "pitch", "heading")
    C_ins = rotation.C_NB_from_euler(*(ins[name] for name in angles))
    C_true = rotation.C_NB_from_euler(*(truth[name][row] for name in angles))
    turn_N = rotation.log_so3(C_ins @ np.swapaxes(C_true, 1, 2))
    C_LN = np.swapaxes(rotation.rotation_z(truth["heading"][row]), 1, 2)
    return ins["time_us"], np.rad2deg((C_LN @ turn_N[..., None])[..., 0])


def _detected(fault: Fault, monitor: Channel, ins_us: NDArray[np.int64], error: Array) -> Detection:
    time_us, state = monitor["time_us"], monitor["state"]
    start, end = fault.start_s * 1e6, (fault.start_s + fault.duration_s) * 1e6
    alarm = (time_us >= start) & (time_us < end) & ((state == _MISCOMPARE) | (state == _NO_INS))
    told = float(time_us[alarm][0]) if alarm.any() else inf
    until = (ins_us >= start) & (ins_us <= min(told, end))
    worst = np.abs(error[until]).max(axis=0, initial=0.0)
    return Detection(fault, (told - start) * 1e-6, worst)


def alarm_rows(case: str, flights: list[Watched]) -> Iterator[Row]:
    """Hours flown, alarms, and how close the differences came to their thresholds."""
    yield _row(case, "flown_hours", sum(flight.hours for flight in flights))
    yield _row(case, "false_alarms", sum(flight.alarms for flight in flights), 0)
    closest = np.max([flight.closest for flight in flights], axis=0)
    for axis, part in zip(LIMITS_DEG, closest, strict=True):
        yield _row(case, f"{axis}_max_of_threshold", float(part), 1)


def detection_rows(case: str, detections: list[Detection]) -> Iterator[Row]:
    """Per kind of fault: how many, how many unseen, the INS's error and the time at the alarm."""
    for name in sorted({detection.name for detection in detections}):
        found = [detection for detection in detections if detection.name == name]
        label = f"{case}/{name}"
        yield _row(label, "faults", len(found))
        yield _row(label, "undetected", sum(d.time_s == inf for d in found), 0)
        seen = [d.time_s for d in found if d.time_s < inf]
        if seen:
            yield _row(label, "time_to_alarm_max_s", max(seen))
        error = np.array([detection.error_deg for detection in found])
        for axis, (field, limit) in enumerate(LIMITS_DEG.items()):
            if found[0].fault.field in ("", field):
                yield _row(label, f"{field}_at_alarm_mean_deg", float(error[:, axis].mean()))
                yield _row(label, f"{field}_at_alarm_max_deg", float(error[:, axis].max()), limit)


def _row(case: str, metric: str, value: float, limit: float | None = None) -> Row:
    row: Row = {"case": case, "estimator": "ins-monitor", "metric": metric, "value": value}
    return row if limit is None else {**row, "limit": limit}


def main() -> None:
    """Fly, print a line per figure, or with --json one object."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=4, help="faultless flights of each scenario")
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    options = parser.parse_args()
    rows: list[Row] = []
    for name in SCENARIOS:
        seeds = range(1, options.runs + 1)
        rows += alarm_rows(name, [false_alarms(name, seed) for seed in seeds])
        faulty = [d for seed in range(1, N_FAULTY + 1) for d in detection(name, seed)]
        rows += detection_rows(name, faulty)
    if options.json:
        json.dump({"study": "ins-monitor", "runs": options.runs, "rows": rows}, sys.stdout)
        print()
        return
    for row in rows:
        limit = f"  (limit {row['limit']:g})" if "limit" in row else ""
        print(f"{row['case']:26s} {row['metric']:28s} {row['value']:9.3f}{limit}")


if __name__ == "__main__":
    main()
