# SPDX-License-Identifier: Apache-2.0
import tomllib
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lodestar import _core
from lodestar.errors import InputError
from lodestar.harness.faults import Fault
from lodestar.harness.scenario import (
    Scenario,
    drawn_turn,
    estimator_config,
    fly_truth,
    load_scenario,
    malformed_datagrams,
    scenario_names,
    simulate,
)
from lodestar.navigator import run

THESIS = (
    "ordinary",
    "wind-pulse-6",
    "wind-strong",
    "wind-pulse-12",
    "gps-loss-long",
    "gps-loss-short",
)
LOSSES = ("gps-loss-steady", "gps-loss-10min", "gps-loss-60min")
MINIMAL = 'route = "ordinary"\nduration_s = 10\n'


def short(name: str, duration_s: float = 20.0) -> Scenario:
    return replace(load_scenario(name), duration_s=duration_s)


def write(tmp_path, text: str):
    path = tmp_path / "mine.toml"
    path.write_text(text)
    return path


def test_all_scenarios_are_shipped_and_say_what_they_are():
    others = {"vanern", "hard", "turbulence", "uav-gps-loss"}
    assert set(scenario_names()) == {*THESIS, *LOSSES, *others}
    for name in scenario_names():
        scenario = load_scenario(name)
        assert scenario.name == name
        assert scenario.description


def test_thesis_scenarios_fly_one_route_for_3000_s_in_their_winds():
    winds = {}
    for name in THESIS:
        scenario = load_scenario(name)
        assert (scenario.duration_s, scenario.route) == (3000, load_scenario("ordinary").route)
        assert (scenario.rate_hz, scenario.suite, scenario.calibrated) == (60, "gripen", False)
        assert (scenario.gps.errors, scenario.gps.velocity) == ("markov", False)
        w = scenario.wind
        assert w.pulse_north_m_s == w.pulse_east_m_s
        winds[name] = (w.north_m_s, w.east_m_s, w.pulse_north_m_s)
    assert winds["ordinary"] == (6, 7, 0)
    assert winds["wind-pulse-6"] == (0, 0, 6)
    assert winds["wind-strong"] == (9, 10, 0)
    for name in ("wind-pulse-12", "gps-loss-long", "gps-loss-short"):
        assert winds[name] == (3, 3, 12)


def test_gps_outages_are_those_of_the_thesis():
    assert load_scenario("gps-loss-long").gps_outages() == ((1120, 120), (2000, 300))
    short_losses = load_scenario("gps-loss-short").gps_outages()
    assert short_losses == tuple((start, 10) for start in range(200, 3000, 200))
    vanern = load_scenario("vanern").gps_outages()
    assert vanern == (*((start, 20) for start in range(500, 1500, 200)), (5200, 300))


def test_gps_is_lost_for_2_to_60_min_in_constant_wind():
    lost = {name: load_scenario(name).gps_outages() for name in LOSSES}
    assert [[length for _, length in one] for one in lost.values()] == [[120, 300], [600], [3600]]
    for name in LOSSES:
        scenario = load_scenario(name)
        start, length = lost[name][-1]
        assert start + length < scenario.duration_s
        assert (scenario.wind.pulse_north_m_s, scenario.wind.wander_sigma_m_s) == (0, 0)


def test_living_air_adds_to_any_scenario_and_keeps_the_stronger_turbulence():
    plain, living = load_scenario("wind-strong"), load_scenario("wind-strong+air")
    assert living.name == "wind-strong+air"
    assert (living.wind.wander_sigma_m_s, living.wind.wander_tau_s) == (1.0, 120.0)
    assert living.turbulence.sigma_m_s == 0.7
    assert living.wind.north_m_s == plain.wind.north_m_s
    assert load_scenario("turbulence+air").turbulence.sigma_m_s == 2.0


def test_same_seed_same_bits_and_another_seed_another_flight():
    scenario = short("wind-strong+air")
    assert simulate(scenario, 5) == simulate(scenario, 5)
    assert simulate(scenario, 5) != simulate(scenario, 6)


def test_simulate_gives_the_sensors_of_the_suite_and_the_truth():
    recording = simulate(short("ordinary"), 1)
    channels = {"EFCS.RATES", "EFCS.LOAD_FACTOR", "SMDU", "ADC", "GPS", "INS", "TRUTH"}
    assert set(recording.channels) == channels
    assert recording.duration_s() == 20.0
    assert len(recording["TRUTH"]["time_us"]) == len(recording["EFCS.RATES"]["time_us"]) == 1201
    north, east, down = recording["TRUTH"]["wind_N"].T
    assert (north.mean(), east.mean(), down.mean()) == pytest.approx((6.0, 7.0, 0.0))
    assert "INS" not in simulate(short("uav-gps-loss", 5.0), 1)


def test_magnetic_truth_is_not_the_estimators_model():
    truth = simulate(short("ordinary", 1.0), 1)["TRUTH"]
    where = (truth["lat"][0], truth["lon"][0], truth["h"][0], 2026.5)
    np.testing.assert_array_equal(truth["b_N"][0], _core.geomagnetic_field(*where, model="wmm2025"))
    honest_error = truth["b_N"][0] - _core.geomagnetic_field(*where, model="igrf14")
    assert 2.0 < np.linalg.norm(honest_error) < 100.0


def test_truth_is_steady_wind_and_not_the_seeds_business():
    one, two = fly_truth(short("ordinary"), 1), fly_truth(short("ordinary"), 2)
    np.testing.assert_array_equal(one.v_N, two.v_N)
    one, two = fly_truth(short("ordinary+air"), 1), fly_truth(short("ordinary+air"), 2)
    assert np.any(one.v_N != two.v_N)


def test_drawn_course_turns_the_route_about_its_start_and_leaves_the_wind():
    filed = fly_truth(short("ordinary"), 3)
    drawn = fly_truth(replace(short("ordinary"), course="drawn"), 3)
    turn = drawn_turn(3)
    assert (drawn.lat[0], drawn.lon[0]) == (filed.lat[0], filed.lon[0])
    through_air = [one.v_N - one.wind_N for one in (filed, drawn)]
    tracks = [np.arctan2(v_N[:, 1], v_N[:, 0]) for v_N in through_air]
    off = np.exp(1j * (tracks[1] - tracks[0] - turn))
    np.testing.assert_allclose(np.angle(off), 0.0, atol=1e-9)
    np.testing.assert_allclose(drawn.wind_N, filed.wind_N)


@given(first=st.integers(0, 10**6))
def test_eight_seeds_in_a_row_leave_no_direction_out(first):
    turns = np.sort([drawn_turn(seed) for seed in range(first, first + 8)])
    gaps = np.diff(np.append(turns, turns[0] + 2 * np.pi))
    assert gaps.max() < np.radians(90)


def test_shorter_scenario_is_the_beginning_of_the_longer():
    a, b = simulate(short("ordinary", 10.0), 3), simulate(short("ordinary", 20.0), 3)
    # The spline's end conditions differ: its last samples are not compared.
    np.testing.assert_allclose(
        a["TRUTH"]["omega_B"][:-30], b["TRUTH"]["omega_B"][:571], rtol=0, atol=1e-12
    )


def test_file_of_a_person_with_base_and_own_route(tmp_path):
    (tmp_path / "home.profile").write_text(
        "start lat 57 deg lon 16 deg altitude 1 km heading 0 deg speed 100 m/s\nstraight 30 s\n"
    )
    path = write(
        tmp_path,
        'base = "gps-loss-long"\nroute = "home.profile"\nduration_s = 30\n[wind]\neast_m_s = -4\n',
    )
    scenario = load_scenario(path)
    assert scenario.name == "mine"
    assert scenario.wind.east_m_s == -4
    assert scenario.wind.pulse_east_m_s == 12
    assert len(scenario.gps.outages) == 2
    assert len(simulate(scenario, 1)["GPS"]["time_us"]) == 31


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("rout = 1", "mine.toml:1: rout: unknown key; allowed are route, duration_s"),
        ("duration_s = 10", "mine.toml: route missing"),
        (MINIMAL + "rate_hz = 65", "mine.toml:3: rate_hz: 65: must be a multiple of 10"),
        (MINIMAL + "rate_hz = 5", "mine.toml:3: rate_hz: 5 is out of range; allowed is 30 to 1000"),
        (MINIMAL + '[gps]\nerrors = "red"', "mine.toml:4: gps.errors: 'red'; allowed are markov"),
        (MINIMAL + "[wind]\nnorth = 3", "mine.toml:4: wind.north: unknown key"),
        (MINIMAL + 'calibrated = "yes"', "mine.toml:3: calibrated: 'yes' is not true or false"),
        ('route = "moon"\nduration_s = 9', "route 'moon': no such file"),
        ('base = "moon"', "mine.toml:1: base: 'moon' is no shipped scenario; they are gps-loss"),
        (
            MINIMAL + '[[faults]]\nkind = "bias"\nchannel = "ADC"\nstart_s = 1\nvalue = 1.0',
            "mine.toml:3: faults: bias needs a field: one of true_airspeed, alpha, beta",
        ),
        (
            MINIMAL + '[[faults]]\nkind = "spoof"\nchannel = "ADC"\nstart_s = 1\nvalue = 1.0',
            "mine.toml:3: faults: spoof is for channel GPS only",
        ),
        (MINIMAL + "[[faults]]\nkind = 3", "mine.toml:4: faults.kind: 3 is not a text"),
        (MINIMAL + '[[faults]]\nkind = "nan"', "mine.toml:3: faults: channel, start_s missing"),
    ],
)
def test_bad_file_is_refused_with_file_line_key_and_what_is_allowed(tmp_path, text, message):
    with pytest.raises(InputError) as error:
        load_scenario(write(tmp_path, text))
    assert message in str(error.value)


def test_unknown_name_lists_what_there_is():
    with pytest.raises(InputError, match=r"scenario nonsense: unknown; shipped are gps-loss-10min"):
        load_scenario("nonsense")
    with pytest.raises(InputError, match=r"nonsense\.toml: cannot be read"):
        load_scenario("nonsense.toml")


def test_route_that_is_too_short_is_refused():
    with pytest.raises(InputError, match=r"ordinary\.profile: lasts 3\d{3}\.\d s, scenario"):
        simulate(short("ordinary", 9000.0), 1)


def test_faults_of_the_file_are_flown(tmp_path):
    text = (
        MINIMAL
        + """
        [[faults]]
        kind = "dropout"
        channel = "SMDU"
        start_s = 5
        duration_s = 2
        [[faults]]
        kind = "malformed"
        channel = "ADC"
        start_s = 8
        interval_s = 0.5
    """
    )
    scenario = load_scenario(write(tmp_path, text))
    recording = simulate(scenario, 1)
    assert len(recording["SMDU"]["time_us"]) == 301 - 60
    assert [p.arrival_us for p in malformed_datagrams(scenario, 1)] == [
        8_000_000,
        8_500_000,
        9_000_000,
        9_500_000,
    ]


def test_fault_on_a_sensor_that_is_not_on_board_is_refused():
    scenario = replace(short("uav-gps-loss", 2.0), faults=(Fault("nan", "INS", 0.0),))
    with pytest.raises(InputError, match=r"no channel INS in this flight; it has EFCS\.RATES"):
        simulate(scenario, 1)


def test_flight_computer_starts_from_the_last_ins_attitude_or_cold():
    scenario = replace(short("ordinary", 2.0), estimator={"sahrs": {"form": "paper"}})
    recording = simulate(scenario, 1)
    config = tomllib.loads(estimator_config(scenario, recording))
    assert config["earth"]["epoch_year"] == 2026.5
    assert config["sahrs"] == {"form": "paper"}
    initial = config["initial"]
    assert initial["heading_sigma_deg"] == 0.1
    assert initial["heading_deg"] == pytest.approx(np.degrees(recording["INS"]["heading"][0]))
    assert initial["lat_deg"] == pytest.approx(np.degrees(recording["INS"]["lat"][0]))
    cold = replace(scenario, initial_heading="cold")
    assert "initial" not in tomllib.loads(estimator_config(cold, recording))


@pytest.mark.parametrize("name", ["ordinary", "hard", "uav-gps-loss"])
def test_flight_computer_takes_the_configuration_of_a_scenario(name):
    scenario = short(name, 15.0)
    recording = simulate(scenario, 1)
    outputs = run(recording, estimator_config(scenario, recording))
    assert len(outputs["SAHRS"]["time_us"]) == len(recording["EFCS.RATES"]["time_us"])
    assert outputs["SAHRS"]["valid"][-1]


def test_overrides_go_before_the_scenarios_own_configuration():
    scenario = replace(short("ordinary", 2.0), estimator={"sahrs": {"form": "paper", "x": 1.5}})
    text = estimator_config(scenario, simulate(scenario, 1), {"sahrs": {"form": "velocity"}})
    assert tomllib.loads(text)["sahrs"] == {"form": "velocity", "x": 1.5}
