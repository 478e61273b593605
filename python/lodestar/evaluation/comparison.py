# SPDX-License-Identifier: Apache-2.0
"""Errors of a flight's outputs against its reference, as series in time.

The reference is TRUTH where there is one, else the INS while it calls itself valid. Errors are
estimate minus reference, at the times of the outputs; where there is no valid output or no
reference they are NaN. Within 10 deg of the vertical, roll and heading have no meaning: NaN too.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from lodestar import rotation
from lodestar.errors import InputError
from lodestar.evaluation.dead_reckoning import air_velocity_N, dead_reckon
from lodestar.evaluation.metrics import Gap, gaps, north_east_m
from lodestar.recordings.recording import Channel, Recording

Array = NDArray[np.float64]
Times = NDArray[np.int64]

STEEPEST_PITCH = np.deg2rad(80.0)
GPS_LOSS_US = 3_000_000
_LONGEST_REFERENCE_GAP_US = 200_000

FUSION_FILTERS = ("integrated", "cascade")
"""By the number that HEALTH gives them."""


@dataclass(frozen=True)
class Reference:
    """The reference at given times; NaN where it is silent."""

    name: str
    C_NB: Array
    lat: Array
    lon: Array
    h: Array
    v_N: Array
    wind_N: Array | None  # only TRUTH knows it

    @property
    def euler(self) -> tuple[Array, Array, Array]:
        """Roll, pitch, heading."""
        return rotation.euler_from_C_NB(self.C_NB)


@dataclass(frozen=True)
class Series:
    """Errors (n, k) with, where the estimator states it, their sigma (n, k)."""

    names: tuple[str, ...]
    error: Array
    sigma: Array | None = None


@dataclass(frozen=True)
class Estimates:
    """The errors of one channel of output."""

    time_us: Times
    available: float
    """Share of the messages that called themselves valid."""
    broken: int = 0
    """Messages that called themselves valid and held a number that is not finite."""
    attitude: Series | None = None  # roll, pitch, heading; rad
    rotation: Series | None = None  # about the body axes; rad
    position: Series | None = None  # north, east; m
    velocity: Series | None = None  # north, east; m/s
    wind: Series | None = None  # north, east; m/s


@dataclass(frozen=True)
class Comparison:
    """A whole flight against its reference."""

    reference: str
    sahrs: Estimates | None
    nav: Estimates | None
    dead_reckoning: Estimates | None
    filter: str
    """What gave NAV: one of FUSION_FILTERS."""
    gps_losses: list[Gap] = field(default_factory=list)


def compare(recording: Recording) -> Comparison:
    """Errors of SAHRS, NAV and dead reckoning.

    Raises InputError when the recording has neither TRUTH nor a valid INS.
    """
    name = reference_name(recording)
    end_us = max(
        int(one["time_us"].max()) for one in recording.channels.values() if len(one["time_us"])
    )
    losses = []
    if "GPS" in recording:
        gps = recording["GPS"]
        losses = gaps(gps["time_us"][gps["fix_type"] >= 2], end_us, GPS_LOSS_US)
    return Comparison(
        reference=name,
        sahrs=compare_sahrs(recording, name) if _has(recording, "SAHRS") else None,
        nav=compare_nav(recording, name) if _has(recording, "NAV") else None,
        dead_reckoning=_dead_reckoning(recording, name),
        filter=fusion_filter(recording),
        gps_losses=losses,
    )


def fusion_filter(recording: Recording) -> str:
    """What gave NAV, as HEALTH says; the default where there is none."""
    if not _has(recording, "HEALTH"):
        return FUSION_FILTERS[0]
    return FUSION_FILTERS[int(recording["HEALTH"]["fusion_filter"][-1])]


def _has(recording: Recording, channel: str) -> bool:
    return channel in recording and len(recording[channel]["time_us"]) > 0


def reference_name(recording: Recording) -> str:
    """TRUTH or INS. Raises InputError when there is neither."""
    if _has(recording, "TRUTH"):
        return "TRUTH"
    if _has(recording, "INS") and recording["INS"]["valid"].any():
        return "INS"
    raise InputError("score: the recording has neither TRUTH nor a valid INS to compare with")


def reference_at(recording: Recording, name: str, time_us: Times) -> Reference:
    """The reference channel at other times, interpolated over at most 0.2 s."""
    source = recording[name]
    rows = np.flatnonzero(source["valid"]) if name == "INS" else np.arange(len(source["time_us"]))
    # A time that occurs twice is no bracket.
    known, first = np.unique(source["time_us"][rows], return_index=True)
    after = np.clip(np.searchsorted(known, time_us, side="left"), 0, len(known) - 1)
    before = np.clip(np.searchsorted(known, time_us, side="right") - 1, 0, len(known) - 1)
    span = known[after] - known[before]
    outside = (time_us < known[0]) | (time_us > known[-1]) | (span > _LONGEST_REFERENCE_GAP_US)
    share = np.where(span > 0, (time_us - known[before]) / np.maximum(span, 1), 0.0)
    share[outside] = np.nan
    before, after = rows[first[before]], rows[first[after]]
    lon = np.full(len(source["lon"]), np.nan)
    lon[rows] = np.unwrap(source["lon"][rows])

    def between(column: Array) -> Array:
        part = share.reshape(-1, *(1,) * (column.ndim - 1))
        blend: Array = column[before] + part * (column[after] - column[before])
        return blend

    return Reference(
        name=name,
        C_NB=_turn_between(source, before, after, share),
        lat=between(source["lat"]),
        lon=between(lon),
        h=between(source["h"]),
        v_N=between(source["v_N"]),
        wind_N=between(source["wind_N"]) if "wind_N" in source else None,
    )


def _turn_between(source: Channel, before: Times, after: Times, share: Array) -> Array:
    def attitude(rows: Times) -> Array:
        return rotation.C_NB_from_euler(
            *(source[angle][rows] for angle in ("roll", "pitch", "heading"))
        )

    turned = attitude(before)
    inside = np.isfinite(share) & (share > 0)
    if inside.any():
        start, end = turned[inside], attitude(after[inside])
        step = rotation.log_so3(np.swapaxes(start, 1, 2) @ end)
        turned[inside] = start @ rotation.exp_so3(share[inside, None] * step)
    turned[np.isnan(share)] = np.nan
    return turned


def _broken(channel: Channel) -> int:
    finite = np.ones(len(channel["time_us"]), bool)
    for column in channel.values():
        finite &= np.isfinite(column.reshape(len(column), -1)).all(axis=1)
    return int(np.sum(channel["valid"] & ~finite))


def _attitude(channel: Channel, reference: Reference, sigma: Array | None) -> Series:
    estimate = (channel["roll"], channel["pitch"], channel["heading"])
    error = np.column_stack(
        [rotation.wrap_pi(e - r) for e, r in zip(estimate, reference.euler, strict=True)]
    )
    error[~channel["valid"]] = np.nan
    steep = np.abs(reference.euler[1]) > STEEPEST_PITCH
    error[np.ix_(steep, (0, 2))] = np.nan
    return Series(("roll", "pitch", "heading"), error, sigma)


def compare_sahrs(recording: Recording, name: str = "TRUTH") -> Estimates:
    """Errors of SAHRS against the reference channel, at the times of SAHRS."""
    sahrs = recording["SAHRS"]
    reference = reference_at(recording, name, sahrs["time_us"])
    C_NB = rotation.C_NB_from_q_NB(sahrs["q_NB"])
    turned = np.swapaxes(reference.C_NB, 1, 2) @ C_NB
    known = sahrs["valid"] & np.isfinite(turned).all(axis=(1, 2))
    error_B = np.full((len(known), 3), np.nan)
    error_B[known] = rotation.log_so3(turned[known])
    return Estimates(
        time_us=sahrs["time_us"],
        available=float(np.mean(sahrs["valid"])),
        broken=_broken(sahrs),
        attitude=_attitude(sahrs, reference, None),
        rotation=Series(("roll_axis", "pitch_axis", "yaw_axis"), error_B, sahrs["sigma_B"]),
    )


def compare_nav(recording: Recording, name: str = "TRUTH") -> Estimates:
    """Errors of NAV against the reference channel, at the times of NAV."""
    nav = recording["NAV"]
    valid = nav["valid"]
    reference = reference_at(recording, name, nav["time_us"])
    position = north_east_m(nav["lat"], nav["lon"], reference.lat, reference.lon, reference.h)
    velocity = (nav["v_N"] - reference.v_N)[:, :2]
    position[~valid] = velocity[~valid] = np.nan
    wind = None
    if reference.wind_N is not None:
        error = nav["wind_N"][:, :2] - reference.wind_N[:, :2]
        error[~valid] = np.nan
        wind = Series(("wind_north", "wind_east"), error, nav["sigma_wind"])
    return Estimates(
        time_us=nav["time_us"],
        available=float(np.mean(valid)),
        broken=_broken(nav),
        attitude=_attitude(nav, reference, nav["sigma_attitude"]),
        position=Series(
            ("position_north", "position_east"), position, nav["sigma_position"][:, :2]
        ),
        velocity=Series(
            ("velocity_north", "velocity_east"), velocity, nav["sigma_velocity"][:, :2]
        ),
        wind=wind,
    )


def _dead_reckoning(recording: Recording, name: str) -> Estimates | None:
    """From the first time that SAHRS, air data and reference are all there."""
    if not (_has(recording, "SAHRS") and _has(recording, "ADC")):
        return None
    sahrs, adc = recording["SAHRS"], recording["ADC"]
    time_us = sahrs["time_us"]
    reference = reference_at(recording, name, time_us)
    v_N = air_velocity_N(sahrs, adc)
    ready = sahrs["valid"] & np.isfinite(v_N[:, 0]) & np.isfinite(reference.lat)
    if not ready.any():
        return None
    start = int(np.argmax(ready))
    error = np.full((len(time_us), 2), np.nan)
    h = np.interp(time_us[start:], adc["time_us"], adc["baro_altitude"])
    lat, lon = dead_reckon(
        time_us[start:], v_N[start:], reference.lat[start], reference.lon[start], h
    )
    error[start:] = north_east_m(
        lat, lon, reference.lat[start:], reference.lon[start:], reference.h[start:]
    )
    wind = None
    if reference.wind_N is not None:
        # Still air is what it assumes.
        wind = Series(("wind_north", "wind_east"), 0.0 - reference.wind_N[:, :2])
    return Estimates(
        time_us=time_us,
        available=float(np.mean(ready)),
        position=Series(("position_north", "position_east"), error),
        velocity=Series(
            ("velocity_north", "velocity_east"),
            np.where(ready[:, None], v_N - reference.v_N, np.nan)[:, :2],
        ),
        wind=wind,
    )
