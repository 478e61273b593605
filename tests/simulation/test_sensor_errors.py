# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from scipy.signal import welch

from lodestar.simulation.sensor_errors import (
    Bias,
    GaussMarkov,
    Lag,
    MatrixError,
    Misalignment,
    Quantisation,
    Saturation,
    ScaleFactor,
    WhiteNoise,
    measured,
    random_stream,
)

DT = 1 / 60
ZERO = np.zeros((3000, 3))


def over_seeds(truth, errors, count=400):
    return np.array([measured(truth, errors, DT, np.random.default_rng(s)) for s in range(count)])


def test_no_errors_no_change():
    truth = np.random.default_rng(0).standard_normal((10, 3))
    np.testing.assert_array_equal(measured(truth, (), DT, np.random.default_rng(0)), truth)


def test_bias_is_constant_within_a_flight_and_drawn_for_each():
    flights = over_seeds(ZERO[:5], (Bias(2.0),))
    assert np.ptp(flights, axis=1).max() == 0.0
    # 400 draws: 3.5 % is one sigma.
    np.testing.assert_allclose(flights[:, 0].std(axis=0), 2.0, rtol=0.12)
    assert np.abs(flights[:, 0].mean(axis=0)).max() < 0.4


def test_scale_factor_misalignment_and_matrix_act_on_their_elements():
    unit = np.eye(3)
    scale = over_seeds(unit, (ScaleFactor(0.01),)) - unit
    lean = over_seeds(unit, (Misalignment(0.01),)) - unit
    matrix = over_seeds(unit, (MatrixError(0.01),)) - unit
    diagonal = np.eye(3, dtype=bool)
    np.testing.assert_allclose(scale[:, diagonal].std(axis=0), 0.01, rtol=0.15)
    assert not scale[:, ~diagonal].any()
    np.testing.assert_allclose(lean[:, ~diagonal].std(axis=0), 0.01, rtol=0.15)
    assert not lean[:, diagonal].any()
    np.testing.assert_allclose(matrix.reshape(-1, 9).std(axis=0), 0.01, rtol=0.15)


def test_white_noise_from_density_has_that_density():
    noise = measured(
        np.zeros(200_000), (WhiteNoise.from_density(0.02, 30.0),), DT, np.random.default_rng(1)
    )
    _, density = welch(noise, 60.0, nperseg=256)
    assert np.mean(density[1:-1]) == pytest.approx(0.02**2, rel=0.03)


def test_gauss_markov_wanders_as_slowly_as_it_should():
    flights = over_seeds(np.zeros((2, 1)), (GaussMarkov(3.0, DT / np.log(2)),), count=4000)
    np.testing.assert_allclose(flights.std(axis=0), 3.0, rtol=0.05)
    after = np.mean(flights[:, 0] * flights[:, 1]) / 9.0
    assert after == pytest.approx(0.5, abs=0.05)


def test_lag_follows_a_ramp_at_its_time_constant_and_starts_settled():
    t = np.arange(600) * DT
    ramp = np.stack([100.0 + 0 * t, 5.0 * t], axis=-1)
    lagged = measured(ramp, (Lag(0.3),), DT, np.random.default_rng(0))
    np.testing.assert_allclose(lagged[:, 0], 100.0, atol=1e-11)
    exact = 5.0 * (t - 0.3 * (1 - np.exp(-t / 0.3)))
    np.testing.assert_allclose(lagged[:, 1], exact, atol=1e-10)


def test_saturation_and_quantisation_are_those_of_a_converter():
    truth = np.array([-12.3, -0.26, 0.0, 0.24, 12.3])
    errors = (Quantisation(0.5), Saturation(10.0))
    read = measured(truth, errors, DT, np.random.default_rng(0))
    np.testing.assert_array_equal(read, [-10.0, -0.5, 0.0, 0.0, 10.0])


def test_adding_a_piece_leaves_the_random_numbers_of_those_before_it():
    few = measured(ZERO, (Bias(1.0), GaussMarkov(1.0, 9.0)), DT, np.random.default_rng(4))
    more = measured(
        ZERO, (Bias(1.0), GaussMarkov(1.0, 9.0), WhiteNoise(0.0)), DT, np.random.default_rng(4)
    )
    np.testing.assert_array_equal(few, more)


def test_named_streams_are_reproducible_and_independent():
    draw = random_stream(3, "gyro").standard_normal(1000)
    np.testing.assert_array_equal(draw, random_stream(3, "gyro").standard_normal(1000))
    for other in (random_stream(3, "adc"), random_stream(4, "gyro")):
        assert abs(np.corrcoef(draw, other.standard_normal(1000))[0, 1]) < 0.12


def test_shape_of_one_dimensional_signals_is_kept():
    assert measured(np.zeros(7), (Bias(1.0),), DT, np.random.default_rng(0)).shape == (7,)
