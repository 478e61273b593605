# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pymap3d
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lodestar import _core

latitudes = st.floats(-np.pi / 2, np.pi / 2)
longitudes = st.floats(-np.pi, np.pi)
heights = st.floats(-10e3, 1000e3)


def random_places(seed: int, ceiling: float = 1000e3) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    lat = rng.uniform(-np.pi / 2, np.pi / 2, 2000)
    return lat, rng.uniform(-np.pi, np.pi, 2000), rng.uniform(-10e3, ceiling, 2000)


def test_ecef_agrees_with_pymap3d() -> None:
    lat, lon, h = random_places(1)
    expected = np.stack(pymap3d.geodetic2ecef(lat, lon, h, deg=False), axis=1)
    np.testing.assert_allclose(_core.geodetic_to_ecef(lat, lon, h), expected, rtol=0, atol=1e-8)


def test_geodetic_agrees_with_pymap3d() -> None:
    # Up to 300 km: at 1000 km pymap3d misses its own way back by 1.2e-9 rad.
    p_E = _core.geodetic_to_ecef(*random_places(2, ceiling=300e3))
    lat, lon, h = _core.ecef_to_geodetic(p_E)
    expected = pymap3d.ecef2geodetic(*p_E.T, deg=False)
    np.testing.assert_allclose([lat, lon], expected[:2], rtol=0, atol=1e-10)
    np.testing.assert_allclose(h, expected[2], rtol=0, atol=1e-8)


def test_radii_agree_with_pymap3d() -> None:
    lat = random_places(3)[0]
    np.testing.assert_allclose(
        _core.meridian_radius(lat), pymap3d.rcurve.meridian(lat, deg=False), rtol=1e-14
    )
    np.testing.assert_allclose(
        _core.transverse_radius(lat), pymap3d.rcurve.transverse(lat, deg=False), rtol=1e-14
    )


@given(latitudes, longitudes, heights)
def test_geodetic_to_ecef_and_back_is_the_same_place(lat: float, lon: float, h: float) -> None:
    p_E = _core.geodetic_to_ecef(lat, lon, h)
    back = _core.ecef_to_geodetic(p_E)
    assert abs(back[0] - lat) < 1e-9
    assert abs(back[2] - h) < 1e-6
    np.testing.assert_allclose(_core.geodetic_to_ecef(*back), p_E, rtol=0, atol=1e-8)


@given(latitudes, longitudes, heights)
def test_height_adds_along_the_normal(lat: float, lon: float, h: float) -> None:
    rise = _core.geodetic_to_ecef(lat, lon, h) - _core.geodetic_to_ecef(lat, lon, 0.0)
    up = np.array([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)])
    np.testing.assert_allclose(rise, h * up, rtol=0, atol=1e-8)


def exact_normal_gravity(lat: np.ndarray, h: np.ndarray) -> np.ndarray:
    """Closed form in ellipsoidal coordinates (u, beta): TR8350.2 eq. 4-5 to 4-15."""
    a, f, rate, gm = 6378137.0, 1.0 / 298.257223563, 7.292115e-5, 3.986004418e14
    b = a * (1.0 - f)
    focal = np.sqrt(a**2 - b**2)
    x, _, z = _core.geodetic_to_ecef(lat, 0.0, h).T
    excess = x**2 + z**2 - focal**2
    u = np.sqrt(0.5 * excess * (1.0 + np.sqrt(1.0 + 4.0 * (focal * z / excess) ** 2)))
    v = np.sqrt(u**2 + focal**2)
    beta = np.arctan2(z * v, u * x)
    w = np.sqrt(u**2 + (focal * np.sin(beta)) ** 2) / v

    def q(u: np.ndarray) -> np.ndarray:
        return 0.5 * ((1.0 + 3.0 * (u / focal) ** 2) * np.arctan(focal / u) - 3.0 * u / focal)

    slope = 3.0 * (1.0 + (u / focal) ** 2) * (1.0 - u / focal * np.arctan(focal / u)) - 1.0
    rotation = (rate * a) ** 2
    mass = (gm + rotation * focal * slope / q(b) * (0.5 * np.sin(beta) ** 2 - 1.0 / 6.0)) / v**2
    along_u = (mass - rate**2 * u * np.cos(beta) ** 2) / w
    along_beta = (rotation / v * q(u) / q(b) - rate**2 * v) * np.sin(beta) * np.cos(beta) / w
    return np.hypot(along_u, along_beta)


def test_gravity_is_that_of_the_closed_form() -> None:
    lat, h = np.meshgrid(np.linspace(-np.pi / 2, np.pi / 2, 37), np.linspace(-1e3, 30e3, 32))
    lat, h = lat.ravel(), h.ravel()
    error = _core.gravity(lat, h) - exact_normal_gravity(lat, h)
    # The series in height ends at the second order: what is left out grows to this at 30 km.
    assert np.max(np.abs(error)) < 1e-5
    assert np.max(np.abs(error[np.abs(h) < 500.0])) < 1e-8


def test_positions_need_three_coordinates() -> None:
    with pytest.raises(ValueError, match=r"p_E: the last axis must have size 3"):
        _core.ecef_to_geodetic(np.zeros((4, 2)))
