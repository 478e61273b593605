# SPDX-License-Identifier: Apache-2.0
"""Where attitude and air data alone lead, in still air: the position before any correction."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from lodestar import _core, rotation
from lodestar.recordings.recording import Channel

Array = NDArray[np.float64]


def air_velocity_N(attitude: Channel, air_data: Channel) -> Array:
    """Velocity (n, 3) relative to the air in N, m/s, at the times of the attitude messages.

    The latest valid air data holds until the next; NaN before the first.
    """
    valid = air_data["valid"]
    speed, alpha, beta = (air_data[name][valid] for name in ("true_airspeed", "alpha", "beta"))
    v_air_B = speed[:, None] * np.column_stack(
        [np.cos(alpha) * np.cos(beta), np.sin(beta), np.sin(alpha) * np.cos(beta)]
    )
    row = np.searchsorted(air_data["time_us"][valid], attitude["time_us"], side="right") - 1
    held = np.full((len(row), 3), np.nan)
    held[row >= 0] = v_air_B[row[row >= 0]]
    velocity: Array = np.einsum("nij,nj->ni", rotation.C_NB_from_q_NB(attitude["q_NB"]), held)
    return velocity


def dead_reckon(
    time_us: NDArray[np.int64], v_N: Array, lat: float, lon: float, h: Array
) -> tuple[Array, Array]:
    """Latitude and longitude (rad) from a start, by velocities (n, 3) m/s at heights (n,) m.

    WGS84 rates, integrated by the trapezoidal rule.
    """
    t = (time_us - time_us[0]) * 1e-6
    latitude = np.full(len(t), lat)
    # The radius depends so little on latitude that this contracts by 1e-3 and more each time.
    for _ in range(4):
        rate = v_N[:, 0] / (_core.meridian_radius(latitude) + h)
        latitude = lat + cumulative_trapezoid(rate, t, initial=0)
    rate = v_N[:, 1] / ((_core.transverse_radius(latitude) + h) * np.cos(latitude))
    return latitude, lon + cumulative_trapezoid(rate, t, initial=0)
