# SPDX-License-Identifier: Apache-2.0
"""What the fields of the input messages measure: units people use for them, and physical ranges."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, pi

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]
Conversion = Callable[[Values], Values]

G0 = 9.80665  # m/s^2, in the definition of the load factor


def linear(scale: float, offset: float = 0.0) -> Conversion:
    """A unit that is ``scale`` SI units, with its zero at ``offset`` SI units."""
    return lambda values: values * scale + offset


def pressure_altitude(pressure: Values) -> Values:
    """Pressure altitude (m) of a static pressure (Pa): ICAO standard atmosphere, troposphere."""
    ratio = np.maximum(pressure, 0.0) / 101325.0
    altitude: Values = 288.15 / 0.0065 * (1.0 - ratio ** (0.0065 * 287.05287 / G0))
    return altitude


ANGLE = {"rad": linear(1.0), "deg": linear(pi / 180)}
ANGULAR_RATE = {"rad/s": linear(1.0), "deg/s": linear(pi / 180)}
LENGTH = {"m": linear(1.0), "km": linear(1000.0), "ft": linear(0.3048)}
PRESSURE_ALTITUDE = {
    **LENGTH,
    "Pa": pressure_altitude,
    "hPa": lambda values: pressure_altitude(100.0 * values),
}
SPEED = {
    "m/s": linear(1.0),
    "km/h": linear(1 / 3.6),
    "kt": linear(1852 / 3600),
    "ft/s": linear(0.3048),
    "ft/min": linear(0.3048 / 60),
}
LOAD_FACTOR = {"g": linear(1.0), "m/s^2": linear(1 / G0)}
ACCELERATION = {"m/s^2": linear(1.0), "g": linear(G0)}
MAGNETIC_FIELD = {
    "nT": linear(1.0),
    "uT": linear(1e3),
    "T": linear(1e9),
    "gauss": linear(1e5),
    "mgauss": linear(1e2),
}
TEMPERATURE = {"K": linear(1.0), "degC": linear(1.0, 273.15)}
TIME = {"s": linear(1.0), "ms": linear(1e-3), "us": linear(1e-6), "ns": linear(1e-9)}
NONE = {"1": linear(1.0)}


@dataclass(frozen=True)
class Quantity:
    """Units in which a field may come, its SI unit first, and its physical range in SI units."""

    units: dict[str, Conversion]
    low: float = -inf
    high: float = inf


_HALF_TURN = pi * (1 + 1e-12)
_ROLL = Quantity(ANGLE, -_HALF_TURN, _HALF_TURN)
_PITCH = Quantity(ANGLE, -_HALF_TURN / 2, _HALF_TURN / 2)
_HEADING = Quantity(ANGLE, -_HALF_TURN, 2 * _HALF_TURN)
_SIGMA = Quantity(LENGTH, 1e-4, 1e5)

QUANTITIES: dict[str, Quantity] = {
    "omega_B": Quantity(ANGULAR_RATE, -20.0, 20.0),
    "n_B": Quantity(LOAD_FACTOR, -30.0, 30.0),
    "b_B": Quantity(MAGNETIC_FIELD, -200e3, 200e3),
    "b_N": Quantity(MAGNETIC_FIELD, -200e3, 200e3),
    "f_B": Quantity(ACCELERATION, -700.0, 700.0),
    "true_airspeed": Quantity(SPEED, 0.0, 1500.0),
    "alpha": _ROLL,
    "beta": _PITCH,
    "baro_altitude": Quantity(PRESSURE_ALTITUDE, -1000.0, 40e3),
    "static_temperature": Quantity(TEMPERATURE, 100.0, 400.0),
    "temperature": Quantity(TEMPERATURE, 100.0, 500.0),
    "roll": _ROLL,
    "pitch": _PITCH,
    "heading": _HEADING,
    "lat": _PITCH,
    "lon": _HEADING,
    "h": Quantity(LENGTH, -1000.0, 100e3),
    "v_N": Quantity(SPEED, -2000.0, 2000.0),
    "wind_N": Quantity(SPEED, -200.0, 200.0),
    "sigma_horizontal": _SIGMA,
    "sigma_vertical": _SIGMA,
    "sigma_velocity": Quantity(SPEED, 1e-5, 1e4),
    "height": Quantity(LENGTH, -100.0, 20e3),
}
"""By field name, the same in every message. A field that is not here has no unit."""


def quantity(field: str) -> Quantity:
    """What a field measures."""
    return QUANTITIES.get(field, Quantity(NONE))
