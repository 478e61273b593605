# SPDX-License-Identifier: Apache-2.0
"""Sensor error models: small pieces that are chained to make a sensor.

Each piece takes the signal (n, k) that reaches it and gives the signal that leaves it; the chain
is applied in order, so put what happens to the quantity itself first (lag, misalignment, scale
factor), then bias and noise, then what the converter does (saturation, quantisation). Numbers are
in the unit of the signal; a ``sigma`` is drawn anew, per axis, for every flight.

A new piece needs nothing but the method of ErrorModel.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol
from zlib import crc32

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from lodestar.simulation.wind import gauss_markov

Array = NDArray[np.float64]


class ErrorModel(Protocol):
    """One piece of a sensor's error."""

    def apply(self, signal: Array, interval: float, rng: np.random.Generator) -> Array:
        """The signal (n, k) with this error; samples are ``interval`` seconds apart."""
        ...


def random_stream(seed: int, name: str) -> np.random.Generator:
    """The random numbers of one named part of a simulation.

    Streams are independent of each other: a sensor that is added, removed or changed leaves the
    random numbers of all others as they were.
    """
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(crc32(name.encode()),)))


def measured(
    truth: Array,
    errors: Sequence[ErrorModel],
    interval: float,
    rng: np.random.Generator,
    lasting: np.random.Generator | None = None,
) -> Array:
    """Truth (n,) or (n, k) as a sensor with these errors gives it, in the same shape.

    Every piece has its own random numbers, spawned from ``rng`` in order; those that stay for a
    sensor's life (LASTING) from ``lasting`` where that is given.
    """
    signal = np.array(truth, float).reshape(len(truth), -1)
    own = rng.spawn(len(errors))
    for_life = own if lasting is None else lasting.spawn(len(errors))
    for model, stream, fixed in zip(errors, own, for_life, strict=True):
        signal = model.apply(signal, interval, fixed if isinstance(model, LASTING) else stream)
    return signal.reshape(truth.shape)


@dataclass(frozen=True)
class Bias:
    """A constant, N(0, sigma) per axis."""

    sigma: float

    def apply(self, signal: Array, interval: float, rng: np.random.Generator) -> Array:
        """See ErrorModel."""
        return signal + self.sigma * rng.standard_normal(signal.shape[1])


@dataclass(frozen=True)
class GaussMarkov:
    """A slowly varying bias: first-order Gauss-Markov, stationary, correlation time tau (s)."""

    sigma: float
    tau: float

    def apply(self, signal: Array, interval: float, rng: np.random.Generator) -> Array:
        """See ErrorModel."""
        count, axes = signal.shape
        return signal + gauss_markov(rng, count, interval, self.sigma, self.tau, axes)


@dataclass(frozen=True)
class WhiteNoise:
    """Independent N(0, sigma) per sample and axis."""

    sigma: float

    @classmethod
    def from_density(cls, density: float, bandwidth: float) -> WhiteNoise:
        """Noise of one-sided spectral ``density`` (unit/sqrt(Hz)) within ``bandwidth`` (Hz)."""
        return cls(density * math.sqrt(bandwidth))

    def apply(self, signal: Array, interval: float, rng: np.random.Generator) -> Array:
        """See ErrorModel."""
        return signal + self.sigma * rng.standard_normal(signal.shape)


@dataclass(frozen=True)
class ScaleFactor:
    """Multiplies each axis by 1 + N(0, sigma)."""

    sigma: float

    def apply(self, signal: Array, interval: float, rng: np.random.Generator) -> Array:
        """See ErrorModel."""
        return signal * (1 + self.sigma * rng.standard_normal(signal.shape[1]))


@dataclass(frozen=True)
class Misalignment:
    """Each axis leans towards each other one by N(0, sigma) rad: six angles for three axes."""

    sigma: float

    def apply(self, signal: Array, interval: float, rng: np.random.Generator) -> Array:
        """See ErrorModel."""
        axes = signal.shape[1]
        lean = self.sigma * rng.standard_normal((axes, axes))
        np.fill_diagonal(lean, 0.0)
        return signal + signal @ lean.T


@dataclass(frozen=True)
class MatrixError:
    """Multiplies by I + E, each element of E (all nine for three axes) N(0, sigma)."""

    sigma: float

    def apply(self, signal: Array, interval: float, rng: np.random.Generator) -> Array:
        """See ErrorModel."""
        axes = signal.shape[1]
        error = self.sigma * rng.standard_normal((axes, axes))
        return signal + signal @ error.T


@dataclass(frozen=True)
class Lag:
    """A first-order lag with time constant tau (s), settled at the first sample.

    Exact for a signal that is straight between samples.
    """

    tau: float

    def apply(self, signal: Array, interval: float, rng: np.random.Generator) -> Array:
        """See ErrorModel."""
        decay = math.exp(-interval / self.tau)
        mean = (1 - decay) * self.tau / interval
        # y_k = decay y_{k-1} + (mean - decay) u_{k-1} + (1 - mean) u_k
        settled = mean * signal[:1]
        lagged, _ = lfilter([1 - mean, mean - decay], [1.0, -decay], signal, axis=0, zi=settled)
        return np.asarray(lagged)


@dataclass(frozen=True)
class Saturation:
    """The converter's range: what lies beyond +-limit reads +-limit."""

    limit: float

    def apply(self, signal: Array, interval: float, rng: np.random.Generator) -> Array:
        """See ErrorModel."""
        return np.clip(signal, -self.limit, self.limit)


@dataclass(frozen=True)
class Quantisation:
    """The converter's resolution: the nearest whole number of steps."""

    step: float

    def apply(self, signal: Array, interval: float, rng: np.random.Generator) -> Array:
        """See ErrorModel."""
        return self.step * np.round(signal / self.step)


LASTING = (Bias, ScaleFactor, Misalignment, MatrixError)
"""Errors that a sensor keeps from flight to flight, if it is the same sensor."""
