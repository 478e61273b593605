# SPDX-License-Identifier: Apache-2.0
"""The test values that the authors of the models publish."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from lodestar import _core

DATA = Path(__file__).parents[2].parent / "shared/data/geomagnetic"


def load(name: str) -> NDArray[np.float64]:
    path = DATA / name
    if not path.exists():
        pytest.skip(f"no official test values: {path} is missing")
    return np.loadtxt(path)


def test_igrf14_gives_the_official_values_to_their_last_digit() -> None:
    year, colatitude, longitude, radius, *official = load("IGRF14_TEST_VALUES.txt").T
    theta, lon, r = np.radians(colatitude), np.radians(longitude), 1e3 * radius
    equatorial = r * np.sin(theta)
    p_E = np.stack([equatorial * np.cos(lon), equatorial * np.sin(lon), r * np.cos(theta)], axis=1)
    lat, lon, h = _core.ecef_to_geodetic(p_E)
    with pytest.warns(RuntimeWarning, match="extrapolated"):  # one point is 6300 km from the centre
        north, east, down = _core.geomagnetic_field(lat, lon, h, year).T

    # The official values are geocentric: turn north and down about east.
    turn = np.pi / 2 - theta - lat
    geocentric = [
        np.cos(turn) * north + np.sin(turn) * down,
        east,
        np.cos(turn) * down - np.sin(turn) * north,
    ]
    # Printed to 0.01 nT, but the values from 2010 on are cut off there, not rounded.
    np.testing.assert_allclose(geocentric, official, rtol=0, atol=0.01)


def test_wmm2025_gives_the_official_field_to_its_last_digit_where_that_is_right() -> None:
    year, altitude, lat, lon, *official = load("WMM2025_TEST_VALUES.txt").T
    field = _core.geomagnetic_field(
        np.radians(lat), np.radians(lon), 1e3 * altitude, year, "wmm2025"
    )
    north, east, down = field.T
    declination, inclination, horizontal, x, y, z, total = official[:7]

    np.testing.assert_allclose(east, y, rtol=0, atol=0.6e-6)  # printed to 1e-6 nT
    # The published X, and what is made of it, carries an error of up to 7e-4 nT of its own, as two
    # independent implementations (this one and pygeomag) agree to 1e-6 nT at the same points;
    # Z takes its share through the 0.2 degrees between geodetic and geocentric north.
    np.testing.assert_allclose(north, x, rtol=0, atol=1e-3)
    np.testing.assert_allclose(down, z, rtol=0, atol=4e-6)
    np.testing.assert_allclose(np.hypot(north, east), horizontal, rtol=0, atol=1e-3)
    np.testing.assert_allclose(np.linalg.norm(field, axis=1), total, rtol=0, atol=1e-3)
    # Printed to 0.01 degrees.
    np.testing.assert_allclose(
        np.degrees(np.arctan2(east, north)), declination, rtol=0, atol=0.00501
    )
    np.testing.assert_allclose(
        np.degrees(np.arctan2(down, np.hypot(north, east))), inclination, rtol=0, atol=0.00501
    )


def test_wmm2025_gives_the_official_secular_variation() -> None:
    year, altitude, lat, lon, *official = load("WMM2025_TEST_VALUES.txt").T
    place = (np.radians(lat), np.radians(lon), 1e3 * altitude)
    # The model is linear in time: a difference over any part of 2025 to 2030 is the derivative.
    later = _core.geomagnetic_field(*place, 2029.0, "wmm2025")
    earlier = _core.geomagnetic_field(*place, 2025.0, "wmm2025")
    variation = (later - earlier).T / 4.0
    assert np.all((year >= 2025.0) & (year <= 2030.0))
    # Printed to 1e-6 nT/year; X and Z with the error of the field above in proportion.
    np.testing.assert_allclose(variation, official[10:13], rtol=0, atol=5e-6)
