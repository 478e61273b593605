# SPDX-License-Identifier: Apache-2.0
"""The plots that a navigation engineer looks for, as PNG."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from lodestar.evaluation import drawing
from lodestar.evaluation.comparison import Series
from lodestar.evaluation.health_plots import innovations, modes
from lodestar.evaluation.score import Score
from lodestar.evaluation.track_plot import track
from lodestar.recordings.recording import Recording

TITLES = {
    "track": "Track",
    "attitude": "Attitude error",
    "sahrs": "SAHRS error about the body axes",
    "position": "Position error",
    "losses": "Error without GPS",
    "wind": "Wind",
    "innovations": "Innovations",
    "modes": "Modes and rejections",
}
"""Name of each plot, which is the stem of its file, to its heading."""

_RECOVERY_US = 10_000_000  # the jump back after a loss is no part of the time with GPS
_MOST_NAMED = 4


def figures(recording: Recording, score: Score) -> dict[str, Figure]:
    """The plots for which the flight has data, by name, in the order of TITLES."""
    makers: dict[str, Callable[[Recording, Score], Figure | None]] = {
        "track": track,
        "attitude": attitude,
        "sahrs": sahrs,
        "position": position,
        "losses": losses,
        "wind": wind,
        "innovations": innovations,
        "modes": modes,
    }
    with mpl.rc_context(drawing.STYLE):
        made = {name: makers[name](recording, score) for name in TITLES}
    return {name: figure for name, figure in made.items() if figure is not None}


def render(recording: Recording, score: Score) -> dict[str, bytes]:
    """The plots as PNG, by name."""
    with mpl.rc_context(drawing.STYLE):
        return {name: drawing.png(one) for name, one in figures(recording, score).items()}


def write_plots(
    recording: Recording, score: Score, folder: Path, images: dict[str, bytes] | None = None
) -> list[Path]:
    """Write the plots as PNG files into a folder, which is made; returns their paths.

    ``images`` are those of render() where it was called already. Raises InputError when they
    cannot be written.
    """
    return drawing.write_images(render(recording, score) if images is None else images, folder)


def attitude(recording: Recording, score: Score) -> Figure | None:
    """Errors of roll, pitch, heading: SAHRS, and NAV with its sigma."""
    sahrs, nav = score.comparison.sahrs, score.comparison.nav
    before = _known(sahrs.attitude) if sahrs is not None else None
    after = _known(nav.attitude) if nav is not None else None
    if before is None and after is None:
        return None
    figure, axes = drawing.panels(("roll, deg", "pitch, deg", "heading, deg"))
    if sahrs is not None and before is not None:
        error = np.rad2deg(before.error)
        drawing.lines(axes, sahrs.time_us, error, "SAHRS", drawing.BEFORE, width=2.0)
        _scale(axes, before, drawing.DEGREES)
    if nav is not None and after is not None:
        drawing.sigma_bands(axes, nav.time_us, after, drawing.DEGREES)
        error = np.rad2deg(after.error)
        drawing.lines(axes, nav.time_us, error, "NAV", drawing.AFTER)
        _scale(axes, after if before is None else before, drawing.DEGREES, after)
    drawing.losses(axes, score.comparison.gps_losses)
    return drawing.titled(figure, axes)


def sahrs(recording: Recording, score: Score) -> Figure | None:
    """Rotation error of SAHRS about the body axes, for which it states its sigma."""
    estimates = score.comparison.sahrs
    error = _known(estimates.rotation) if estimates is not None else None
    if estimates is None or error is None:
        return None
    figure, axes = drawing.panels(("roll axis, deg", "pitch axis, deg", "yaw axis, deg"))
    drawing.sigma_bands(axes, estimates.time_us, error, drawing.DEGREES)
    drawing.lines(axes, estimates.time_us, np.rad2deg(error.error), "SAHRS", drawing.AFTER)
    _scale(axes, error, drawing.DEGREES)
    return drawing.titled(figure, axes)


def position(recording: Recording, score: Score) -> Figure | None:
    """Position error of NAV with its sigma, and of the GPS fixes; scaled to the time with GPS."""
    nav = score.comparison.nav
    if nav is None or nav.position is None or _known(nav.position) is None:
        return None
    figure, axes = drawing.panels(("north, m", "east, m"))
    fixes = drawing.gps_errors(recording, score.comparison.reference)
    if fixes is not None:
        drawing.dots(axes, *fixes, "GPS")
    drawing.sigma_bands(axes, nav.time_us, nav.position, 1.0)
    drawing.lines(axes, nav.time_us, nav.position.error, "NAV", drawing.AFTER)
    aided = np.ones(len(nav.time_us), bool)
    for gap in score.comparison.gps_losses:
        aided &= (nav.time_us < gap.start_us) | (nav.time_us > gap.end_us + _RECOVERY_US)
    if aided.any():
        _scale(axes, nav.position, 1.0, rows=aided)
    drawing.losses(axes, score.comparison.gps_losses)
    return drawing.titled(figure, axes)


def losses(recording: Recording, score: Score) -> Figure | None:
    """Horizontal error of NAV, and its sigma, over the time since GPS was lost."""
    nav, gaps = score.comparison.nav, score.comparison.gps_losses
    if nav is None or nav.position is None or nav.position.sigma is None or not gaps:
        return None
    if _known(nav.position) is None:
        return None
    distance = np.hypot(*nav.position.error.T)
    sigma = np.hypot(*nav.position.sigma.T)
    figure, (axes,) = drawing.panels(("horizontal error, m",), height=3.4)
    for index, gap in enumerate(gaps):
        rows = (nav.time_us >= gap.start_us) & (nav.time_us < gap.end_us)
        t = np.asarray((nav.time_us[rows] - gap.start_us) * 1e-6, np.float64)
        first = index == 0
        axes.plot(
            *drawing.envelope(t, distance[rows]),
            color=drawing.AFTER,
            label="NAV" if first else None,
        )
        axes.plot(
            *drawing.thin(t, sigma[rows]),
            color=drawing.GPS,
            lw=1.0,
            ls=(0, (4, 2)),
            label="σ (north and east)" if first else None,
        )
        if rows.any() and len(gaps) <= _MOST_NAMED:
            at = f"lost at {gap.start_us * 1e-6:.0f} s"
            end = (float(t[-1]), float(distance[rows][-1]))
            axes.annotate(at, end, (-4, 4), textcoords="offset points", ha="right", va="bottom")
    axes.set_ylim(bottom=0)
    drawing.titled(figure, [axes])
    axes.set_xlabel("time without GPS, s")
    return figure


def wind(recording: Recording, score: Score) -> Figure | None:
    """Wind that NAV estimates, with its sigma, and the true one where it is known."""
    if "NAV" not in recording or score.comparison.nav is None:
        return None
    nav = recording["NAV"]
    estimate = drawing.valid_only(nav, nav["wind_N"][:, :2])
    if not np.isfinite(estimate).any():
        return None
    figure, axes = drawing.panels(("north, m/s", "east, m/s"))
    drawing.estimate_bands(axes, nav["time_us"], estimate, nav["sigma_wind"])
    shown = [estimate]
    if "TRUTH" in recording:
        truth = recording["TRUTH"]
        shown.append(truth["wind_N"][:, :2])
        drawing.lines(axes, truth["time_us"], shown[1], "true", drawing.TRUE)
    drawing.lines(axes, nav["time_us"], estimate, "NAV", drawing.AFTER)
    for index, one in enumerate(axes):
        low, high = np.nanpercentile(np.concatenate([s[:, index] for s in shown]), [0.5, 99.5])
        room = 0.4 * (high - low) + 1.0
        one.set_ylim(low - room, high + room)
    drawing.losses(axes, score.comparison.gps_losses)
    return drawing.titled(figure, axes)


def _known(series: Series | None) -> Series | None:
    """The series, unless no error of it is known."""
    return series if series is not None and np.isfinite(series.error).any() else None


def _scale(
    axes: list[Axes],
    series: Series,
    factor: float,
    judged: Series | None = None,
    rows: NDArray[np.bool_] | slice = slice(None),
) -> None:
    """Scale each panel by the errors of ``series`` and by three typical sigma."""
    sigma = (judged or series).sigma
    for index, one in enumerate(axes):
        usual = 0.0 if sigma is None else 3.3 * factor * float(np.nanmedian(sigma[rows, index]))
        drawing.scale_by(one, factor * series.error[rows, index], usual)
