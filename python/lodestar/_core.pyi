# SPDX-License-Identifier: Apache-2.0
"""The C++ core of Lodestar. Arrays broadcast as in NumPy; `...` is their common shape."""

from typing import Any, Literal, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

def geomagnetic_field(
    lat: ArrayLike,
    lon: ArrayLike,
    h: ArrayLike,
    decimal_year: ArrayLike,
    model: Literal["igrf14", "wmm2025"] = "igrf14",
) -> NDArray[np.float64]:
    """Geomagnetic field in N (north, east, down), nT, shape (..., 3).

    `lat` (geodetic) and `lon` in rad, `h` in m above the ellipsoid. IGRF-14 covers 1900 to 2030 and
    -1 to 600 km, WMM2025 2025 to 2030 and -1 to 850 km; outside, the nearest epoch is used or the
    field is extrapolated in height, and a RuntimeWarning says so. ValueError: unknown model, or
    shapes that do not broadcast.
    """

@overload
def gravity(lat: float, h: float) -> float: ...
@overload
def gravity(lat: ArrayLike, h: ArrayLike) -> NDArray[np.float64]:
    """WGS84 normal gravity (Somigliana with the height correction to second order), m/s^2."""

@overload
def meridian_radius(lat: float) -> float: ...
@overload
def meridian_radius(lat: ArrayLike) -> NDArray[np.float64]:
    """Radius of curvature of the WGS84 meridian, m, at geodetic `lat` (rad)."""

@overload
def transverse_radius(lat: float) -> float: ...
@overload
def transverse_radius(lat: ArrayLike) -> NDArray[np.float64]:
    """Radius of curvature in the WGS84 prime vertical, m, at geodetic `lat` (rad)."""

def geodetic_to_ecef(lat: ArrayLike, lon: ArrayLike, h: ArrayLike) -> NDArray[np.float64]:
    """Position in E, m, shape (..., 3), of geodetic `lat`, `lon` (rad), `h` (m)."""

def ecef_to_geodetic(
    p_E: ArrayLike,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Geodetic `lat`, `lon` (rad) and `h` (m), shape (...), of positions `p_E` (m, shape (..., 3)).

    ValueError: the last axis of `p_E` is not 3 long.
    """

class ConfigError(ValueError):
    """A configuration is wrong: one line with file, line, key and what is allowed."""

def check_config(text: str, source: str) -> None:
    """Raise ConfigError if `text` (TOML) is not a valid configuration; `source` names it."""

def parameter_table() -> str:
    """Table of all configuration keys, in Markdown."""

def run(
    config_text: str,
    calibration: str | bytes,
    channels: dict[str, dict[str, NDArray[Any]]],
    names: list[str],
    channel: NDArray[np.int64],
    row: NDArray[np.int64],
) -> dict[str, dict[str, NDArray[Any]]]:
    """Run messages through a fresh Navigator and return the answers: channel, field, array.

    Message i is row `row[i]` of `channels[names[channel[i]]]`. ConfigError for a bad configuration,
    ValueError for arrays that are not those of the channel. See lodestar.navigator.run.
    """

class StorageError(OSError):
    """A calibration file cannot be read, written or used: one line with its path and why."""

def calibrate_flight(
    config_text: str, ins: dict[str, NDArray[Any]], smdu: dict[str, NDArray[Any]]
) -> dict[str, Any]:
    """Calibrate SMDU by INS with the flight computer's filter; arrays are a recording's channels.

    The answer has x (12,), P (12, 12), verdict (text), checks (name: (value, limit)), time_us,
    epoch_year and airframe. ConfigError for a bad configuration, ValueError for bad arrays.
    """

def calibrate_ground(
    config_text: str, ins: dict[str, NDArray[Any]], smdu: dict[str, NDArray[Any]]
) -> dict[str, Any]:
    """Calibrate bias and a common scale by a swing on the ground; answers as calibrate_flight."""

def store_calibration(
    path: str,
    airframe: str,
    time_us: int,
    epoch_year: float,
    ground: bool,
    x: NDArray[np.float64],
    P: NDArray[np.float64],
) -> None:
    """Store a calibration for lodestar-fc --calibration; the one before is kept.

    StorageError where it cannot be written.
    """

def load_calibration(path: str, airframe: str) -> dict[str, Any] | None:
    """A stored calibration: x, P, airframe, time_us, epoch_year, source, note. None: not there yet.

    StorageError if it, and the one before, are refused.
    """
