# SPDX-License-Identifier: Apache-2.0
import json

import numpy as np
import pytest

from lodestar import rotation
from lodestar.errors import InputError
from lodestar.evaluation.score import loss_case, score

DEG = np.pi / 180
WIND = (6.0, 7.0, 0.0)


@pytest.fixture(scope="module")
def flight(synthetic):
    """180 s at 10 Hz: SAHRS and NAV with errors of known size, GPS lost from 60 to 100 s."""
    time_us = np.arange(0, 180_000_001, 100_000)
    t = time_us * 1e-6
    truth = synthetic.truth(time_us, WIND)
    # Whole periods in 60 to 180 s and in 0 to 180 s, so that means are exact.
    wave = np.sin(2 * np.pi * t / 30)
    return synthetic.recording(
        {
            "TRUTH": truth,
            "ADC": synthetic.air_data(truth),
            "GPS": synthetic.gps(truth, 10, [(59.5, 100.0)]),
            "SAHRS": synthetic.sahrs(truth, 1.0 * DEG, -0.5 * DEG, 3.0 * DEG * wave, 2.0 * DEG),
            "NAV": synthetic.nav(
                truth,
                3.0 + 0.0 * t,
                -4.0 + 0.0 * t,
                (0.25 * DEG, 0.5 * DEG, 1.0 * DEG * wave),
                (0.5, -1.5, 0.0),
                (3.5, 0.6 * DEG, 1.0),
            ),
        }
    )


@pytest.fixture(scope="module")
def flown(flight):
    return score(flight, case="ordinary", seed=1, realtime_factor=50.0)


def test_recovers_the_errors_that_were_put_in(flown):
    samples = 1801
    wave_rms = np.sqrt(0.5 * 1800 / samples)
    expected = {
        ("sahrs", "roll_rmse_deg"): 1.0,
        ("sahrs", "roll_max_deg"): 1.0,
        ("sahrs", "pitch_rmse_deg"): 0.5,
        ("sahrs", "pitch_max_deg"): 0.5,
        ("sahrs", "heading_rmse_deg"): 3.0 * wave_rms,
        ("integrated", "roll_rmse_deg"): 0.25,
        ("integrated", "pitch_rmse_deg"): 0.5,
        ("integrated", "heading_rmse_deg"): 1.0 * wave_rms,
        ("integrated", "position_rmse_m"): 5.0,
        ("integrated", "position_max_m"): 5.0,
        ("integrated", "position_final_m"): 5.0,
        ("integrated", "wind_north_rmse_m_s"): 0.5,
        ("integrated", "wind_east_rmse_m_s"): 1.5,
        ("dead-reckoning", "wind_north_rmse_m_s"): 6.0,
        ("dead-reckoning", "wind_east_rmse_m_s"): 7.0,
    }
    for (estimator, metric), value in expected.items():
        assert flown.value(estimator, metric) == pytest.approx(value, rel=1e-7), metric
    # The sampled wave does not meet its crest exactly.
    assert flown.value("sahrs", "heading_max_deg") == pytest.approx(3.0, abs=0.02)


def test_coverage_is_the_share_within_sigma(flown):
    assert flown.value("integrated", "coverage_1sigma_position_north") == 1.0
    assert flown.value("integrated", "coverage_1sigma_position_east") == 0.0
    assert flown.value("integrated", "coverage_2sigma_position_east") == 1.0
    assert flown.value("integrated", "coverage_1sigma_wind_north") == 1.0
    assert flown.value("integrated", "coverage_1sigma_wind_east") == 0.0
    assert flown.value("integrated", "coverage_1sigma_roll") == 1.0
    # |sin| < 0.6 for asin(0.6) / 90 deg of the time.
    share = np.arcsin(0.6) / (np.pi / 2)
    assert flown.value("integrated", "coverage_1sigma_heading") == pytest.approx(share, abs=0.01)
    assert flown.value("integrated", "coverage_2sigma_heading") == 1.0


def test_rotation_about_the_body_axes_is_covered_by_the_published_sigma(synthetic):
    time_us = np.arange(0, 10_000_001, 100_000)
    truth = synthetic.truth(time_us)
    sahrs = synthetic.sahrs(truth, 0.0, 0.0, 0.0, 1.0 * DEG)
    turn = np.broadcast_to(np.array([0.5, 1.5, 2.5]) * DEG, (len(time_us), 3))
    sahrs["q_NB"] = rotation.quaternion_product(sahrs["q_NB"], rotation.exp_quaternion(turn))
    flown = score(synthetic.recording({"TRUTH": truth, "SAHRS": sahrs}), case="x")
    got = [
        flown.value("sahrs", f"coverage_{k}sigma_{axis}_axis")
        for axis in ("roll", "pitch", "yaw")
        for k in (1, 2)
    ]
    assert got == [1.0, 1.0, 0.0, 1.0, 0.0, 0.0]


def test_dead_reckoning_drifts_with_the_wind_it_does_not_know(synthetic):
    time_us = np.arange(0, 60_000_001, 50_000)
    results = []
    for wind in ((0.0, 0.0, 0.0), WIND):
        truth = synthetic.truth(time_us, wind)
        perfect = synthetic.sahrs(truth, 0.0, 0.0, 0.0, DEG)
        flight = synthetic.recording(
            {"TRUTH": truth, "SAHRS": perfect, "ADC": synthetic.air_data(truth)}
        )
        results.append(score(flight, case="x").value("dead-reckoning", "position_final_m"))
    assert results[0] < 1e-6
    # Its meridians converge at another latitude than the true ones: 0.1 m in 553.
    assert results[1] == pytest.approx(60 * np.hypot(6.0, 7.0), rel=5e-4)


def test_rows_of_a_gps_loss_give_the_error_at_its_end(flown):
    (gap,) = flown.comparison.gps_losses
    assert gap.duration_s == 40.0
    case = loss_case("ordinary", gap)
    assert case == "ordinary/gps-loss-40s-at-60s"
    assert flown.value("integrated", "position_final_m", case) == pytest.approx(5.0, rel=1e-7)
    rows = [row for row in flown.rows if row["case"] == case]
    assert [row["estimator"] for row in rows] == ["integrated", "dead-reckoning"]
    # It grows by wind times 40 s less the last frame, and a little by the heading error.
    assert rows[1]["value"] == pytest.approx(39.9 * np.hypot(6.0, 7.0), rel=0.2)


def test_limits_and_published_figures_stand_in_their_rows_alone(flown):
    by_name = {(row["estimator"], row["metric"]): row for row in flown.rows}
    assert by_name["sahrs", "heading_rmse_deg"]["limit"] == 5.0
    assert by_name["sahrs", "heading_rmse_deg"]["reference"] == 3.46
    assert by_name["integrated", "heading_rmse_deg"]["reference"] == 0.72
    assert by_name["integrated", "wind_east_rmse_m_s"]["reference"] == 1.33
    assert "limit" not in by_name["integrated", "heading_rmse_deg"]
    assert "reference" not in by_name["integrated", "position_rmse_m"]
    assert flown.passed
    assert flown.failures == []


def test_json_is_plain_and_complete(flown):
    told = json.loads(json.dumps(flown.to_json(), allow_nan=False))
    assert told.keys() == {"scenario", "seed", "duration_s", "realtime_factor", "rows"}
    assert told["scenario"] == "ordinary"
    assert told["duration_s"] == pytest.approx(180.0)
    required = {"case", "estimator", "metric", "value"}
    assert all(required <= row.keys() <= required | {"reference", "limit"} for row in told["rows"])


def test_a_flight_beyond_a_limit_fails_and_says_which(synthetic):
    time_us = np.arange(0, 120_000_001, 100_000)
    truth = synthetic.truth(time_us)
    late = np.where(time_us > 90e6, 12.0 * DEG, 0.0)
    flight = synthetic.recording(
        {"TRUTH": truth, "SAHRS": synthetic.sahrs(truth, late, 0.0, 0.0, DEG)}
    )
    calm = score(flight, case="ordinary")
    assert not calm.passed
    assert [text.split(" is ")[0] for text in calm.failures] == [
        "sahrs roll_rmse_deg",
        "sahrs roll_max_deg",
    ]
    assert score(flight, case="hard").passed
    assert score(flight, case="hard+air/calibrated").passed


def test_maxima_start_after_settling_but_rmse_does_not(synthetic):
    time_us = np.arange(0, 120_000_001, 100_000)
    truth = synthetic.truth(time_us)
    early = np.where(time_us < 6e6, 20.0 * DEG, 0.0)
    flown = score(
        synthetic.recording(
            {"TRUTH": truth, "SAHRS": synthetic.sahrs(truth, early, 0.0, 0.0, DEG)}
        ),
        case="ordinary",
    )
    assert flown.value("sahrs", "roll_max_deg") == pytest.approx(0.0, abs=1e-9)
    assert flown.value("sahrs", "roll_rmse_deg") == pytest.approx(20 * np.sqrt(60 / 1201))


def test_only_valid_output_counts(synthetic):
    time_us = np.arange(0, 120_000_001, 100_000)
    truth = synthetic.truth(time_us)
    wrong = time_us < 30e6
    sahrs = synthetic.sahrs(truth, np.where(wrong, 1.0, 0.0), 0.0, 0.0, DEG)
    sahrs["valid"] = ~wrong
    flown = score(synthetic.recording({"TRUTH": truth, "SAHRS": sahrs}), case="x")
    assert flown.value("sahrs", "roll_rmse_deg") == pytest.approx(0.0, abs=1e-9)
    assert flown.comparison.sahrs.available == pytest.approx(901 / 1201)


def test_output_that_is_not_finite_fails(synthetic):
    time_us = np.arange(0, 120_000_001, 100_000)
    truth = synthetic.truth(time_us)
    sahrs = synthetic.sahrs(truth, 0.0, 0.0, 0.0, DEG)
    sahrs["roll"][500] = np.nan
    flown = score(synthetic.recording({"TRUTH": truth, "SAHRS": sahrs}), case="x")
    assert flown.failures == ["SAHRS: 1 valid messages are not finite"]


def test_near_the_vertical_only_pitch_counts(synthetic):
    time_us = np.arange(0, 120_000_001, 100_000)
    truth = synthetic.truth(time_us)
    steep = (time_us > 70e6) & (time_us < 80e6)
    truth["pitch"] = np.where(steep, 85 * DEG, truth["pitch"])
    sahrs = synthetic.sahrs(truth, np.where(steep, 1.0, 0.0), 0.01 * DEG, steep * 1.0, DEG)
    flown = score(synthetic.recording({"TRUTH": truth, "SAHRS": sahrs}), case="x")
    assert flown.value("sahrs", "roll_max_deg") == pytest.approx(0.0, abs=1e-9)
    assert flown.value("sahrs", "heading_max_deg") == pytest.approx(0.0, abs=1e-9)
    assert flown.value("sahrs", "pitch_max_deg") == pytest.approx(0.01, rel=1e-6)


def test_heading_errors_wrap(synthetic):
    time_us = np.arange(0, 120_000_001, 100_000)
    truth = synthetic.truth(time_us)
    truth["heading"] = np.full(len(time_us), 0.01 * DEG)
    sahrs = synthetic.sahrs(truth, 0.0, 0.0, -0.02 * DEG, DEG)
    flown = score(synthetic.recording({"TRUTH": truth, "SAHRS": sahrs}), case="x")
    assert flown.value("sahrs", "heading_max_deg") == pytest.approx(0.02, rel=1e-6)


def ins_of(truth, valid):
    fields = ("time_us", "roll", "pitch", "heading", "lat", "lon", "h", "v_N")
    return {**{name: truth[name] for name in fields}, "valid": valid}


def test_the_ins_is_the_reference_where_there_is_no_truth_and_while_it_is_valid(synthetic):
    time_us = np.arange(0, 120_000_001, 100_000)
    truth = synthetic.truth(time_us)
    valid = (time_us > 70e6) & (time_us < 110e6)
    sahrs = synthetic.sahrs(truth, np.where(valid, 9.0 * DEG, 1.0), 0.0, 0.0, DEG)
    nav = synthetic.nav(truth, 30.0, 40.0, (0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (1.0, 1.0, 1.0))
    flight = synthetic.recording({"INS": ins_of(truth, valid), "SAHRS": sahrs, "NAV": nav})
    flown = score(flight, case="flight")
    assert flown.comparison.reference == "INS"
    assert flown.value("sahrs", "roll_rmse_deg") == pytest.approx(9.0, rel=1e-7)
    assert flown.value("integrated", "position_rmse_m") == pytest.approx(50.0, rel=1e-6)
    assert flown.value("integrated", "wind_north_rmse_m_s") is None
    assert flown.passed
    assert not any("limit" in row for row in flown.rows)


def test_reference_between_its_samples_is_interpolated_on_the_sphere(synthetic):
    time_us = np.arange(0, 120_000_001, 20_000)
    truth = synthetic.truth(time_us)
    sahrs = synthetic.sahrs(truth, 0.0, 0.0, 0.0, DEG)
    coarse = {name: column[::5] for name, column in truth.items()}
    flown = score(synthetic.recording({"TRUTH": coarse, "SAHRS": sahrs}), case="x")
    # A chord of 0.1 s leaves its arc by an eighth of the step squared times the acceleration.
    acceleration = np.gradient(np.gradient(truth["roll"], 0.02), 0.02)
    for angle in ("roll", "pitch", "heading"):
        error = np.deg2rad(flown.value("sahrs", f"{angle}_max_deg"))
        assert error < 1.01 * 0.1**2 / 8 * np.abs(acceleration).max()


def test_a_gap_of_the_reference_is_not_bridged(synthetic):
    time_us = np.arange(0, 120_000_001, 100_000)
    truth = synthetic.truth(time_us)
    sahrs = synthetic.sahrs(truth, np.where(time_us == 90_000_000, 1.0, 0.0), 0.0, 0.0, DEG)
    keep = np.abs(time_us - 90_000_000) > 400_000
    holed = {name: column[keep] for name, column in truth.items()}
    flown = score(synthetic.recording({"TRUTH": holed, "SAHRS": sahrs}), case="x")
    assert flown.value("sahrs", "roll_max_deg") == pytest.approx(0.0, abs=1e-9)


def test_without_valid_sahrs_the_flight_fails(synthetic):
    time_us = np.arange(0, 10_000_001, 100_000)
    truth = synthetic.truth(time_us)
    nav = synthetic.nav(truth, 3.0, 4.0, (0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (1.0, 1.0, 1.0))
    flown = score(synthetic.recording({"TRUTH": truth, "NAV": nav}), case="x")
    assert flown.failures == ["SAHRS gave no valid attitude while TRUTH was there"]
    assert flown.value("integrated", "position_rmse_m") == pytest.approx(5.0, rel=1e-6)


def test_without_reference_there_is_no_score(synthetic):
    time_us = np.arange(0, 10_000_001, 100_000)
    truth = synthetic.truth(time_us)
    recording = synthetic.recording({"SAHRS": synthetic.sahrs(truth, 0.0, 0.0, 0.0, DEG)})
    with pytest.raises(InputError, match="neither TRUTH nor a valid INS"):
        score(recording, case="x")
    recording.put("INS", ins_of(truth, np.zeros(len(time_us), bool)))
    with pytest.raises(InputError, match="neither TRUTH nor a valid INS"):
        score(recording, case="x")
