# SPDX-License-Identifier: Apache-2.0
"""An autopilot that makes a simulated fighter fly a path: from reference and motion to the stick.

It follows the direction of flight and the height, not the track over the ground: the velocity
through the air is to turn as that of the path does. What this takes across the velocity, less
gravity, is lift; its length is a load factor and its direction a bank. All of it is vectors in N,
so a loop is like any other manoeuvre. Roll, load, sideslip and speed are loops around the
fly-by-wire of the aircraft, at the rate of the path.

Vectors are plain tuples: at three elements they are several times faster than arrays.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from lodestar.rotation import C_NB_from_euler
from lodestar.simulation.calculus import derivative, running_integral
from lodestar.simulation.earth import STANDARD_GRAVITY as G
from lodestar.simulation.flight_path import FlightPath

Vector = tuple[float, float, float]

FLOOR = 500.0  # m above the ellipsoid, below which the autopilot does not dive
_RECOVERY_LOAD = 4.0  # g, that a pull-out counts on
_RECOVERY_DELAY = 2.0  # s, until a pull-out has begun
_RECOVERY_MARGIN = 200.0  # m above the floor, where the path is taken up again
_LEVEL = 0.05  # rad; a path that goes down less than this is not a dive

_DIRECTION_GAIN = 0.6  # 1/s
_LARGEST_ERROR = 0.4  # of direction, beyond which the correction grows no more
_HEIGHT_GAIN = 0.15  # 1/s
_HEIGHT_RATE = 15.0  # m/s, at most to make good a height
_LEAN_SOFTNESS = 0.3  # g; below this lift, leaning moves the path too little
_ROLLING = 0.5  # rad/s; in faster rolls a lean would only disturb
_BANK_GAIN = 2.0  # 1/s
_ROLL_RATE = 3.3  # rad/s, at most
_LOAD = (-1.5, 7.5)  # g
_PULL = (-0.44, 1.0)  # of the stick
_PULL_PER_G = 0.12  # of the stick, at _PULL_SPEED; falls with the power _PULL_POWER of speed
_PULL_SPEED = 200.0  # m/s
_PULL_POWER = 1.5
_LOAD_GAIN = 1.25  # of _PULL_PER_G
_LOAD_RATE = 3.75  # 1/s, of _PULL_PER_G
_YAW_GAIN = 10.0  # s
_SIDESLIP_GAIN = 2.0
_SPEED_GAIN = 0.25  # 1/s
_THROTTLE_RATE = 0.06  # 1/s per m/s^2
_BRAKE_ON, _BRAKE_OFF = 3.0, 1.0  # m/s too fast


class Motion(NamedTuple):
    """What the autopilot measures.

    Height (m); velocity through the air without gusts (m/s, N); axes of B in N; body rates
    (rad/s); load factor (g).
    """

    h: float
    v_air_N: Vector
    x_B: Vector
    y_B: Vector
    z_B: Vector
    omega_B: Vector
    n_B: Vector


class Controls(NamedTuple):
    """Roll rate (rad/s), stick (back positive), rudder (nose left positive), throttle (0 to 1)."""

    roll_rate: float
    pull: float
    rudder: float
    throttle: float
    brake: bool


class Aim(NamedTuple):
    """The path at one sample: m/s, m/s^2, m, rad/s; unit vectors and rate of turn (rad/s) in N.

    ``right`` and ``down`` are the axes y and z of the flight-path frame; x is ``direction``.
    """

    airspeed: float
    acceleration: float
    h: float
    roll_rate: float
    direction: Vector
    right: Vector
    down: Vector
    turn: Vector


def aims(path: FlightPath) -> list[Aim]:
    """What there is to aim at, sample by sample."""
    interval = 1 / path.rate_hz
    C_NW = C_NB_from_euler(path.bank, path.path_angle, path.track)
    direction, right, down = (C_NW[:, :, axis] for axis in range(3))
    climb = path.airspeed * np.sin(path.path_angle)
    columns = (
        path.airspeed,
        derivative(path.airspeed, interval),
        path.start.altitude + running_integral(climb, interval),
        np.sum(down * derivative(right, interval), axis=-1),
        direction,
        right,
        down,
        np.cross(direction, derivative(direction, interval)),
    )
    return [Aim(*row) for row in zip(*(column.tolist() for column in columns), strict=True)]


class Autopilot:
    """Flies one flight; called once per sample of the path."""

    def __init__(self, interval: float) -> None:
        """``interval``: s between calls."""
        self._interval = interval
        self._pull = 0.0  # integrated
        self._throttle = 0.3
        self._brake = False
        self._recovery: Aim | None = None

    def steer(self, aim: Aim, motion: Motion) -> Controls:
        """The controls until the next call."""
        airspeed = math.sqrt(_dot(motion.v_air_N, motion.v_air_N))
        u = _scaled(motion.v_air_N, 1 / airspeed)
        aim = self._safe(aim, motion, airspeed, u)
        load, down = _wanted_lift(aim, motion.h, airspeed, u)
        throttle, brake = self._speed(aim, motion, airspeed, u)
        return Controls(
            _roll_rate(aim, motion, u, down),
            self._load(load, motion.n_B[2], airspeed),
            _rudder(motion, airspeed, u),
            throttle,
            brake,
        )

    def _safe(self, aim: Aim, motion: Motion, airspeed: float, u: Vector) -> Aim:
        """The aim, or level flight as long as the ground is too near or the aim too far off."""
        radius = airspeed**2 / (G * (_RECOVERY_LOAD - 1.0))
        sinking = max(u[2], 0.0)
        needed = radius * (1 - math.sqrt(1 - sinking**2)) + _RECOVERY_DELAY * airspeed * sinking
        safe = FLOOR + _RECOVERY_MARGIN
        if self._recovery is None and motion.h - needed < FLOOR:
            # In a steep dive ahead is where the lift points.
            ahead = math.atan2(u[1] - 0.5 * motion.z_B[1], u[0] - 0.5 * motion.z_B[0])
            self._recovery = _level(ahead, safe + _RECOVERY_MARGIN, aim.airspeed)
        elif motion.h > safe and sinking == 0.0 and aim.direction[2] < _LEVEL:
            self._recovery = None
        if self._recovery is not None:
            return self._recovery
        height = max(aim.h, safe)
        if _dot(aim.direction, u) > 0.0:
            return aim._replace(h=height)
        # Far off, as after a recovery: the shortest way may lead over the top.
        to_the_right = aim.direction[1] * u[0] - aim.direction[0] * u[1] > -0.1
        track = math.atan2(u[1], u[0]) + (1.0 if to_the_right else -1.0)
        return _level(track, height, aim.airspeed)

    def _load(self, wanted: float, load: float, airspeed: float) -> float:
        """The stick for a load factor, g."""
        per_g = _PULL_PER_G * (_PULL_SPEED / airspeed) ** _PULL_POWER
        error = wanted - load
        step = _LOAD_RATE * per_g * error * self._interval
        pull = per_g * (wanted - 1.0 + _LOAD_GAIN * error) + self._pull + step
        if _PULL[0] < pull < _PULL[1]:
            self._pull += step
        return _limited(pull, *_PULL)

    def _speed(self, aim: Aim, motion: Motion, airspeed: float, u: Vector) -> tuple[float, bool]:
        """Throttle and speed brake: the specific force along the path makes the acceleration."""
        axes = (motion.x_B, motion.y_B, motion.z_B)
        force = -G * sum(n * _dot(axis, u) for n, axis in zip(motion.n_B, axes, strict=True))
        too_fast = airspeed - aim.airspeed
        wanted = aim.acceleration - _SPEED_GAIN * too_fast - G * u[2]
        step = _THROTTLE_RATE * (wanted - force) * self._interval
        self._throttle = _limited(self._throttle + step, 0.0, 1.0)
        if too_fast < _BRAKE_OFF:
            self._brake = False
        elif too_fast > _BRAKE_ON and self._throttle == 0.0:
            self._brake = True
        return self._throttle, self._brake


def _level(track: float, h: float, airspeed: float) -> Aim:
    """Straight and level flight."""
    north, east = math.cos(track), math.sin(track)
    return Aim(
        airspeed=airspeed,
        acceleration=0.0,
        h=h,
        roll_rate=0.0,
        direction=(north, east, 0.0),
        right=(-east, north, 0.0),
        down=(0.0, 0.0, 1.0),
        turn=(0.0, 0.0, 0.0),
    )


def _wanted_lift(aim: Aim, h: float, airspeed: float, u: Vector) -> tuple[float, Vector]:
    """The load factor (g) that is wanted, and the direction in N that is to be down for it."""
    climb = _limited(_HEIGHT_GAIN * (aim.h - h), -_HEIGHT_RATE, _HEIGHT_RATE)
    towards = (aim.direction[0], aim.direction[1], aim.direction[2] - climb / airspeed)
    # The path's own frame is carried by the shortest turn to where the aircraft is going.
    axis = _cross(aim.direction, u)
    share = 1 / (1 + max(_dot(aim.direction, u), -0.9))
    right, down, turn = (
        _carried(vector, axis, share) for vector in (aim.right, aim.down, aim.turn)
    )
    error = _cross(u, towards)
    gain = _DIRECTION_GAIN / max(1.0, math.sqrt(_dot(error, error)) / _LARGEST_ERROR)
    turn = _sum(turn, 1.0, error, gain)
    north, east, downward = _cross(turn, u)
    lift = (airspeed * north / G, airspeed * east / G, airspeed * downward / G - 1.0)
    lift_up, lift_right = -_dot(lift, down), _dot(lift, right)
    # Pushing, it leans the other way; but not where it has to go sideways more than down.
    upwards = max(lift_up, 0.2 * (abs(lift_right) - 1.0))
    lean = math.atan(lift_right * upwards / (upwards**2 + _LEAN_SOFTNESS**2))
    lean /= 1 + (aim.roll_rate / _ROLLING) ** 2
    c, s = math.cos(lean), math.sin(lean)
    return _limited(c * lift_up + s * lift_right, *_LOAD), _sum(down, c, right, -s)


def _roll_rate(aim: Aim, motion: Motion, u: Vector, down: Vector) -> float:
    """Roll about the velocity until the belly points ``down``."""
    belly = _sum(motion.z_B, 1.0, u, -_dot(motion.z_B, u))
    error = math.atan2(_dot(u, _cross(belly, down)), _dot(belly, down))
    return _limited(aim.roll_rate + _BANK_GAIN * error, -_ROLL_RATE, _ROLL_RATE)


def _rudder(motion: Motion, airspeed: float, u: Vector) -> float:
    """Damps the yaw rate beyond that of coordinated flight, and the sideslip."""
    axes = (motion.x_B, motion.y_B, motion.z_B)
    about_velocity = sum(
        rate * _dot(axis, u) for rate, axis in zip(motion.omega_B, axes, strict=True)
    )
    from_gravity = (u[1] * motion.z_B[0] - u[0] * motion.z_B[1]) * G / airspeed
    coordinated = from_gravity + about_velocity * _dot(u, motion.z_B)
    sideslip = math.asin(_limited(_dot(u, motion.y_B), -1.0, 1.0))
    rudder = _YAW_GAIN * (motion.omega_B[2] - coordinated) - _SIDESLIP_GAIN * sideslip
    return _limited(rudder, -1.0, 1.0)


def _carried(a: Vector, axis: Vector, share: float) -> Vector:
    """``a`` turned about ``axis`` of length sin(angle); share = 1/(1 + cos(angle))."""
    once = _cross(axis, a)
    return _sum(_sum(a, 1.0, once, 1.0), 1.0, _cross(axis, once), share)


def _limited(x: float, low: float, high: float) -> float:
    return min(max(x, low), high)


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _scaled(a: Vector, s: float) -> Vector:
    return (a[0] * s, a[1] * s, a[2] * s)


def _sum(a: Vector, s: float, b: Vector, t: float) -> Vector:
    return (a[0] * s + b[0] * t, a[1] * s + b[1] * t, a[2] * s + b[2] * t)
