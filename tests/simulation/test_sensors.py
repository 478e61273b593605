# SPDX-License-Identifier: Apache-2.0
"""The suite gripen against its table, from many seeds of a short flight."""

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from lodestar.simulation.earth import meridian_radius, transverse_radius
from lodestar.simulation.flight_path import PathBuilder, Start
from lodestar.simulation.sensors import GpsService, sense
from lodestar.simulation.suites import SUITES
from lodestar.simulation.trajectory import Aircraft, fly_path

GRIPEN = SUITES["gripen"]
SEEDS = 200


def short_flight(rate_hz=60):
    builder = PathBuilder(Start(radians(57.5), radians(16.0), 2500.0, 0.3, 190.0), rate_hz)
    builder.straight(5.0)
    builder.horizontal_turn(radians(60), bank=radians(40), roll_rate=radians(25))
    builder.climb(2700.0, angle=radians(4), load=0.3)
    path = builder.path()
    calm = np.zeros((len(path.airspeed), 3))
    return fly_path(path, calm, calm, Aircraft(), 2026.5)


@pytest.fixture(scope="module")
def flight():
    return short_flight()


@pytest.fixture(scope="module")
def flights(flight):
    """Channels of many seeds; uncalibrated, default GPS."""
    return [
        sense(flight, GRIPEN, GpsService(), calibrated=False, seed=seed) for seed in range(SEEDS)
    ]


def error_of_mean(flights, channel, field, truth):
    """Mean over each flight of measured minus true: the constant part of the error."""
    errors = [np.mean(one[channel][field] - truth(one[channel]), axis=0) for one in flights]
    return np.array(errors)


def noise_of(flights, channel, field):
    """White part, from third differences of the first seconds, where the flight is straight."""
    straight = [np.diff(one[channel][field][:100], n=3, axis=0) for one in flights]
    return np.std(straight, axis=(0, 1)) / np.sqrt(20)


def test_rates_of_the_channels(flights, flight):
    counts = {name: len(columns["time_us"]) for name, columns in flights[0].items()}
    seconds = (len(flight.time_us) - 1) / 60
    assert counts["EFCS.RATES"] == counts["EFCS.LOAD_FACTOR"] == counts["TRUTH"] == 60 * seconds + 1
    assert counts["SMDU"] == counts["ADC"] == counts["INS"] == int(30 * seconds) + 1
    assert counts["GPS"] == int(seconds) + 1


def test_times_are_those_of_the_truth_and_only_gps_is_late(flights, flight):
    for name, columns in flights[0].items():
        assert np.isin(columns["time_us"], flight.time_us).all()
        late = columns.get("arrival_us", columns["time_us"]) - columns["time_us"]
        assert (late == (200_000 if name == "GPS" else 0)).all()


def test_body_rates(flights, flight):
    assert noise_of(flights, "EFCS.RATES", "omega_B") == pytest.approx(radians(0.05), rel=0.03)
    # Before the turn nothing but the turn-on bias and its in-run drift is there.
    straight = np.array([one["EFCS.RATES"]["omega_B"][:240].mean(axis=0) for one in flights])
    expected = np.hypot(radians(0.2), radians(0.03))
    # 200 flights: 5 % is one sigma; so below.
    np.testing.assert_allclose((straight - flight.omega_B[:240].mean(0)).std(0), expected, rtol=0.2)


def test_load_factor(flights, flight):
    assert noise_of(flights, "EFCS.LOAD_FACTOR", "n_B") == pytest.approx(0.02, rel=0.03)
    bias = error_of_mean(flights, "EFCS.LOAD_FACTOR", "n_B", lambda _: -flight.f_B / 9.80665)
    np.testing.assert_allclose(bias.std(axis=0), 0.01, rtol=0.2)


@pytest.mark.parametrize(("calibrated", "bias", "matrix"), [(False, 500, 0.003), (True, 75, 5e-4)])
def test_magnetic_detector(flight, calibrated, bias, matrix):
    b_B = np.einsum("nji,nj->ni", flight.C_NB, flight.b_N)[::2]
    errors = []
    for seed in range(SEEDS):
        channels = sense(flight, GRIPEN, GpsService(), calibrated=calibrated, seed=seed)
        errors.append((channels["SMDU"]["b_B"] - b_B)[:120].mean(axis=0))
    field = np.linalg.norm(b_B[0])
    expected = np.sqrt(bias**2 + (matrix * field) ** 2 + 60**2)
    np.testing.assert_allclose(np.std(errors, axis=0), expected, rtol=0.2)


def test_magnetic_detector_noise(flights):
    assert noise_of(flights, "SMDU", "b_B") == pytest.approx(80.0, rel=0.03)


def test_air_data(flights, flight):
    assert noise_of(flights, "ADC", "true_airspeed") == pytest.approx(0.5, rel=0.03)
    for field in ("alpha", "beta"):
        assert noise_of(flights, "ADC", field) == pytest.approx(radians(0.1), rel=0.03)
    assert noise_of(flights, "ADC", "baro_altitude") == pytest.approx(0.5, rel=0.03)
    speed = error_of_mean(flights, "ADC", "true_airspeed", lambda _: flight.true_airspeed[::2])
    assert speed.std() == pytest.approx(np.hypot(0.5, 0.005 * 190), rel=0.2)
    for field in ("alpha", "beta"):
        error = error_of_mean(flights, "ADC", field, lambda _, f=field: getattr(flight, f)[::2])
        assert error.std() == pytest.approx(radians(0.3), rel=0.2)
    baro = error_of_mean(flights, "ADC", "baro_altitude", lambda _: flight.h[::2])
    assert baro.std() == pytest.approx(20.0, rel=0.2)


def test_baro_altitude_lags_a_climb_by_its_time_constant(flights, flight):
    climb = -flight.v_N[::2, 2]
    steady = climb > 0.95 * climb.max()
    error = np.array([one["ADC"]["baro_altitude"] - flight.h[::2] for one in flights])
    lag = error[:, :90].mean(axis=1) - error[:, steady].mean(axis=1)
    assert lag.mean() == pytest.approx(0.3 * climb[steady].mean(), rel=0.05)


def test_static_temperature_is_that_of_the_standard_atmosphere(flights, flight):
    expected = 288.15 - 0.0065 * flight.h[::2]
    np.testing.assert_allclose(flights[0]["ADC"]["static_temperature"], expected, rtol=1e-12)


def position_errors(flights, flight, channel, rows):
    lat, h = flight.lat[rows], flight.h[rows]
    return np.array(
        [
            [
                (one[channel]["lat"] - lat) * (meridian_radius(lat) + h),
                (one[channel]["lon"] - flight.lon[rows])
                * (transverse_radius(lat) + h)
                * np.cos(lat),
                h - one[channel]["h"],
            ]
            for one in flights
        ]
    )


def test_gps_position_wanders_and_scatters(flights, flight):
    error = position_errors(flights, flight, "GPS", slice(None, None, 60))
    np.testing.assert_allclose(error.std(axis=(0, 2)), np.hypot(5.0, 1.0), rtol=0.12)
    steps = np.diff(error, axis=2)
    expected = np.sqrt(2 * 25 * (1 - np.exp(-1 / 150)) + 2)
    np.testing.assert_allclose(steps.std(axis=(0, 2)), expected, rtol=0.05)
    fix = flights[0]["GPS"]
    assert (fix["sigma_horizontal"] == 5.1).all()
    assert not fix["has_velocity"].any()
    assert not fix["v_N"].any()


def test_white_gps_has_no_memory(flight):
    flights = [
        sense(flight, GRIPEN, GpsService(errors="white"), calibrated=False, seed=seed)
        for seed in range(60)
    ]
    error = position_errors(flights, flight, "GPS", slice(None, None, 60))
    assert error.std() == pytest.approx(5.0, rel=0.05)
    assert np.mean(error[..., 1:] * error[..., :-1]) == pytest.approx(0.0, abs=1.0)


def test_gps_velocity_is_given_where_asked_for(flight):
    flights = [
        sense(flight, GRIPEN, GpsService(velocity=True), calibrated=False, seed=seed)
        for seed in range(60)
    ]
    error = np.array([one["GPS"]["v_N"] - flight.v_N[::60] for one in flights])
    assert error.std() == pytest.approx(0.1, rel=0.05)
    assert flights[0]["GPS"]["has_velocity"].all()
    assert (flights[0]["GPS"]["sigma_velocity"] == 0.1).all()


def test_outage_removes_fixes_and_changes_no_other(flights, flight):
    service = GpsService(outages=((3.0, 2.0), (10.0, 1.5)))
    cut = sense(flight, GRIPEN, service, calibrated=False, seed=0)["GPS"]
    whole = flights[0]["GPS"]
    lost = np.isin(whole["time_us"], [3_000_000, 4_000_000, 10_000_000, 11_000_000])
    assert lost.sum() == 4
    for name, values in whole.items():
        np.testing.assert_array_equal(cut[name], values[~lost])


def test_latency_delays_arrival_only(flight):
    channels = sense(flight, GRIPEN, GpsService(latency=0.7), calibrated=False, seed=0)
    late = channels["GPS"]["arrival_us"] - channels["GPS"]["time_us"]
    assert (late == 700_000).all()


def test_ins(flights, flight):
    rows = slice(None, None, 2)
    for field, sigma in (("roll", 0.05), ("pitch", 0.05), ("heading", 0.1)):
        error = error_of_mean(flights, "INS", field, lambda _, f=field: getattr(flight, f)[rows])
        assert np.degrees(error).std() == pytest.approx(sigma, rel=0.2)
    velocity = np.array([one["INS"]["v_N"] - flight.v_N[rows] for one in flights])
    np.testing.assert_allclose(velocity.std(axis=(0, 1)), 0.3, rtol=0.2)
    error = position_errors(flights, flight, "INS", rows)
    assert np.abs(error[:, :2, 0]).max() < 1e-8
    seconds = flight.time_us[rows][-1] * 1e-6
    np.testing.assert_allclose(error[:, :2, -1], velocity[:, 0, :2] * seconds, atol=1e-6)
    radial = np.hypot(*(error[:, :2, -1].T)) / seconds
    # 0.8 NM/h is 0.41 m/s.
    assert np.sqrt(np.mean(radial**2)) == pytest.approx(0.41, rel=0.15)
    assert (np.abs(np.diff(flights[0]["INS"]["heading"][:100])) > 0).all()


def test_sensors_do_not_share_random_numbers(flight, flights):
    other = replace(GRIPEN, body_rates=(), load_factor=())
    changed = sense(flight, other, GpsService(), calibrated=True, seed=0)
    for channel in ("ADC", "GPS", "INS"):
        for name, values in flights[0][channel].items():
            np.testing.assert_array_equal(changed[channel][name], values)


def test_sensor_rate_need_not_divide_that_of_the_truth():
    flight = short_flight(rate_hz=50)
    smdu = sense(flight, GRIPEN, GpsService(), calibrated=False, seed=0)["SMDU"]
    steps = np.diff(smdu["time_us"])
    assert set(steps) <= {20_000, 40_000}
    assert np.mean(steps) == pytest.approx(1e6 / 30, rel=1e-3)


def test_uav_suite_flies_at_constant_alpha():
    builder = PathBuilder(Start(radians(57.5), radians(16.0), 400.0, 0.0, 25.0), 250)
    builder.horizontal_turn(radians(90), bank=radians(25), roll_rate=radians(30))
    path = builder.path()
    calm = np.zeros((len(path.airspeed), 3))
    suite = SUITES["uav"]
    flight = fly_path(path, calm, calm, suite.aircraft, 2026.5)
    np.testing.assert_allclose(flight.alpha, 0.05, atol=1e-12)
    np.testing.assert_allclose(flight.beta, 0.0, atol=1e-12)
    channels = sense(flight, suite, GpsService("white", True), calibrated=False, seed=1)
    assert "INS" not in channels
    seconds = (len(flight.time_us) - 1) / 250
    assert len(channels["GPS"]["time_us"]) == int(5 * seconds) + 1
    assert len(channels["ADC"]["time_us"]) == int(10 * seconds) + 1


def test_an_aircraft_keeps_the_lasting_errors_of_its_detector_from_flight_to_flight(flight):
    def mean_field(seed, airframe_seed):
        channels = sense(
            flight, GRIPEN, GpsService(), calibrated=False, seed=seed, airframe_seed=airframe_seed
        )
        return np.mean(channels["SMDU"]["b_B"], axis=0)

    # Two flights differ by their slow errors, 60 nT each; two aircraft by their biases, 500 nT.
    assert np.abs(mean_field(1, 9) - mean_field(2, 9)).max() < 300
    assert np.abs(mean_field(1, 9) - mean_field(1, 10)).max() > 300
    assert np.array_equal(mean_field(1, None), mean_field(1, 1))
