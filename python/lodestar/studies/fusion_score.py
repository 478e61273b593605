# SPDX-License-Identifier: Apache-2.0
"""What one flight of the study of navigation scores.

Errors are looked at every 0.2 s, which is more often than any of them changes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lodestar.evaluation.comparison import Estimates, Series, compare, reference_at
from lodestar.evaluation.dead_reckoning import air_velocity_N, dead_reckon
from lodestar.evaluation.metrics import Gap, coverage, maximum, north_east_m, rmse
from lodestar.harness.scenario import Scenario
from lodestar.recordings.recording import Channel, Recording
from lodestar.simulation.wind import STEP_RAMP
from lodestar.studies.sahrs import SERIES_S, nees

Array = NDArray[np.float64]
Rows = NDArray[np.bool_]

ANGLES = ("roll", "pitch", "heading")
AXES = ("north", "east")
LOSSES_S = (10, 20, 120, 300, 600, 3600)
"""Lengths of losses of GPS whose end is scored."""
SINCE_LOSS_S = (60, 300, 540)
"""Times into a loss of GPS at which the peer's error is known."""
PEER_SETTLED_S = 100.0
"""The peer's errors with GPS count from here on."""

SAMPLE_US = 200_000
SEEN_S = 5.0
"""In which a step of wind may be found out, from its end."""
REACQUIRED_S = 10.0
"""In which GPS that is back has to be believed."""


@dataclass(frozen=True)
class Flight:
    """Errors of one flight, NaN where there is no valid output; SI and radians."""

    time_s: Array
    nav: Estimates
    before: Estimates
    """Of dead reckoning on SAHRS and air data alone, in still air."""
    heading_before: Array
    """Of SAHRS, at the times of NAV."""
    wind: Array
    """Estimated wind (n, 2)."""
    protection: Array
    """Horizontal protection level, m; NaN where none is stated."""
    gps: Array
    """Errors (k, 2) of the fixes themselves, m."""
    losses: tuple[Gap, ...]
    frozen: Array
    """Error (n, 2) in a loss of GPS of SAHRS alone with the last estimate of wind; NaN outside."""
    unseen: Rows
    """Where a step of wind cannot have been found out yet."""

    @classmethod
    def of(cls, answered: Recording, scenario: Scenario) -> Flight:
        """Of a recording with SAHRS, NAV and TRUTH."""
        thin = Recording(dict(answered.channels))
        for channel in ("SAHRS", "NAV"):
            thin.channels[channel] = _thinned(answered[channel])
        compared = compare(thin)
        nav, sahrs = compared.nav, compared.sahrs
        assert nav is not None
        assert sahrs is not None
        assert sahrs.attitude is not None
        before = compared.dead_reckoning or _unknown(nav)
        assert np.array_equal(nav.time_us, sahrs.time_us)
        time_s = np.asarray(nav.time_us * 1e-6, np.float64)
        losses = tuple(compared.gps_losses)
        fixes = answered["GPS"]
        at = reference_at(answered, "TRUTH", fixes["time_us"])
        level = thin["NAV"]["horizontal_protection_level"]
        return cls(
            time_s=time_s,
            nav=nav,
            before=before,
            heading_before=sahrs.attitude.error[:, 2],
            wind=thin["NAV"]["wind_N"][:, :2],
            protection=np.where(thin["NAV"]["valid"] & (level >= 0), level, np.nan),
            gps=north_east_m(fixes["lat"], fixes["lon"], at.lat, at.lon, at.h),
            losses=losses,
            frozen=_frozen(answered, losses, nav),
            unseen=unseen_steps(time_s, scenario, losses),
        )

    def lost(self, back_s: float = 0.0) -> Rows:
        """Where GPS is lost, or back for less than ``back_s``."""
        rows = np.zeros(len(self.time_s), bool)
        for gap in self.losses:
            rows |= (self.time_s >= gap.start_us * 1e-6) & (
                self.time_s < gap.end_us * 1e-6 + back_s
            )
        return rows


def unseen_steps(time_s: Array, scenario: Scenario, losses: tuple[Gap, ...]) -> Rows:
    """Where the wind has just made a step, or made one while there was no GPS to see it by.

    From the beginning of the step until 5 s after its end; where GPS was lost during it, until
    10 s after GPS is back.
    """
    wind = scenario.wind
    rows = np.zeros(len(time_s), bool)
    if not (wind.pulse_north_m_s or wind.pulse_east_m_s):
        return rows
    for begin in np.arange(wind.pulse_interval_s, scenario.duration_s, wind.pulse_interval_s):
        end = begin + STEP_RAMP
        known = end + SEEN_S
        for gap in losses:
            if gap.start_us * 1e-6 < end and gap.end_us * 1e-6 > begin:
                known = max(known, gap.end_us * 1e-6 + REACQUIRED_S)
        rows |= (time_s >= begin) & (time_s < known)
    return rows


def figures(flight: Flight) -> Iterator[tuple[str, float]]:
    """The figures of one flight, by name; NaN for what the flight does not have."""
    everywhere = np.ones(len(flight.time_s), bool)
    yield from _attitude("", flight, everywhere)
    yield "before_heading_rmse_deg", rmse(np.rad2deg(flight.heading_before))
    for prefix, estimates in (("", flight.nav), ("before_", flight.before)):
        for axis, error in zip(AXES, _of(estimates.velocity).error.T, strict=True):
            yield f"{prefix}velocity_{axis}_rmse_m_s", rmse(error)
    for axis, error in zip(AXES, _of(flight.nav.wind).error.T, strict=True):
        yield f"wind_{axis}_rmse_m_s", rmse(error)
    yield from _position(flight)
    yield from _consistency(flight)
    yield from _losses(flight)
    yield from _against_the_peer(flight)


def series(flight: Flight) -> Iterator[tuple[str, NDArray[np.float32]]]:
    """What is drawn over time, every SERIES_S; angles in deg."""
    time = flight.time_s
    kept = np.searchsorted(time, np.arange(time[0], time[-1] + 1e-9, SERIES_S))
    attitude, wind, position = (
        _of(one) for one in (flight.nav.attitude, flight.nav.wind, flight.nav.position)
    )
    columns = {
        "time_s": time,
        "heading_error_deg": np.rad2deg(attitude.error[:, 2]),
        "heading_sigma_deg": np.rad2deg(_sigma(attitude)[:, 2]),
        "heading_before_deg": np.rad2deg(flight.heading_before),
        "position_before_m": np.hypot(*_of(flight.before.position).error.T),
        "frozen_error_m": np.hypot(*flight.frozen.T),
        "protection_m": flight.protection,
    }
    for index, axis in enumerate(AXES):
        columns |= {
            f"wind_{axis}_m_s": flight.wind[:, index],
            f"wind_{axis}_error_m_s": wind.error[:, index],
            f"wind_{axis}_sigma_m_s": _sigma(wind)[:, index],
            f"position_{axis}_error_m": position.error[:, index],
            f"position_{axis}_sigma_m": _sigma(position)[:, index],
        }
    for name, values in columns.items():
        yield name, values[kept].astype(np.float32)


def _attitude(prefix: str, flight: Flight, rows: Rows) -> Iterator[tuple[str, float]]:
    for name, error in zip(ANGLES, _of(flight.nav.attitude).error.T, strict=True):
        yield f"{prefix}{name}_rmse_deg", rmse(np.rad2deg(error[rows]))


def _position(flight: Flight) -> Iterator[tuple[str, float]]:
    """Over the whole flight; where GPS is there; and of GPS itself."""
    aided = ~flight.lost(REACQUIRED_S)
    for index, axis in enumerate(AXES):
        error = _of(flight.nav.position).error[:, index]
        yield f"position_{axis}_rmse_m", rmse(error)
        yield f"aided_position_{axis}_rmse_m", rmse(error[aided])
        yield f"gps_{axis}_rmse_m", rmse(flight.gps[:, index])


def _consistency(flight: Flight) -> Iterator[tuple[str, float]]:
    attitude, wind, position = (
        _of(one) for one in (flight.nav.attitude, flight.nav.wind, flight.nav.position)
    )
    counted = ~flight.unseen
    for name, one, columns in (("heading", attitude, slice(2, 3)), ("wind", wind, slice(0, 2))):
        squares = nees(one.error[counted, columns], _sigma(one)[counted, columns])
        known = squares[np.isfinite(squares)]
        yield f"nees_{name}", float(np.mean(known)) if len(known) else float("nan")
    for one in (attitude, wind, position):
        for index, name in enumerate(one.names):
            for multiple in (1, 2):
                share = coverage(one.error[:, index], _sigma(one)[:, index], multiple)
                yield f"coverage_{multiple}sigma_{name}", share
    stated = np.where(np.isnan(attitude.error), np.nan, _sigma(attitude))[:, 2]
    yield "sigma_heading_rms_deg", rmse(np.rad2deg(stated))
    yield "valid_share", flight.nav.available
    level = flight.protection
    distance = np.hypot(*position.error.T)
    sample_h = SAMPLE_US * 1e-6 / 3600
    yield "protected_h", float(np.sum(np.isfinite(level))) * sample_h
    yield "beyond_protection_h", float(np.sum(distance > level)) * sample_h
    yield "largest_of_protection", maximum(distance / level)


def _losses(flight: Flight) -> Iterator[tuple[str, float]]:
    """Horizontal error at the end of losses of GPS, and what was stated of it: means by length."""
    position = _of(flight.nav.position)
    values = {
        "end": np.hypot(*position.error.T),
        "sigma_end": np.hypot(*_sigma(position).T),
        "protection_end": flight.protection,
        "frozen_end": np.hypot(*flight.frozen.T),
    }
    for length in LOSSES_S:
        gaps = [gap for gap in flight.losses if round(gap.duration_s) == length]
        last = [int(np.searchsorted(flight.time_s, gap.end_us * 1e-6)) - 1 for gap in gaps]
        for name, one in values.items():
            yield f"{name}_{length}s_m", float(np.mean(one[last])) if last else float("nan")


def _against_the_peer(flight: Flight) -> Iterator[tuple[str, float]]:
    """What is known of the peer: attitude and wind before and in the first loss, error in it."""
    start = flight.losses[0].start_us * 1e-6 if flight.losses else np.inf
    end = flight.losses[0].end_us * 1e-6 if flight.losses else np.inf
    time = flight.time_s
    aided = (time >= PEER_SETTLED_S) & (time < start)
    lost = (time >= start) & (time < end)
    yield from _attitude("aided_", flight, aided)
    yield from _attitude("lost_", flight, lost)
    yield "aided_wind_rmse_m_s", rmse(np.hypot(*_of(flight.nav.wind).error[aided].T))
    distance = np.hypot(*_of(flight.nav.position).error.T)
    for since in SINCE_LOSS_S:
        row = int(np.searchsorted(time, start + since))
        known = start + since < end and row < len(time)
        yield f"lost_{since}s_m", float(distance[row]) if known else float("nan")


def _of(series: Series | None) -> Series:
    assert series is not None
    return series


def _sigma(series: Series) -> Array:
    assert series.sigma is not None
    return series.sigma


def _thinned(channel: Channel) -> Channel:
    """The messages nearest to every SAMPLE_US."""
    usual = float(np.median(np.diff(channel["time_us"])))
    step = max(1, round(SAMPLE_US / usual))
    return {name: column[::step] for name, column in channel.items()}


def _unknown(nav: Estimates) -> Estimates:
    """What dead reckoning gives without air data: nothing."""

    def nowhere(names: tuple[str, ...]) -> Series:
        return Series(names, np.full((len(nav.time_us), len(names)), np.nan))

    return Estimates(
        time_us=nav.time_us,
        available=0.0,
        position=nowhere(_of(nav.position).names),
        velocity=nowhere(_of(nav.velocity).names),
        wind=nowhere(_of(nav.wind).names),
    )


def _frozen(answered: Recording, losses: tuple[Gap, ...], nav: Estimates) -> Array:
    """Error (n, 2), at the times of ``nav``, of SAHRS and air data alone in losses of GPS, m.

    It starts from NAV's position, and the wind stays as NAV had it then.
    """
    error = np.full((len(nav.time_us), 2), np.nan)
    if not len(answered["ADC"]["time_us"]):
        return error
    for gap in losses:
        sahrs, answer = answered["SAHRS"], answered["NAV"]
        inside = (sahrs["time_us"] >= gap.start_us) & (sahrs["time_us"] < gap.end_us)
        first = int(np.searchsorted(answer["time_us"], gap.start_us))
        if not inside.any() or first >= len(answer["time_us"]):
            continue
        time_us = sahrs["time_us"][inside]
        part = {name: column[inside] for name, column in sahrs.items()}
        v_N = air_velocity_N(part, answered["ADC"]) + answer["wind_N"][first]
        h = np.interp(time_us, answered["ADC"]["time_us"], answered["ADC"]["baro_altitude"])
        lat, lon = dead_reckon(
            time_us, v_N, float(answer["lat"][first]), float(answer["lon"][first]), h
        )
        rows = np.flatnonzero(np.isin(nav.time_us, time_us))
        seen = np.searchsorted(time_us, nav.time_us[rows])
        at = reference_at(answered, "TRUTH", nav.time_us[rows])
        error[rows] = north_east_m(lat[seen], lon[seen], at.lat, at.lon, at.h)
    return error
