# SPDX-License-Identifier: Apache-2.0
"""The shipped map of a real flight, every sign checked against physics. The data is not shipped."""

from pathlib import Path

import numpy as np
import pytest

from lodestar import _core, rotation
from lodestar.recordings.importer import import_recording
from lodestar.studies.smdu_calibration import calibrate

ROOT = Path(__file__).parents[2]
DATA = ROOT.parent / "shared" / "data" / "umn_thor75" / "umn_thor75_50hz.npz"
MAP = ROOT / "config" / "maps" / "umn_thor75.toml"
YEAR = 2012.78
STEADY = (235.0, 540.0)  # s, on the square, before the approach

pytestmark = pytest.mark.skipif(not DATA.exists(), reason=f"the recorded flight is not at {DATA}")


@pytest.fixture(scope="module")
def flight():
    recording, report = import_recording(DATA, MAP)
    assert not report.dropped.keys() - {"ADC", "GPS"}
    return recording


@pytest.fixture(scope="module")
def steady(flight):
    """Reference attitude and the sensors on its rows, on the square."""
    t = flight["INS"]["time_us"] * 1e-6
    rows = (t > STEADY[0]) & (t < STEADY[1])
    ins = {name: column[rows] for name, column in flight["INS"].items()}
    C_NB = rotation.C_NB_from_euler(ins["roll"], ins["pitch"], ins["heading"])
    return t[rows], ins, C_NB, rows


def held(channel, name, t):
    return np.interp(t, channel["time_us"] * 1e-6, channel[name])


def test_the_gyros_turn_the_reference_attitude(flight, steady):
    t, _, C_NB, rows = steady
    omega_B = flight["EFCS.RATES"]["omega_B"][rows]
    # The mean rate over 0.2 s, from one attitude to the next but nine.
    turned = rotation.log_so3(np.swapaxes(C_NB[:-10], 1, 2) @ C_NB[10:]) / 0.2
    cumulated = np.cumsum(omega_B, axis=0)
    measured = (cumulated[10:] - cumulated[:-10]) / 10
    for axis in range(3):
        # Reference and gyros are one instrument: what is left is the reference's own corrections.
        assert np.corrcoef(turned[:, axis], measured[:, axis])[0, 1] > 0.98
        slope, bias = np.polyfit(turned[:, axis], measured[:, axis], 1)
        assert slope == pytest.approx(1.0, abs=0.03)
        assert abs(bias) < 0.03
    assert len(t) == len(omega_B)


def test_the_load_factor_is_reversed_specific_force(flight, steady):
    t, ins, C_NB, rows = steady
    f_B = -9.80665 * flight["EFCS.LOAD_FACTOR"]["n_B"][rows]
    g = _core.gravity(float(ins["lat"][0]), float(ins["h"][0]))
    acceleration = np.einsum("nij,nj->ni", C_NB, f_B) + np.array([0.0, 0.0, g])
    gained = np.cumsum(acceleration, axis=0) * 0.02
    gps = flight["GPS"]
    at = gps["time_us"] * 1e-6
    inside = (at > t[0] + 1) & (at < t[-1] - 1)
    # Over 5 s; 0.5 m/s^2 is 3 deg of tilt, which the reference claims to be better than.
    for axis in range(3):
        by_gps = gps["v_N"][inside][5:, axis] - gps["v_N"][inside][:-5, axis]
        integrated = np.interp(at[inside], t, gained[:, axis])
        difference = by_gps - (integrated[5:] - integrated[:-5])
        assert difference.std() / 5 < 0.5


def test_the_air_data_close_the_wind_triangle(flight, steady):
    t, ins, C_NB, _ = steady
    speed, alpha, beta = (
        held(flight["ADC"], name, t) for name in ("true_airspeed", "alpha", "beta")
    )
    v_air_B = speed[:, None] * np.column_stack(
        [np.cos(alpha) * np.cos(beta), np.sin(beta), np.sin(alpha) * np.cos(beta)]
    )
    wind_N = ins["v_N"] - np.einsum("nij,nj->ni", C_NB, v_air_B)
    # A steady westerly of 6.7 m/s; what is left is gusts, vane noise and the change of the wind.
    np.testing.assert_allclose(wind_N.mean(axis=0), [-0.7, 6.7, 0.0], atol=0.5)
    assert wind_N.std(axis=0).max() < 2.0
    # Angle of attack goes with load over dynamic pressure, sideslip against the side force.
    n_B = flight["EFCS.LOAD_FACTOR"]["n_B"][steady[3]]
    assert np.corrcoef(n_B[:, 2] / speed**2, alpha)[0, 1] > 0.8
    assert np.corrcoef(n_B[:, 1] / speed**2, beta)[0, 1] > 0.8


def test_roll_follows_from_rates_and_load_factor_in_the_turns(flight, steady):
    t, ins, _, rows = steady
    kernel = np.ones(50) / 50  # 1 s
    smooth = lambda x: np.convolve(x, kernel, "same")  # noqa: E731
    p, q, r = (smooth(x) for x in flight["EFCS.RATES"]["omega_B"][rows].T)
    n_z = smooth(flight["EFCS.LOAD_FACTOR"]["n_B"][rows][:, 2])
    speed, alpha = (smooth(held(flight["ADC"], name, t)) for name in ("true_airspeed", "alpha"))
    u, w = speed * np.cos(alpha), speed * np.sin(alpha)
    phi = np.arctan2(r * u - p * w, 9.80665 * n_z - q * u)
    banked = smooth(ins["roll"]) < np.deg2rad(-40)
    level = np.abs(smooth(ins["roll"])) < np.deg2rad(5)
    # The formula leaves out accelerations, which are large here: its sign and size are checked.
    assert np.median(phi[banked]) == pytest.approx(np.median(ins["roll"][banked]), abs=0.12)
    assert abs(np.median(phi[level])) < np.deg2rad(5)


def test_pressure_altitude_and_gps_height_rise_together(flight):
    gps = flight["GPS"]
    altitude = held(flight["ADC"], "baro_altitude", gps["time_us"] * 1e-6)
    flying = (gps["time_us"] > 211e6) & (gps["time_us"] < 575e6)
    slope, _ = np.polyfit(gps["h"][flying], altitude[flying], 1)
    # GPS height itself wanders by some metres over a climb of 65 m.
    assert slope == pytest.approx(1.0, abs=0.1)


def test_a_calibration_from_one_part_gives_heading_in_the_other(flight, steady):
    t, ins, _, rows = steady
    config = (ROOT / "config" / "thor75.toml").read_text()
    result = calibrate(flight, config, window_s=(230.0, 400.0))
    b_B = result.apply(flight["SMDU"]["b_B"][rows])
    levelled = rotation.C_NB_from_euler(ins["roll"], ins["pitch"], np.zeros(len(t)))
    level = np.einsum("nij,nj->ni", levelled, b_B)
    b_N = _core.geomagnetic_field(ins["lat"][0], ins["lon"][0], ins["h"][0], YEAR)
    heading = np.arctan2(b_N[1], b_N[0]) - np.arctan2(level[:, 1], level[:, 0])
    error = rotation.wrap_pi(heading - ins["heading"])[t > 400.0]
    # Single samples at 72 deg of dip, against a reference good to 4 deg.
    assert np.sqrt(np.mean(error**2)) < np.deg2rad(5.0)
    assert abs(error.mean()) < np.deg2rad(2.0)
