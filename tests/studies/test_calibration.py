# SPDX-License-Identifier: Apache-2.0
import re

import numpy as np
import pytest

from lodestar import _core, rotation
from lodestar.errors import InputError
from lodestar.recordings import Recording
from lodestar.studies import calibration as cal

YEAR = 2026.5


def flight(bank_deg=45.0, duration_s=400):
    """Turns to both sides with a raw field of known errors; INS at 30 Hz, SMDU at 10 Hz."""
    ins_us = np.arange(0, duration_s * 1_000_000, 33_333)
    t = ins_us * 1e-6
    ins = {
        "time_us": ins_us,
        "roll": np.deg2rad(bank_deg) * np.sin(2 * np.pi * t / 80),
        "pitch": np.deg2rad(5) * np.sin(2 * np.pi * t / 37) * (bank_deg > 0),
        "heading": rotation.wrap_2pi(2 * np.pi * t / 67),
        "lat": np.full_like(t, np.deg2rad(57.5)),
        "lon": np.full_like(t, np.deg2rad(16.0)),
        "h": np.full_like(t, 3000.0),
        "v_N": np.zeros((len(t), 3)),
        "valid": np.ones(len(t), bool),
    }
    recording = Recording()
    recording.put("INS", ins)
    # On every third row of INS, so that no interpolation error enters the exact tests.
    C_NB = rotation.C_NB_from_euler(ins["roll"], ins["pitch"], ins["heading"])[::3]
    b_N = _core.geomagnetic_field(ins["lat"][0], ins["lon"][0], ins["h"][0], YEAR)
    b_cal = np.einsum("nji,j->ni", C_NB, b_N)
    b_raw = np.linalg.solve(cal.matrix_of(TRUE_X), (b_cal - TRUE_X[:3]).T).T
    time_us = ins_us[::3]
    recording.put("SMDU", {"time_us": time_us, "b_B": b_raw, "valid": np.ones(len(time_us), bool)})
    return recording


TRUE_X = np.array([500, -300, 200, 3e-3, -2e-3, 4e-3, 1e-3, -3e-3, 2e-3, 5e-3, -1e-3, -4e-3])


def test_recovers_the_twelve_parameters_exactly_without_noise():
    result = cal.calibrate(flight(), YEAR)
    np.testing.assert_allclose(result.bias_nT, TRUE_X[:3], atol=1e-6)
    np.testing.assert_allclose(result.x[3:], TRUE_X[3:], atol=1e-10)
    assert result.residual_rms.max() < 1e-6


def test_its_sigma_covers_the_error_of_a_noisy_detector():
    recording = flight()
    smdu = recording["SMDU"]
    clean, generator = smdu["b_B"].copy(), np.random.default_rng(3)
    inside = []
    for _ in range(30):
        smdu["b_B"][:] = clean + 80.0 * generator.standard_normal(clean.shape)
        result = cal.calibrate(recording, YEAR)
        inside.append(np.abs(result.x - TRUE_X) < 2 * result.sigma)
    # 360 parameters, 95 % of them inside with a spread of 1 %; more is allowed because those of
    # one flight are not independent.
    assert 0.90 < np.mean(inside) < 0.99


def test_sigma_grows_when_errors_last():
    white, lasting = flight(), flight()
    generator = np.random.default_rng(5)
    count = len(white["SMDU"]["b_B"])
    white["SMDU"]["b_B"] += generator.normal(0, 80, (count, 3))
    steps = generator.normal(0, 80, (100, 3))
    lasting["SMDU"]["b_B"] += np.repeat(steps, count // 100 + 1, axis=0)[:count]
    assert np.all(cal.calibrate(lasting, YEAR).sigma > 3 * cal.calibrate(white, YEAR).sigma)


def test_uses_only_the_window_and_the_valid_reference():
    recording = flight()
    outside = recording["SMDU"]["time_us"] > 300e6
    recording["SMDU"]["b_B"][outside] += 5000.0
    recording["INS"]["valid"][:300] = False
    recording["INS"]["roll"][:300] = 2.0
    result = cal.calibrate(recording, YEAR, (0.0, 300.0))
    np.testing.assert_allclose(result.bias_nT, TRUE_X[:3], atol=1e-6)
    assert result.samples == np.sum(~outside) - 100


def test_does_not_interpolate_over_a_gap_of_the_reference():
    recording = flight()
    recording["INS"]["valid"][3000:4000] = False
    full, holed = cal.calibrate(flight(), YEAR), cal.calibrate(recording, YEAR)
    # 1000 rows of INS are 333 or 334 samples of SMDU.
    assert full.samples - holed.samples in (333, 334)
    np.testing.assert_allclose(holed.bias_nT, TRUE_X[:3], atol=1e-6)


def test_level_turns_alone_are_refused():
    with pytest.raises(InputError, match="too little of the sphere was seen"):
        cal.calibrate(flight(bank_deg=0.0), YEAR)


def test_missing_channels_and_short_windows_are_named():
    with pytest.raises(InputError, match="the recording has no INS"):
        cal.calibrate(flight().subset(("SMDU",)), YEAR)
    with pytest.raises(InputError, match="101 SMDU samples with a valid INS between 0 and 10 s"):
        cal.calibrate(flight(), YEAR, (0.0, 10.0))
    recording = flight()
    recording["INS"]["valid"][:] = False
    with pytest.raises(InputError, match="0 SMDU samples"):
        cal.calibrate(recording, YEAR)


def test_file_keeps_every_bit_and_leaves_no_temporary(tmp_path):
    result = cal.calibrate(flight(), YEAR)
    path = tmp_path / "smdu.toml"
    cal.write_calibration(result, path)
    bias, matrix = cal.read_calibration(path)
    np.testing.assert_array_equal(bias, result.bias_nT)
    np.testing.assert_array_equal(matrix, result.matrix)
    assert [one.name for one in tmp_path.iterdir()] == ["smdu.toml"]


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "has no table [smdu_calibration]"),
        ("[smdu_calibration]\nbias_nT = [1, 2]\n", "smdu_calibration.bias_nT must be (3,) finite"),
        ("[smdu_calibration]\nbias_nT = [1, 2, 'x']\n", "smdu_calibration.bias_nT must be (3,)"),
        ("[smdu_calibration]\nbias_nT = [1, 2, 3]\n", "smdu_calibration.matrix must be (3, 3)"),
        ("torn", "Expected '='"),
        (None, "No such file"),
    ],
)
def test_a_foreign_calibration_file_is_refused(tmp_path, text, complaint):
    path = tmp_path / "smdu.toml"
    if text is not None:
        path.write_text(text)
    with pytest.raises(InputError, match=re.escape(f"{path}: {complaint}")):
        cal.read_calibration(path)
