# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from scipy.signal import welch

from lodestar.simulation.wind import Turbulence, Wind, gauss_markov

T = np.arange(0, 1500, 0.1)


def rng(seed=0):
    return np.random.default_rng(seed)


def test_steady_wind_is_steady_and_horizontal():
    wind_N = Wind((6.0, 7.0)).velocity_N(T, rng())
    np.testing.assert_array_equal(wind_N, np.tile([6.0, 7.0, 0.0], (len(T), 1)))


def test_pulses_take_turns_every_interval_with_ramps_of_ten_seconds():
    wind_N = Wind((3.0, 3.0), (12.0, -12.0), 300.0).velocity_N(T, rng())
    for middle, pulse in [(150, 0), (450, 12), (750, 0), (1050, 12), (1350, 0)]:
        np.testing.assert_allclose(wind_N[middle * 10], [3 + pulse, 3 - pulse, 0], atol=1e-9)
    assert wind_N[3000, 0] == pytest.approx(3.0)
    assert wind_N[3050, 0] == pytest.approx(9.0)
    assert wind_N[3100, 0] == pytest.approx(15.0)
    steepest = np.abs(np.diff(wind_N[:, 0])).max() / 0.1
    assert 1.2 < steepest < 1.6  # 12 m/s in 10 s, a little more in the middle


def test_wandering_wind_has_its_sigma_and_correlation_time_and_is_smooth():
    t = np.arange(0, 200_000, 1.0)
    wind_N = Wind(wander_sigma=1.0, wander_tau=120.0).velocity_N(t, rng(1))
    # 1700 correlation times: 4 % of one sigma on the sigma, 6 % on the correlation.
    np.testing.assert_allclose(wind_N[:, :2].std(axis=0), 1.0, atol=0.08)
    for axis in range(2):
        lagged = np.mean(wind_N[120:, axis] * wind_N[:-120, axis]) / np.var(wind_N[:, axis])
        assert lagged == pytest.approx(np.exp(-1), abs=0.12)
    assert abs(np.corrcoef(wind_N[:, 0], wind_N[:, 1])[0, 1]) < 0.15
    np.testing.assert_array_equal(wind_N[:, 2], 0.0)
    fine = Wind(wander_sigma=1.0).velocity_N(T, rng(2))[:, 0]
    assert np.abs(np.diff(fine, n=2)).max() / 0.1**2 < 0.5  # m/s^3: an aircraft follows that


def test_same_seed_same_wind():
    wind = Wind(wander_sigma=1.0)
    np.testing.assert_array_equal(wind.velocity_N(T, rng(5)), wind.velocity_N(T, rng(5)))
    assert np.any(wind.velocity_N(T, rng(5)) != wind.velocity_N(T, rng(6)))


def test_no_turbulence_is_none():
    assert not Turbulence().gust_B(10, 0.1, 200.0, rng()).any()


def test_turbulence_has_the_spectra_of_dryden():
    sigma, length, airspeed, interval = 2.0, 533.4, 200.0, 0.05
    gust_B = Turbulence(sigma, length).gust_B(400_000, interval, airspeed, rng(7))
    # 20 000 s of 2.7 s correlation: 1 % on the variance.
    np.testing.assert_allclose(gust_B.std(axis=0), sigma, rtol=0.04)
    assert np.abs(np.corrcoef(gust_B.T) - np.eye(3)).max() < 0.05
    frequency, density = welch(gust_B, 1 / interval, nperseg=4096, axis=0)
    omega, tau = 2 * np.pi * frequency, length / airspeed
    x = (tau * omega) ** 2
    along = 4 * sigma**2 * tau / (1 + x)
    across = 2 * sigma**2 * tau * (1 + 3 * x) / (1 + x) ** 2
    band = (frequency > 0.02) & (frequency < 2.0)
    for axis, expected in enumerate((along, across, across)):
        ratio = density[band, axis] / expected[band]
        # 190 averaged segments: 7 % per line, well below 1 % in the mean.
        assert np.mean(ratio) == pytest.approx(1.0, abs=0.03)
        assert np.abs(np.log(ratio)).max() < 0.5


def test_turbulence_is_stationary_from_the_first_sample():
    first = [Turbulence(2.0).gust_B(2, 1 / 60, 200.0, rng(seed))[0] for seed in range(2000)]
    np.testing.assert_allclose(np.std(first, axis=0), 2.0, rtol=0.06)  # 1.6 % is one sigma


def test_gauss_markov_series_is_stationary_with_its_decay():
    series = gauss_markov(rng(9), 200_000, 1.0, 3.0, 10.0, axes=2)
    np.testing.assert_allclose(series.std(axis=0), 3.0, rtol=0.04)
    lagged = np.mean(series[10:] * series[:-10], axis=0) / 9.0
    np.testing.assert_allclose(lagged, np.exp(-1), atol=0.05)
    starts = [gauss_markov(rng(seed), 1, 1.0, 3.0, 10.0)[0, 0] for seed in range(2000)]
    assert np.std(starts) == pytest.approx(3.0, rel=0.06)
