# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lodestar import _core, navigator, rotation
from lodestar.errors import InputError
from lodestar.harness.scenario import Scenario, load_scenario, simulate
from lodestar.recordings import Recording
from lodestar.studies import calibrated_flights, smdu_calibration

CONFIG = '[airframe]\nid = "39-101"\n[earth]\nepoch_year = 2026.5\n'


def scenario(**changes: object) -> Scenario:
    return replace(load_scenario("ordinary"), airframe_seed=5, **changes)


@pytest.fixture(scope="module")
def flight() -> Recording:
    return simulate(scenario(duration_s=1500), 11)


@pytest.fixture(scope="module")
def result(flight: Recording) -> smdu_calibration.Calibration:
    return smdu_calibration.calibrate(flight, CONFIG)


def test_a_flight_of_turns_calibrates_the_detector_within_its_sigma(result):
    assert result.verdict == "good"
    error = result.x - calibrated_flights.true_calibration(scenario())
    # Chi-square of 12 degrees: 99.9 % of the draws lie below 32.9.
    assert error @ np.linalg.solve(result.P, error) < 32.9
    assert result.sigma[:3].max() < 100
    assert result.sigma[3:].max() < 0.002


def test_it_is_what_the_flight_computer_publishes_at_the_end_of_the_flight(flight, result):
    published = navigator.run(flight, CONFIG)["SMDU.CALIBRATION"]
    assert np.all(np.diff(published["time_us"]) == 1_000_000)
    assert published["state"][0] == 0
    assert published["state"][-1] == 2
    np.testing.assert_array_equal(published["x"][-1], result.x)
    np.testing.assert_allclose(published["sigma"][-1], result.sigma)


def test_a_short_and_a_straight_flight_are_refused_by_name(flight):
    assert smdu_calibration.calibrate(flight, CONFIG, window_s=(0, 300)).verdict == "too short"
    straight = CONFIG + "[smdu_calibration_filter]\nmin_duration_s = 10\n"
    result = smdu_calibration.calibrate(flight, straight, window_s=(0, 100))
    assert result.verdict == "not observable"


def test_an_ins_that_fails_in_flight_is_named(flight):
    failed = flight.subset(("SMDU", "INS"))
    failed.channels["INS"] = dict(failed["INS"], valid=failed["INS"]["time_us"] < 1400e6)
    assert smdu_calibration.calibrate(failed, CONFIG).verdict == "INS failed"


def test_missing_channels_and_a_bad_configuration_are_named(flight):
    with pytest.raises(InputError, match="has no INS"):
        smdu_calibration.calibrate(flight.subset(("SMDU",)), CONFIG)
    with pytest.raises(InputError, match=r"smdu_calibration_filter\.interval_s"):
        smdu_calibration.calibrate(flight, "[smdu_calibration_filter]\ninterval_s = -1\n")


def test_what_is_stored_comes_back_and_is_used(flight, result, tmp_path: Path):
    path = tmp_path / "smdu.cal"
    smdu_calibration.store(result, path)
    loaded = _core.load_calibration(str(path), "39-101")
    assert loaded is not None
    np.testing.assert_array_equal(loaded["x"], result.x)
    np.testing.assert_array_equal(loaded["P"], result.P)
    assert (loaded["airframe"], loaded["source"], loaded["note"]) == ("39-101", "flight", "")
    answered = navigator.run(flight, CONFIG, path.read_bytes())
    assert answered["HEALTH"]["calibration_id"][-1] != 0
    with pytest.raises(InputError, match="calibration: of another airframe"):
        navigator.run(flight, CONFIG.replace("101", "102"), path.read_bytes())
    with pytest.raises(_core.StorageError, match="of another airframe than '39-102'"):
        _core.load_calibration(str(path), "39-102")
    assert _core.load_calibration(str(tmp_path / "none.cal"), "39-101") is None


def test_only_a_good_one_is_stored(result, tmp_path: Path):
    with pytest.raises(ValueError, match="too short"):
        smdu_calibration.store(replace(result, verdict="too short"), tmp_path / "smdu.cal")
    with pytest.raises(InputError, match="cannot write"):
        smdu_calibration.store(result, tmp_path / "none" / "smdu.cal")


def swing(headings_deg: float) -> Recording:
    """A level aircraft that turns over so many degrees in six minutes; bias 800 nT, scale 2 %."""
    time_us = np.arange(0, 360_000_000, 250_000)
    t = time_us * 1e-6
    generator = np.random.default_rng(3)
    zeros = np.zeros_like(t)
    heading = rotation.wrap_2pi(0.3 + np.deg2rad(headings_deg) * t / 360)
    lat, lon = np.deg2rad(58.0), np.deg2rad(16.0)
    b_N = _core.geomagnetic_field(lat, lon, 50.0, 2026.5)
    b_B = np.einsum("nji,j->ni", rotation.C_NB_from_euler(zeros, zeros, heading), b_N)
    noise = generator.normal(0, 80, b_B.shape)
    recording = Recording()
    recording.put(
        "INS",
        {
            "time_us": time_us,
            "roll": zeros,
            "pitch": zeros,
            "heading": heading,
            "lat": zeros + lat,
            "lon": zeros + lon,
            "h": zeros + 50.0,
            "v_N": np.zeros((len(t), 3)),
            "valid": np.ones(len(t), bool),
        },
    )
    b_raw = (b_B - np.array([800.0, -500.0, 300.0])) / 1.02 + noise
    recording.put("SMDU", {"time_us": time_us, "b_B": b_raw, "valid": np.ones(len(t), bool)})
    return recording


def test_a_swing_on_the_ground_gives_bias_and_one_scale(tmp_path: Path):
    result = smdu_calibration.calibrate(swing(360.0), CONFIG, ground=True)
    assert result.verdict == "good"
    error = result.x - np.array([800.0, -500.0, 300.0, *[0.02] * 3, *[0.0] * 6])
    assert np.all(np.abs(error) < 3 * result.sigma)
    assert np.abs(error[:2]).max() < 60
    smdu_calibration.store(result, tmp_path / "smdu.cal")
    loaded = _core.load_calibration(str(tmp_path / "smdu.cal"), "39-101")
    assert loaded is not None
    assert loaded["source"] == "ground swing"


def test_a_swing_over_too_few_headings_is_refused_by_name():
    assert smdu_calibration.calibrate(swing(150.0), CONFIG, ground=True).verdict == (
        "too few headings"
    )
