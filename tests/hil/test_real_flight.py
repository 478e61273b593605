# SPDX-License-Identifier: Apache-2.0
"""A recorded flight of a small aircraft, against the attitude that its own filter had."""

from pathlib import Path

import numpy as np
import pytest

from lodestar import navigator
from lodestar.evaluation.score import loss_case, score
from lodestar.paths import config_path
from lodestar.recordings import Recording
from lodestar.recordings.importer import import_recording
from lodestar.studies.smdu_calibration import calibrate, store

DATA = Path(__file__).resolve().parents[3] / "shared/data/umn_thor75/umn_thor75_50hz.npz"
HALVES = ((230.0, 400.0), (405.0, 575.0))
WHOLE = (230.0, 575.0)
ANGLES = ("roll", "pitch", "heading")
MIDDLE_S = 400.0


@pytest.fixture(scope="module")
def flight() -> Recording:
    if not DATA.exists():
        pytest.skip(f"the recorded flight is not at {DATA}")
    return import_recording(DATA, config_path("maps/umn_thor75.toml"))[0]


def between(recording: Recording, start_s: float, end_s: float) -> Recording:
    cut = Recording()
    for name, columns in recording.channels.items():
        rows = (columns["time_us"] >= start_s * 1e6) & (columns["time_us"] <= end_s * 1e6)
        cut.channels[name] = {field: values[rows] for field, values in columns.items()}
    return cut


@pytest.mark.parametrize(("calibrated_on", "scored_on"), [HALVES, HALVES[::-1]])
def test_attitude_holds_on_the_half_that_the_detector_was_not_calibrated_on(
    flight, calibrated_on, scored_on, tmp_path
):
    config = config_path("thor75.toml").read_text()
    calibration = calibrate(flight, config, window_s=calibrated_on)
    assert calibration.verdict == "good"
    store(calibration, tmp_path / "smdu.cal")
    answered = navigator.run(flight, config, (tmp_path / "smdu.cal").read_bytes())
    result = score(between(answered, *scored_on), case="thor75")
    limits = {"sahrs": (1.3, 1.3, 4.0), "integrated": (1.2, 1.2, 3.5)}
    for estimator, most in limits.items():
        rms = [result.value(estimator, f"{angle}_rmse_deg") for angle in ANGLES]
        print(estimator, "roll, pitch, heading", [f"{one:.2f}" for one in rms])
        assert (np.array(rms) <= most).all()
    assert result.value("integrated", "position_rmse_m") <= 15.0


@pytest.fixture(scope="module")
def calibrated(flight, tmp_path_factory):
    """Configuration and calibration of the whole flight."""
    config = config_path("thor75.toml").read_text()
    path = tmp_path_factory.mktemp("calibration") / "smdu.cal"
    store(calibrate(flight, config, window_s=WHOLE), path)
    return config, path.read_bytes()


def test_wind_is_that_of_a_constant_wind_fitted_to_the_whole_flight(flight, calibrated):
    nav = between(navigator.run(flight, *calibrated), *WHOLE)["NAV"]
    assert nav["valid"].all()
    mean = nav["wind_N"].mean(axis=0)
    print(f"mean wind {mean[0]:.1f}, {mean[1]:.1f} m/s")
    assert abs(mean[0] - -0.7) <= 1.5
    assert abs(mean[1] - 6.2) <= 1.5


@pytest.mark.parametrize(("length_s", "most_m"), [(60, 120), (120, 360)])
def test_position_holds_through_a_loss_of_gps(flight, calibrated, length_s, most_m):
    start, end = MIDDLE_S - length_s / 2, MIDDLE_S + length_s / 2
    cut = Recording()
    cut.channels = dict(flight.channels)
    time_s = flight["GPS"]["time_us"] * 1e-6
    kept = (time_s < start) | (time_s > end)
    cut.channels["GPS"] = {name: values[kept] for name, values in flight["GPS"].items()}
    result = score(between(navigator.run(cut, *calibrated), *WHOLE), case="thor75")
    (loss,) = result.comparison.gps_losses
    error = result.value("integrated", "position_final_m", loss_case("thor75", loss))
    nav = result.comparison.nav
    last = np.searchsorted(nav.time_us, end * 1e6) - 1
    stated = np.hypot(*nav.position.sigma[last])
    print(f"after {length_s} s {error:.0f} m off, {stated:.0f} m stated")
    assert error <= most_m
    assert error <= 2 * stated
