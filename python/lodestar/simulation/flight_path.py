# SPDX-License-Identifier: Apache-2.0
"""The path through the air: airspeed, path angle, track and bank as smooth functions of time.

The flight-path frame W has x along the velocity through the air and z against the lift:
``C_NW = Rz(track) Ry(path_angle) Rx(bank)``. The path angle is not limited, so a loop is one
smooth function like any other and nothing is singular at the vertical.

Every manoeuvre is coordinated: the lift is the only force across the path. With load factor n,

    V path_angle' = g (n cos(bank) - cos(path_angle)),   V cos(path_angle) track' = g n sin(bank)

A PathBuilder strings manoeuvres together. Each starts and ends in steady straight flight and lasts
a whole number of ticks of 0.1 s; where angle, load and time cannot all be met to the digit, the
angle is met exactly and the load gives way.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from lodestar.simulation.calculus import (
    STEP_MOMENT,
    STEP_SLOPE,
    plateau,
    plateau_integral,
    running_integral,
    step,
    step_slope,
)
from lodestar.simulation.earth import STANDARD_GRAVITY as G

Array = NDArray[np.float64]

TICK = 0.1  # s
ROLL_ONSET = 0.5  # s, to reach a roll rate
LOAD_ONSET = 4.0  # g/s, steepest
SHORTEST_ONSET = 1.0  # s, of a load or a bank
SPEED_RAMP = 5.0  # s, to reach a longitudinal acceleration
STEEPEST_BANK = math.radians(85.0)
STEEPEST_PATH = math.radians(75.0)  # of straight flight
ENERGY_TRADE = 0.6  # share of gravity along the path that thrust does not make good in loops
RECOVERY_LOAD = 2.0  # g, of the pulls before and after an aileron roll


class FlightError(ValueError):
    """A manoeuvre that cannot be flown as asked; the message says why."""


@dataclass(frozen=True)
class Start:
    """Where a flight begins: rad, m above the ellipsoid, rad (true), m/s through the air."""

    lat: float
    lon: float
    altitude: float
    heading: float
    airspeed: float


@dataclass(frozen=True)
class State:
    """End of a manoeuvre: m/s, rad, m. ``turn_up``: path_angle' and path_angle'' (rad/s, rad/s^2).

    Between manoeuvres bank and ``turn_up`` are zero; within one they carry from part to part.
    """

    airspeed: float
    path_angle: float
    track: float
    bank: float
    altitude: float
    turn_up: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class FlightPath:
    """Samples (n,) of the path at ``rate_hz``: m/s, rad, rad (not wrapped), rad (not wrapped)."""

    start: Start
    rate_hz: int
    airspeed: Array
    path_angle: Array
    track: Array
    bank: Array

    @property
    def duration(self) -> float:
        """Seconds from the first to the last sample."""
        return (len(self.airspeed) - 1) / self.rate_hz


class PathBuilder:
    """Strings manoeuvres together; each method flies one and raises FlightError if it cannot."""

    def __init__(self, start: Start, rate_hz: int) -> None:
        """``rate_hz``: of the samples; a multiple of 10, at least 30."""
        if rate_hz < 30 or rate_hz % 10:
            raise FlightError(f"rate {rate_hz} Hz: must be a multiple of 10 Hz, 30 at least")
        self.start = start
        self.rate_hz = rate_hz
        self.state = State(start.airspeed, 0.0, start.heading, 0.0, start.altitude)
        self.time = 0.0
        self._parts: list[Array] = []

    def path(self) -> FlightPath:
        """The path flown so far; there must be some.

        Where a loop or roll is complete, the angles start again from zero with the next part.
        """
        parts = [part[:-1] for part in self._parts[:-1]] + self._parts[-1:]
        return FlightPath(self.start, self.rate_hz, *np.concatenate(parts).T.copy())

    # Manoeuvres

    def straight(self, duration: float, *, airspeed: float | None = None) -> None:
        """Hold track and path angle; reach ``airspeed`` (m/s) at the end."""
        t = self._clock(duration)
        self._fly(t, airspeed=self._speed_profile(t, airspeed))

    def horizontal_turn(
        self,
        angle: float,
        *,
        bank: float | None = None,
        duration: float | None = None,
        roll_rate: float,
        airspeed: float | None = None,
    ) -> None:
        """Turn the track by ``angle`` (rad, right positive), with a bank or within a time."""
        to_speed = self.state.airspeed if airspeed is None else airspeed
        mean_speed = 0.5 * (self.state.airspeed + to_speed)
        if bank is None:
            if duration is None:
                raise FlightError("a turn needs a bank or a duration")
            bank = math.atan(mean_speed * abs(angle) / (0.9 * duration * G))
        ramp = _round_up(max(SHORTEST_ONSET, STEP_SLOPE * bank / roll_rate))
        if duration is None:
            per_second = G / mean_speed * np.tan(bank * step(np.linspace(0, 1, 201)))
            while_rolling = 2 * ramp * float(np.mean(per_second))
            steady = (abs(angle) - while_rolling) / float(per_second[-1])
            duration = 2 * ramp + max(0.0, _round(steady))
        ramp = min(ramp, 0.5 * duration)
        t = self._clock(duration)
        speed = self._speed_profile(t, airspeed)
        shape = plateau(t, duration, ramp)

        def track(peak: float) -> Array:
            return running_integral(G * np.tan(peak * shape) / speed, 1 / self.rate_hz)

        if track(STEEPEST_BANK)[-1] < abs(angle):
            raise FlightError(
                f"needs more than {math.degrees(STEEPEST_BANK):.0f} deg of bank; "
                "allow more time or fly slower"
            )
        peak = brentq(lambda b: track(b)[-1] - abs(angle), 0.0, STEEPEST_BANK, xtol=1e-14)
        sign = math.copysign(1.0, angle)
        self._fly(
            t,
            airspeed=speed,
            track=self.state.track + sign * track(peak),
            bank=sign * peak * shape,
        )

    def vertical_turn(
        self,
        to: float,
        *,
        load: float | None = None,
        duration: float | None = None,
        airspeed: float | None = None,
    ) -> None:
        """Turn the path up or down to the path angle ``to`` (rad), with a load (g) or a time."""
        if abs(to) > STEEPEST_PATH:
            raise FlightError(f"path angle beyond {math.degrees(STEEPEST_PATH):.0f} deg")
        angle = to - self.state.path_angle
        if angle == 0.0:
            raise FlightError("the path angle is already that")
        if duration is None:
            if load is None:
                load = 1.0 + math.copysign(0.3, angle)
            if (load - 1.0) * angle <= 0:
                raise FlightError("load must be above 1 g to turn up and below 1 g to turn down")
            rate = abs(load - 1.0) * G / self.state.airspeed
            onset = _load_onset(load - 1.0)
            duration = _round_up(max(2 * onset, onset + abs(angle) / rate))
        else:
            onset = min(max(SHORTEST_ONSET, 0.25 * duration), 0.5 * duration)
        self._pitch(angle, duration, onset, airspeed=airspeed)
        self.state = replace(self.state, path_angle=to)

    def climb(self, to: float, *, angle: float, load: float) -> None:
        """Climb or descend to the altitude ``to`` (m), to a metre, at the path angle (rad).

        The path turns up and down with ``load`` g more and less than straight flight.
        """
        if self.state.path_angle != 0.0:
            raise FlightError("starts from level flight")
        rise = to - self.state.altitude
        path = math.copysign(angle, rise)
        self.vertical_turn(path, load=1 + math.copysign(load, path))
        climbed_in_turn = self.state.altitude - (to - rise)
        # The turn back to level covers the same height as the turn that led off it.
        remaining = rise - 2 * climbed_in_turn
        hold = _round(remaining / (self.state.airspeed * math.sin(path)))
        if hold < 0:
            raise FlightError("altitude change too small for this path angle; lower the angle")
        if hold > 0:
            self.straight(hold)
        self.vertical_turn(0.0, load=1 - math.copysign(load, path))

    def heading_oscillation(self, amplitude: float, period: float, cycles: int) -> None:
        """Swing the track by +-``amplitude`` (rad), growing and fading in half a period."""
        duration = period * cycles
        t = self._clock(duration)
        ramp = 0.5 * period
        omega = 2 * math.pi / period
        window = plateau(t, duration, ramp)
        growth = (step_slope(t / ramp) - step_slope((t - duration + ramp) / ramp)) / ramp
        swing = amplitude * window * np.sin(omega * t)
        rate = amplitude * (growth * np.sin(omega * t) + window * omega * np.cos(omega * t))
        bank = np.arctan(self.state.airspeed * rate / G)
        if np.max(np.abs(bank)) > STEEPEST_BANK:
            raise FlightError("needs too much bank; lower the amplitude or lengthen the period")
        self._fly(t, track=self.state.track + swing, bank=bank)

    def loop(self, load: float) -> None:
        """A full loop upwards; ``load`` (g) is reached at the bottom. Speed trades with height."""
        self._need_level()
        rate = (load - 1.0) * G / self.state.airspeed
        onset = _load_onset(load - 1.0)
        self._pitch(2 * math.pi, _round(onset + 2 * math.pi / rate), onset, trade=ENERGY_TRADE)
        self.state = replace(self.state, path_angle=0.0)

    def aileron_roll(self, angle: float, *, rate: float, load: float) -> None:
        """Roll full turns (rad, right positive) with constant load along the body's own z axis.

        The path sags while the lift points elsewhere, so the nose is pulled up before and the path
        levelled after, as a pilot does.
        """
        before = self.state.path_angle
        duration = _round(abs(angle) / rate + ROLL_ONSET)
        t = np.linspace(0, duration, 400)
        banked = angle * plateau_integral(t, duration, ROLL_ONSET) / (duration - ROLL_ONSET)
        sag = float(np.mean(load * np.cos(banked) - 1.0)) * duration * G / self.state.airspeed
        if abs(before - 0.5 * sag) > STEEPEST_PATH:
            raise FlightError("the path would sag too far; roll faster or fewer turns")
        self.vertical_turn(before - 0.5 * sag, load=RECOVERY_LOAD if sag < 0 else 0.0)
        self._roll(angle, duration, load)
        back = before - self.state.path_angle
        onset = _load_onset(RECOVERY_LOAD - 1.0)
        wanted = onset + abs(back) * self.state.airspeed / ((RECOVERY_LOAD - 1.0) * G)
        self._pitch(back, _round_up(max(2 * onset, wanted)), onset)
        self.state = replace(self.state, path_angle=before, bank=0.0)

    def split_s(self, *, rate: float, load: float) -> None:
        """Half roll to the right, then half a loop downwards; ``load`` (g) at its bottom."""
        self._need_level()
        self._roll(math.pi, _round(math.pi / rate + ROLL_ONSET), 1.0)
        self.state = replace(self.state, bank=math.pi)
        pull = (load - 1.0 - 2.0 * ENERGY_TRADE) * G / self.state.airspeed
        if pull <= 0.02:
            raise FlightError("load too low to pull through; raise it")
        angle = -math.pi - self.state.path_angle
        onset = _load_onset(load - 1.0)
        self._pitch(angle, _round(onset + abs(angle) / pull), onset, trade=ENERGY_TRADE)
        # Inverted with the path turned by half a circle is upright on the opposite track.
        self.state = replace(self.state, path_angle=0.0, bank=0.0, track=self.state.track + math.pi)

    # Parts of manoeuvres

    def _need_level(self) -> None:
        if self.state.path_angle != 0.0:
            raise FlightError("starts from level flight")

    def _pitch(
        self,
        angle: float,
        duration: float,
        onset: float,
        *,
        airspeed: float | None = None,
        trade: float = 0.0,
    ) -> None:
        """Turn the path by ``angle`` in its vertical plane, wings level or inverted.

        path_angle' goes smoothly from what it is to a constant, and to zero. ``trade``: share of
        gravity along the path that changes the speed.
        """
        rate0, slope0 = self.state.turn_up
        started = rate0 * onset / 2 + slope0 * STEP_MOMENT * onset**2
        peak = (angle - started) / (duration - onset)
        t = self._clock(duration)
        rising = step(t / onset)
        falling = step((t - duration + onset) / onset)
        turn = (rate0 + slope0 * t) * (1 - rising) + peak * (rising - falling)
        path_angle = self.state.path_angle + running_integral(turn, 1 / self.rate_hz)
        if trade:
            pull = -trade * G * np.sin(path_angle) * plateau(t, duration, SHORTEST_ONSET)
            speed = self.state.airspeed + running_integral(pull, 1 / self.rate_hz)
            if speed.min() < 0.3 * self.state.airspeed:
                raise FlightError("runs out of speed; pull harder or enter faster")
        else:
            speed = self._speed_profile(t, airspeed)
        self._fly(t, airspeed=speed, path_angle=path_angle)

    def _roll(self, angle: float, duration: float, load: float) -> None:
        """Roll by ``angle`` about the velocity; the load goes smoothly to ``load`` (g)."""
        s = self.state
        t = self._clock(duration)
        interval = 1 / self.rate_hz
        bank = s.bank + angle * plateau_integral(t, duration, ROLL_ONSET) / (duration - ROLL_ONSET)
        at_start = math.cos(s.bank) * (s.airspeed * s.turn_up[0] / G + math.cos(s.path_angle))
        lift = at_start + (load - at_start) * step(t / ROLL_ONSET)
        path_angle = np.full_like(t, s.path_angle)
        for _ in range(20):  # Picard's iteration; gains three digits each time round
            turn = (lift * np.cos(bank) - np.cos(path_angle)) * G / s.airspeed
            path_angle, previous = s.path_angle + running_integral(turn, interval), path_angle
            if np.max(np.abs(path_angle - previous)) < 1e-14:
                break
        sideways = lift * np.sin(bank) * G / (s.airspeed * np.cos(path_angle))
        track = s.track + running_integral(sideways, interval)
        self._fly(t, path_angle=path_angle, track=track, bank=bank)
        slope = math.sin(path_angle[-1]) * float(turn[-1]) * G / s.airspeed
        self.state = replace(self.state, turn_up=(float(turn[-1]), slope))

    def _speed_profile(self, t: Array, airspeed: float | None) -> Array:
        if airspeed is None:
            return np.full_like(t, self.state.airspeed)
        duration = float(t[-1])
        ramp = min(SPEED_RAMP, 0.5 * duration)
        gained = plateau_integral(t, duration, ramp) / (duration - ramp)
        return self.state.airspeed + (airspeed - self.state.airspeed) * gained

    def _clock(self, duration: float) -> Array:
        ticks = round(duration / TICK)
        if ticks < 1 or abs(duration / TICK - ticks) > 1e-6:
            raise FlightError(
                f"{duration:g} s: a time must be a whole number of tenths of a second"
            )
        return np.arange(ticks * self.rate_hz // 10 + 1) / self.rate_hz

    def _fly(
        self,
        t: Array,
        *,
        airspeed: Array | None = None,
        path_angle: Array | None = None,
        track: Array | None = None,
        bank: Array | None = None,
    ) -> None:
        """Append samples at the times t; what is not given stays as it is."""
        s = self.state
        kept = zip(
            (airspeed, path_angle, track, bank),
            (s.airspeed, s.path_angle, s.track, s.bank),
            strict=True,
        )
        columns = [np.full_like(t, old) if new is None else new for new, old in kept]
        climb = columns[0] * np.sin(columns[1])
        rise = float(np.sum(climb[1:] + climb[:-1])) / (2 * self.rate_hz)
        part = np.stack(columns, axis=-1)
        self._parts.append(part)
        self.time += float(t[-1])
        speed, path, direction, banked = part[-1].tolist()
        self.state = State(speed, path, direction, banked, s.altitude + rise)


def _load_onset(change: float) -> float:
    """Seconds (whole ticks) in which the load changes by ``change`` g."""
    return _round_up(max(SHORTEST_ONSET, STEP_SLOPE * abs(change) / LOAD_ONSET))


def _round(seconds: float) -> float:
    return round(seconds / TICK) * TICK


def _round_up(seconds: float) -> float:
    return math.ceil(seconds / TICK - 1e-9) * TICK
