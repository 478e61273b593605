# SPDX-License-Identifier: Apache-2.0
"""What the study of SAHRS says: against the paper's requirement, our goals, and its own sigma."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from lodestar.evaluation import requirements
from lodestar.evaluation.score import Row
from lodestar.evaluation.summary import NONE, Table
from lodestar.studies.campaign import Result
from lodestar.studies.ensemble import Ensemble, mean_interval, nees_bounds, with_half
from lodestar.studies.findings import Findings, row
from lodestar.studies.sahrs import AXES, FORM_OF, FORMS, RECOVERY_S, WINDOWS

RMSE = tuple(f"{axis}_rmse_deg" for axis in AXES)
MAXIMA = tuple(f"{axis}_max_deg" for axis in AXES)
COVERED = {1: 0.68, 2: 0.95}
COVERAGE_TOLERANCE = 0.05
_DOF = 3


def findings(study: str, ensembles: Sequence[Ensemble]) -> Findings:
    """Rows and tables of the study."""
    makers = (_requirement, _goals, _errors, _hard, _consistency)
    tables = [make(ensembles) for make in makers]
    return Findings(
        study=study,
        title="SAHRS in simulated flights",
        runs=min(ensemble.runs for ensemble in ensembles),
        rows=[one for ensemble in ensembles for one in rows(ensemble)],
        tables=[table for table in tables if table.rows],
        notes=_notes(ensembles),
    )


def rows(ensemble: Ensemble) -> Iterator[Row]:
    """The rows of one cell.

    rmse is the mean over the flights with its 95 % interval, max the largest of all flights,
    violations the number of flights that broke the paper's requirement.
    """
    cell = ensemble.cell
    paper = requirements.paper(cell.case)
    goals = requirements.goals(cell.case, cell.estimator)
    limits = dict(paper) if _judged(ensemble) else {}
    limits |= {metric: must for metric, (must, _) in goals.items()}
    yield from _error_rows(ensemble, "", cell.case, paper, limits)
    if requirements.is_hard(cell.case):
        yield from _error_rows(ensemble, "during_", f"{cell.case}/during", paper, {})
        calm = requirements.CALM
        after = calm if _judged(ensemble) else {}
        yield from _error_rows(ensemble, "after_", f"{cell.case}/after", calm, after)
    most = 0 if _judged(ensemble) else None
    violations = int(np.sum(_violations(ensemble)))
    yield row(cell.case, cell.estimator, "violations", violations, reference=0, limit=most)
    for multiple in COVERED:
        for axis in AXES:
            metric = f"coverage_{multiple}sigma_{axis}"
            mean, *interval = mean_interval(ensemble.figure(metric))
            yield row(cell.case, cell.estimator, metric, mean, interval=(interval[0], interval[1]))
    mean = float(np.mean(ensemble.figure("nees_attitude")))
    bounds = nees_bounds(ensemble.runs, _DOF)
    yield row(cell.case, cell.estimator, "nees_attitude", mean, interval=bounds)
    largest = float(np.max(ensemble.figure("rotation_max_deg")))
    yield row(cell.case, cell.estimator, "rotation_max_deg", largest)
    share = float(np.mean(ensemble.figure("valid_share")))
    yield row(cell.case, cell.estimator, "valid_share", share)


def _error_rows(
    ensemble: Ensemble,
    window: str,
    case: str,
    reference: dict[str, float],
    limits: dict[str, float],
) -> Iterator[Row]:
    for metric in (*RMSE, *MAXIMA):
        values = ensemble.figure(window + metric)
        mean, low, high = mean_interval(values)
        is_mean = metric in RMSE
        yield row(
            case,
            ensemble.cell.estimator,
            metric,
            mean if is_mean else float(np.max(values)),
            interval=(low, high) if is_mean else None,
            reference=reference.get(metric),
            limit=limits.get(metric),
        )


def _judged(ensemble: Ensemble) -> bool:
    """Whether the paper's requirement is a limit here: for its own form in calm flight and air."""
    case, estimator = ensemble.cell.case, ensemble.cell.estimator
    return estimator == "sahrs" or requirements.is_calm(case)


def _violations(ensemble: Ensemble) -> list[bool]:
    """For each flight, whether it broke the paper's requirement anywhere."""
    case = ensemble.cell.case
    broken = [_breaks(result, requirements.paper(case)) for result in ensemble.results]
    if not requirements.is_hard(case):
        return broken
    after = [_breaks(result, requirements.CALM, "after_") for result in ensemble.results]
    return [any(both) for both in zip(broken, after, strict=True)]


def _breaks(result: Result, required: dict[str, float], window: str = "") -> bool:
    return any(not result.figures[window + metric] <= most for metric, most in required.items())


def _is_calm_in_turbulence(case: str) -> bool:
    return requirements.is_turbulent(case) and not requirements.is_hard(case)


# Name, whether a case belongs to it, what the paper requires there, and of which window.
_CLASSES: tuple[tuple[str, Callable[[str], bool], dict[str, float], str], ...] = (
    ("calm", requirements.is_calm, requirements.CALM, ""),
    ("calm, in turbulence", _is_calm_in_turbulence, requirements.CALM, ""),
    ("hard", requirements.is_hard, requirements.HARD, ""),
    ("after hard", requirements.is_hard, requirements.CALM, "after_"),
)


def _requirement(ensembles: Sequence[Ensemble]) -> Table:
    """The paper's requirement, which no single flight may break, beside the worst flight of all."""
    body: list[tuple[str, ...]] = []
    bad = set()
    for form in FORMS.values():
        for name, belongs, required, window in _CLASSES:
            members = [
                result
                for ensemble in ensembles
                if ensemble.cell.estimator == form.estimator and belongs(ensemble.cell.case)
                for result in ensemble.results
            ]
            if not members:
                continue
            cells = []
            for metrics in (RMSE, MAXIMA):
                figures = [[one.figures[window + metric] for one in members] for metric in metrics]
                largest = [float(np.max(one)) for one in figures]
                limits = [required.get(metric) for metric in metrics]
                cells += [_joined(limits, "g"), _joined(largest, ".2f")]
                if any(most and not v <= most for v, most in zip(largest, limits, strict=True)):
                    bad.add((len(body), len(cells) + 1))
            broken = sum(_breaks(one, required, window) for one in members)
            if broken:
                bad.add((len(body), len(cells) + 2))
            body.append((name, FORM_OF[form.estimator], *cells, f"{broken} of {len(members)}"))
    header = (
        "manoeuvring",
        "form",
        "rms limit, °",
        "largest rms, °",
        "never beyond, °",
        "worst, °",
        "flights that broke it",
    )
    title = f"The SAHRS paper's requirement of every flight ({' / '.join(AXES)})"
    return Table(title, header, body, frozenset(bad))


def _joined(values: Sequence[float | None], style: str) -> str:
    if not any(value is not None for value in values):
        return NONE
    return " / ".join(NONE if value is None else format(value, style) for value in values)


def _names(ensemble: Ensemble) -> tuple[str, str]:
    return ensemble.cell.case, FORM_OF[ensemble.cell.estimator]


def _errors(ensembles: Sequence[Ensemble]) -> Table:
    body, bad = [], set()
    for number, ensemble in enumerate(ensembles):
        paper = requirements.paper(ensemble.cell.case)
        cells = []
        for column, metric in enumerate((*RMSE, *MAXIMA), start=2):
            values = ensemble.figure(metric)
            cells.append(with_half(values) if metric in RMSE else f"{np.max(values):.2f}")
            if metric in paper and not np.max(values) <= paper[metric]:
                bad.add((number, column))
        body.append((*_names(ensemble), *cells))
    header = (
        "case",
        "form",
        *(f"{axis} rms, °" for axis in AXES),
        *(f"{axis} worst, °" for axis in AXES),
    )
    return Table("Errors of each case over all flights", header, body, frozenset(bad))


def _goals(ensembles: Sequence[Ensemble]) -> Table:
    body: list[tuple[str, ...]] = []
    bad = set()
    for ensemble in ensembles:
        goals = requirements.goals(ensemble.cell.case, ensemble.cell.estimator)
        if not goals:
            continue
        cells = []
        for column, metric in enumerate((*RMSE, *MAXIMA), start=1):
            if metric not in goals:
                cells.append(NONE)
                continue
            values = ensemble.figure(metric)
            value = float(np.mean(values) if metric in RMSE else np.max(values))
            must, stretch = goals[metric]
            cells.append(f"{value:.2f} ({must:g} / {stretch:g})")
            if not value <= must:
                bad.add((len(body), column))
        body.append((ensemble.cell.case, *cells))
    header = ("case", *(f"{axis} rms, °" for axis in AXES), *(f"{axis} worst, °" for axis in AXES))
    return Table("Velocity form and its goals (must / stretch)", header, body, frozenset(bad))


def _hard(ensembles: Sequence[Ensemble]) -> Table:
    body: list[tuple[str, ...]] = []
    bad = set()
    for ensemble in ensembles:
        if not requirements.is_hard(ensemble.cell.case):
            continue
        cells = []
        for window in WINDOWS:
            required = requirements.CALM if window == "after" else requirements.HARD
            for cell, over in errors_within(ensemble, window, required):
                cells.append(cell)
                if over:
                    bad.add((len(body), len(cells) + 1))
        body.append((*_names(ensemble), *cells))
    header = (
        "case",
        "form",
        "during: rms, °",
        "during: worst, °",
        "after: rms, °",
        "after: worst, °",
    )
    title = (
        f"Hard manoeuvring: during it, and from {RECOVERY_S:g} s after its end ({' / '.join(AXES)})"
    )
    return Table(title, header, body, frozenset(bad))


def errors_within(
    ensemble: Ensemble, window: str, limits: Mapping[str, float]
) -> Iterator[tuple[str, bool]]:
    """Rms, then worst, of the axes in a window, and whether one flight is over a limit."""
    for metrics, total in ((RMSE, np.mean), (MAXIMA, np.max)):
        values = {metric: ensemble.figure(f"{window}_{metric}") for metric in metrics}
        over = any(not np.max(v) <= limits.get(metric, np.inf) for metric, v in values.items())
        yield " / ".join(f"{total(one):.2f}" for one in values.values()), over


def _consistency(ensembles: Sequence[Ensemble]) -> Table:
    body, bad = [], set()
    for number, ensemble in enumerate(ensembles):
        nees = float(np.mean(ensemble.figure("nees_attitude")))
        low, high = nees_bounds(ensemble.runs, _DOF)
        if not low <= nees <= high:
            bad.add((number, 2))
        shares = []
        for column, (multiple, wanted) in enumerate(COVERED.items(), start=4):
            covered = [
                float(np.mean(ensemble.figure(f"coverage_{multiple}sigma_{axis}"))) for axis in AXES
            ]
            shares.append(" / ".join(f"{100 * share:.0f}" for share in covered))
            if any(not abs(share - wanted) <= COVERAGE_TOLERANCE for share in covered):
                bad.add((number, column))
        valid = f"{100 * np.mean(ensemble.figure('valid_share')):.1f}"
        largest = f"{np.max(ensemble.figure('rotation_max_deg')):.2f}"
        bounds = f"{low:.2f} to {high:.2f}"
        body.append((*_names(ensemble), f"{nees:.2f}", bounds, *shares, largest, valid))
    header = (
        "case",
        "form",
        "NEES / 3",
        "bounds (95 %)",
        "% in 1σ",
        "% in 2σ",
        "largest rotation, °",
        "% valid",
    )
    title = f"Consistency (about the body axes: {', '.join(AXES)})"
    return Table(title, header, body, frozenset(bad))


def _notes(ensembles: Sequence[Ensemble]) -> list[str]:
    runs = sorted({ensemble.runs for ensemble in ensembles})
    told = [
        "rms: mean over the flights with its 95 % interval; worst: the largest of all flights "
        "after the first 60 s. Red is over a limit: of ours (must) in the table of goals, of the "
        "paper elsewhere. Roll and heading do not count within 10° of the vertical, where "
        "they have no meaning; the largest rotation does.",
        "NEES / 3 is 1 where σ is the truth. It should lie within the bounds, 68 ± 5 % of the "
        "errors within 1σ, and 95 ± 5 % within 2σ.",
    ]
    if len(runs) > 1:
        told.append(f"Incomplete: the cases have {runs[0]} to {runs[-1]} flights.")
    return told
