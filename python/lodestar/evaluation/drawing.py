# SPDX-License-Identifier: Apache-2.0
"""One style for all plots, and the pieces they are made of.

Colours are of the Okabe-Ito set, which the colour-blind can tell apart.
"""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from lodestar.errors import InputError
from lodestar.evaluation.comparison import Series, reference_at
from lodestar.evaluation.metrics import Gap, north_east_m
from lodestar.recordings.recording import Channel, Recording

Array = NDArray[np.float64]
Times = NDArray[np.int64]

TRUE = "#222222"
BEFORE = "#D55E00"  # vermillion
AFTER = "#0072B2"  # blue
GPS = "#8C8C8C"
LOSS = "#E69F00"  # orange
REFUSED = "#CC79A7"  # reddish purple
GOOD = "#009E73"  # bluish green
PALETTE = (AFTER, LOSS, GOOD, REFUSED, "#56B4E9", BEFORE, "#7A7A7A", TRUE)

DEGREES = 180.0 / np.pi
WIDTH = 10.0  # inch
_POINTS = 1500
_DAY_US = 86_400_000_000

STYLE: dict[Any, Any] = {
    "figure.dpi": 100,
    "savefig.dpi": 144,
    "figure.facecolor": "white",
    "font.size": 10,
    "font.family": "sans-serif",
    "axes.edgecolor": "#9A9A9A",
    "axes.labelcolor": "#333333",
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#E6E6E6",
    "grid.linewidth": 0.8,
    "xtick.color": "#555555",
    "ytick.color": "#555555",
    "lines.linewidth": 1.1,
    "lines.solid_joinstyle": "round",
    "legend.frameon": False,
    "legend.fontsize": 9.5,
    "path.simplify_threshold": 0.2,
}


def png(figure: Figure) -> bytes:
    """The figure as PNG; the same figure gives the same bytes."""
    buffer = io.BytesIO()
    # Without the version of the writer.
    figure.savefig(buffer, format="png", metadata={"Software": None})
    return buffer.getvalue()


def write_images(images: Mapping[str, bytes], folder: Path) -> list[Path]:
    """Write PNG images by name into a folder, which is made; returns their paths.

    Raises InputError when they cannot be written.
    """
    paths = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name, image in images.items():
            paths.append(folder / f"{name}.png")
            paths[-1].write_bytes(image)
    except OSError as error:
        raise InputError(f"{folder}: {error.strerror}") from None
    return paths


def panels(labels: Sequence[str], height: float = 1.9) -> tuple[Figure, list[Axes]]:
    """A column of panels over one time axis, each with its label."""
    figure = Figure(figsize=(WIDTH, height * len(labels) + 0.7), layout="constrained")
    axes = list(figure.subplots(len(labels), 1, sharex=True, squeeze=False)[:, 0])
    for one, label in zip(axes, labels, strict=True):
        one.set_ylabel(label)
        one.margins(x=0.01)
    return figure, axes


def seconds(time_us: Times) -> Array:
    """Flight time in s; a time base that is a date counts from its first message."""
    origin = int(time_us[0]) if len(time_us) and abs(int(time_us[0])) > _DAY_US else 0
    return np.asarray((time_us - origin) * 1e-6, np.float64)


def envelope(t: Array, values: Array) -> tuple[Array, Array]:
    """At most a few thousand points that draw like all: least and largest of each stretch of time.

    NaN is kept where a whole stretch is NaN, so that gaps stay gaps.
    """
    stretch = -(-len(t) // _POINTS)
    if stretch <= 2:
        return t, values
    pad = -len(t) % stretch
    table = np.pad(values, (0, pad), mode="edge").reshape(-1, stretch)
    empty = np.isnan(table).all(axis=1)
    rows = np.arange(len(table))
    low = np.argmin(np.where(np.isnan(table), np.inf, table), axis=1)
    high = np.argmax(np.where(np.isnan(table), -np.inf, table), axis=1)
    places = np.sort(np.column_stack([low, high]), axis=1)
    picked = np.minimum((rows[:, None] * stretch + places).ravel(), len(t) - 1)
    drawn = values[picked].astype(float)
    drawn[np.repeat(empty, 2)] = np.nan
    return t[picked], drawn


def thin(t: Array, *columns: Array) -> list[Array]:
    """Every n-th sample, for what is smooth."""
    step = -(-len(t) // _POINTS)
    return [one[::step] for one in (t, *columns)]


def lines(
    axes: list[Axes], time_us: Times, values: Array, label: str, colour: str, width: float = 1.1
) -> None:
    """One line per panel of the columns of ``values``."""
    t = seconds(time_us)
    for one, column in zip(axes, values.T, strict=True):
        one.plot(*envelope(t, column), color=colour, lw=width, label=label)


def sigma_bands(axes: list[Axes], time_us: Times, series: Series, scale: float) -> None:
    """Bands of one and three sigma about zero, where there is an error to judge."""
    if series.sigma is None:
        return
    sigma = np.where(np.isnan(series.error), np.nan, scale * series.sigma)
    estimate_bands(axes, time_us, np.zeros_like(sigma), sigma)


def estimate_bands(axes: list[Axes], time_us: Times, centre: Array, sigma: Array) -> None:
    """Bands of one and three sigma about an estimate."""
    t = seconds(time_us)
    for one, middle, spread in zip(axes, centre.T, sigma.T, strict=True):
        at, c, s = thin(t, middle, spread)
        one.fill_between(at, c - 3 * s, c + 3 * s, color=AFTER, alpha=0.10, lw=0, label="±3σ")
        one.fill_between(at, c - s, c + s, color=AFTER, alpha=0.18, lw=0, label="±σ")


def dots(axes: list[Axes], time_us: Times, values: Array, label: str) -> None:
    """Faint single samples, one panel per column."""
    t = seconds(time_us)
    for one, column in zip(axes, values.T, strict=True):
        one.plot(t, column, ".", ms=2.0, color=GPS, alpha=0.55, mew=0, label=label, zorder=1.5)


def losses(axes: list[Axes], gaps: Sequence[Gap]) -> None:
    """Shade the losses of GPS."""
    for one in axes:
        for index, gap in enumerate(gaps):
            start, end = seconds(np.array([gap.start_us, gap.end_us]))
            label = "GPS lost" if index == 0 else None
            one.axvspan(start, end, color=LOSS, alpha=0.25, lw=0, label=label, zorder=1.4)


def scale_by(one: Axes, values: Array, least: float = 0.0) -> None:
    """Scale y about zero by the bulk of the errors, and so that ``least`` is seen."""
    known = np.abs(values[np.isfinite(values)])
    if len(known):
        limit = max(1.3 * float(np.percentile(known, 99.5)), least, 1e-9)
        one.set_ylim(-limit, limit)


def titled(figure: Figure, axes: list[Axes]) -> Figure:
    """The time axis, and one legend for all panels: lines first, then bands."""
    axes[-1].set_xlabel("flight time, s")
    entries: dict[str, Any] = {}
    for one in axes:
        for handle, label in zip(*one.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    labels = sorted(entries, key=lambda label: not isinstance(entries[label], Line2D))
    figure.legend(
        [entries[label] for label in labels],
        labels,
        loc="outside upper right",
        ncols=len(labels),
        markerscale=2.5,
    )
    figure.align_ylabels(axes)
    return figure


def valid_only(channel: Channel, values: Array) -> Array:
    """The values with NaN in the rows whose message is not valid."""
    return np.where(channel["valid"][:, None], values, np.nan)


def gps_errors(recording: Recording, reference: str) -> tuple[Times, Array] | None:
    """Times and errors (north, east, m) of the GPS fixes against the reference channel."""
    if "GPS" not in recording:
        return None
    gps = recording["GPS"]
    at = reference_at(recording, reference, gps["time_us"])
    return gps["time_us"], north_east_m(gps["lat"], gps["lon"], at.lat, at.lon, at.h)
