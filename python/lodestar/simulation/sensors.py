# SPDX-License-Identifier: Apache-2.0
"""What the sensors of a suite give on a flight: columns of messages by channel and field.

Each function returns the fields of one LCM type as arrays over its messages. Samples are taken at
the instants of the trajectory nearest to the sensor's own period; ``time_us`` is exactly theirs.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodestar.rotation import wrap_2pi, wrap_pi
from lodestar.simulation.earth import (
    STANDARD_GRAVITY,
    air_temperature,
    meridian_radius,
    transverse_radius,
)
from lodestar.simulation.sensor_errors import ErrorModel, measured, random_stream
from lodestar.simulation.suites import AirDataErrors, GpsErrors, InsErrors, Suite
from lodestar.simulation.trajectory import Trajectory

Array = NDArray[np.float64]
Columns = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class GpsService:
    """How the scenario's GPS behaves: error kind ("markov" or "white"), velocity given or not.

    latency: s from validity to arrival. outages: (start, duration) in s, with no fix at all.
    """

    errors: str = "markov"
    velocity: bool = False
    latency: float = 0.2
    outages: tuple[tuple[float, float], ...] = ()


def sense(
    trajectory: Trajectory,
    suite: Suite,
    gps: GpsService,
    *,
    calibrated: bool,
    seed: int,
    airframe_seed: int | None = None,
) -> dict[str, Columns]:
    """All channels of a suite and TRUTH on a flight, with ``arrival_us`` where it is late.

    The lasting errors of the magnetic detector are drawn with ``airframe_seed`` where given: an
    aircraft that flies with different seeds keeps them.
    """
    channels = {
        "EFCS.RATES": _vector(trajectory, "omega_B", trajectory.omega_B, suite.body_rates, seed),
        "EFCS.LOAD_FACTOR": _vector(
            trajectory, "n_B", -trajectory.f_B / STANDARD_GRAVITY, suite.load_factor, seed
        ),
        "SMDU": _vector(
            trajectory,
            "b_B",
            np.einsum("nji,nj->ni", trajectory.C_NB, trajectory.b_N),
            suite.smdu[calibrated],
            seed,
            rate_hz=suite.smdu_rate_hz,
            airframe_seed=airframe_seed,
        ),
        "ADC": _air_data(trajectory, suite.air_data, seed),
        "GPS": _gps(trajectory, suite.gps, gps, seed),
        "TRUTH": _truth(trajectory),
    }
    if suite.ins is not None:
        channels["INS"] = _ins(trajectory, suite.ins, seed)
    return channels


def _rows(trajectory: Trajectory, rate_hz: int) -> NDArray[np.int64]:
    """Samples of the trajectory at which a sensor of ``rate_hz`` measures."""
    count = (len(trajectory.time_us) - 1) * rate_hz // trajectory.rate_hz + 1
    return np.round(np.arange(count) * (trajectory.rate_hz / rate_hz)).astype(np.int64)


def _vector(
    trajectory: Trajectory,
    name: str,
    truth: Array,
    errors: tuple[ErrorModel, ...],
    seed: int,
    *,
    rate_hz: int | None = None,
    airframe_seed: int | None = None,
) -> Columns:
    rate_hz = rate_hz or trajectory.rate_hz
    rows = _rows(trajectory, rate_hz)
    lasting = None if airframe_seed is None else random_stream(airframe_seed, name)
    return {
        "time_us": trajectory.time_us[rows],
        name: measured(truth[rows], errors, 1 / rate_hz, random_stream(seed, name), lasting),
        "valid": np.ones(len(rows), bool),
    }


def _air_data(trajectory: Trajectory, errors: AirDataErrors, seed: int) -> Columns:
    rows = _rows(trajectory, errors.rate_hz)
    truth = {
        "true_airspeed": (trajectory.true_airspeed, errors.true_airspeed),
        "alpha": (trajectory.alpha, errors.alpha),
        "beta": (trajectory.beta, errors.beta),
        "baro_altitude": (trajectory.h, errors.baro_altitude),
    }
    columns = {
        name: measured(values[rows], models, 1 / errors.rate_hz, random_stream(seed, name))
        for name, (values, models) in truth.items()
    }
    return {
        "time_us": trajectory.time_us[rows],
        **columns,
        "static_temperature": air_temperature(trajectory.h[rows]),
        "valid": np.ones(len(rows), bool),
    }


def _gps(trajectory: Trajectory, errors: GpsErrors, service: GpsService, seed: int) -> Columns:
    # Drawn for the whole flight and then cut, so that an outage changes no other fix.
    rows = _rows(trajectory, errors.rate_hz)
    interval = 1 / errors.rate_hz
    nothing = np.zeros((len(rows), 3))
    error_N = measured(
        nothing, errors.position[service.errors], interval, random_stream(seed, "gps position")
    )
    lat, lon, h = _displaced(trajectory, rows, error_N)
    v_N = measured(
        trajectory.v_N[rows], errors.velocity, interval, random_stream(seed, "gps velocity")
    )
    sigma = np.full(len(rows), errors.sigma_position[service.errors])
    columns: Columns = {
        "time_us": trajectory.time_us[rows],
        "arrival_us": trajectory.time_us[rows] + round(service.latency * 1e6),
        "lat": lat,
        "lon": lon,
        "h": h,
        "v_N": v_N if service.velocity else nothing,
        "has_velocity": np.full(len(rows), service.velocity),
        "sigma_horizontal": sigma,
        "sigma_vertical": sigma,
        "sigma_velocity": np.full(len(rows), errors.sigma_velocity if service.velocity else 0.0),
        "fix_type": np.full(len(rows), 3, np.int8),
        "satellites": np.full(len(rows), 9, np.int8),
        "hdop": np.ones(len(rows)),
    }
    time = columns["time_us"] * 1e-6
    lost = np.zeros(len(rows), bool)
    for start, duration in service.outages:
        lost |= (time >= start) & (time < start + duration)
    return {name: values[~lost] for name, values in columns.items()}


def _ins(trajectory: Trajectory, errors: InsErrors, seed: int) -> Columns:
    rows = _rows(trajectory, errors.rate_hz)
    interval = 1 / errors.rate_hz

    def error(models: tuple[ErrorModel, ...], axes: int, name: str) -> Array:
        return measured(
            np.zeros((len(rows), axes)), models, interval, random_stream(seed, f"ins {name}")
        )

    level = error(errors.level, 2, "level")
    heading = error(errors.heading, 1, "heading")[:, 0]
    error_v_N = np.hstack(
        [
            error(errors.velocity_horizontal, 2, "velocity horizontal"),
            error(errors.velocity_down, 1, "velocity down"),
        ]
    )
    drift_N = np.zeros_like(error_v_N)
    drift_N[1:, :2] = np.cumsum(0.5 * (error_v_N[1:, :2] + error_v_N[:-1, :2]), axis=0) * interval
    drift_N[:, 2:] = error(errors.height, 1, "height")
    lat, lon, h = _displaced(trajectory, rows, drift_N)
    return {
        "time_us": trajectory.time_us[rows],
        "roll": wrap_pi(trajectory.roll[rows] + level[:, 0]),
        "pitch": np.clip(trajectory.pitch[rows] + level[:, 1], -np.pi / 2, np.pi / 2),
        "heading": wrap_2pi(trajectory.heading[rows] + heading),
        "lat": lat,
        "lon": lon,
        "h": h,
        "v_N": trajectory.v_N[rows] + error_v_N,
        "valid": np.ones(len(rows), bool),
    }


def _displaced(
    trajectory: Trajectory, rows: NDArray[np.int64], offset_N: Array
) -> tuple[Array, Array, Array]:
    """The true position moved by ``offset_N`` (m north, east, down)."""
    lat, h = trajectory.lat[rows], trajectory.h[rows]
    north, east, down = offset_N.T
    return (
        lat + north / (meridian_radius(lat) + h),
        trajectory.lon[rows] + east / ((transverse_radius(lat) + h) * np.cos(lat)),
        h - down,
    )


def _truth(trajectory: Trajectory) -> Columns:
    fields = (
        "time_us",
        "lat",
        "lon",
        "h",
        "v_N",
        "roll",
        "pitch",
        "heading",
        "wind_N",
        "omega_B",
        "f_B",
        "b_N",
    )
    return {name: getattr(trajectory, name) for name in fields}
