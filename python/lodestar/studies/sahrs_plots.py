# SPDX-License-Identifier: Apache-2.0
"""Plots of the study of SAHRS."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from lodestar.evaluation import drawing
from lodestar.studies.ensemble import Ensemble, nees_bounds
from lodestar.studies.findings import Plot
from lodestar.studies.sahrs import AXES, FORMS
from lodestar.studies.sahrs_findings import COVERAGE_TOLERANCE, COVERED, RMSE

Array = NDArray[np.float64]

_SHOWN = 25  # flights drawn one by one
_COLOURS = dict(
    zip([f.estimator for f in FORMS.values()], (drawing.AFTER, drawing.BEFORE), strict=True)
)
_NAMES = {form.estimator: f"{name} form" for name, form in FORMS.items()}


def plots(ensembles: Sequence[Ensemble]) -> list[Plot]:
    """Box plots of the rms, the coverage, and the errors of every cell over time."""
    with mpl.rc_context(drawing.STYLE):
        made = [
            Plot(
                "rms",
                "Error by case",
                "Each box holds the middle half of the flights' rms, its whiskers all of them.",
                _boxes(ensembles),
            ),
            Plot(
                "coverage",
                "Errors within σ",
                "Share of the errors about the body axes within 1σ and 2σ, the mean over the "
                "flights. The bands are 68 ± 5 % and 95 ± 5 %.",
                _coverage(ensembles),
            ),
        ]
        for ensemble in ensembles:
            cell = ensemble.cell
            name = f"errors-{cell.case.replace('/', '-')}-{cell.estimator}"
            title = f"{cell.case}, {_NAMES[cell.estimator]}"
            made.append(Plot(name, title, _CAPTION, _errors_in_time(ensemble)))
    return made


_CAPTION = (
    "Errors about the body axes: single flights, and the rms over all flights on both sides of "
    "zero, which should keep to the edge of the ±σ band. Below, NEES / 3 over all flights with the "
    "bounds that hold 95 % of the time for a consistent filter."
)


def _errors_in_time(ensemble: Ensemble) -> Figure:
    figure, axes = drawing.panels(("roll axis, °", "pitch axis, °", "yaw axis, °", "NEES / 3"))
    time = ensemble.series("time_s")[0]
    squares, known = np.zeros((ensemble.runs, len(time))), np.ones(len(time), bool)
    for one, axis in zip(axes, AXES, strict=False):
        error = ensemble.series(f"error_{axis}_deg")
        sigma = ensemble.series(f"sigma_{axis}_deg")
        stated, actual = _rms(np.where(np.isnan(error), np.nan, sigma)), _rms(error)
        for width, alpha, label in ((3, 0.10, "±3σ"), (1, 0.18, "±σ")):
            edge = width * stated
            one.fill_between(time, -edge, edge, color=drawing.AFTER, alpha=alpha, lw=0, label=label)
        one.plot(time, error[:_SHOWN].T, color=drawing.GPS, lw=0.4, alpha=0.6)
        one.plot([], [], color=drawing.GPS, lw=0.8, label="single flights")
        one.plot(time, actual, color=drawing.BEFORE, lw=1.3, label="rms of all flights")
        one.plot(time, -actual, color=drawing.BEFORE, lw=1.3)
        drawing.scale_by(one, error, 3.3 * float(np.nanmedian(stated)))
        squares += (error / sigma) ** 2 / len(AXES)
        known &= np.isfinite(stated)
    below = axes[-1]
    nees = np.full(len(time), np.nan)
    nees[known] = np.nanmean(squares[:, known], axis=0)
    low, high = nees_bounds(ensemble.runs, len(AXES))
    below.axhspan(low, high, color=drawing.GOOD, alpha=0.25, lw=0, label="95 % bounds of NEES")
    below.plot(time, nees, color=drawing.TRUE, lw=0.9)
    below.set_yscale("log")
    return drawing.titled(figure, axes)


def _rms(values: Array) -> Array:
    """Over the flights, at every time; NaN where no flight has a value."""
    count = np.sum(np.isfinite(values), axis=0)
    mean = np.nansum(values**2, axis=0) / np.maximum(count, 1)
    return np.where(count > 0, np.sqrt(mean), np.nan)


def _boxes(ensembles: Sequence[Ensemble]) -> Figure:
    figure, axes, places = _by_case(ensembles, [f"{axis} rms, °" for axis in AXES])
    for one, metric in zip(axes, RMSE, strict=True):
        for ensemble, place in zip(ensembles, places, strict=True):
            colour = _COLOURS[ensemble.cell.estimator]
            one.boxplot(
                [ensemble.figure(metric)],
                positions=[place],
                orientation="horizontal",
                widths=0.3,
                whis=(0, 100),
                patch_artist=True,
                manage_ticks=False,
                boxprops={"facecolor": colour, "alpha": 0.35, "edgecolor": colour},
                medianprops={"color": colour, "lw": 1.6},
                whiskerprops={"color": colour},
                capprops={"color": colour},
            )
        one.set_xlim(left=0)
    return figure


def _coverage(ensembles: Sequence[Ensemble]) -> Figure:
    figure, axes, places = _by_case(
        ensembles, [f"{axis} axis, %" for axis in ("roll", "pitch", "yaw")]
    )
    for one, axis in zip(axes, AXES, strict=True):
        for multiple, wanted in COVERED.items():
            edges = 100 * (wanted - COVERAGE_TOLERANCE), 100 * (wanted + COVERAGE_TOLERANCE)
            one.axvspan(*edges, color=drawing.GOOD, alpha=0.18, lw=0)
            for ensemble, place in zip(ensembles, places, strict=True):
                share = np.mean(ensemble.figure(f"coverage_{multiple}sigma_{axis}"))
                marker = "o" if multiple == 1 else "D"
                one.plot(100 * share, place, marker, color=_COLOURS[ensemble.cell.estimator], ms=5)
        one.set_xlim(0, 102)
        one.set_title("● within 1σ   ◆ within 2σ", fontsize=9, loc="left")
    return figure


def _by_case(
    ensembles: Sequence[Ensemble], labels: Sequence[str]
) -> tuple[Figure, list[Axes], list[float]]:
    """Panels side by side with a line for each case, and the place of each cell on it."""
    cases = list(dict.fromkeys(ensemble.cell.case for ensemble in ensembles))
    present = [e for e in _COLOURS if any(one.cell.estimator == e for one in ensembles)]
    height = 0.45 * len(cases) + 1.5
    figure = Figure(figsize=(drawing.WIDTH, height), layout="constrained")
    axes = list(figure.subplots(1, len(labels), sharey=True, squeeze=False)[0])
    for one, label in zip(axes, labels, strict=True):
        one.set_xlabel(label)
    axes[0].set_yticks(range(len(cases)), cases)
    axes[0].set_ylim(len(cases) - 0.5, -0.5)
    shift = {e: 0.36 * (k - (len(present) - 1) / 2) for k, e in enumerate(present)}
    handles = [Line2D([], [], color=_COLOURS[e], lw=5, alpha=0.6) for e in present]
    figure.legend(handles, [_NAMES[e] for e in present], loc="outside upper right", ncols=2)
    places = [cases.index(one.cell.case) + shift[one.cell.estimator] for one in ensembles]
    return figure, axes, places
