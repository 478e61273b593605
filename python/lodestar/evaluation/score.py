# SPDX-License-Identifier: Apache-2.0
"""The score of a flight: rows of figures, and whether it passed."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from math import isnan
from typing import Any

import numpy as np

from lodestar.evaluation import requirements
from lodestar.evaluation.comparison import Comparison, Estimates, Series, compare
from lodestar.evaluation.metrics import Gap, coverage, maximum, rmse
from lodestar.recordings.recording import Recording

Row = dict[str, Any]


@dataclass(frozen=True)
class Score:
    """The figures of one flight. ``comparison`` holds the series they were computed from."""

    case: str
    seed: int | None
    duration_s: float
    realtime_factor: float | None
    rows: list[Row]
    failures: list[str]
    """What the flight fell short of, one line each; empty when it passed."""
    comparison: Comparison = field(repr=False)

    @property
    def passed(self) -> bool:
        """Whether every limit was kept and there was something to judge."""
        return not self.failures

    def value(self, estimator: str, metric: str, case: str | None = None) -> float | None:
        """One figure; None when the score has no such row."""
        wanted = (case or self.case, estimator, metric)
        for row in self.rows:
            if (row["case"], row["estimator"], row["metric"]) == wanted:
                return float(row["value"])
        return None

    def to_json(self) -> dict[str, Any]:
        """The object that ``--json`` prints."""
        return {
            "scenario": self.case,
            "seed": self.seed,
            "duration_s": self.duration_s,
            "realtime_factor": self.realtime_factor,
            "rows": self.rows,
        }


def score(
    recording: Recording,
    *,
    case: str,
    seed: int | None = None,
    realtime_factor: float | None = None,
) -> Score:
    """Score SAHRS, NAV and dead reckoning against TRUTH, or against the INS where there is none.

    Root mean squares and coverage are over all valid output; maxima start 60 s after the
    estimator's first message. The paper's limits apply against TRUTH only: an INS is an estimate
    itself.

    Raises InputError when the recording has neither TRUTH nor a valid INS.
    """
    comparison = compare(recording)
    rows = [
        _row(case, estimator, metric, value, judged=comparison.reference == "TRUTH")
        for estimator, metric, value in _figures(comparison)
        if not isnan(value)
    ]
    rows += [row for gap in comparison.gps_losses for row in _loss_rows(case, comparison, gap)]
    return Score(
        case=case,
        seed=seed,
        duration_s=recording.duration_s(),
        realtime_factor=realtime_factor,
        rows=rows,
        failures=_failures(rows, comparison),
        comparison=comparison,
    )


def loss_case(case: str, gap: Gap) -> str:
    """The case of the rows of one loss of GPS: its length and when it began."""
    return f"{case}/gps-loss-{gap.duration_s:.0f}s-at-{gap.start_us * 1e-6:.0f}s"


def _row(case: str, estimator: str, metric: str, value: float, *, judged: bool) -> Row:
    row: Row = {"case": case, "estimator": estimator, "metric": metric, "value": value}
    extra = {
        "reference": requirements.published(case, estimator, metric),
        "limit": requirements.limit(case, estimator, metric) if judged else None,
    }
    return row | {key: value for key, value in extra.items() if value is not None}


def _figures(comparison: Comparison) -> Iterator[tuple[str, str, float]]:
    """(estimator, metric, value) of the whole flight."""
    for estimator, estimates in (
        ("sahrs", comparison.sahrs),
        (comparison.filter, comparison.nav),
        ("dead-reckoning", comparison.dead_reckoning),
    ):
        if estimates is None:
            continue
        for metric, value in _attitude_figures(estimates):
            yield estimator, metric, value
        for metric, value in _track_figures(estimates):
            yield estimator, metric, value
        for metric, value in _coverage_figures(estimates):
            yield estimator, metric, value


def _attitude_figures(estimates: Estimates) -> Iterator[tuple[str, float]]:
    if estimates.attitude is None:
        return
    degrees = np.rad2deg(estimates.attitude.error)
    settled = estimates.time_us >= estimates.time_us[0] + requirements.SETTLING_S * 1e6
    for index, name in enumerate(estimates.attitude.names):
        yield f"{name}_rmse_deg", rmse(degrees[:, index])
        yield f"{name}_max_deg", maximum(degrees[settled, index])


def _track_figures(estimates: Estimates) -> Iterator[tuple[str, float]]:
    if estimates.position is not None:
        distance = np.hypot(*estimates.position.error.T)
        known = distance[~np.isnan(distance)]
        yield "position_rmse_m", rmse(distance)
        yield "position_max_m", maximum(distance)
        yield "position_final_m", float(known[-1]) if len(known) else float("nan")
    if estimates.wind is not None:
        for index, name in enumerate(estimates.wind.names):
            yield f"{name}_rmse_m_s", rmse(estimates.wind.error[:, index])


def _coverage_figures(estimates: Estimates) -> Iterator[tuple[str, float]]:
    series: list[Series | None] = [
        estimates.attitude,
        estimates.rotation,
        estimates.position,
        estimates.wind,
    ]
    for one in series:
        if one is None or one.sigma is None:
            continue
        for index, name in enumerate(one.names):
            for multiple in (1, 2):
                share = coverage(one.error[:, index], one.sigma[:, index], multiple)
                yield f"coverage_{multiple}sigma_{name}", share


def _loss_rows(case: str, comparison: Comparison, gap: Gap) -> Iterator[Row]:
    """Position error at the end of a loss; of dead reckoning, what it grew by since the start."""
    for estimator, estimates in (
        (comparison.filter, comparison.nav),
        ("dead-reckoning", comparison.dead_reckoning),
    ):
        if estimates is None or estimates.position is None:
            continue
        error, time_us = estimates.position.error, estimates.time_us
        start = int(np.searchsorted(time_us, gap.start_us))
        last = int(np.searchsorted(time_us, gap.end_us)) - 1
        if not 0 <= start <= last:
            continue
        end = error[last] if estimator == comparison.filter else error[last] - error[start]
        if not np.isnan(end).any():
            yield {
                "case": loss_case(case, gap),
                "estimator": estimator,
                "metric": "position_final_m",
                "value": float(np.hypot(*end)),
            }


def _failures(rows: list[Row], comparison: Comparison) -> list[str]:
    failures = [
        f"{row['estimator']} {row['metric']} is {row['value']:.3g}, limit {row['limit']:g}"
        for row in rows
        if "limit" in row and not row["value"] <= row["limit"]
    ]
    if not any(row["estimator"] == "sahrs" and row["metric"] == "roll_rmse_deg" for row in rows):
        failures.append(f"SAHRS gave no valid attitude while {comparison.reference} was there")
    for channel, estimates in (("SAHRS", comparison.sahrs), ("NAV", comparison.nav)):
        if estimates is not None and estimates.broken:
            failures.append(f"{channel}: {estimates.broken} valid messages are not finite")
    return failures
