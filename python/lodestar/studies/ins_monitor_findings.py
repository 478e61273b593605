# SPDX-License-Identifier: Apache-2.0
"""What the study of the INS monitor says: hours without a false alarm, errors at the alarm."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from lodestar.evaluation.score import Row
from lodestar.evaluation.summary import NONE, Table
from lodestar.studies.ensemble import Ensemble
from lodestar.studies.findings import Findings, Plot, row
from lodestar.studies.ins_monitor import ESTIMATORS, KINDS, RAMP_DEG_S
from lodestar.studies.sahrs import AXES

LIMITS_DEG = {"roll": 5.0, "pitch": 5.0, "heading": 10.0}
"""Error of the INS by which it has to be told."""

_FORM_OF = {estimator: form for form, estimator in ESTIMATORS.items()}


def findings(study: str, ensembles: Sequence[Ensemble]) -> Findings:
    """Rows and tables of the study."""
    working = [one for one in ensembles if one.cell.case.endswith("/working")]
    failing = [one for one in ensembles if one.cell.case.endswith("/failing")]
    rows = [row for ensemble in working for row in alarm_rows(ensemble)]
    rows += [row for ensemble in failing for row in detection_rows(ensemble)]
    return Findings(
        study=study,
        title="The INS watched by SAHRS",
        runs=min(ensemble.runs for ensemble in ensembles),
        rows=rows,
        tables=[_alarms(working), _detections(failing)],
        notes=[
            f"A ramp grows by {RAMP_DEG_S:g}°/s; a frozen INS repeats its last solution. Errors "
            "are about level axes: along the heading, to its right, down.",
            "Difference: the largest, in parts of the threshold it had at that time.",
        ],
    )


def plots(_: Sequence[Ensemble]) -> list[Plot]:
    """None: the tables say it all."""
    return []


def alarm_rows(ensemble: Ensemble) -> Iterator[Row]:
    """Hours, false alarms, and how close the differences came to their thresholds."""
    case, estimator = ensemble.cell.case, ensemble.cell.estimator
    yield row(case, estimator, "flown_hours", _sum(ensemble, "hours"))
    yield row(case, estimator, "false_alarms", _sum(ensemble, "alarms"), limit=0)
    for axis in AXES:
        value = _max(ensemble, f"closest_{axis}")
        yield row(case, estimator, f"{axis}_max_of_threshold", value)


def detection_rows(ensemble: Ensemble) -> Iterator[Row]:
    """Per kind of fault: how many, how many unseen, longest time, largest errors.

    `at_alarm` counts the solution that was told, `before_alarm` those that were still believed. At
    150 deg/s a frozen INS of 30 Hz is 5 degrees off with its first wrong solution.
    """
    estimator = ensemble.cell.estimator
    for kind in KINDS:
        case = f"{ensemble.cell.case}/{kind}"
        faults = _sum(ensemble, f"{kind}_faults")
        if not faults:
            continue
        yield row(case, estimator, "faults", faults)
        unseen = _sum(ensemble, f"{kind}_undetected")
        yield row(case, estimator, "undetected", unseen, limit=0)
        yield row(case, estimator, "time_to_alarm_max_s", _max(ensemble, f"{kind}_time_s"))
        for axis in _axes_of(kind):
            worst = _max(ensemble, f"{kind}_{axis}_deg")
            yield row(case, estimator, f"{axis}_at_alarm_max_deg", worst, limit=LIMITS_DEG[axis])
            believed = _max(ensemble, f"{kind}_{axis}_believed_deg")
            yield row(case, estimator, f"{axis}_before_alarm_max_deg", believed)


def _axes_of(kind: str) -> tuple[str, ...]:
    return AXES if kind == "freeze" else (kind.removeprefix("ramp-"),)


def _sum(ensemble: Ensemble, figure: str) -> float:
    return float(np.sum(ensemble.figure(figure)))


def _max(ensemble: Ensemble, figure: str) -> float:
    """The largest of the flights that have one; NaN if none has."""
    values = ensemble.figure(figure)
    there = values[~np.isnan(values)]
    return float(there.max()) if len(there) else np.nan


def _names(ensemble: Ensemble) -> tuple[str, str]:
    return ensemble.cell.case, _FORM_OF[ensemble.cell.estimator]


def _alarms(ensembles: Sequence[Ensemble]) -> Table:
    body: list[tuple[str, ...]] = []
    bad = set()
    for number, ensemble in enumerate(ensembles):
        alarms = _sum(ensemble, "alarms")
        closest = " / ".join(f"{_max(ensemble, f'closest_{axis}'):.2f}" for axis in AXES)
        body.append((*_names(ensemble), f"{_sum(ensemble, 'hours'):.1f}", f"{alarms:.0f}", closest))
        if alarms:
            bad.add((number, 3))
    header = ("case", "form", "hours", "false alarms", f"difference ({' / '.join(AXES)})")
    return Table("An INS that works", header, body, frozenset(bad))


def _detections(ensembles: Sequence[Ensemble]) -> Table:
    body: list[tuple[str, ...]] = []
    bad = set()
    for ensemble in ensembles:
        for kind in KINDS:
            unseen = _sum(ensemble, f"{kind}_undetected")
            axes = _axes_of(kind)
            believed = [_max(ensemble, f"{kind}_{axis}_believed_deg") for axis in axes]
            told = [_max(ensemble, f"{kind}_{axis}_deg") for axis in axes]
            if unseen:
                bad.add((len(body), 4))
            if any(value > LIMITS_DEG[axis] for axis, value in zip(axes, told, strict=True)):
                bad.add((len(body), 7))
            counts = (_sum(ensemble, f"{kind}_faults"), unseen)
            time = f"{_max(ensemble, f'{kind}_time_s'):.1f}"
            body.append(
                (
                    *_names(ensemble),
                    kind,
                    *(f"{count:.0f}" for count in counts),
                    time,
                    _by_axis(axes, believed),
                    _by_axis(axes, told),
                )
            )
    header = (
        "case",
        "form",
        "fault",
        "faults",
        "not told",
        "longest, s",
        "error before, °",
        "error when told, °",
    )
    return Table("An INS that fails: until the alarm", header, body, frozenset(bad))


def _by_axis(axes: Sequence[str], values: Sequence[float]) -> str:
    known = dict(zip(axes, values, strict=True))
    return " / ".join(f"{known[axis]:.2f}" if axis in known else NONE for axis in AXES)
