# SPDX-License-Identifier: Apache-2.0
"""Sensor suites: which errors each sensor of an aircraft has, as tables.

``gripen`` is a fighter's set; ``uav`` a small unmanned aircraft's with the figures of the PX4 EKF2
comparison. All sigmas are per flight and axis and drawn anew for every seed.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import radians

from lodestar.simulation.earth import STANDARD_GRAVITY
from lodestar.simulation.sensor_errors import (
    Bias,
    ErrorModel,
    GaussMarkov,
    Lag,
    MatrixError,
    Misalignment,
    ScaleFactor,
    WhiteNoise,
)
from lodestar.simulation.trajectory import Aircraft

Errors = tuple[ErrorModel, ...]


@dataclass(frozen=True)
class AirDataErrors:
    """Air data computer: rate (Hz) and the errors of each quantity (m/s, rad, rad, m)."""

    rate_hz: int
    true_airspeed: Errors
    alpha: Errors
    beta: Errors
    baro_altitude: Errors


@dataclass(frozen=True)
class GpsErrors:
    """GPS receiver: position errors north, east, down (m) of either kind, velocity errors (m/s).

    The sigmas are what the receiver itself states.
    """

    rate_hz: int
    position: dict[str, Errors]
    sigma_position: dict[str, float]
    velocity: Errors
    sigma_velocity: float


@dataclass(frozen=True)
class InsErrors:
    """Inertial navigation system: roll and pitch, heading (rad), velocity (m/s), height (m).

    The position error is the integral of the horizontal velocity error.
    """

    rate_hz: int
    level: Errors
    heading: Errors
    velocity_horizontal: Errors
    velocity_down: Errors
    height: Errors


@dataclass(frozen=True)
class Suite:
    """The sensors of an aircraft. Body rates and load factor come at the scenario's own rate."""

    aircraft: Aircraft
    body_rates: Errors
    load_factor: Errors
    smdu_rate_hz: int
    smdu: dict[bool, Errors]
    """Magnetic detector by whether it has been calibrated."""
    air_data: AirDataErrors
    gps: GpsErrors
    ins: InsErrors | None


# 0.3 m/s per horizontal axis, kept up for an hour, is a radial drift of 0.8 NM.
_INS_VELOCITY = 0.3

GRIPEN = Suite(
    aircraft=Aircraft(),
    body_rates=(
        Misalignment(radians(0.2)),
        ScaleFactor(0.003),
        Bias(radians(0.2)),
        GaussMarkov(radians(0.03), 300.0),
        WhiteNoise(radians(0.05)),
    ),
    load_factor=(Bias(0.01), WhiteNoise(0.02)),
    smdu_rate_hz=30,
    smdu={
        False: (MatrixError(0.003), Bias(500.0), GaussMarkov(60.0, 60.0), WhiteNoise(80.0)),
        True: (MatrixError(0.0005), Bias(75.0), GaussMarkov(60.0, 60.0), WhiteNoise(80.0)),
    },
    air_data=AirDataErrors(
        rate_hz=30,
        true_airspeed=(ScaleFactor(0.005), Bias(0.5), WhiteNoise(0.5)),
        alpha=(ScaleFactor(0.02), Bias(radians(0.3)), WhiteNoise(radians(0.1))),
        beta=(ScaleFactor(0.02), Bias(radians(0.3)), WhiteNoise(radians(0.1))),
        baro_altitude=(Lag(0.3), Bias(20.0), WhiteNoise(0.5)),
    ),
    gps=GpsErrors(
        rate_hz=1,
        position={
            "markov": (GaussMarkov(5.0, 150.0), WhiteNoise(1.0)),
            "white": (WhiteNoise(5.0),),
        },
        sigma_position={"markov": 5.1, "white": 5.0},
        velocity=(WhiteNoise(0.1),),
        sigma_velocity=0.1,
    ),
    ins=InsErrors(
        rate_hz=30,
        # The last piece is the jitter of a strapdown system's output, far below its accuracy.
        level=(Bias(radians(0.05)), WhiteNoise(radians(0.002))),
        heading=(Bias(radians(0.1)), WhiteNoise(radians(0.002))),
        velocity_horizontal=(Bias(_INS_VELOCITY),),
        # The vertical channel is held by the baro altitude.
        velocity_down=(GaussMarkov(_INS_VELOCITY, 60.0),),
        height=(Bias(20.0),),
    ),
)

_UAV_GPS = (WhiteNoise(0.5),)
# The peer was told alpha and beta exactly; vanes that never move would be refused as stuck.
_UAV_VANE = (WhiteNoise(radians(0.1)),)

UAV = Suite(
    # Its angle of attack is a constant 0.05 rad: the wing's lift slope is left out.
    aircraft=Aircraft(wing_loading=0.0, zero_lift_alpha=0.05),
    body_rates=(Bias(radians(0.3)), WhiteNoise(0.002)),
    load_factor=(Bias(0.05 / STANDARD_GRAVITY), WhiteNoise(0.05 / STANDARD_GRAVITY)),
    smdu_rate_hz=20,
    smdu=dict.fromkeys((False, True), (Bias(1000.0), WhiteNoise(300.0))),
    # The peer had the baro altitude at 20 Hz; here it comes with the airspeed at 10 Hz.
    air_data=AirDataErrors(
        rate_hz=10,
        true_airspeed=(WhiteNoise(0.4),),
        alpha=_UAV_VANE,
        beta=_UAV_VANE,
        baro_altitude=(WhiteNoise(0.15),),
    ),
    gps=GpsErrors(
        rate_hz=5,
        position={"markov": _UAV_GPS, "white": _UAV_GPS},
        sigma_position={"markov": 0.5, "white": 0.5},
        velocity=(WhiteNoise(0.1),),
        sigma_velocity=0.1,
    ),
    ins=None,
)

SUITES = {"gripen": GRIPEN, "uav": UAV}
