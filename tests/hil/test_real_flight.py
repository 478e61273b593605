# SPDX-License-Identifier: Apache-2.0
"""A recorded flight of a small aircraft, against the attitude that its own filter had."""

from pathlib import Path

import pytest

from lodestar import navigator
from lodestar.evaluation.score import score
from lodestar.paths import config_path
from lodestar.recordings import Recording
from lodestar.recordings.importer import import_recording
from lodestar.studies.smdu_calibration import calibrate, store

DATA = Path(__file__).resolve().parents[3] / "shared/data/umn_thor75/umn_thor75_50hz.npz"
HALVES = ((230.0, 400.0), (405.0, 575.0))


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
    for estimator in ("sahrs", "cascade"):
        assert result.value(estimator, "roll_rmse_deg") <= 1.3
        assert result.value(estimator, "pitch_rmse_deg") <= 1.3
        assert result.value(estimator, "heading_rmse_deg") <= 4.0
    assert result.value("cascade", "position_rmse_m") <= 15.0
