# SPDX-License-Identifier: Apache-2.0
"""Smooth functions of time, sampled: how a simulated flight is differentiated and integrated.

A sampled quantity stands for the quintic spline through its samples. Its derivative and integral
at the samples are those of the spline, so they agree with each other exactly.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import make_interp_spline

Array = NDArray[np.float64]

# 1 at x = 1, and four derivatives zero at both ends.
_STEP = np.polynomial.Polynomial([0, 0, 0, 0, 0, 126, -420, 540, -315, 70])
_STEP_INTEGRAL = _STEP.integ()
STEP_SLOPE = 315 / 128
"""Steepest slope of step(x), at x = 1/2."""
STEP_MOMENT = 0.5 - float((_STEP * np.polynomial.Polynomial([0, 1])).integ()(1.0))
"""Integral of x (1 - step(x)) over [0, 1]."""


def step(x: ArrayLike) -> Array:
    """A smooth step (four continuous derivatives) from 0 for x <= 0 to 1 for x >= 1."""
    return np.asarray(_STEP(np.clip(x, 0.0, 1.0)))


def step_slope(x: ArrayLike) -> Array:
    """Derivative of step(x)."""
    return np.asarray(_STEP.deriv()(np.clip(x, 0.0, 1.0)))


def plateau(t: ArrayLike, duration: float, ramp: float) -> Array:
    """A smooth pulse: from 0 to 1 within ``ramp`` seconds, and back to 0 by ``duration``."""
    t = np.asarray(t, float)
    return step(t / ramp) - step((t - duration + ramp) / ramp)


def plateau_integral(t: ArrayLike, duration: float, ramp: float) -> Array:
    """Integral of plateau() from 0; it ends at duration - ramp."""
    t = np.asarray(t, float)
    return _step_integral(t, ramp) - _step_integral(t - duration + ramp, ramp)


def _step_integral(t: Array, ramp: float) -> Array:
    inside = ramp * _STEP_INTEGRAL(np.clip(t / ramp, 0.0, 1.0))
    return np.asarray(inside + np.maximum(t - ramp, 0.0))


def derivative(values: Array, interval: float) -> Array:
    """Time derivative of samples (n, ...) that are ``interval`` seconds apart."""
    return np.asarray(_spline(values, interval).derivative()(_times(values, interval)))


def running_integral(values: Array, interval: float) -> Array:
    """Integral (n, ...) from the first sample, of samples that are ``interval`` seconds apart."""
    return np.asarray(_spline(values, interval).antiderivative()(_times(values, interval)))


def _times(values: Array, interval: float) -> Array:
    return np.arange(len(values), dtype=np.float64) * interval


def _spline(values: Array, interval: float) -> Any:
    return make_interp_spline(_times(values, interval), values, k=5)
