# SPDX-License-Identifier: Apache-2.0
"""What the study of SAHRS with bad input says: what was refused, and what it cost."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from lodestar.evaluation import drawing, requirements
from lodestar.evaluation.score import Row
from lodestar.evaluation.summary import Table
from lodestar.studies import fault_findings
from lodestar.studies.ensemble import Ensemble, mean_interval
from lodestar.studies.fault_window import RECOVERY_S, reasons
from lodestar.studies.findings import Findings, Plot, row
from lodestar.studies.sahrs import AXES, FORM_OF
from lodestar.studies.sahrs_faults import (
    CHANNELS,
    CHECKS,
    MEASUREMENTS,
    WHAT,
    WINDOW,
)
from lodestar.studies.sahrs_findings import MAXIMA, RMSE, errors_within

_REASONS = [
    (reason, reason) for reason in (*reasons(CHANNELS), *(f"check {check}" for check in CHECKS))
]


def findings(study: str, ensembles: Sequence[Ensemble]) -> Findings:
    """Rows and tables of the study."""
    return Findings(
        study=study,
        title="SAHRS with bad input",
        runs=min(ensemble.runs for ensemble in ensembles),
        rows=[one for ensemble in ensembles for one in rows(ensemble)],
        tables=[_errors(ensembles), _rejections(ensembles)],
        notes=[
            f"The fault lasts from {WINDOW.start_s:g} to {WINDOW.end_s:g} s; errors after it count "
            f"from {RECOVERY_S:g} s later. rms: mean over the flights; worst: the largest of all.",
            *(f"{fault}: {what}" for fault, what in WHAT.items()),
        ],
    )


def rows(ensemble: Ensemble) -> Iterator[Row]:
    """The rows of one cell.

    Limits are the SAHRS paper's: after the fault those of calm flight hold again; during it the
    velocity form keeps to those of hard manoeuvring, the widest there are.
    """
    cell = ensemble.cell
    bounds = requirements.HARD if cell.estimator == "sahrs" else {}
    for window in ("during", "after"):
        limits = requirements.CALM if window == "after" else bounds
        for metric in (*RMSE, *MAXIMA):
            values = ensemble.figure(f"{window}_{metric}")
            mean, low, high = mean_interval(values)
            is_mean = metric in RMSE
            yield row(
                f"{cell.case}/{window}",
                cell.estimator,
                metric,
                mean if is_mean else float(np.max(values)),
                interval=(low, high) if is_mean else None,
                limit=limits.get(metric),
            )
    yield from fault_findings.rejected_rows(ensemble, (*_measurements(ensemble), *_REASONS))


def _measurements(ensemble: Ensemble) -> list[tuple[str, str]]:
    """Name and figure of each measurement of the cell's form."""
    names = MEASUREMENTS[FORM_OF[ensemble.cell.estimator]]
    return [(name, f"refused_{number}") for number, name in enumerate(names)]


def _errors(ensembles: Sequence[Ensemble]) -> Table:
    body = []
    bad = set()
    for number, ensemble in enumerate(ensembles):
        cells = []
        for window in ("during", "after"):
            for cell, over in errors_within(ensemble, window, requirements.CALM):
                cells.append(cell)
                if over:
                    bad.add((number, len(cells) + 1))
        rotation = f"{np.max(ensemble.figure('during_rotation_max_deg')):.2f}"
        valid = f"{100 * np.mean(ensemble.figure('during_valid_share')):.0f}"
        body.append((*_names(ensemble), *cells, rotation, valid))
    header = (
        "case",
        "form",
        "during: rms, °",
        "during: worst, °",
        "after: rms, °",
        "after: worst, °",
        "largest rotation, °",
        "% valid",
    )
    title = f"Errors ({' / '.join(AXES)}); red is over the paper's limits for calm flight"
    return Table(title, header, body, frozenset(bad))


def _rejections(ensembles: Sequence[Ensemble]) -> Table:
    body: list[tuple[str, ...]] = []
    for ensemble in ensembles:
        resets = f"{np.mean(ensemble.figure('resets')):.1f}"
        refused = fault_findings.told(ensemble, _measurements(ensemble), _REASONS)
        body.append((*_names(ensemble), resets, refused))
    header = ("case", "form", "resets", "measurements refused; why, by channel and check")
    title = "Refused during the fault, mean of the flights"
    return Table(title, header, body, wide=True)


def _names(ensemble: Ensemble) -> tuple[str, str]:
    return ensemble.cell.case, FORM_OF[ensemble.cell.estimator]


def plots(ensembles: Sequence[Ensemble]) -> list[Plot]:
    """The errors of all faults over time, one figure for each engine and form."""
    groups: dict[tuple[str, str], list[Ensemble]] = {}
    for ensemble in ensembles:
        groups.setdefault((ensemble.cell.flight, ensemble.cell.estimator), []).append(ensemble)
    with mpl.rc_context(drawing.STYLE):
        return [
            Plot(
                f"errors-{flight.replace('/', '-')}-{estimator}",
                f"{flight}, {FORM_OF[estimator]} form",
                "Rms of the errors about the body axes over the flights; the fault is shaded.",
                _errors_in_time(members),
            )
            for (flight, estimator), members in groups.items()
        ]


def _errors_in_time(ensembles: Sequence[Ensemble]) -> Figure:
    figure, axes = drawing.panels([f"{axis} axis, °" for axis in ("roll", "pitch", "yaw")])
    for one, axis in zip(axes, AXES, strict=True):
        one.axvspan(WINDOW.start_s, WINDOW.end_s, color=drawing.LOSS, alpha=0.15, lw=0)
        fault_findings.rms_lines(one, ensembles, f"error_{axis}_deg")
        one.set_xlim(WINDOW.start_s - 100, WINDOW.end_s + 200)
        one.set_ylim(bottom=0)
    return drawing.titled(figure, axes)
