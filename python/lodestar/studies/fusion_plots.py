# SPDX-License-Identifier: Apache-2.0
"""Plots of the study of navigation, after the figures of the Linköping thesis."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator, NullFormatter
from numpy.typing import NDArray

from lodestar.evaluation import drawing
from lodestar.harness.scenario import LIVING_AIR, drawn_turn
from lodestar.studies.ensemble import Ensemble
from lodestar.studies.findings import Plot
from lodestar.studies.fusion import LOSSES
from lodestar.studies.fusion_book import Book, has, scenario_of
from lodestar.studies.fusion_score import AXES, LOSSES_S
from lodestar.studies.fusion_setups import FILTERS
from lodestar.studies.sahrs import SERIES_S

Array = NDArray[np.float64]
Curve = Callable[[Ensemble], Array]
Dashes = str | tuple[int, tuple[int, int]]
Style = tuple[str, str, Dashes]
"""What is drawn, its colour, its dashes."""

_COLOURS = dict(zip(FILTERS, (drawing.GOOD, drawing.AFTER), strict=True))
_DASHED = (0, (4, 2))
_DASHES: dict[str, Dashes] = {"init": "-", "cold": _DASHED}
_COLUMNS = 3
_SHORTEST_S = 100.0  # a loss of GPS that is drawn as growth


def plots(ensembles: Sequence[Ensemble], course: str = "drawn") -> list[Plot]:
    """One flight of each scenario, the errors over all flights in time, and losses of GPS.

    ``course``: the study's.
    """
    book = Book(ensembles)
    shown = {one.cell.flight: one.cell.case for one in reversed([*book.filters()])}
    made = []
    with mpl.rc_context(drawing.STYLE):
        for case in reversed(shown.values()):
            cells = [one for name in FILTERS for one in [book.of(case, name)] if one]
            seed = cells[0].results[0].seed
            name = "flight-" + case.replace("/", "-")
            made.append(Plot(name, f"{case}, seed {seed}", _FLIGHT, _flight(cells)))
        for living in (False, True):
            cases = [c for c in book.cases if scenario_of(c).endswith(LIVING_AIR) == living]
            cells = [one for one in book.filters() if one.cell.case in cases]
            for name, label, curve, before in _ENSEMBLES:
                if cells:
                    air = "living" if living else "steady"
                    figure = _over_all_flights(cells, label, curve, before)
                    title = f"{label.split(',')[0].capitalize()} over all flights, {air} air"
                    made.append(Plot(f"{name}-{air}", title, _ENSEMBLE, figure))
        first = shown.values()
        grown = [one for one in book.filters() if one.cell.case in first and any(_long_losses(one))]
        if grown:
            made.append(Plot("gps-loss", "Losses of GPS", _GROWTH, _growth(grown)))
        ends = [
            one for one in grown if scenario_of(one.cell.case).removesuffix(LIVING_AIR) in LOSSES
        ]
        if ends:
            made.append(Plot("gps-loss-rate", "Error by length of the loss", _RATE, _rates(ends)))
        turned = [one for one in grown if course == "drawn" and has(one, _AT_END)]
        if turned:
            title = "Error at the end of 5 min without GPS, by course"
            made.append(Plot("gps-loss-course", title, _COURSE, _by_course(turned)))
    return made


_FLIGHT = (
    "Error of heading before correction (SAHRS) and after, with its σ; the wind and its estimate; "
    "the horizontal error of position, before by dead reckoning in still air, dotted what SAHRS "
    "alone would give with the wind as it was when GPS was lost."
)
_ENSEMBLE = "Rms over all flights at every time. Bands: GPS is lost."
_GROWTH = (
    "Rms over all flights of the horizontal error (lines) and of its stated σ (dashes), from the "
    "loss of GPS on. SAHRS alone keeps the wind as it was last estimated. Dotted: the protection "
    "level, its mean."
)

_RATE = (
    "Mean horizontal error at the end of losses of GPS of 2, 5, 10 and 60 min over their length."
)

_AT_END = "end_300s_m"
_COURSE = (
    "Each dot is a flight: its horizontal error at the end of the loss, over the angle by which "
    "its route is turned. Crosses: the σ that was stated (norm of both axes)."
)


def _flight(cells: Sequence[Ensemble]) -> Figure:
    """The first flight of a case, one line for each filter."""
    labels = ("heading error, °", "wind N, m/s", "wind E, m/s", "position error, m")
    figure, axes = drawing.panels(labels)
    first, last = cells[0].results[0].series, cells[-1].results[0].series
    time = first["time_s"]
    _shade(axes, cells[0])
    axes[0].plot(time, first["heading_before_deg"], color=drawing.BEFORE, label="SAHRS")
    shade = _COLOURS[cells[-1].cell.estimator]
    for width, alpha, label in ((3, 0.10, "±3σ"), (1, 0.18, "±σ")):
        edge = width * last["heading_sigma_deg"]
        axes[0].fill_between(time, -edge, edge, color=shade, alpha=alpha, lw=0, label=label)
    for one, axis in zip(axes[1:3], AXES, strict=True):
        true = first[f"wind_{axis}_m_s"] - first[f"wind_{axis}_error_m_s"]
        thickness = 0.6 if _is_rough(true) else 1.6
        one.plot(time, true, color=drawing.TRUE, lw=thickness, label="truth")
    axes[3].plot(time, first["position_before_m"], color=drawing.BEFORE, label="SAHRS")
    if np.isfinite(first["frozen_error_m"]).any():
        axes[3].plot(time, first["frozen_error_m"], ":", color=drawing.BEFORE, label="SAHRS alone")
    for ensemble in cells:
        series, name = ensemble.results[0].series, ensemble.cell.estimator
        position = np.hypot(*(series[f"position_{axis}_error_m"] for axis in AXES))
        winds = [series[f"wind_{axis}_m_s"] for axis in AXES]
        for one, values in zip(axes, (series["heading_error_deg"], *winds, position), strict=True):
            one.plot(time, values, color=_COLOURS[name], lw=0.9, label=name)
    drawing.scale_by(axes[0], np.append(first["heading_before_deg"], last["heading_error_deg"]))
    for one, axis in zip(axes[1:3], AXES, strict=True):
        _scale_wind(one, cells[0].results[0].series, axis)
    axes[3].set_ylim(bottom=max(0.05, float(np.nanpercentile(position, 1))))
    _logarithmic(axes[3])
    return drawing.titled(figure, axes)


def _is_rough(values: NDArray[np.float32]) -> bool:
    """Whether most of the samples differ from the one before, as in turbulence."""
    return bool(np.nanmedian(np.abs(np.diff(values))) > 0.05)


def _scale_wind(one: Axes, series: dict[str, NDArray[np.float32]], axis: str) -> None:
    """Scale y by the bulk of wind and estimate: a start without any is not the flight."""
    estimate, error = (series[f"wind_{axis}_{what}"] for what in ("m_s", "error_m_s"))
    known = np.isfinite(error)
    if known.any():
        both = np.append(estimate[known], (estimate - error)[known])
        low, high = np.percentile(both, [0.5, 99.5])
        one.set_ylim(low - 2.0, high + 2.0)


def _logarithmic(one: Axes) -> None:
    """Scale what has been drawn by its logarithm, with plain numbers beside the axis."""
    one.set_yscale("log")
    low, high = one.get_ylim()
    marks = (1.0, 2.0, 5.0) if high < 60 * low else (1.0,)
    one.yaxis.set_major_locator(LogLocator(subs=marks))
    one.yaxis.set_major_formatter("{x:g}")
    one.yaxis.set_minor_formatter(NullFormatter())


def _shade(axes: Sequence[Axes], ensemble: Ensemble) -> None:
    for number, (start, end) in enumerate(_losses(ensemble)):
        for one in axes:
            label = "GPS lost" if number == 0 and one is axes[0] else None
            one.axvspan(start, end, color=drawing.LOSS, alpha=0.22, lw=0, label=label, zorder=0.5)


def _losses(ensemble: Ensemble) -> list[tuple[float, float]]:
    """(start, end), s, of the losses of GPS: where SAHRS alone has an error."""
    series = ensemble.results[0].series
    lost = np.isfinite(series["frozen_error_m"]).astype(int)
    edges = np.flatnonzero(np.diff(lost, prepend=0, append=0)).reshape(-1, 2)
    time = series["time_s"]
    return [(float(time[a]), float(time[b - 1]) + SERIES_S) for a, b in edges]


def _long_losses(ensemble: Ensemble) -> Iterator[tuple[float, float]]:
    return ((a, b) for a, b in _losses(ensemble) if b - a > _SHORTEST_S)


def _rms(values: Array) -> Array:
    """Over the flights, at every time; NaN where one of them has no value."""
    return np.asarray(np.sqrt(np.mean(values**2, axis=0)))


def _heading(ensemble: Ensemble) -> Array:
    return _rms(ensemble.series("heading_error_deg"))


def _heading_before(ensemble: Ensemble) -> Array:
    return _rms(ensemble.series("heading_before_deg"))


def _horizontal(ensemble: Ensemble, what: str) -> Array:
    """Rms of the norm of a quantity of two axes."""
    return np.asarray(np.hypot(*(_rms(ensemble.series(what.format(axis))) for axis in AXES)))


def _wind(ensemble: Ensemble) -> Array:
    return _horizontal(ensemble, "wind_{}_error_m_s")


def _position(ensemble: Ensemble) -> Array:
    return _horizontal(ensemble, "position_{}_error_m")


_ENSEMBLES: tuple[tuple[str, str, Curve, Curve | None], ...] = (
    ("heading", "heading, rms in °", _heading, _heading_before),
    ("wind", "wind (both axes), rms in m/s", _wind, None),
    ("position", "position, rms in m", _position, None),
)


def _over_all_flights(
    cells: Sequence[Ensemble], label: str, curve: Curve, before: Curve | None
) -> Figure:
    """A panel for each flight, lines for its filters and starts."""
    flights = list(dict.fromkeys(one.cell.flight for one in cells))
    figure, axes = _grid(len(flights))
    for one, flight in zip(axes, flights, strict=True):
        members = [ensemble for ensemble in cells if ensemble.cell.flight == flight]
        time = members[0].results[0].series["time_s"]
        _shade([one], members[0])
        if before is not None:
            one.plot(time, before(members[0]), color=drawing.BEFORE, lw=0.9)
        for ensemble in members:
            start = ensemble.cell.case.rsplit("/", 1)[1]
            colour = _COLOURS[ensemble.cell.estimator]
            one.plot(time, curve(ensemble), color=colour, ls=_DASHES[start], lw=1.1)
        one.set_title(flight, fontsize=10, loc="left")
        _logarithmic(one)
        one.margins(x=0.01)
    styles: list[Style] = [("SAHRS", drawing.BEFORE, "-")] if before is not None else []
    starts = [one.cell.case.rsplit("/", 1)[1] for one in cells]
    for name in dict.fromkeys(one.cell.estimator for one in cells):
        for start in dict.fromkeys(starts):
            styles.append((f"{name}, {start}", _COLOURS[name], _DASHES[start]))
    figure.supylabel(label, fontsize=10)
    figure.supxlabel("flight time, s", fontsize=10)
    _legend(figure, styles)
    return figure


def _growth(cells: Sequence[Ensemble]) -> Figure:
    """A panel for each long loss of each case."""
    losses = {
        (one.cell.case, loss): None
        for one in sorted(cells, key=lambda one: LIVING_AIR in one.cell.case)
        for loss in _long_losses(one)
    }
    figure, axes = _grid(len(losses))
    protected: dict[str, None] = {}
    for one, (case, (start, end)) in zip(axes, losses, strict=True):
        members = [ensemble for ensemble in cells if ensemble.cell.case == case]
        time = members[0].series("time_s")[0]
        inside = (time >= start) & (time < end)
        minutes = (time[inside] - start) / 60
        alone = _rms(members[0].series("frozen_error_m")[:, inside])
        one.plot(minutes, alone, color=drawing.BEFORE, lw=1.1)
        for ensemble in members:
            colour = _COLOURS[ensemble.cell.estimator]
            one.plot(minutes, _position(ensemble)[inside], color=colour, lw=1.3)
            sigma = _horizontal(ensemble, "position_{}_sigma_m")[inside]
            one.plot(minutes, sigma, color=colour, ls=_DASHED, lw=0.9)
            level = ensemble.series("protection_m")[:, inside]
            if np.isfinite(level).any():
                one.plot(minutes, np.mean(level, axis=0), ":", color=colour, lw=1.1)
                protected[ensemble.cell.estimator] = None
        one.set_title(f"{case.rsplit('/', 1)[0]}, {(end - start) / 60:.0f} min", loc="left", size=9)
        one.set_ylim(bottom=1.0)
        _logarithmic(one)
        one.margins(x=0.01)
    styles: list[Style] = [("SAHRS alone", drawing.BEFORE, "-")]
    for name in dict.fromkeys(one.cell.estimator for one in cells):
        styles += [(name, _COLOURS[name], "-"), (f"its σ ({name})", _COLOURS[name], _DASHED)]
    styles += [(f"its protection level ({name})", _COLOURS[name], ":") for name in protected]
    figure.supylabel("horizontal error, m", fontsize=10)
    figure.supxlabel("since the loss of GPS, min", fontsize=10)
    _legend(figure, styles)
    return figure


def _rates(cells: Sequence[Ensemble]) -> Figure:
    """Error at the end over the length of the loss, in constant wind and in living air."""
    of_air: dict[str, list[Ensemble]] = {}
    for ensemble in sorted(cells, key=lambda one: LIVING_AIR in one.cell.case):
        living = scenario_of(ensemble.cell.case).endswith(LIVING_AIR)
        of_air.setdefault("living air" if living else "constant wind", []).append(ensemble)
    figure, axes = _grid(len(of_air))
    styles: dict[str, Style] = {}
    for one, (air, members) in zip(axes, of_air.items(), strict=True):
        for ensemble in members:
            name = ensemble.cell.estimator
            styles[name] = (name, _COLOURS[name], "-")
        for name, (_, colour, _) in list(styles.items()):
            own = [ensemble for ensemble in members if ensemble.cell.estimator == name]
            one.plot(*_rate(own, "end"), "o-", color=colour, ms=4)
        alone = [e for e in members if e.cell.estimator == members[0].cell.estimator]
        one.plot(*_rate(alone, "frozen_end"), "o-", color=drawing.BEFORE, ms=4)
        one.set_title(air, loc="left", fontsize=10)
        one.set_xscale("log")
        one.set_xticks([2, 5, 10, 60], ["2", "5", "10", "60"])
        one.xaxis.set_minor_formatter(NullFormatter())
        _logarithmic(one)
    figure.supylabel("m/min", fontsize=10)
    figure.supxlabel("length of the loss, min", fontsize=10)
    _legend(figure, [("SAHRS alone", drawing.BEFORE, "-"), *styles.values()])
    return figure


def _by_course(cells: Sequence[Ensemble]) -> Figure:
    """A panel for each case, a dot for each flight."""
    cases = list(dict.fromkeys(one.cell.case for one in cells))
    figure, axes = _grid(len(cases))
    for one, case in zip(axes, cases, strict=True):
        for ensemble in (e for e in cells if e.cell.case == case):
            turns = np.degrees([drawn_turn(result.seed) for result in ensemble.results])
            colour = _COLOURS[ensemble.cell.estimator]
            one.plot(turns, ensemble.figure(_AT_END), "o", color=colour, ms=4)
            one.plot(turns, ensemble.figure(f"sigma_{_AT_END}"), "x", color=colour, ms=3, alpha=0.6)
        one.set_title(case.rsplit("/", 1)[0], loc="left", fontsize=10)
        one.set_xticks(range(0, 361, 90))
        _logarithmic(one)
    figure.supylabel("horizontal error, m", fontsize=10)
    figure.supxlabel("turn of the route to the right, ° (0: as filed)", fontsize=10)
    names = dict.fromkeys(one.cell.estimator for one in cells)
    _legend(figure, [(name, _COLOURS[name], "-") for name in names])
    return figure


def _rate(cells: Sequence[Ensemble], what: str) -> tuple[list[float], list[float]]:
    """Lengths of losses, min, and the mean of a figure at their end, m/min."""
    points = [
        (length / 60, float(np.mean(ensemble.figure(f"{what}_{length}s_m"))) / (length / 60))
        for length in LOSSES_S
        for ensemble in cells
        if has(ensemble, f"{what}_{length}s_m")
    ]
    return [minutes for minutes, _ in points], [rate for _, rate in points]


def _grid(count: int) -> tuple[Figure, list[Axes]]:
    """Small panels, _COLUMNS side by side."""
    columns = min(count, _COLUMNS)
    rows = -(-count // columns)
    figure = Figure(figsize=(1.35 * drawing.WIDTH, 2.5 * rows + 0.8), layout="constrained")
    axes = list(figure.subplots(rows, columns, squeeze=False).ravel())
    for spare in axes[count:]:
        spare.remove()
    return figure, axes[:count]


def _legend(figure: Figure, styles: Sequence[Style]) -> None:
    handles = [Line2D([], [], color=colour, ls=style) for _, colour, style in styles]
    names = [name for name, _, _ in styles]
    figure.legend(handles, names, loc="outside upper right", ncols=len(names))
