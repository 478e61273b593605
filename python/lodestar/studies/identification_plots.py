# SPDX-License-Identifier: Apache-2.0
"""Plots of an identification, as in the thesis's appendix B: errors, residuals, correlations."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from lodestar.evaluation import drawing
from lodestar.studies.identification import ANGLES, ErrorSeries, Identification
from lodestar.studies.innovations_model import CONFIDENCE, LAGS, Residuals


def write_plots(found: Identification, folder: Path) -> list[Path]:
    """Write the plots as PNG; returns their paths. Raises InputError where it cannot."""
    with mpl.rc_context(drawing.STYLE):
        figures = {
            "errors": _errors(found),
            "residuals": _residuals([one.own for one in found.angles], found.flight),
            "autocorrelation": _autocorrelation(found),
        }
        if found.validated_on is not None:
            others = [one.validation for one in found.angles if one.validation is not None]
            figures["validation-residuals"] = _residuals(others, found.validated_on)
        images = {name: drawing.png(figure) for name, figure in figures.items()}
    return drawing.write_images(images, folder)


def _errors(found: Identification) -> Figure:
    figure, axes = drawing.panels([f"{angle} error, °" for angle in ANGLES])
    flights = [(found.flight, drawing.AFTER)]
    if found.validated_on is not None:
        flights.append((found.validated_on, drawing.LOSS))
    for flight, colour in flights:
        values = np.rad2deg(np.column_stack([flight.errors[angle] for angle in ANGLES]))
        drawing.lines(axes, flight.time_us, values, flight.flight, colour)
    return drawing.titled(figure, axes)


def _residuals(left: list[Residuals], flight: ErrorSeries) -> Figure:
    figure, axes = drawing.panels([f"{angle} residual, °" for angle in ANGLES])
    values = np.rad2deg(np.column_stack([one.values for one in left]))
    drawing.lines(axes, flight.time_us, values, flight.flight, drawing.AFTER, 0.7)
    return drawing.titled(figure, axes)


def _autocorrelation(found: Identification) -> Figure:
    figure, axes = drawing.panels([f"{angle} residual" for angle in ANGLES], height=2.2)
    lags = found.flight.interval_s * np.arange(1, LAGS + 1)
    for one, axis in zip(found.angles, axes, strict=True):
        axis.fill_between(
            lags,
            -one.own.bounds,
            one.own.bounds,
            color=drawing.AFTER,
            alpha=0.18,
            lw=0,
            label=f"{100 * CONFIDENCE:.0f} % if white",
        )
        axis.axhline(0.0, color=drawing.TRUE, lw=0.6)
        axis.plot(lags, one.own.autocorrelation, "o", color=drawing.AFTER, ms=4, label="own flight")
        if one.validation is not None:
            correlation = one.validation.autocorrelation
            axis.plot(lags, correlation, "s", color=drawing.LOSS, ms=4, label="other flight")
    drawing.titled(figure, axes)
    axes[-1].set_xlabel("lag, s")
    return figure
