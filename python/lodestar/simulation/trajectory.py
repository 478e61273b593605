# SPDX-License-Identifier: Apache-2.0
"""The whole truth of a flight: from the path through the air to attitude, rates and forces.

The path (flight_path) gives velocity through the air. With the wind it gives ground velocity, and
from that follow, each by calculus alone: position; specific force, from the acceleration over the
rotating Earth; angle of attack and sideslip, from the forces across the path; attitude; rates.
Integrate the rates and the attitude comes back; integrate the specific force and so do velocity
and position.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lodestar._core import geomagnetic_field
from lodestar.rotation import (
    C_NB_from_euler,
    euler_from_C_NB,
    q_NB_from_C_NB,
    quaternion_conjugate,
    quaternion_product,
)
from lodestar.simulation.calculus import derivative, running_integral
from lodestar.simulation.earth import (
    STANDARD_GRAVITY,
    air_density,
    earth_rate_N,
    gravity,
    meridian_radius,
    transport_rate_N,
    transverse_radius,
)
from lodestar.simulation.flight_path import FlightPath

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Aircraft:
    """How the air holds the aircraft up: what alpha and beta the forces take.

    alpha = zero_lift_alpha + load * wing_loading / (lift_slope * dynamic pressure), and beta
    likewise from the lateral load with side_slope. Fighter-like by default (wing loading N/m^2,
    slopes 1/rad).
    """

    wing_loading: float = 3300.0
    lift_slope: float = 3.6
    side_slope: float = 1.0
    zero_lift_alpha: float = 0.0


@dataclass(frozen=True)
class Trajectory:
    """Truth, (n,) or (n, k) arrays over the samples; frames and units as in the names.

    time_us (int64); lat, lon (rad), h (m, ellipsoid); v_N (m/s over ground); roll, pitch, heading
    (rad) and q_NB; omega_B (rad/s, relative to the inertial frame); f_B (m/s^2, specific force);
    wind_N (m/s, gusts included); true_airspeed (m/s), alpha, beta (rad), all of the gusty air;
    b_N (nT, WMM2025).
    """

    rate_hz: int
    time_us: NDArray[np.int64]
    lat: Array
    lon: Array
    h: Array
    v_N: Array
    roll: Array
    pitch: Array
    heading: Array
    q_NB: Array
    C_NB: Array
    omega_B: Array
    f_B: Array
    wind_N: Array
    true_airspeed: Array
    alpha: Array
    beta: Array
    b_N: Array


def fly_path(
    path: FlightPath, wind_N: Array, gust_B: Array, aircraft: Aircraft, decimal_year: float
) -> Trajectory:
    """Fly a path in wind (n, 3) and gusts (n, 3), m/s, given at the samples of the path."""
    interval = 1 / path.rate_hz
    C_NW = C_NB_from_euler(path.bank, path.path_angle, path.track)
    v_N = path.airspeed[:, None] * C_NW[:, :, 0] + wind_N
    lat, lon, h = _position(path, v_N, interval)

    earth_rate = earth_rate_N(lat)
    transport_rate = transport_rate_N(lat, h, v_N)
    f_N = derivative(v_N, interval) + np.cross(2 * earth_rate + transport_rate, v_N)
    f_N[:, 2] -= gravity(lat, h)

    C_NB = C_NW @ _C_WB(path, h, _transposed_times(C_NW, f_N), aircraft)
    q_NB = continuous_q_NB(C_NB)
    omega_NB_B = 2 * quaternion_product(quaternion_conjugate(q_NB), derivative(q_NB, interval))
    return assemble(
        path.rate_hz,
        lat=lat,
        lon=lon,
        h=h,
        v_N=v_N,
        C_NB=C_NB,
        q_NB=q_NB,
        omega_B=omega_NB_B[:, 1:] + _transposed_times(C_NB, earth_rate + transport_rate),
        f_B=_transposed_times(C_NB, f_N),
        wind_N=wind_N + np.einsum("nij,nj->ni", C_NB, gust_B),
        decimal_year=decimal_year,
    )


def assemble(
    rate_hz: int,
    *,
    lat: Array,
    lon: Array,
    h: Array,
    v_N: Array,
    C_NB: Array,
    q_NB: Array,
    omega_B: Array,
    f_B: Array,
    wind_N: Array,
    decimal_year: float,
) -> Trajectory:
    """The trajectory of a motion: what follows from it by definition is added."""
    roll, pitch, heading = euler_from_C_NB(C_NB)
    v_air_B = _transposed_times(C_NB, v_N - wind_N)
    true_airspeed = np.linalg.norm(v_air_B, axis=-1)
    return Trajectory(
        rate_hz=rate_hz,
        time_us=np.round(np.arange(len(lat)) * (1e6 / rate_hz)).astype(np.int64),
        lat=lat,
        lon=lon,
        h=h,
        v_N=v_N,
        roll=roll,
        pitch=pitch,
        heading=heading,
        q_NB=q_NB,
        C_NB=C_NB,
        omega_B=omega_B,
        f_B=f_B,
        wind_N=wind_N,
        true_airspeed=true_airspeed,
        alpha=np.arctan2(v_air_B[:, 2], v_air_B[:, 0]),
        beta=np.arcsin(v_air_B[:, 1] / true_airspeed),
        b_N=geomagnetic_field(lat, lon, h, decimal_year, model="wmm2025"),
    )


def _position(path: FlightPath, v_N: Array, interval: float) -> tuple[Array, Array, Array]:
    h = path.start.altitude - running_integral(v_N[:, 2], interval)
    lat = np.full_like(h, path.start.lat)
    # The meridian radius hardly depends on latitude: three rounds settle to 1e-13 rad.
    for _ in range(3):
        rate = v_N[:, 0] / (meridian_radius(lat) + h)
        lat = path.start.lat + running_integral(rate, interval)
    eastward = v_N[:, 1] / ((transverse_radius(lat) + h) * np.cos(lat))
    return lat, path.start.lon + running_integral(eastward, interval), h


def _C_WB(path: FlightPath, h: Array, f_W: Array, aircraft: Aircraft) -> Array:
    """Attitude relative to the flight-path frame W (n, 3, 3): the alpha and beta that f_W takes."""
    dynamic_pressure = 0.5 * air_density(h) * path.airspeed**2
    per_load = aircraft.wing_loading / (STANDARD_GRAVITY * dynamic_pressure)
    alpha = aircraft.zero_lift_alpha - f_W[:, 2] * per_load / aircraft.lift_slope
    beta = -f_W[:, 1] * per_load / aircraft.side_slope
    ca, sa, cb, sb = np.cos(alpha), np.sin(alpha), np.cos(beta), np.sin(beta)
    zero = np.zeros_like(alpha)
    # Rows are the axes of W in B; the first is the direction of the velocity.
    rows = [
        [ca * cb, sb, sa * cb],
        [-ca * sb, cb, -sa * sb],
        [-sa, zero, ca],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _transposed_times(C: Array, v: Array) -> Array:
    return np.asarray(np.einsum("nji,nj->ni", C, v))


def continuous_q_NB(C_NB: Array) -> Array:
    """Quaternions (n, 4) of a motion's attitudes (n, 3, 3), without jumps between q and -q."""
    q = q_NB_from_C_NB(C_NB)
    same_side = np.sum(q[1:] * q[:-1], axis=-1) >= 0
    sign = np.cumprod(np.concatenate([[1.0], np.where(same_side, 1.0, -1.0)]))
    return np.asarray(q * sign[:, None])
