# SPDX-License-Identifier: Apache-2.0
"""The track over a local map grid."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from lodestar import _core
from lodestar.evaluation import drawing
from lodestar.evaluation.metrics import Gap
from lodestar.evaluation.score import Score
from lodestar.recordings.recording import Channel, Recording

Array = NDArray[np.float64]
Times = NDArray[np.int64]

_POINTS = 6000
_TALLEST, _LOWEST = 9.0, 4.5  # inch


def track(recording: Recording, score: Score) -> Figure | None:
    """Reference and NAV tracks in degrees, undistorted, with a scale and the losses of GPS."""
    channel = recording[score.comparison.reference]
    used = channel["valid"] if "valid" in channel else np.ones(len(channel["lat"]), bool)
    lat, lon = channel["lat"][used], np.unwrap(channel["lon"][used])
    time_us = channel["time_us"][used]
    stretch = _stretch(lat, channel["h"][used])
    figure, axes = _map(lat, lon, stretch)
    name = "true" if score.comparison.reference == "TRUTH" else "INS"
    step = -(-len(lat) // _POINTS)
    axes.plot(*_degrees(lat[::step], lon[::step]), color=drawing.TRUE, lw=1.0, label=name, zorder=3)
    if "NAV" in recording:
        _nav_track(axes, recording["NAV"], time_us, float(np.mean(lon)))
    for index, gap in enumerate(score.comparison.gps_losses):
        _mark_loss(axes, gap, index, time_us, lat, lon)
    for place, marker, label in ((0, "o", "start"), (-1, "s", "end")):
        axes.plot(
            *_degrees(lat[place], lon[place]),
            marker,
            ms=7,
            mfc="white",
            mec=drawing.TRUE,
            mew=1.4,
            ls="none",
            label=label,
            zorder=5,
        )
    _scale_bar(axes, lat, stretch)
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), borderaxespad=0.5)
    return figure


def _stretch(lat: Array, h: Array) -> float:
    """Length of a degree of latitude over one of longitude."""
    middle, height = float(np.mean(lat)), float(np.mean(h))
    north = _core.meridian_radius(middle) + height
    return float(north / ((_core.transverse_radius(middle) + height) * np.cos(middle)))


def _map(lat: Array, lon: Array, stretch: float) -> tuple[Figure, Axes]:
    """An empty map about the track with a margin, its figure as tall as it needs to be."""
    south, north = np.rad2deg([lat.min(), lat.max()])
    west, east = np.rad2deg([lon.min(), lon.max()])
    margin = 0.08 * max(north - south, (east - west) / stretch, 1e-4)
    height = (drawing.WIDTH - 2.6) * (north - south + 2 * margin) * stretch
    height /= east - west + 2 * margin * stretch
    figure = Figure(
        figsize=(drawing.WIDTH, float(np.clip(height + 0.8, _LOWEST, _TALLEST))),
        layout="constrained",
    )
    axes = figure.subplots()
    axes.set_aspect(stretch)
    axes.set_xlim(west - margin * stretch, east + margin * stretch)
    axes.set_ylim(south - margin, north + margin)
    for axis, letters in ((axes.xaxis, "EW"), (axes.yaxis, "NS")):
        axis.set_major_locator(MaxNLocator(6, steps=[1, 2, 2.5, 5, 10]))
        axis.set_major_formatter(FuncFormatter(_degree_label(letters)))
    for spine in axes.spines.values():
        spine.set_visible(True)
    return figure, axes


def _degree_label(letters: str) -> Callable[[float, int | None], str]:
    def label(value: float, _: int | None = None) -> str:
        wrapped = (value + 180.0) % 360.0 - 180.0
        digits = f"{abs(wrapped):.4f}".rstrip("0").rstrip(".")
        return f"{digits}° {letters[0] if wrapped >= 0 else letters[1]}"

    return label


def _degrees(lat: Array, lon: Array) -> tuple[Array, Array]:
    return np.atleast_1d(np.rad2deg(lon)), np.atleast_1d(np.rad2deg(lat))


def _nav_track(axes: Axes, nav: Channel, reference_us: Times, near: float) -> None:
    shown = (
        nav["valid"] & (nav["time_us"] >= reference_us[0]) & (nav["time_us"] <= reference_us[-1])
    )
    lat = np.where(shown, nav["lat"], np.nan)
    lon = near + np.remainder(nav["lon"] - near + np.pi, 2 * np.pi) - np.pi
    step = -(-len(lat) // _POINTS)
    axes.plot(
        *_degrees(lat[::step], lon[::step]),
        color=drawing.AFTER,
        lw=2.6,
        alpha=0.45,
        label="NAV",
        zorder=2.5,
    )


def _mark_loss(axes: Axes, gap: Gap, index: int, time_us: Times, lat: Array, lon: Array) -> None:
    during = np.flatnonzero((time_us >= gap.start_us) & (time_us <= gap.end_us))
    if not len(during):
        return
    during = during[:: -(-len(during) // _POINTS)]
    axes.plot(
        *_degrees(lat[during], lon[during]),
        color=drawing.LOSS,
        lw=6.0,
        alpha=0.75,
        solid_capstyle="butt",
        label="GPS lost" if index == 0 else None,
        zorder=2,
    )


def _scale_bar(axes: Axes, lat: Array, stretch: float) -> None:
    """A bar of a round length, about a fifth of the width, in the lower left corner."""
    west, east = axes.get_xlim()
    south, north = axes.get_ylim()
    metre = np.rad2deg(1.0 / float(_core.meridian_radius(np.mean(lat)))) * stretch
    wanted = 0.2 * (east - west) / metre
    power = 10.0 ** np.floor(np.log10(wanted))
    length = max(step * power for step in (1, 2, 5) if step * power <= wanted)
    x, y = west + 0.04 * (east - west), south + 0.05 * (north - south)
    axes.plot(
        [x, x + length * metre], [y, y], color=drawing.TRUE, lw=3, solid_capstyle="butt", zorder=6
    )
    label = f"{length / 1000:g} km" if length >= 1000 else f"{length:g} m"
    axes.annotate(
        label,
        (x + 0.5 * length * metre, y),
        (0, 5),
        textcoords="offset points",
        ha="center",
        zorder=6,
    )
