# SPDX-License-Identifier: Apache-2.0
"""The first-order innovations model of an error, its maximum likelihood fit, and its residuals.

    x' = A x + K e,   y = x + e,   e white                      (Linköping thesis eq. 3.24, B.1)

That is ARMA(1, 1); with 0 < K < A it is a first-order Gauss-Markov process in white noise. Series
are evenly sampled, zero-mean as in the thesis, NaN where a sample is missing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import exp, inf, isnan, log, nan, sqrt

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, stats

from lodestar.errors import InputError

Array = NDArray[np.float64]

MIN_SAMPLES = 100
LAGS = 25
"""Of the autocorrelation of residuals, as in the thesis's figures B.4 to B.6."""
CONFIDENCE = 0.99
"""Of the bounds of whiteness."""

_FITTED = 2  # A and K
_SLOWEST, _FASTEST = 10.0, 0.05  # tau in lengths of the series, in sampling intervals
_STEP = 0.02  # of the second differences of the likelihood, in ln tau and atanh(A - K)


@dataclass(frozen=True)
class InnovationsModel:
    """A model of a series with ``interval_s`` between its samples; 0 < A < 1, |A - K| < 1."""

    A: float
    K: float
    e_sigma: float
    """Standard deviation of e, in the unit of the series."""
    interval_s: float

    @property
    def tau_s(self) -> float:
        """Correlation time, -Ts / ln A."""
        return -self.interval_s / log(self.A)

    @property
    def sigma(self) -> float:
        """Standard deviation of the series."""
        return self.e_sigma * sqrt(1.0 + self._state_variance)

    @property
    def process_sigma(self) -> float:
        """Standard deviation of the Gauss-Markov process in the series.

        Its covariance over one interval is A times its variance. Where K > A the series is smoother
        than any such process, and all of it counts.
        """
        covariance = self.A * self._state_variance + self.K
        return min(self.e_sigma * sqrt(max(covariance / self.A, 0.0)), self.sigma)

    @property
    def noise_sigma(self) -> float:
        """Standard deviation of the white noise in the series; 0 where K > A."""
        return sqrt(max(self.sigma**2 - self.process_sigma**2, 0.0))

    def residuals(self, y: Array) -> Array:
        """Errors of the one-step prediction, y minus its prediction from all before it.

        Weighted down where less is known than in the long run: at the start and after a gap.
        """
        residual, variance = _filter(y, self.A, self.K)
        return residual / np.sqrt(variance)

    @property
    def _state_variance(self) -> float:
        """Of x in the long run, in units of e's."""
        return self.K**2 / (1.0 - self.A**2)


@dataclass(frozen=True)
class Fit:
    """A model found from a series, with the standard errors of what was found."""

    model: InnovationsModel
    samples: int
    A_sigma: float
    K_sigma: float
    log_tau_sigma: float
    """Of ln tau, whose error is far more nearly Gaussian than that of tau; NaN: not determined."""

    @property
    def tau_sigma_s(self) -> float:
        """Standard error of tau."""
        return self.model.tau_s * self.log_tau_sigma

    @property
    def tau_interval_s(self) -> tuple[float, float]:
        """Where tau is with 95 %."""
        if isnan(self.log_tau_sigma):
            return 0.0, inf
        factor = exp(min(1.96 * self.log_tau_sigma, 700.0))
        return self.model.tau_s / factor, self.model.tau_s * factor


@dataclass(frozen=True)
class Residuals:
    """What is left of a series after the one-step prediction, and whether it is white."""

    values: Array
    """NaN where there is no sample."""
    explained: float
    """1 - rms of the residuals over that of the series about its mean: 1 is perfect."""
    fitted: int
    """Parameters of the model that were fitted to this very series."""

    @property
    def rms(self) -> float:
        """Root mean square."""
        return sqrt(float(np.nanmean(self.values**2)))

    @cached_property
    def pairs(self) -> Array:
        """How many pairs of samples each lag from 1 to LAGS has."""
        known = (~np.isnan(self.values)).astype(float)
        return _lagged_sums(known)

    @cached_property
    def autocorrelation(self) -> Array:
        """At the lags from 1 to LAGS (thesis eq. 3.27 over its value at lag 0)."""
        products = _lagged_sums(np.nan_to_num(self.values))
        return np.asarray(products / np.maximum(self.pairs, 1.0) / self.rms**2)

    @property
    def bounds(self) -> Array:
        """Within which each correlation of a white series lies with CONFIDENCE."""
        quantile = float(stats.norm.ppf(0.5 + CONFIDENCE / 2))
        return np.asarray(quantile / np.sqrt(np.maximum(self.pairs, 1.0)))

    @property
    def outside(self) -> int:
        """How many of the LAGS correlations are out of bounds."""
        return int(np.sum(np.abs(self.autocorrelation) > self.bounds))

    @property
    def portmanteau(self) -> float:
        """All LAGS at once (Ljung and Box, 1978): chi-squared where the series is white."""
        return float(np.sum(self.pairs * self.autocorrelation**2))

    @property
    def portmanteau_limit(self) -> float:
        """Under which it is with CONFIDENCE where the series is white."""
        return float(stats.chi2.ppf(CONFIDENCE, LAGS - self.fitted))

    @property
    def white(self) -> bool:
        """Whether the model has taken out all that can be predicted."""
        return self.portmanteau <= self.portmanteau_limit


def fit(y: Array, interval_s: float) -> Fit:
    """The model of greatest likelihood for a Gaussian series, exact at its start and over gaps.

    Raises InputError for fewer than MIN_SAMPLES samples, and where all of them are zero.
    """
    samples = int(np.sum(~np.isnan(y)))
    if samples < MIN_SAMPLES:
        raise InputError(f"{samples} samples at {interval_s:g} s; a fit needs {MIN_SAMPLES}")
    if not np.nanmax(np.abs(y)) > 0:
        raise InputError("is zero throughout; there is nothing to fit")

    def cost(u: Array) -> float:
        return _cost(y, *_from_search(u, interval_s))

    limits = (log(_FASTEST * interval_s), log(_SLOWEST * len(y) * interval_s))
    slowest = log(0.3 * len(y) * interval_s)
    starts = [
        np.array([log_tau, moving])
        for log_tau in np.linspace(log(interval_s), slowest, 7)
        for moving in np.arctanh([-0.5, 0.0, 0.5, 0.9])
    ]
    start = min(starts, key=cost)
    found = optimize.minimize(
        cost,
        start,
        method="Nelder-Mead",
        bounds=[limits, (-8.0, 8.0)],
        options={
            "initial_simplex": start + np.array([[0.0, 0.0], [-0.5, 0.1], [-0.5, -0.1]]),
            "xatol": 1e-5,
            "fatol": 1e-6,
        },
    )
    A, K = _from_search(found.x, interval_s)
    variance = _innovation_variance(*_filter(y, A, K))
    covariance = _covariance(cost, found.x)
    return Fit(
        InnovationsModel(A, K, sqrt(variance), interval_s),
        samples,
        *_standard_errors(A, K, covariance),
    )


def residuals(model: InnovationsModel, y: Array, *, own: bool) -> Residuals:
    """How well the model predicts a series; ``own``: the one that it was fitted to.

    Raises InputError for fewer than MIN_SAMPLES samples.
    """
    samples = int(np.sum(~np.isnan(y)))
    if samples < MIN_SAMPLES:
        raise InputError(f"{samples} samples; a validation needs {MIN_SAMPLES}")
    values = model.residuals(y)
    spread = float(np.nanstd(y))
    explained = 1.0 - sqrt(float(np.nanmean(values**2))) / spread if spread else nan
    return Residuals(values, explained, _FITTED if own else 0)


def _from_search(u: Array, interval_s: float) -> tuple[float, float]:
    """A and K of (ln tau, atanh(A - K)), in which 0 < A < 1 and |A - K| < 1 always hold."""
    A = exp(-interval_s / exp(u[0]))
    return A, A - float(np.tanh(u[1]))


def _filter(y: Array, A: float, K: float) -> tuple[Array, Array]:
    """Errors of the one-step prediction, and their variances in units of e's; NaN over gaps.

    The Kalman filter of the model, from its long-run distribution on. Process and measurement noise
    are both e, so that what is not known of x, p, dies out as (A - K)^2 while there are samples.
    """
    errors, variances = [], []
    x, p = 0.0, K * K / (1.0 - A * A)
    forgotten = (A - K) ** 2
    for value in y.tolist():
        s = p + 1.0
        error = value - x
        errors.append(error)
        variances.append(s)
        if isnan(value):
            x *= A
            p = A * A * p + K * K
        else:
            x = A * x + (A * p + K) / s * error
            p *= forgotten / s
    return np.array(errors), np.array(variances)


def _innovation_variance(error: Array, variance: Array) -> float:
    return float(np.nanmean(error**2 / variance))


def _cost(y: Array, A: float, K: float) -> float:
    """Minus the logarithm of the likelihood of A and K, with the best variance of e."""
    error, variance = _filter(y, A, K)
    known = ~np.isnan(error)
    spread = float(np.sum(np.log(variance[known])))
    return 0.5 * (float(np.sum(known)) * log(_innovation_variance(error, variance)) + spread)


def _covariance(cost: Callable[[Array], float], u: Array) -> Array:
    """Of what was searched, by the curvature of the likelihood; NaN where it has none."""
    steps = _STEP * np.eye(2)
    curvature = np.empty((2, 2))
    for i in range(2):
        for j in range(2):
            a, b = steps[i], steps[j]
            corners = cost(u + a + b) - cost(u + a - b) - cost(u - a + b) + cost(u - a - b)
            curvature[i, j] = corners / (4.0 * _STEP**2)
    if not np.all(np.linalg.eigvalsh(curvature) > 1e-6):
        return np.full((2, 2), nan)
    return np.asarray(np.linalg.inv(curvature))


def _standard_errors(A: float, K: float, covariance: Array) -> tuple[float, float, float]:
    """Of A, K and ln tau."""
    by_log_tau = -A * log(A)
    gradient_of_K = np.array([by_log_tau, -(1.0 - (A - K) ** 2)])
    log_tau_sigma = sqrt(covariance[0, 0])
    K_variance = float(gradient_of_K @ covariance @ gradient_of_K)
    return by_log_tau * log_tau_sigma, sqrt(K_variance), log_tau_sigma


def _lagged_sums(values: Array) -> Array:
    return np.array([float(values[lag:] @ values[:-lag]) for lag in range(1, LAGS + 1)])
