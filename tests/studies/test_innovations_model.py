# SPDX-License-Identifier: Apache-2.0
"""The innovations model: found again in series that it made, and refused where it does not fit."""

from math import exp, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

from lodestar.errors import InputError
from lodestar.studies.innovations_model import (
    LAGS,
    MIN_SAMPLES,
    InnovationsModel,
    Residuals,
    fit,
    residuals,
)

MODEL = InnovationsModel(A=0.96, K=0.6, e_sigma=0.3, interval_s=1.0)


def made_by(model, count, seed):
    """A series of the model, from long before its first sample on."""
    e = model.e_sigma * np.random.default_rng(seed).standard_normal(count + 3000)
    return lfilter([1.0, model.K - model.A], [1.0, -model.A], e)[3000:]


def gauss_markov(tau_s, sigma, count, seed):
    A = exp(-1.0 / tau_s)
    w = sigma * sqrt(1 - A * A) * np.random.default_rng(seed).standard_normal(count + 3000)
    return lfilter([1.0], [1.0, -A], w)[3000:]


def noisy(tau_s, noise, count, seed):
    """A Gauss-Markov process of variance 1 in white noise."""
    white = np.random.default_rng([seed, 1]).standard_normal(count)
    return gauss_markov(tau_s, 1.0, count, seed) + noise * white


def gain(tau_s, noise):
    """K of such a process: that of its Kalman filter in the long run."""
    A = exp(-1.0 / tau_s)
    p = 1.0
    for _ in range(10_000):
        p = A * A * p * noise**2 / (p + noise**2) + 1 - A * A
    return A * p / (p + noise**2)


def assert_same_dynamics(one, other):
    """Both are where the search ends, to its 1e-5."""
    np.testing.assert_allclose((one.A, one.K), (other.A, other.K), atol=1e-4)


@pytest.mark.parametrize(
    ("tau_s", "noise"), [(5.0, 0.0), (10.0, 0.5), (30.0, 0.0), (30.0, 1.0), (100.0, 0.3)]
)
def test_a_known_process_is_found_within_its_standard_errors(tau_s, noise):
    A, K = exp(-1.0 / tau_s), gain(tau_s, noise)
    off = []
    for seed in range(6):
        found = fit(noisy(tau_s, noise, 2000, seed), 1.0)
        model = found.model
        off.append(
            [
                (model.A - A) / found.A_sigma,
                (model.K - K) / found.K_sigma,
                np.log(model.tau_s / tau_s) / found.log_tau_sigma,
            ]
        )
        # tau 100 s is 20 times in the series: its variance is known to a third.
        assert model.process_sigma == pytest.approx(1.0, rel=0.5)
        # Next to a process of variance 1 little white noise is not to be told from none.
        assert model.noise_sigma == pytest.approx(noise, abs=0.13)
    off = np.abs(off)
    assert np.all(off < 4.0)
    # Nor are they stated larger than they are: 0.62 of what is normal lie beyond 0.5.
    assert np.mean(off > 0.5) > 0.3


def test_the_interval_between_samples_scales_tau_and_nothing_else():
    y = made_by(MODEL, 600, 1)
    one, tenth = fit(y, 1.0), fit(y, 0.1)
    assert tenth.model.tau_s == pytest.approx(0.1 * one.model.tau_s, rel=1e-3)  # of the search
    assert_same_dynamics(tenth.model, one.model)
    assert tenth.log_tau_sigma == pytest.approx(one.log_tau_sigma, rel=1e-2)


def test_a_smoother_series_than_any_process_has_no_white_noise():
    smooth = InnovationsModel(A=0.997, K=1.3, e_sigma=1.0, interval_s=1.0)
    found = fit(made_by(smooth, 3000, 3), 1.0)
    assert abs(found.model.K - smooth.K) < 4 * found.K_sigma
    assert abs(np.log(found.model.tau_s / smooth.tau_s)) < 4 * found.log_tau_sigma < 4
    assert found.model.noise_sigma == 0.0
    assert found.model.process_sigma == found.model.sigma


def test_white_noise_has_no_time_constant_to_be_sure_of():
    found = fit(np.random.default_rng(5).standard_normal(1500), 1.0)
    low, high = found.tau_interval_s
    assert np.isnan(found.log_tau_sigma) or low < 1.0 or high > 100.0 or found.model.tau_s < 1.0
    assert residuals(found.model, np.random.default_rng(6).standard_normal(1500), own=False).white


@settings(max_examples=25, deadline=None)
@given(
    A=st.floats(0.2, 0.999),
    moving=st.floats(-0.9, 0.95),
    lost=st.sets(st.integers(0, 39), max_size=30),
    seed=st.integers(0, 2**32),
)
def test_residuals_weigh_a_series_with_gaps_as_its_whole_covariance_does(A, moving, lost, seed):
    model = InnovationsModel(A=A, K=A - moving, e_sigma=1.0, interval_s=1.0)
    y = np.random.default_rng(seed).standard_normal(40)
    y[list(lost)] = np.nan
    lag = np.abs(np.subtract.outer(np.arange(40), np.arange(40)))
    state = model.K**2 / (1 - A * A)
    covariance = np.where(lag == 0, state + 1, A ** (lag - 1.0) * (A * state + model.K))
    known = ~np.isnan(y)
    whole = y[known] @ np.linalg.solve(covariance[np.ix_(known, known)], y[known])
    left = model.residuals(y)
    assert np.array_equal(np.isnan(left), ~known)
    # The covariance's condition number is up to (1 + |moving|)^2 / (1 - A)^2: 1e-8 are left of it.
    assert np.nansum(left**2) == pytest.approx(whole, rel=1e-7)


@settings(max_examples=10, deadline=None)
@given(factor=st.floats(1e-4, 1e4), sign=st.sampled_from([-1.0, 1.0]))
def test_the_unit_of_a_series_does_not_change_its_model(factor, sign):
    y = made_by(MODEL, 200, 2)
    one, other = fit(y, 1.0).model, fit(sign * factor * y, 1.0).model
    assert_same_dynamics(one, other)
    assert other.e_sigma == pytest.approx(factor * one.e_sigma, rel=1e-4)


def test_a_model_is_found_through_gaps():
    y = made_by(MODEL, 2500, 7)
    y[400:700] = np.nan
    y[np.random.default_rng(7).random(2500) < 0.1] = np.nan
    found = fit(y, 1.0)
    assert found.samples == np.sum(~np.isnan(y))
    assert abs(found.model.A - MODEL.A) < 4 * found.A_sigma
    assert abs(found.model.K - MODEL.K) < 4 * found.K_sigma
    left = residuals(found.model, y, own=True)
    assert left.white
    assert left.pairs[0] < found.samples


def test_residuals_of_the_right_model_are_its_e():
    y = made_by(MODEL, 3000, 4)
    left = residuals(MODEL, y, own=False)
    # A rms of 3000 samples is known to 1.3 %.
    assert left.rms == pytest.approx(MODEL.e_sigma, rel=0.05)
    assert left.explained == pytest.approx(1 - MODEL.e_sigma / np.std(y), abs=0.02)
    assert left.white


def test_bounds_of_whiteness_are_broken_as_often_as_they_say():
    rng = np.random.default_rng(11)
    white = [Residuals(rng.standard_normal(600), 0.0, fitted=0) for _ in range(400)]
    # 10 000 correlations, 1 % out: 100 +- 10. 400 series, 1 % not white: 4 +- 2.
    assert 60 < sum(one.outside for one in white) < 140
    assert sum(not one.white for one in white) <= 12


def test_what_the_model_leaves_behind_is_found_not_white():
    two = gauss_markov(4.0, 1.0, 3000, 1) + gauss_markov(300.0, 1.0, 3000, 2)
    wave = made_by(MODEL, 3000, 3) + 0.5 * np.sin(2 * np.pi * np.arange(3000) / 12.0)
    for y in (two, wave):
        found = fit(y, 1.0)
        left = residuals(found.model, y, own=True)
        assert not left.white
        assert left.outside > 1
    assert not residuals(MODEL, noisy(3.0, 0.0, 3000, 5), own=False).white


def test_the_fitted_parameters_count_in_the_limit():
    own, other = (residuals(MODEL, made_by(MODEL, 300, 1), own=own) for own in (True, False))
    assert own.portmanteau == other.portmanteau
    assert own.portmanteau_limit < other.portmanteau_limit
    assert len(own.bounds) == LAGS


@pytest.mark.parametrize(
    ("y", "said"),
    [
        (np.ones(MIN_SAMPLES - 1), "99 samples at 1 s; a fit needs 100"),
        (np.full(500, np.nan), "0 samples at 1 s"),
        (np.zeros(500), "zero throughout"),
    ],
)
def test_what_cannot_be_fitted_is_refused(y, said):
    with pytest.raises(InputError, match=said):
        fit(y, 1.0)
    if "samples" in said:
        with pytest.raises(InputError, match="samples; a validation needs"):
            residuals(MODEL, y, own=False)
