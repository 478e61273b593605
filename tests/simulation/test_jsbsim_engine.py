# SPDX-License-Identifier: Apache-2.0
"""The F-16 of JSBSim must fly the profile, survive it, and its truth must agree with itself."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lodestar.errors import InputError
from lodestar.harness.scenario import Scenario, fly_truth, load_scenario, simulate
from lodestar.rotation import exp_quaternion, quaternion_conjugate, quaternion_product, wrap_pi
from lodestar.simulation import autopilot, earth
from lodestar.simulation.calculus import running_integral
from lodestar.simulation.profile import flight_path, read_profile
from lodestar.simulation.trajectory import Trajectory

pytest.importorskip("jsbsim", reason="the extra lodestar[jsbsim] is not installed")

CALM = """
start            lat 57.4 deg  lon 16.2 deg  altitude 2000 m  heading 350 deg  speed 180 m/s
straight         10 s
horizontal_turn  right 60 deg  bank 45 deg
climb            to 2150 m  angle 4 deg
speed_change     to 200 m/s  in 15 s
horizontal_turn  left 60 deg  bank 30 deg
straight         30 s
"""
HARD = """
start            lat 57.4 deg  lon 16.2 deg  altitude 5000 m  heading 350 deg  speed 210 m/s
straight         5 s
aileron_roll     right 1  rate 120 deg/s
aileron_roll     left 2  rate 120 deg/s  load 0.5 g
horizontal_turn  right 180 deg  load 5 g  roll_rate 120 deg/s
loop             load 5 g
speed_change     to 165 m/s  in 15 s
split_s          load 5.5 g
speed_change     to 210 m/s  in 10 s
horizontal_turn  left 90 deg  bank 70 deg  roll_rate 90 deg/s
straight         30 s
"""
START = "start lat 57.4 deg  lon 16.2 deg  altitude 1400 m  heading 350 deg  speed 170 m/s\n"
DIVES = {
    "straight dive": "vertical_turn to -40 deg\nstraight 15 s\nvertical_turn to 0 deg\n",
    "split-S": "straight 5 s\nsplit_s load 5 g\n",
    "spiral": "vertical_turn to -30 deg\nhorizontal_turn right 300 deg  bank 75 deg\n"
    "vertical_turn to 0 deg\n",
}


def scenario(folder: Path, profile: str, **changes: float) -> Scenario:
    """A flight of the whole profile, in wind and turbulence as the base scenario has them."""
    (folder / "route.profile").write_text(profile)
    path = flight_path(read_profile(folder / "route.profile"), 60)
    (folder / "flight.toml").write_text(
        f'route = "route.profile"\nduration_s = {path.duration}\n'
        "wind = { north_m_s = 6, east_m_s = 7 }\n"
    )
    return replace(load_scenario(folder / "flight.toml"), **changes)


def turbulent(folder: Path) -> Scenario:
    still = scenario(folder, CALM)
    return replace(still, turbulence=replace(still.turbulence, sigma_m_s=2.0))


def fly(folder: Path, profile: str) -> Trajectory:
    return fly_truth(scenario(folder, profile), seed=1, engine="jsbsim")


@pytest.fixture(scope="module")
def calm(tmp_path_factory) -> Trajectory:
    return fly(tmp_path_factory.mktemp("calm"), CALM)


@pytest.fixture(scope="module")
def hard(tmp_path_factory) -> Trajectory:
    return fly(tmp_path_factory.mktemp("hard"), HARD)


@pytest.fixture(scope="module")
def rough(tmp_path_factory) -> Trajectory:
    return fly_truth(turbulent(tmp_path_factory.mktemp("rough")), seed=1, engine="jsbsim")


@pytest.fixture(params=["calm", "hard", "rough"])
def flight(request) -> Trajectory:
    return request.getfixturevalue(request.param)


def reference(folder: Path, profile: str) -> list[autopilot.Aim]:
    (folder / "route.profile").write_text(profile)
    return autopilot.aims(flight_path(read_profile(folder / "route.profile"), 60))


def test_calm_flight_keeps_to_height_speed_and_direction_of_the_profile(calm, tmp_path):
    aims = reference(tmp_path, CALM)
    assert len(calm.h) == len(aims)
    assert np.abs(calm.h - [aim.h for aim in aims]).max() < 8
    assert np.abs(calm.true_airspeed - [aim.airspeed for aim in aims]).max() < 3
    v_air_N = calm.v_N - calm.wind_N
    direction = v_air_N / calm.true_airspeed[:, None]
    across = np.cross(direction, [aim.direction for aim in aims])
    assert np.degrees(np.linalg.norm(across, axis=1)).max() < 3
    assert np.degrees(np.abs(calm.beta)).max() < 0.5
    assert 43 < np.degrees(calm.roll).max() < 49
    assert np.degrees(np.abs(calm.roll[-300:])).max() < 0.5


def test_flight_begins_where_and_as_the_profile_says(calm, tmp_path):
    (tmp_path / "route.profile").write_text(CALM)
    start = flight_path(read_profile(tmp_path / "route.profile"), 60).start
    # The run-in may end some metres off: the aircraft gains its height and heading on the way.
    assert abs(calm.lat[0] - start.lat) * 6.4e6 < 30
    assert abs(calm.lon[0] - start.lon) * 3.4e6 < 30
    assert abs(calm.h[0] - start.altitude) < 1
    assert calm.true_airspeed[0] == pytest.approx(start.airspeed, abs=0.1)
    assert abs(np.degrees(wrap_pi(calm.heading[0] - start.heading))) < 0.1
    assert calm.time_us[0] == 0


def test_hard_flight_is_flown_and_ends_calm(hard):
    load, roll_rate = -hard.f_B[:, 2] / earth.STANDARD_GRAVITY, np.degrees(hard.omega_B[:, 0])
    assert 4.5 < load.max() < 8
    assert roll_rate.max() > 100
    assert roll_rate.min() < -100
    assert np.degrees(hard.pitch).max() > 85
    assert np.degrees(hard.pitch).min() < -60
    assert np.degrees(np.abs(hard.roll)).max() > 178
    assert np.degrees(np.abs(hard.alpha)).max() < 20
    assert np.degrees(np.abs(hard.beta)).max() < 5
    last = slice(-600, None)
    assert np.degrees(np.abs(hard.roll[last])).max() < 2
    assert np.abs(load[last] - 1).max() < 0.1


def test_rates_integrate_to_the_attitude(flight):
    frame_rate = earth.earth_rate_N(flight.lat) + earth.transport_rate_N(
        flight.lat, flight.h, flight.v_N
    )
    omega = flight.omega_B - np.einsum("nji,nj->ni", flight.C_NB, frame_rate)
    turned = np.diff(running_integral(omega, 1 / flight.rate_hz), axis=0)
    # The turn of the axis within a sample, to second order (Savage's coning correction).
    turned += np.cross(omega[:-1], omega[1:]) / (12 * flight.rate_hz**2)
    q = flight.q_NB[0]
    error = []
    for step, true in zip(exp_quaternion(turned), flight.q_NB[1:], strict=True):
        q = quaternion_product(q, step)
        error.append(2 * np.linalg.norm(quaternion_product(quaternion_conjugate(q), true)[1:]))
    # JSBSim integrates the attitude to second order at 60 Hz.
    assert np.degrees(max(error)) < 0.03
    assert np.degrees(error[-1]) < 0.005


def test_specific_force_integrates_to_velocity_and_velocity_to_position(flight):
    interval = 1 / flight.rate_hz
    lat, h, v_N = flight.lat, flight.h, flight.v_N
    acceleration = np.einsum("nij,nj->ni", flight.C_NB, flight.f_B) - np.cross(
        2 * earth.earth_rate_N(lat) + earth.transport_rate_N(lat, h, v_N), v_N
    )
    acceleration[:, 2] += earth.gravity(lat, h)
    # 100 s of its gravity, which stops at J2, are 0.01 m/s; the rest is JSBSim's integration.
    assert np.abs(v_N[0] + running_integral(acceleration, interval) - v_N).max() < 0.05
    north = running_integral(v_N[:, 0] / (earth.meridian_radius(lat) + h), interval)
    circle = (earth.transverse_radius(lat) + h) * np.cos(lat)
    east = running_integral(v_N[:, 1] / circle, interval)
    assert np.abs(lat - lat[0] - north).max() * 6.4e6 < 0.01
    assert np.abs(flight.lon - flight.lon[0] - east).max() * 3.4e6 < 0.01
    assert np.abs(h - h[0] + running_integral(v_N[:, 2], interval)).max() < 0.01


def test_steady_wind_is_the_wind_of_the_truth_and_felt_by_nobody(calm):
    np.testing.assert_allclose(calm.wind_N, np.tile([6.0, 7.0, 0.0], (len(calm.h), 1)), atol=1e-12)
    assert np.abs(np.linalg.norm(calm.v_N - calm.wind_N, axis=1) - calm.true_airspeed).max() < 1e-9
    assert np.std(calm.f_B[:540, 1]) < 1e-3  # the first straight


def test_turbulence_shakes_air_data_and_aircraft(rough, calm):
    gust_N = rough.wind_N - [6.0, 7.0, 0.0]
    # 2 m/s per axis, over a few correlation times of 3 s.
    assert np.all((np.std(gust_N, axis=0) > 1.2) & (np.std(gust_N, axis=0) < 2.8))
    straight = slice(0, 540)
    assert np.degrees(np.std(rough.alpha[straight])) > 0.2
    assert np.std(rough.f_B[straight, 2]) > 0.5
    assert np.degrees(np.std(rough.omega_B[straight, 1])) > 0.2
    assert np.std(calm.f_B[straight, 2]) < 0.05


def test_same_seed_same_bits_and_another_seed_another_flight(rough, tmp_path):
    air = turbulent(tmp_path)
    again, other = (fly_truth(air, seed, engine="jsbsim") for seed in (1, 2))
    assert again is not rough
    for name, values in vars(again).items():
        np.testing.assert_array_equal(values, getattr(rough, name))
    assert not np.array_equal(other.h, rough.h)


def test_calm_flight_is_flown_once_for_all_seeds(tmp_path):
    air = scenario(tmp_path, CALM)
    assert fly_truth(air, 1, engine="jsbsim") is fly_truth(air, 2, engine="jsbsim")


@pytest.mark.filterwarnings("ignore:h. outside")  # of the field model, by the route itself
@pytest.mark.parametrize("dive", DIVES)
def test_autopilot_does_not_dive_into_the_ground(dive, tmp_path):
    diving = scenario(tmp_path, START + DIVES[dive] + "straight 60 s")
    assert fly_truth(diving, 1).h.min() < 0
    flown = fly_truth(diving, 1, engine="jsbsim")
    assert flown.h.min() > 0.8 * autopilot.FLOOR
    assert flown.h[-1] > autopilot.FLOOR
    assert np.degrees(np.abs(flown.roll[-300:])).max() < 2
    assert -flown.f_B[:, 2].min() < 9 * earth.STANDARD_GRAVITY


def test_sensors_see_it_as_they_see_the_other_engine(tmp_path):
    air = scenario(tmp_path, CALM)
    flown, drawn = simulate(air, 3, engine="jsbsim"), simulate(air, 3)
    assert list(flown.channels) == list(drawn.channels)
    for channel, fields in drawn.channels.items():
        for name, values in fields.items():
            assert flown[channel][name].shape == values.shape, (channel, name)
            assert flown[channel][name].dtype == values.dtype, (channel, name)
    np.testing.assert_array_equal(flown["GPS"]["arrival_us"], drawn["GPS"]["arrival_us"])


def test_wind_that_jumps_is_flown(tmp_path):
    still = scenario(tmp_path, CALM)
    pulse = replace(still.wind, pulse_north_m_s=12.0, pulse_interval_s=30.0)
    flown = fly_truth(replace(still, wind=pulse), 1, engine="jsbsim")
    assert np.ptp(flown.wind_N[:, 0]) == pytest.approx(12.0, abs=1e-6)
    # It comes as forces: the ground velocity has no jump.
    assert np.abs(np.diff(flown.v_N, axis=0)).max() * 60 < 1.2 * earth.STANDARD_GRAVITY


def test_flight_that_is_not_for_a_fighter_is_refused_with_the_speeds(tmp_path):
    slow = scenario(tmp_path, CALM.replace("180 m/s", "60 m/s"))
    with pytest.raises(InputError, match=r"route\.profile: airspeed 60 to 200 m/s: .* 110 to 320"):
        fly_truth(slow, 1, engine="jsbsim")


def test_flight_into_the_ground_is_refused_with_time_and_height(tmp_path):
    low = scenario(tmp_path, CALM.replace("2000 m", "-300 m").replace("2150 m", "-150 m"))
    with pytest.raises(InputError, match=r"lost 0 s into the flight, at -3\d\d m"):
        fly_truth(low, 1, engine="jsbsim")


def test_unknown_engine_is_refused_by_name(tmp_path):
    with pytest.raises(InputError, match="engine warp: unknown; allowed are profile, jsbsim"):
        fly_truth(scenario(tmp_path, CALM), 1, engine="warp")


def test_missing_package_is_named_with_the_remedy(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "jsbsim", None)
    with pytest.raises(InputError, match=r"jsbsim is missing; pip install 'lodestar\[jsbsim\]'"):
        fly_truth(scenario(tmp_path, CALM), 1, engine="jsbsim")


def test_rate_that_is_too_slow_for_the_dynamics_is_refused(tmp_path):
    slow = replace(scenario(tmp_path, CALM), rate_hz=30)
    with pytest.raises(InputError, match=r"route\.profile: rate 30 Hz: JSBSim needs 60 Hz"):
        fly_truth(slow, 1, engine="jsbsim")


def test_faster_rate_is_the_same_flight(calm, tmp_path):
    fast = fly_truth(replace(scenario(tmp_path, CALM), rate_hz=120), 1, engine="jsbsim")
    assert fast.rate_hz == 120
    # The controls are moved, and the motion integrated, twice as often.
    assert np.abs(fast.h[::2] - calm.h).max() < 0.5
    assert np.degrees(np.abs(fast.roll[::2] - calm.roll)).max() < 1
