# SPDX-License-Identifier: Apache-2.0
"""What a person is told of a score, for the terminal and the report alike."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lodestar.evaluation.metrics import Gap
from lodestar.evaluation.score import Row, Score, loss_case

NONE = "–"
_SINGLE_LOSSES = 3


@dataclass(frozen=True)
class Table:
    """A table of text: the first column names the row; ``bad`` holds the cells over a limit.

    ``wide``: the last column may break its lines.
    """

    title: str
    header: tuple[str, ...]
    rows: list[tuple[str, ...]]
    bad: frozenset[tuple[int, int]] = frozenset()
    wide: bool = False


# Name, metric stem, unit, estimator before and after correction.
_QUANTITIES = (
    ("roll", "roll_{}_deg", "°", "sahrs"),
    ("pitch", "pitch_{}_deg", "°", "sahrs"),
    ("heading", "heading_{}_deg", "°", "sahrs"),
    ("position", "position_{}_m", "m", "dead-reckoning"),
    ("wind N", "wind_north_{}_m_s", "m/s", "dead-reckoning"),
    ("wind E", "wind_east_{}_m_s", "m/s", "dead-reckoning"),
)


def headline(score: Score) -> str:
    """What was flown, in one line."""
    parts = [score.case]
    if score.seed is not None:
        parts.append(f"seed {score.seed}")
    parts.append(f"{score.duration_s:.0f} s")
    parts.append(f"compared with {score.comparison.reference}")
    if score.realtime_factor is not None:
        parts.append(f"{score.realtime_factor:.3g} × real time")
    return " · ".join(parts)


def verdict(score: Score) -> str:
    """Passed or failed, and why, in one line."""
    if not score.passed:
        return f"failed: {'; '.join(score.failures)}"
    if any("limit" in row for row in score.rows):
        return "passed: every limit was kept"
    return "passed: there was an answer; no limit applies"


def notes(score: Score) -> list[str]:
    """What the reader of the figures should know."""
    told = []
    comparison = score.comparison
    if any("reference" in row for row in score.rows):
        told.append(
            "Thesis: the figures of the Linköping thesis for this kind of flight. Its wind is what "
            "is missing between true and calculated velocity, not the same quantity."
        )
    if comparison.reference == "INS":
        told.append("The reference is the INS, itself an estimate; the limits do not apply to it.")
    for channel, estimates in (("SAHRS", comparison.sahrs), ("NAV", comparison.nav)):
        if estimates is None:
            told.append(f"There is no {channel} in the recording.")
        elif estimates.available < 0.9995:
            told.append(f"{channel} called {100 * estimates.available:.1f} % of its output valid.")
    shares = [
        [
            score.value("sahrs", f"coverage_{k}sigma_{axis}_axis")
            for axis in ("roll", "pitch", "yaw")
        ]
        for k in (1, 2)
    ]
    inside = [" / ".join(_percent(share) for share in known) for known in shares]
    if None not in (*shares[0], *shares[1]):
        told.append(
            f"SAHRS about the roll / pitch / yaw axis: {inside[0]} % within 1σ, "
            f"{inside[1]} % within 2σ."
        )
    return told


def error_table(score: Score) -> Table:
    """Errors before and after correction, their maxima, limits, and how well σ covers them."""
    figures = {(row["case"], row["estimator"], row["metric"]): row for row in score.rows}
    rows: list[tuple[str, ...]] = []
    bad: set[tuple[int, int]] = set()
    for name, stem, unit, before in _QUANTITIES:
        rmse, largest = stem.format("rmse"), stem.format("max")
        cells = [
            figures.get((score.case, estimator, metric))
            for metric in (rmse, largest)
            for estimator in (before, score.comparison.filter)
        ]
        if not any(cells):
            continue
        limits = [_limit(cell) for cell in (cells[0], cells[2])]
        both = limits != [NONE, NONE]
        for column, cell in enumerate(cells, start=1):
            if cell and "limit" in cell and not cell["value"] <= cell["limit"]:
                bad.add((len(rows), column))
        rows.append(
            (
                f"{name}, {unit}",
                *(_number(cell["value"]) if cell else NONE for cell in cells),
                "/".join(limits) if both else NONE,
                _coverage(score, stem, 1),
                _coverage(score, stem, 2),
                _published(cells[0], cells[1]),
            )
        )
    header = (
        "error",
        "rmse before",
        "rmse after",
        "max before",
        "max after",
        "limit rmse/max",
        "% in 1σ",
        "% in 2σ",
        "thesis rmse",
    )
    # Limits and published figures exist for some flights only; they stand last.
    told = [i for i, _ in enumerate(header) if i < 5 or any(row[i] != NONE for row in rows)]
    return Table(
        "Errors before and after correction",
        tuple(header[i] for i in told),
        [tuple(row[i] for i in told) for row in rows],
        frozenset(bad),
    )


def loss_table(score: Score) -> Table | None:
    """Errors at the end of the losses of GPS; losses of one length are summed up when many."""
    groups: dict[str, list[Gap]] = {}
    for gap in score.comparison.gps_losses:
        groups.setdefault(f"{gap.duration_s:.0f}", []).append(gap)
    rows: list[tuple[str, ...]] = []
    for duration, gaps in groups.items():
        ends = {
            estimator: [
                value
                for gap in gaps
                for value in [
                    score.value(estimator, "position_final_m", loss_case(score.case, gap))
                ]
                if value is not None
            ]
            for estimator in (score.comparison.filter, "dead-reckoning")
        }
        if len(gaps) > _SINGLE_LOSSES:
            when = f"{len(gaps)} times"
            told = [_mean_and_max(values) for values in ends.values()]
            rows.append((when, duration, *told))
            continue
        for index, gap in enumerate(gaps):
            told = [
                _number(values[index]) if len(values) == len(gaps) else NONE
                for values in ends.values()
            ]
            rows.append((f"at {gap.start_us * 1e-6:.0f} s", duration, *told))
    if not rows:
        return None
    header = ("GPS lost", "for, s", "NAV error at the end, m", "dead reckoning grew by, m")
    return Table("Losses of GPS", header, rows)


def _limit(row: Row | None) -> str:
    return f"{row['limit']:g}" if row and "limit" in row else NONE


def _published(before: Row | None, after: Row | None) -> str:
    figures = [f"{row['reference']:.2f}" for row in (before, after) if row and "reference" in row]
    return " → ".join(figures) or NONE


def _coverage(score: Score, stem: str, multiple: int) -> str:
    """Share within sigma of a quantity after correction; of position, over both axes."""
    quantity = stem.split("_{}")[0]
    axes = [f"{quantity}_north", f"{quantity}_east"] if quantity == "position" else [quantity]
    shares = [
        score.value(score.comparison.filter, f"coverage_{multiple}sigma_{axis}") for axis in axes
    ]
    known = [share for share in shares if share is not None]
    return _percent(float(np.mean(known))) if known else NONE


def _percent(share: float | None) -> str:
    return NONE if share is None else f"{100 * share:.0f}"


def _mean_and_max(values: list[float]) -> str:
    if not values:
        return NONE
    return f"{_number(float(np.mean(values)))} (worst {_number(max(values))})"


def _number(value: float) -> str:
    """Two digits after the point for what is small, none for what is large."""
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.2f}"
