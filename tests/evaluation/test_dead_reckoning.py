# SPDX-License-Identifier: Apache-2.0
import numpy as np
from scipy.integrate import solve_ivp

from lodestar.evaluation.dead_reckoning import air_velocity_N, dead_reckon
from lodestar.simulation import earth


def test_agrees_with_a_fine_integration_of_the_wgs84_rates():
    h = 3000.0

    def velocity(t):
        heading = 0.5 + 2.0 * np.sin(t / 40)
        return 200 * np.cos(heading), 200 * np.sin(heading)

    def rates(t, x):
        north, east = velocity(t)
        return [
            north / (earth.meridian_radius(x[0]) + h),
            east / ((earth.transverse_radius(x[0]) + h) * np.cos(x[0])),
        ]

    t = np.arange(0, 1200.01, 0.02)
    fine = solve_ivp(rates, (0, t[-1]), [1.0, 0.3], t_eval=t, rtol=1e-12, atol=1e-15)
    v_N = np.column_stack([*velocity(t), np.zeros_like(t)])
    time_us = np.rint(t * 1e6).astype(np.int64)
    lat, lon = dead_reckon(time_us, v_N, 1.0, 0.3, np.full_like(t, h))
    # 1 cm after 240 km: the trapezoidal rule at 50 Hz in turns of 3 deg/s.
    np.testing.assert_allclose(lat, fine.y[0], atol=1e-2 / 6.4e6)
    np.testing.assert_allclose(lon, fine.y[1], atol=1e-2 / 6.4e6)


def test_air_data_hold_until_the_next_and_invalid_ones_do_not_count():
    attitude = {"time_us": np.array([0, 10, 20, 30]), "q_NB": np.tile([1.0, 0, 0, 0], (4, 1))}
    air_data = {
        "time_us": np.array([5, 15, 25]),
        "true_airspeed": np.array([100.0, 999.0, 120.0]),
        "alpha": np.array([0.0, 0.0, 0.1]),
        "beta": np.array([0.0, 0.0, 0.2]),
        "valid": np.array([True, False, True]),
    }
    v_N = air_velocity_N(attitude, air_data)
    assert np.isnan(v_N[0]).all()
    np.testing.assert_allclose(v_N[1:3], [[100, 0, 0], [100, 0, 0]], rtol=1e-12)
    u, v, w = v_N[3]
    np.testing.assert_allclose(
        [np.hypot(np.hypot(u, v), w), np.arctan2(w, u), np.arcsin(v / 120.0)],
        [120.0, 0.1, 0.2],
        rtol=1e-12,
    )
