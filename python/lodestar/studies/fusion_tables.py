# SPDX-License-Identifier: Apache-2.0
"""Tables of the study of navigation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from lodestar.evaluation.fusion_requirements import OVER_LIMIT, THESIS, THESIS_GPS_M
from lodestar.evaluation.summary import NONE, Table
from lodestar.studies.ensemble import Ensemble, nees_bounds, with_half
from lodestar.studies.fusion_book import (
    HEADING,
    NEES,
    Book,
    goals_of,
    grade,
    is_consistent,
    rms,
    scenario_of,
)
from lodestar.studies.fusion_score import AXES
from lodestar.studies.fusion_setups import BEFORE, FILTERS, LIMIT, told
from lodestar.studies.sahrs_findings import COVERAGE_TOLERANCE, COVERED

Array = NDArray[np.float64]

_QUANTITIES = (
    (HEADING, "heading, °"),
    ("wind_north_rmse_m_s", "wind N, m/s"),
    ("wind_east_rmse_m_s", "wind E, m/s"),
    ("end_120s_m", "after 120 s, m"),
    ("end_300s_m", "after 300 s, m"),
)


def heading(book: Book) -> Table:
    """The thesis's figures of heading beside ours."""
    body: list[tuple[str, ...]] = []
    for case in book.cases:
        if scenario_of(case) not in THESIS:
            continue
        setups = [book.of(case, name) for name in ("cascade", *(setup.name for setup in BEFORE))]
        first, integrated = setups[0] or book.of(case, "integrated"), book.of(case, "integrated")
        limit = book.limit(case)
        ratio = book.over_limit(integrated) if integrated else None
        before, after = THESIS[scenario_of(case)]["heading"]
        body.append(
            (
                case,
                f"{before:.2f} → {after:.2f}",
                *(_mean(one, "before_" + HEADING) for one in (first, *setups[1:])),
                *(_mean(one, HEADING) for one in (*setups, integrated)),
                _number(limit, ".3f"),
                _number(ratio),
            )
        )
    header = (
        "case",
        "thesis",
        *(f"before: {form}" for form in ("velocity", "paper", "thesis-like")),
        *(f"cascade behind {form}" for form in ("velocity", "paper", "thesis-like")),
        "integrated",
        "limit",
        "integrated / limit",
    )
    return Table("Heading, rms in °: the thesis's figures beside ours", header, body)


def velocity(book: Book) -> Table:
    """The thesis's wind: what is missing between true and calculated velocity."""
    body: list[tuple[str, ...]] = []
    for case in book.cases:
        published = THESIS.get(scenario_of(case))
        if published is None:
            continue
        filters = [book.of(case, name) for name in FILTERS]
        first = filters[0] or filters[1]
        cells = []
        for axis in AXES:
            before, after = published[f"wind_{axis}"]
            metric = f"velocity_{axis}_rmse_m_s"
            cells.append(f"{before:.2f} → {after:.2f}")
            cells.append(_mean(first, f"before_{metric}"))
            cells += [_mean(one, metric) for one in filters]
        body.append((case, *cells))
    columns = ("thesis", "before", *FILTERS)
    header = ("case", *(f"{axis}: {name}" for axis in "NE" for name in columns))
    title = "The thesis's wind (true minus calculated ground velocity), rms in m/s"
    return Table(title, header, body)


def wind_and_position(book: Book) -> Table:
    """Errors against the true wind, and how much of the error of GPS itself is corrected."""
    body: list[tuple[str, ...]] = []
    for one in book.filters():
        gps = [rms(one.figure(f"gps_{axis}_rmse_m")) for axis in AXES]
        ours = [rms(one.figure(f"aided_position_{axis}_rmse_m")) for axis in AXES]
        body.append(
            (
                one.cell.case,
                one.cell.estimator,
                *(_mean(one, f"wind_{axis}_rmse_m_s") for axis in AXES),
                " / ".join(f"{value:.2f}" for value in gps),
                " / ".join(f"{value:.2f}" for value in ours),
                " / ".join(f"{a / b:.3f}" for a, b in zip(ours, gps, strict=True)),
                *(_mean(one, f"position_{axis}_rmse_m", ".1f") for axis in AXES),
            )
        )
    header = (
        "case",
        "filter",
        "wind N, m/s",
        "wind E, m/s",
        "GPS itself N / E, m",
        "corrected N / E, m",
        "corrected / GPS",
        "all flight N, m",
        "all flight E, m",
    )
    before, after = THESIS_GPS_M
    title = (
        "Error of wind, and position with GPS and over the flight (the thesis, latitude: "
        f"{before:.2f} → {after:.2f} m, {after / before:.3f})"
    )
    return Table(title, header, body)


def verdicts(book: Book) -> Table:
    """Ours: value (must / stretch) of every cell with a goal, and what it comes to."""
    body: list[tuple[str, ...]] = []
    bad = set()
    for one in book.filters():
        wanted = goals_of(one)
        if not wanted:
            continue
        cells = [one.cell.case, one.cell.estimator]
        grades = []
        for metric, _ in _QUANTITIES:
            if metric not in wanted:
                cells.append(NONE)
                continue
            value = float(np.mean(one.figure(metric)))
            must, stretch = wanted[metric]
            cells.append(f"{value:.3g} ({must:g} / {stretch:g})")
            grades.append((len(cells) - 1, grade(value, must, stretch)))
        ratio = book.over_limit(one) if one.cell.estimator == LIMIT.filter else None
        cells.append(_number(ratio))
        if ratio is not None:
            grades.append((len(cells) - 1, grade(ratio, *OVER_LIMIT)))
        for metric in NEES:
            cells.append(f"{np.mean(one.figure(metric)):.2f}")
            if not is_consistent(one, metric):
                bad.add((len(body), len(cells) - 1))
        bad |= {(len(body), column) for column, reached in grades if reached == "missed"}
        honest = all(is_consistent(one, metric) for metric in NEES)
        cells.append(_worst([reached for _, reached in grades]) + ("" if honest else ", σ wrong"))
        if "missed" in cells[-1] or not honest:
            bad.add((len(body), len(cells) - 1))
        body.append(tuple(cells))
    header = (
        "case",
        "filter",
        *(name for _, name in _QUANTITIES),
        "heading / limit",
        "NEES heading",
        "NEES wind / 2",
        "reached",
    )
    return Table("Ours: value (must / stretch)", header, body, frozenset(bad))


def _worst(grades: Sequence[str]) -> str:
    return next(one for one in ("missed", "must", "stretch") if one in grades)


def consistency(book: Book) -> Table:
    """Whether sigma tells the truth. HPL: horizontal protection level."""
    names = ("heading", *(f"{what}_{axis}" for what in ("wind", "position") for axis in AXES))
    body: list[tuple[str, ...]] = []
    bad = set()
    for one in book.filters():
        cells = [one.cell.case, one.cell.estimator]
        for metric in NEES:
            cells.append(f"{np.mean(one.figure(metric)):.2f}")
            if not is_consistent(one, metric):
                bad.add((len(body), len(cells) - 1))
        for multiple, wanted in COVERED.items():
            shares = [
                float(np.mean(one.figure(f"coverage_{multiple}sigma_{name}"))) for name in names
            ]
            cells.append(" / ".join(f"{100 * share:.0f}" for share in shares))
            if any(not abs(share - wanted) <= COVERAGE_TOLERANCE for share in shares):
                bad.add((len(body), len(cells) - 1))
        valid = 100 * np.mean(one.figure("valid_share"))
        hours = float(np.sum(one.figure("protected_h")))
        beyond = int(np.sum(one.figure("beyond_protection_h") > 0))
        if hours and beyond:
            bad.add((len(body), len(cells) + 1))
        cells += [f"{valid:.1f}", f"{beyond} of {one.runs}, in {hours:.1f} h" if hours else NONE]
        body.append(tuple(cells))
    header = (
        "case",
        "filter",
        "NEES heading",
        "NEES wind / 2",
        "% in 1σ",
        "% in 2σ",
        "% valid",
        "flights beyond HPL",
    )
    runs = min((one.runs for one in book.filters()), default=1)
    bounds = [nees_bounds(runs, size) for size in NEES.values()]
    told_bounds = " and ".join(f"{low:.2f} to {high:.2f}" for low, high in bounds)
    title = (
        f"Consistency: NEES, which should be {told_bounds}, and % of heading / wind N / wind E / "
        "position N / position E"
    )
    return Table(title, header, body, frozenset(bad))


def options(book: Book) -> Table:
    """Other configurations beside the shipped one, on the same seeds."""
    body: list[tuple[str, ...]] = []
    for case in book.cases:
        for name in FILTERS:
            shipped = book.of(case, name)
            others = [
                one
                for one in book.ensembles
                if one.cell.case == case and one.cell.estimator.startswith(f"{name}:")
            ]
            if not others or shipped is None:
                continue
            seeds = set.intersection(*({r.seed for r in one.results} for one in others))
            same = Ensemble(shipped.cell, tuple(r for r in shipped.results if r.seed in seeds))
            for one in (same, *others):
                what = told(one.cell.estimator) if one is not same else "as shipped"
                body.append((case, name, *_compared(one), what))
    header = (
        "case",
        "filter",
        "flights",
        "heading, °",
        "NEES",
        "wind N / E, m/s",
        "NEES / 2",
        "roll / pitch, °",
        "position with GPS, m",
        "configuration",
    )
    return Table("What the options and the states are worth", header, body, wide=True)


def _compared(one: Ensemble) -> tuple[str, ...]:
    mean = {name: float(np.mean(values)) for name, values in _figures(one).items()}
    position = float(
        np.hypot(mean["aided_position_north_rmse_m"], mean["aided_position_east_rmse_m"])
    )
    return (
        str(one.runs),
        f"{mean[HEADING]:.3f}",
        f"{mean['nees_heading']:.2f}",
        " / ".join(f"{mean[f'wind_{axis}_rmse_m_s']:.2f}" for axis in AXES),
        f"{mean['nees_wind']:.2f}",
        " / ".join(f"{mean[f'{axis}_rmse_deg']:.3f}" for axis in ("roll", "pitch")),
        f"{position:.2f}",
    )


def _figures(one: Ensemble) -> dict[str, Array]:
    return {name: one.figure(name) for name in one.results[0].figures}


def _mean(ensemble: Ensemble | None, metric: str, style: str = ".2f") -> str:
    return NONE if ensemble is None else with_half(ensemble.figure(metric), style)


def _number(value: float | None, style: str = ".2f") -> str:
    return NONE if value is None else format(value, style)
