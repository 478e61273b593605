# SPDX-License-Identifier: Apache-2.0
"""What the study of navigation says: against the thesis, our goals, its own sigma, and a peer."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from lodestar.evaluation.fusion_requirements import EKF2, OVER_LIMIT, PEER_SCENARIO, THESIS, Goals
from lodestar.evaluation.score import Row
from lodestar.studies.ensemble import Ensemble, mean_interval, nees_bounds
from lodestar.studies.findings import Findings, row
from lodestar.studies.fusion_book import (
    NEES,
    Book,
    goals_of,
    has,
    is_judged,
    peer_value,
    scenario_of,
)
from lodestar.studies.fusion_loss_tables import losses, peer
from lodestar.studies.fusion_score import AXES, LOSSES_S
from lodestar.studies.fusion_setups import FILTERS, LIMIT
from lodestar.studies.fusion_tables import (
    consistency,
    heading,
    options,
    velocity,
    verdicts,
    wind_and_position,
)

_TABLES = (heading, velocity, verdicts, wind_and_position, consistency, losses, peer, options)

_MEANS = (
    *(f"{angle}_rmse_deg" for angle in ("roll", "pitch", "heading", "before_heading")),
    *(f"wind_{axis}_rmse_m_s" for axis in AXES),
    *(f"{before}velocity_{axis}_rmse_m_s" for before in ("before_", "") for axis in AXES),
    *(f"{of}_{axis}_rmse_m" for of in ("position", "aided_position", "gps") for axis in AXES),
    "sigma_heading_rms_deg",
    "valid_share",
)
_COVERAGE = tuple(
    f"coverage_{multiple}sigma_{name}"
    for multiple in (1, 2)
    for name in ("heading", *(f"{what}_{axis}" for what in ("wind", "position") for axis in AXES))
)
_AT_END = ("end", "sigma_end", "protection_end", "frozen_end")
_WANTED_RUNS = 50


def findings(study: str, ensembles: Sequence[Ensemble]) -> Findings:
    """Rows and tables of the study."""
    book = Book(ensembles)
    tables = [make(book) for make in _TABLES]
    return Findings(
        study=study,
        title="SAHRS and GPS in simulated flights",
        runs=min(one.runs for one in [*book.filters()] or ensembles),
        rows=[one for ensemble in ensembles for one in rows(book, ensemble)],
        tables=[table for table in tables if table.rows],
        notes=_notes(book),
    )


def rows(book: Book, ensemble: Ensemble) -> Iterator[Row]:
    """The rows of one cell: means over the flights with their 95 % interval.

    Where there is a goal, the mean must not be above it, and NEES must lie within its bounds: a
    small error with a wrong sigma does not count.
    """
    case, estimator = ensemble.cell.case, ensemble.cell.estimator
    wanted = goals_of(ensemble)
    references = _references(scenario_of(case))
    ends = [f"{name}_{s}s_m" for s in LOSSES_S for name in _AT_END]
    known = [metric for metric in ends if has(ensemble, metric)]
    for metric in (*_MEANS, *_COVERAGE, *known):
        yield _mean_row(ensemble, metric, references.get(metric), wanted)
    for metric in (one for one in wanted if one not in (*_MEANS, *known)):
        # A goal that no flight has a figure for has not been reached.
        yield _mean_row(ensemble, metric, None, wanted)
    judged = is_judged(ensemble)
    for metric, size in NEES.items():
        low, high = nees_bounds(ensemble.runs, size)
        bounds = {"least": low, "limit": high} if judged else {}
        mean = float(np.mean(ensemble.figure(metric)))
        yield row(case, estimator, metric, mean, interval=(low, high), **bounds)
    yield from _protection(ensemble)
    ratio = book.over_limit(ensemble)
    if estimator in FILTERS and ratio is not None:
        must, stretch = OVER_LIMIT if estimator == LIMIT.filter else (None, None)
        yield row(case, estimator, "heading_over_limit", ratio, limit=must, stretch=stretch)
    if scenario_of(case) == PEER_SCENARIO:
        for metric, reached in EKF2.items():
            value = peer_value(metric, ensemble.figure(metric))
            most = reached if estimator == "integrated" else None
            yield row(case, estimator, metric, value, reference=reached, limit=most)


def _references(scenario: str) -> dict[str, float]:
    """The thesis's figures by metric; its wind is our error of velocity."""
    published = THESIS.get(scenario)
    if published is None:
        return {}
    metrics = {"heading": "heading_rmse_deg"}
    metrics |= {f"wind_{axis}": f"velocity_{axis}_rmse_m_s" for axis in AXES}
    return {
        f"{prefix}{metric}": published[quantity][place]
        for quantity, metric in metrics.items()
        for place, prefix in enumerate(("before_", ""))
    }


def _mean_row(ensemble: Ensemble, metric: str, reference: float | None, wanted: Goals) -> Row:
    mean, low, high = mean_interval(ensemble.figure(metric))
    must, stretch = wanted.get(metric, (None, None))
    return row(
        ensemble.cell.case,
        ensemble.cell.estimator,
        metric,
        mean,
        interval=(low, high),
        reference=reference,
        limit=must,
        stretch=stretch,
    )


def _protection(ensemble: Ensemble) -> Iterator[Row]:
    """For how long a protection level was stated, and in how many flights it did not hold."""
    case, estimator = ensemble.cell.case, ensemble.cell.estimator
    hours = float(np.sum(ensemble.figure("protected_h")))
    if hours == 0.0:
        return
    yield row(case, estimator, "protected_h", hours)
    beyond = int(np.sum(ensemble.figure("beyond_protection_h") > 0))
    # At 1e-5/h the hours of a study leave room for none.
    most = 0 if estimator in FILTERS else None
    yield row(case, estimator, "flights_beyond_protection", beyond, limit=most)


def _notes(book: Book) -> list[str]:
    told = [
        "rms: mean over the flights with its 95 % interval. Before: SAHRS, and dead reckoning on "
        "it with air data in still air; after: NAV. SAHRS before correction is that of cascade's "
        "cells, in its velocity form, its paper's form, and that without states for the errors "
        "of the magnetic detector (thesis-like).",
        "Thesis: the Linköping thesis. Its wind is what is missing between true and calculated "
        "velocity, and was added to the magnitude of the airspeed only; here it enters through the "
        "wind triangle. Its figures of wind are a reference, not the same experiment.",
        "Red in “Ours”: over must, or NEES outside its bounds. NEES does not count from "
        "the beginning of a step of the wind to 5 s after it, or to 10 s after GPS is back where "
        "the step fell into a loss. A small error with a wrong σ does not count.",
        "limit: the stated σ of heading (rms) of the same filter when it knows the error model "
        "exactly. The protection level holds at a risk of 1e-5 per hour.",
    ]
    runs = sorted({one.runs for one in book.filters()})
    if runs and runs[0] < _WANTED_RUNS:
        told.append(f"The goals are for means over {_WANTED_RUNS} flights and more.")
    if len(runs) > 1:
        told.append(f"Incomplete: the cases have {runs[0]} to {runs[-1]} flights.")
    return told
