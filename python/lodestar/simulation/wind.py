# SPDX-License-Identifier: Apache-2.0
"""Wind that carries the aircraft, and turbulence that only shakes the air around it.

Two parts, by what an aircraft of some tons does with them:

- *Wind* changes over seconds to hours. The aircraft is carried along: ground velocity is air
  velocity plus wind, and the change of wind is a force that accelerometers feel. It is smooth;
  a step of wind is a ramp of 10 s.
- *Gusts* (Dryden's turbulence) are shorter. Their velocity is relative air only: what airspeed,
  alpha and beta measure moves, the ground velocity does not.

The wind of TRUTH is the sum of both.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import make_interp_spline
from scipy.signal import lfilter

from lodestar.simulation.calculus import plateau_integral

Array = NDArray[np.float64]

STEP_RAMP = 10.0  # s, a step of wind
STEP_ONSET = 2.0  # s of the ramp at either end, in which the change of wind sets in and ends
KNOT_INTERVAL = 5.0  # s, between the random values that the living wind passes through


@dataclass(frozen=True)
class Wind:
    """Velocity of the air over the ground, (north, east) in m/s each.

    steady: always there. pulse: added in every second interval of ``pulse_interval`` seconds, the
    first one without. wander_sigma (both axes), wander_tau (s): a first-order Gauss-Markov part.
    """

    steady: tuple[float, float] = (0.0, 0.0)
    pulse: tuple[float, float] = (0.0, 0.0)
    pulse_interval: float = 300.0
    wander_sigma: float = 0.0
    wander_tau: float = 120.0

    def velocity_N(self, t: Array, rng: np.random.Generator) -> Array:
        """The wind (n, 3) in N, m/s, at the times t (n,), s."""
        wind_N = np.zeros((len(t), 3))
        wind_N[:, :2] = self.steady
        if any(self.pulse):
            wind_N[:, :2] += self._pulses(t)[:, None] * np.asarray(self.pulse)
        if self.wander_sigma > 0.0:
            wind_N[:, :2] += self._wander(t, rng)
        return wind_N

    def _pulses(self, t: Array) -> Array:
        edges = np.arange(self.pulse_interval, t[-1], self.pulse_interval)
        level = np.zeros_like(t)
        for k, edge in enumerate(edges):
            ramp = plateau_integral(t - edge, STEP_RAMP, STEP_ONSET) / (STEP_RAMP - STEP_ONSET)
            level += (-1) ** k * ramp
        return level

    def _wander(self, t: Array, rng: np.random.Generator) -> Array:
        # A Gauss-Markov process has no derivative; a spline through its values every few seconds
        # has, and the same spectrum below. An aircraft does not follow what is faster.
        knots = np.arange(t[0] - 5 * KNOT_INTERVAL, t[-1] + 6 * KNOT_INTERVAL, KNOT_INTERVAL)
        values = gauss_markov(
            rng, len(knots), KNOT_INTERVAL, self.wander_sigma, self.wander_tau, axes=2
        )
        return np.asarray(make_interp_spline(knots, values, k=5)(t))


@dataclass(frozen=True)
class Turbulence:
    """Dryden's turbulence, MIL-F-8785C: sigma (m/s) per axis, length scale (m).

    The length scale of 1750 ft holds for all axes above 2000 ft.
    """

    sigma: float = 0.0
    length: float = 533.4

    def gust_B(
        self, count: int, interval: float, airspeed: float, rng: np.random.Generator
    ) -> Array:
        """Gusts (count, 3) in B, m/s, every ``interval`` s, at one mean airspeed (m/s).

        Exactly discretised and stationary from the first sample.
        """
        if self.sigma == 0.0:
            return np.zeros((count, 3))
        tau = self.length / airspeed
        longitudinal, lateral, vertical = rng.spawn(3)
        return np.stack(
            [
                gauss_markov(longitudinal, count, interval, self.sigma, tau)[:, 0],
                self.sigma * _transverse(lateral, count, interval, tau),
                self.sigma * _transverse(vertical, count, interval, tau),
            ],
            axis=-1,
        )


def gauss_markov(
    rng: np.random.Generator, count: int, interval: float, sigma: float, tau: float, axes: int = 1
) -> Array:
    """Stationary first-order Gauss-Markov series (count, axes), exactly discretised."""
    decay = math.exp(-interval / tau)
    drive = rng.standard_normal((count, axes))
    drive[1:] *= math.sqrt(1 - decay**2)
    return np.asarray(sigma * lfilter([1.0], [1.0, -decay], drive, axis=0))


def _transverse(rng: np.random.Generator, count: int, interval: float, tau: float) -> Array:
    """Unit-variance series with the spectrum |1 + sqrt(3) tau s|^2 / |1 + tau s|^4.

    State-space form with x1' = -a x1 + white noise, x2' = -a x2 + x1 and a = 1/tau.
    """
    a = 1 / tau
    decay = math.exp(-a * interval)
    transition = decay * np.array([[1.0, 0.0], [interval, 1.0]])
    stationary = np.array([[1 / (2 * a), 1 / (4 * a**2)], [1 / (4 * a**2), 1 / (4 * a**3)]])
    drive_covariance = stationary - transition @ stationary @ transition.T
    noise = rng.standard_normal((count, 2))
    drive = noise @ np.linalg.cholesky(drive_covariance).T
    drive[0] = np.linalg.cholesky(stationary) @ noise[0]
    x1 = lfilter([1.0], [1.0, -decay], drive[:, 0])
    carried = drive[:, 1].copy()
    carried[1:] += decay * interval * x1[:-1]
    x2 = lfilter([1.0], [1.0, -decay], carried)
    output = np.array([1.0, a * (1 / math.sqrt(3) - 1)])
    scale = 1 / math.sqrt(output @ stationary @ output)
    return np.asarray(scale * (output[0] * x1 + output[1] * x2))
