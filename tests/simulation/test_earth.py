# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pymap3d
import pytest

from lodestar import _core
from lodestar.simulation import earth

LAT = np.radians(np.linspace(-80, 80, 33))


def test_radii_agree_with_an_independent_package():
    np.testing.assert_allclose(
        earth.meridian_radius(LAT), pymap3d.rcurve.meridian(LAT, deg=False), rtol=1e-12
    )
    np.testing.assert_allclose(
        earth.transverse_radius(LAT), pymap3d.rcurve.transverse(LAT, deg=False), rtol=1e-12
    )


@pytest.mark.parametrize("h", [-100.0, 0.0, 3000.0, 20e3])
def test_flight_computer_believes_in_the_same_gravity(h):
    np.testing.assert_allclose(earth.gravity(LAT, h), _core.gravity(LAT, h), rtol=1e-12)


def test_transport_rate_moves_the_position_as_the_velocity_does():
    lat, h, v_N = np.array(1.0), np.array(2500.0), np.array([120.0, -80.0, 3.0])
    rate_N = earth.transport_rate_N(lat, h, v_N)
    lat_rate = v_N[0] / (earth.meridian_radius(lat) + h)
    lon_rate = v_N[1] / ((earth.transverse_radius(lat) + h) * np.cos(lat))
    expected = [lon_rate * np.cos(lat), -lat_rate, -lon_rate * np.sin(lat)]
    np.testing.assert_allclose(rate_N, expected, rtol=1e-14)


@pytest.mark.parametrize(
    ("h", "temperature", "density"),
    [
        (0.0, 288.15, 1.225),
        (5000.0, 255.65, 0.73612),
        (11000.0, 216.65, 0.36392),
        (20000.0, 216.65, 0.08803),
    ],
)
def test_standard_atmosphere_is_the_tabulated_one(h, temperature, density):
    # Tables of the US Standard Atmosphere, printed to four or five digits (geopotential height).
    assert float(earth.air_temperature(h)) == pytest.approx(temperature, abs=0.01)
    assert float(earth.air_density(h)) == pytest.approx(density, rel=2e-4)
