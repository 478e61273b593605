# SPDX-License-Identifier: Apache-2.0
"""What the study of fusion with bad fixes says: was it told, and how far off was the position."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from lodestar.evaluation import drawing
from lodestar.evaluation.score import Row
from lodestar.evaluation.summary import NONE, Table
from lodestar.studies import fault_findings
from lodestar.studies.ensemble import Ensemble, mean_interval
from lodestar.studies.fault_window import RECOVERY_S, reasons
from lodestar.studies.findings import Findings, Plot, row
from lodestar.studies.fusion_faults import (
    BROKEN,
    CASES,
    CHANNELS,
    ERRORS,
    SPOOFED,
    START_S,
    Case,
)

BELIEVED_WITHIN_S = 10.0
"""Limit: from the end of the fault until good fixes are used again."""

_KEPT_OUT = 0.5
"""Share of the bad fixes that must not be used for the verdict to be that it was detected."""

_REASONS = [(reason, reason) for reason in reasons(CHANNELS)]
_MAXIMA = tuple(f"{quantity}_max_{unit}" for quantity, unit in ERRORS.items())


def findings(study: str, ensembles: Sequence[Ensemble]) -> Findings:
    """Rows and tables of the study."""
    return Findings(
        study=study,
        title="Fusion with bad fixes",
        runs=min(ensemble.runs for ensemble in ensembles),
        rows=[one for ensemble in ensembles for one in rows(ensemble)],
        tables=[_errors(ensembles), _detection(ensembles), _refused(ensembles)],
        notes=[
            f"The fault begins at {START_S:g} s; errors after it count from {RECOVERY_S:g} s after "
            "its end. Errors and times are the largest of all flights, shares their mean.",
            "Good again: from the end until a good fix is used, at most "
            f"{BELIEVED_WITHIN_S:g} s. Verdict detected: told in every flight, and at least "
            f"{100 * _KEPT_OUT:g} % of the fixes kept out.",
            *(f"{name}: {case.what}" for name, case in CASES.items()),
        ],
    )


def rows(ensemble: Ensemble) -> Iterator[Row]:
    """The rows of one cell: the largest of all flights, or the mean for shares."""
    case, estimator = ensemble.cell.case, ensemble.cell.estimator
    for window in ("during", "after"):
        for metric in (*_MAXIMA, "position_max_sigmas"):
            value = _worst(ensemble, f"{window}_{metric}")
            yield row(f"{case}/{window}", estimator, metric, value)
        for metric in ("valid_share", "not_aiding_share"):
            mean, low, high = mean_interval(ensemble.figure(f"{window}_{metric}"))
            yield row(f"{case}/{window}", estimator, metric, mean, interval=(low, high))
    mean, low, high = mean_interval(ensemble.figure("fixes_refused_share"))
    yield row(f"{case}/during", estimator, "fixes_refused_share", mean, interval=(low, high))
    undetected = float(np.sum(np.isnan(ensemble.figure("detect_s"))))
    yield row(case, estimator, "undetected", undetected)
    if undetected < ensemble.runs:
        yield row(case, estimator, "detect_s", float(np.nanmax(ensemble.figure("detect_s"))))
    believed = _worst(ensemble, "believe_s")
    yield row(case, estimator, "believe_s", believed, limit=BELIEVED_WITHIN_S)
    yield row(case, estimator, "resets", float(np.mean(ensemble.figure("resets"))))
    beyond = _mean(ensemble, "beyond_hpl_share")
    if not np.isnan(beyond):
        yield row(case, estimator, "beyond_hpl_share", beyond)
    yield from fault_findings.rejected_rows(ensemble, _REASONS)


def verdict(ensemble: Ensemble) -> str:
    """Whether it was told and kept out in every flight, or how far off the position was at most."""
    if _fault(ensemble) == "none":
        return NONE
    kept_out = ensemble.figure("fixes_refused_share") >= _KEPT_OUT
    if np.all(kept_out & ~np.isnan(ensemble.figure("detect_s"))):
        return "detected"
    return f"bounded by {_worst(ensemble, 'during_position_max_m'):.0f} m"


def _errors(ensembles: Sequence[Ensemble]) -> Table:
    body: list[tuple[str, ...]] = []
    for ensemble in ensembles:
        cells = []
        for window in ("during", "after"):
            position, *others = (_worst(ensemble, f"{window}_{metric}") for metric in _MAXIMA)
            sigmas = _worst(ensemble, f"{window}_position_max_sigmas")
            cells += [f"{position:.0f}", f"{sigmas:.1f}", *(f"{other:.1f}" for other in others)]
        body.append((*_names(ensemble), *cells))
    quantities = ("position, m", "in σ", "velocity, m/s", "wind, m/s", "heading, °")
    header = (
        "case",
        "filter",
        *(f"{window}: {quantity}" for window in ("during", "after") for quantity in quantities),
    )
    return Table("Largest errors of all flights", header, body)


def _detection(ensembles: Sequence[Ensemble]) -> Table:
    body: list[tuple[str, ...]] = []
    bad = set()
    for number, ensemble in enumerate(ensembles):
        detect, believe = ensemble.figure("detect_s"), _worst(ensemble, "believe_s")
        told = ~np.isnan(detect)
        beyond = _mean(ensemble, "beyond_hpl_share")
        if not believe <= BELIEVED_WITHIN_S:
            bad.add((number, 6))
        body.append(
            (
                *_names(ensemble),
                f"{np.sum(told)} of {ensemble.runs}",
                f"{np.max(detect[told]):.1f}" if told.any() else NONE,
                f"{100 * _mean(ensemble, 'fixes_refused_share'):.0f}",
                f"{100 * _mean(ensemble, 'during_not_aiding_share'):.0f}",
                "never" if np.isnan(believe) else f"{believe:.1f}",
                f"{_mean(ensemble, 'resets'):.1f}",
                NONE if np.isnan(beyond) else f"{100 * beyond:.2g}",
                verdict(ensemble),
            )
        )
    header = (
        "case",
        "filter",
        "detected, flights",
        "after, s",
        "refused, %",
        "not aiding, %",
        "good again, s",
        "resets",
        "beyond HPL, %",
        "verdict",
    )
    return Table("Detected, or bounded", header, body, frozenset(bad))


def _refused(ensembles: Sequence[Ensemble]) -> Table:
    body: list[tuple[str, ...]] = [
        (*_names(ensemble), fault_findings.told(ensemble, _REASONS)) for ensemble in ensembles
    ]
    title = "Refused during the fault by the count of HEALTH, mean of the flights"
    return Table(title, ("case", "filter", "fixes, by reason"), body, wide=True)


def _worst(ensemble: Ensemble, figure: str) -> float:
    return float(np.max(ensemble.figure(figure)))


def _mean(ensemble: Ensemble, figure: str) -> float:
    return float(np.mean(ensemble.figure(figure)))


def _fault(ensemble: Ensemble) -> str:
    return ensemble.cell.case.split("/")[-1]


def _names(ensemble: Ensemble) -> tuple[str, str]:
    return ensemble.cell.case, ensemble.cell.estimator


def plots(ensembles: Sequence[Ensemble]) -> list[Plot]:
    """Errors over time for each engine and filter: fixes that lie, and fixes that are broken."""
    groups: dict[tuple[str, str, str], list[Ensemble]] = {}
    for ensemble in ensembles:
        for kind, cases in (("spoofed", SPOOFED), ("broken", BROKEN)):
            if _fault(ensemble) in ("none", *cases):
                cell = ensemble.cell
                groups.setdefault((cell.flight, cell.estimator, kind), []).append(ensemble)
    with mpl.rc_context(drawing.STYLE):
        return [
            Plot(
                f"{kind}-{flight.replace('/', '-')}-{estimator}",
                f"{kind} GPS: {flight}, {estimator}",
                "Rms of the errors over the flights; marks: begin and ends of the faults.",
                _errors_in_time(members, {"none": CASES["none"]} | cases),
            )
            for (flight, estimator, kind), members in groups.items()
            for cases in [SPOOFED if kind == "spoofed" else BROKEN]
        ]


def _errors_in_time(ensembles: Sequence[Ensemble], cases: Mapping[str, Case]) -> Figure:
    figure, axes = drawing.panels(
        [f"{name}, {unit.replace('_', '/').replace('deg', '°')}" for name, unit in ERRORS.items()]
    )
    marks = {START_S, *(case.window.end_s for case in cases.values() if case.faults)}
    for axis, (name, unit) in zip(axes, ERRORS.items(), strict=True):
        for mark in marks:
            axis.axvline(mark, color=drawing.LOSS, lw=0.8, ls="--")
        fault_findings.rms_lines(axis, ensembles, f"{name}_{unit}")
        axis.set_xlim(START_S - 100, max(marks) + 200)
        axis.set_ylim(bottom=0)
    # From metres to kilometres.
    axes[0].set_yscale("log")
    axes[0].set_ylim(bottom=1.0)
    return drawing.titled(figure, axes)
