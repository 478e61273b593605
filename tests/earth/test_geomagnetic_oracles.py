# SPDX-License-Identifier: Apache-2.0
"""The field against independent implementations of the same models."""

from datetime import datetime, timedelta

import numpy as np
import ppigrf
import pytest
from pygeomag import GeoMag

from lodestar import _core

POINTS = 1000


def random_places(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Latitude and longitude in degrees, even over the sphere, and height in km."""
    lat = np.degrees(np.arcsin(rng.uniform(-1.0, 1.0, POINTS)))
    return lat, rng.uniform(-180.0, 180.0, POINTS), rng.uniform(-1.0, 30.0, POINTS)


def our_field(lat, lon, h, year, model):
    return _core.geomagnetic_field(np.radians(lat), np.radians(lon), 1e3 * h, year, model)


@pytest.mark.parametrize("first_year", [1960, 2010, 2015, 2020, 2025])
def test_igrf14_agrees_with_ppigrf(first_year: int) -> None:
    rng = np.random.default_rng(first_year)
    lat, lon, h = random_places(rng)
    # ppigrf interpolates by days between epochs; in decimal years as long as that the two are one.
    days = (datetime(first_year + 5, 1, 1) - datetime(first_year, 1, 1)).days
    for fraction in rng.uniform(0.0, 1.0, 4):
        date = datetime(first_year, 1, 1) + timedelta(days=days * fraction)
        east, north, up = ppigrf.igrf(lon, lat, h, date)
        expected = np.stack([north[0], east[0], -up[0]], axis=1)
        ours = our_field(lat, lon, h, first_year + 5.0 * fraction, "igrf14")
        np.testing.assert_allclose(ours, expected, rtol=0, atol=1e-3)


def test_wmm2025_agrees_with_pygeomag() -> None:
    rng = np.random.default_rng(2)
    lat, lon, h = random_places(rng)
    year = rng.uniform(2025.0, 2030.0, POINTS)
    oracle = GeoMag(coefficients_file="wmm/WMM_2025.COF")
    results = [
        oracle.calculate(glat=a, glon=b, alt=c, time=t)
        for a, b, c, t in zip(lat, lon, h, year, strict=True)
    ]
    expected = np.array([(r.x, r.y, r.z) for r in results])
    np.testing.assert_allclose(our_field(lat, lon, h, year, "wmm2025"), expected, atol=1e-3, rtol=0)


def test_arguments_broadcast() -> None:
    lat = np.array([[0.1], [0.2]])
    year = np.array([2012.8, 2020.0, 2026.0])
    field = _core.geomagnetic_field(lat, 0.5, 1000.0, year)
    assert field.shape == (2, 3, 3)
    np.testing.assert_array_equal(field[1, 2], _core.geomagnetic_field(0.2, 0.5, 1000.0, 2026.0))


def test_beyond_the_epochs_the_nearest_is_used_and_a_warning_says_so() -> None:
    with pytest.warns(RuntimeWarning, match=r"decimal_year: outside 2025 to 2030 of wmm2025"):
        early = _core.geomagnetic_field(0.5, 0.5, 0.0, 2012.8, "wmm2025")
    np.testing.assert_array_equal(early, _core.geomagnetic_field(0.5, 0.5, 0.0, 2025.0, "wmm2025"))
    with pytest.warns(RuntimeWarning, match=r"h: outside -1000 to 600000 m of igrf14"):
        _core.geomagnetic_field(0.5, 0.5, 700e3, 2020.0)


def test_unknown_model_is_named_with_those_allowed() -> None:
    with pytest.raises(ValueError, match=r"unknown geomagnetic model 'emm' .*igrf14, wmm2025"):
        _core.geomagnetic_field(0.5, 0.5, 0.0, 2020.0, "emm")  # type: ignore[arg-type]
