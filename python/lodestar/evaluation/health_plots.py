# SPDX-License-Identifier: Apache-2.0
"""Plots of what the flight computer says of itself: innovations, modes, rejections."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from lodestar.channels import INPUTS
from lodestar.evaluation import drawing
from lodestar.evaluation.score import Score
from lodestar.recordings.recording import Channel, Recording

Array = NDArray[np.float64]

# As lcm_types/health_t.lcm has them.
REASONS = (
    "size",
    "fingerprint",
    "decode",
    "not finite",
    "out of range",
    "time backwards",
    "late",
    "future",
    "stuck",
    "invalid",
    "queue full",
    "gate",
)
_SAHRS_INNOVATIONS = {
    0: (
        ("field x, nT", 1.0),
        ("field y, nT", 1.0),
        ("field z, nT", 1.0),
        ("airspeed, m/s", 1.0),
        ("alpha, deg", drawing.DEGREES),
        ("beta, deg", drawing.DEGREES),
        ("baro altitude, m", 1.0),
    ),
    1: (
        ("field north, nT", 1.0),
        ("field east, nT", 1.0),
        ("field down, nT", 1.0),
        ("pitch, deg", drawing.DEGREES),
        ("roll, deg", drawing.DEGREES),
        ("", 1.0),
        ("", 1.0),
    ),
}
_NAV_INNOVATIONS = (("GPS north, m", 1.0), ("GPS east, m", 1.0))
SAHRS_MODES = ("waiting", "aligning", "running", "coasting", "re-aligning")
NAV_MODES = ("waiting", "aiding", "dead reckoning", "re-acquiring")
_MOST_SERIES = 6
_MANY = 1000


def innovations(recording: Recording, score: Score) -> Figure | None:
    """Innovations once a second with one and three of their sigma."""
    if "HEALTH" not in recording:
        return None
    health = recording["HEALTH"]
    rows = (*_SAHRS_INNOVATIONS[int(health["sahrs_form"][-1])], *_NAV_INNOVATIONS)
    shown = [i for i in range(len(rows)) if (health["innovation_sigma"][:, i] > 0).any()]
    if not shown:
        return None
    figure, axes = drawing.panels([rows[i][0] for i in shown], height=1.35)
    t = drawing.seconds(health["time_us"])
    for one, index in zip(axes, shown, strict=True):
        scale = rows[index][1]
        sigma = scale * health["innovation_sigma"][:, index]
        value = scale * health["innovation"][:, index]
        # HEALTH repeats the latest innovation until there is another.
        fresh = (sigma > 0) & (np.diff(value, prepend=np.nan) != 0)
        value = np.where(fresh, value, np.nan)
        sigma = np.where(sigma > 0, sigma, np.nan)
        for multiple, alpha in ((3, 0.10), (1, 0.18)):
            label = f"±{multiple if multiple > 1 else ''}σ"
            one.fill_between(
                t,
                -multiple * sigma,
                multiple * sigma,
                color=drawing.AFTER,
                alpha=alpha,
                lw=0,
                label=label,
            )
        size = 2.5 if len(t) > _MANY else 4.0
        one.plot(t, value, ".", ms=size, mew=0, color=drawing.AFTER, label="innovation")
        beyond = np.abs(value) > 3 * sigma
        if beyond.any():
            one.plot(
                t[beyond], value[beyond], ".", ms=5, mew=0, color=drawing.BEFORE, label="beyond 3σ"
            )
        limit = np.nanpercentile(np.maximum(3 * sigma, np.abs(value)), 98) * 1.15
        one.set_ylim(-limit, limit)
    return drawing.titled(figure, axes)


def modes(recording: Recording, score: Score) -> Figure | None:
    """Modes of SAHRS and NAV, and messages refused per second by channel and reason."""
    panels = [name for name in ("SAHRS", "NAV") if name in recording]
    refused = _refused(recording["HEALTH"]) if "HEALTH" in recording else None
    labels = [*panels, *(["refused per second"] if refused is not None else [])]
    if not labels:
        return None
    figure, axes = drawing.panels(labels, height=1.7)
    for name, one in zip(panels, axes, strict=False):
        _mode_steps(one, recording[name], SAHRS_MODES if name == "SAHRS" else NAV_MODES)
    drawing.losses(axes[: len(panels)], score.comparison.gps_losses)
    if refused is not None:
        t, series = refused
        _refusals(axes[-1], t, series)
    axes[-1].set_xlabel("flight time, s")
    figure.align_ylabels(axes)
    return figure


def _mode_steps(one: Axes, channel: Channel, names: tuple[str, ...]) -> None:
    mode = channel["mode"].astype(float)
    change = np.flatnonzero(np.diff(mode, prepend=np.nan, append=np.nan) != 0)
    t = drawing.seconds(channel["time_us"])
    edges = np.append(t[change[:-1]], t[-1])
    one.stairs(mode[change[:-1]], edges, baseline=None, color=drawing.AFTER, lw=2.0, zorder=3)
    one.set_yticks(range(len(names)), names)
    one.set_ylim(-0.4, len(names) - 0.6)


def _refused(health: Channel) -> tuple[Array, dict[str, Array]]:
    """Messages refused per second, by channel and reason, the most frequent first."""
    t = drawing.seconds(health["time_us"])
    span = np.maximum(np.diff(t), 1e-3)
    series = {}
    for row, channel in enumerate(INPUTS):
        for column, reason in enumerate(REASONS):
            count = health["rejected"][:, row, column]
            if count[-1] > count[0]:
                series[f"{channel} {reason}"] = np.diff(count) / span
    order = sorted(series, key=lambda name: -float(np.sum(series[name])))
    return t[1:], {name: series[name] for name in order}


def _refusals(one: Axes, t: Array, series: dict[str, Array]) -> None:
    if not series:
        one.text(0.5, 0.5, "none", transform=one.transAxes, ha="center", color="#777777")
        one.set_yticks([])
        return
    names = list(series)
    shown = {name: series[name] for name in names[:_MOST_SERIES]}
    if len(names) > _MOST_SERIES:
        shown["others"] = np.sum([series[name] for name in names[_MOST_SERIES:]], axis=0)
    for colour, (name, rate) in zip(drawing.PALETTE, shown.items(), strict=False):
        one.plot(*drawing.envelope(t, rate), color=colour, label=name)
    one.set_ylim(bottom=0)
    one.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.2)
