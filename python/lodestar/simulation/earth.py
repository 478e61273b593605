# SPDX-License-Identifier: Apache-2.0
"""The Earth and the atmosphere that the simulated aircraft flies in: WGS84 and the ISA.

Written apart from the flight computer's own Earth model, so that a slip in either shows.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

SEMI_MAJOR_AXIS = 6378137.0  # m
FLATTENING = 1 / 298.257223563
ECCENTRICITY_SQUARED = FLATTENING * (2 - FLATTENING)
EARTH_RATE = 7.292115e-5  # rad/s
STANDARD_GRAVITY = 9.80665  # m/s^2, of the load factor only

_EQUATORIAL_GRAVITY = 9.7803253359  # m/s^2
_SOMIGLIANA = 1.931852652458e-3
_GRAVITY_RATIO = 3.449786506841e-3  # centrifugal over gravitational, at the equator


def meridian_radius(lat: ArrayLike) -> Array:
    """Radius of curvature (m) along the meridian at latitude ``lat`` (rad)."""
    flattened = 1 - ECCENTRICITY_SQUARED * np.sin(lat) ** 2
    return np.asarray(SEMI_MAJOR_AXIS * (1 - ECCENTRICITY_SQUARED) / flattened**1.5)


def transverse_radius(lat: ArrayLike) -> Array:
    """Radius of curvature (m) across the meridian at latitude ``lat`` (rad)."""
    return np.asarray(SEMI_MAJOR_AXIS / np.sqrt(1 - ECCENTRICITY_SQUARED * np.sin(lat) ** 2))


def gravity(lat: ArrayLike, h: ArrayLike) -> Array:
    """Normal gravity (m/s^2, down) at latitude (rad) and ellipsoidal height (m).

    Somigliana's closed formula with the height correction to second order (NIMA TR8350.2,
    eq. 4-1 and 4-3).
    """
    squared = np.sin(lat) ** 2
    on_ellipsoid = (
        _EQUATORIAL_GRAVITY
        * (1 + _SOMIGLIANA * squared)
        / np.sqrt(1 - ECCENTRICITY_SQUARED * squared)
    )
    ratio = np.asarray(h, float) / SEMI_MAJOR_AXIS
    slope = 1 + FLATTENING + _GRAVITY_RATIO - 2 * FLATTENING * squared
    return np.asarray(on_ellipsoid * (1 - 2 * slope * ratio + 3 * ratio**2))


def earth_rate_N(lat: ArrayLike) -> Array:
    """Rate of the Earth in N (..., 3), rad/s."""
    lat = np.asarray(lat, float)
    return np.stack(
        [EARTH_RATE * np.cos(lat), np.zeros_like(lat), -EARTH_RATE * np.sin(lat)], axis=-1
    )


def transport_rate_N(lat: Array, h: Array, v_N: Array) -> Array:
    """Rate of N over the Earth, in N (..., 3), rad/s, at ground velocity v_N (..., 3) in m/s."""
    about_north = v_N[..., 1] / (transverse_radius(lat) + h)
    about_east = -v_N[..., 0] / (meridian_radius(lat) + h)
    return np.stack([about_north, about_east, -about_north * np.tan(lat)], axis=-1)


def air_temperature(h: ArrayLike) -> Array:
    """Temperature (K) of the standard atmosphere at height (m), up to 20 km."""
    return np.asarray(288.15 - 0.0065 * np.minimum(h, 11e3))


def air_density(h: ArrayLike) -> Array:
    """Density (kg/m^3) of the standard atmosphere at height (m), up to 20 km."""
    in_troposphere = 1.225 * (air_temperature(h) / 288.15) ** 4.25588
    above = np.maximum(np.asarray(h, float) - 11e3, 0.0)
    return np.asarray(in_troposphere * np.exp(-above / 6341.62))
