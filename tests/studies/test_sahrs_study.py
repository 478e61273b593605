# SPDX-License-Identifier: Apache-2.0
"""The study of SAHRS: what it scores, what it calls a failure, what it prints."""

import json
import sys
from dataclasses import replace

import numpy as np
import pytest

from lodestar.errors import InputError
from lodestar.evaluation.requirements import CALM, goals
from lodestar.harness.scenario import fly_truth, load_scenario, simulate
from lodestar.studies.campaign import Cell, Result
from lodestar.studies.ensemble import grouped
from lodestar.studies.findings import write
from lodestar.studies.sahrs import AXES, Errors, Variant, hard_windows, sahrs_study, score, series
from lodestar.studies.sahrs_findings import findings
from lodestar.studies.sahrs_plots import plots

RNG = np.random.default_rng(5)
N = 60_000


def errors(scale=1.0):
    """Of a flight of 1000 s whose errors are ``scale`` times what sigma says."""
    sigma = np.tile([0.2, 0.3, 1.0], (N, 1))
    rotation = scale * sigma * RNG.normal(size=(N, 3))
    time_us = np.arange(N) * 16_667
    return Errors(time_us, rotation.copy(), rotation, sigma, valid_share=1.0)


def figures(**changed):
    """What a good flight scores, with changes."""
    return dict(score(errors(), {"during": np.ones(N, bool), "after": np.ones(N, bool)})) | changed


def cells(case, estimator="sahrs", runs=3, **changed):
    flights = [figures() for _ in range(runs)]
    flights[-1] |= changed
    cell = Cell(case.rsplit("/", 1)[0], case, estimator)
    kept = dict(series(errors()))
    return grouped([Result(cell, seed, one, kept) for seed, one in enumerate(flights)])


def row(found, metric, case=None):
    case = case or found.rows[0]["case"]
    (one,) = [r for r in found.rows if (r["case"], r["metric"]) == (case, metric)]
    return one


# Scores


def test_errors_that_are_what_sigma_says_are_consistent():
    scored = dict(score(errors(), {}))
    # 60 000 samples: three sigma of the shares is 0.6 %, of the NEES 1 %.
    assert scored["nees_attitude"] == pytest.approx(1.0, abs=0.01)
    for axis in AXES:
        assert scored[f"coverage_1sigma_{axis}"] == pytest.approx(0.683, abs=0.006)
        assert scored[f"coverage_2sigma_{axis}"] == pytest.approx(0.954, abs=0.006)
    assert scored["roll_rmse_deg"] == pytest.approx(0.2, rel=0.01)
    assert scored["heading_rmse_deg"] == pytest.approx(1.0, rel=0.01)


def test_a_sigma_that_is_half_the_error_shows_in_nees_and_coverage():
    scored = dict(score(errors(2.0), {}))
    assert scored["nees_attitude"] == pytest.approx(4.0, abs=0.05)
    assert scored["coverage_1sigma_pitch"] == pytest.approx(0.383, abs=0.006)


def test_the_largest_error_counts_after_a_minute_and_in_its_window():
    one = errors(0.0)
    one.attitude[100, 0] = 7.0
    one.attitude[30_000, 0] = 3.0
    one.rotation[100] = [3.0, 4.0, 12.0]
    one.rotation[30_000] = [0.0, 3.0, 4.0]
    late = np.arange(N) > 40_000
    scored = dict(score(one, {"during": ~late, "after": late}))
    assert scored["roll_max_deg"] == 3.0
    assert scored["during_roll_max_deg"] == 7.0
    assert scored["after_roll_max_deg"] == 0.0
    assert scored["rotation_max_deg"] == 5.0


def test_samples_without_valid_output_do_not_count():
    one = errors()
    one.attitude[: N // 2] = np.nan
    one.rotation[: N // 2] = np.nan
    scored = dict(score(one, {}))
    assert scored["nees_attitude"] == pytest.approx(1.0, abs=0.02)
    assert scored["coverage_1sigma_roll"] == pytest.approx(0.683, abs=0.009)


def test_series_are_sparse_and_small():
    kept = dict(series(errors()))
    assert {values.dtype for values in kept.values()} == {np.dtype(np.float32)}
    np.testing.assert_allclose(np.diff(kept["time_s"]), 5.0, atol=0.02)
    assert set(kept) == {"time_s"} | {f"{k}_{a}_deg" for k in ("error", "sigma") for a in AXES}


@pytest.mark.parametrize("name", ["hard", "ordinary"])
def test_hard_manoeuvring_is_found_in_the_truth(name):
    scenario = load_scenario(name)
    truth = simulate(scenario, 1)["TRUTH"]
    during, after = hard_windows(name, truth, truth["time_us"]).values()
    if name == "ordinary":
        assert not during.any()
        assert not after.any()
        return
    # The first roll of the route begins at 528 s, the last turn ends at 1573 s.
    np.testing.assert_allclose(truth["time_us"][during][[0, -1]] * 1e-6, [529, 1572], atol=2)
    assert truth["time_us"][after][0] * 1e-6 == pytest.approx(1583, abs=2)
    assert np.degrees(np.abs(truth["roll"][~during])).max() < 50


# Variants


def test_forms_and_calibrations_of_a_flight_share_its_truth_and_its_other_sensors():
    scenario = replace(load_scenario("ordinary"), duration_s=30)
    study = replace(sahrs_study([], ["profile"], [], set()), scenarios=(scenario,))
    assert [cell.case.split("/", 2)[2] for cell in study.cells] == [
        "uncalibrated",
        "uncalibrated",
        "calibrated",
        "calibrated",
    ]
    assert {cell.estimator for cell in study.cells} == {"sahrs", "sahrs-paper"}
    results = study.fly(study.cells, 3)
    assert [result.cell for result in results] == list(study.cells)
    assert len({result.figures["roll_rmse_deg"] for result in results}) == 4
    assert fly_truth(scenario, 3) is fly_truth(scenario, 4)  # calm air: flown once for all seeds


def test_a_calibrated_estimator_knows_that_it_is():
    scenario = load_scenario("ordinary")
    for form, section in (("velocity", "strapdown"), ("paper", "sahrs")):
        told = Variant(scenario, "profile", form, True).config()
        assert told["sahrs"]["form"] == form
        assert told[section]["field_bias_sigma_nT"] == 75.0
        assert told[section]["field_matrix_sigma"] == 0.0005
        untold = Variant(scenario, "profile", form, False).config()
        assert untold["sahrs"] == {"form": form}
        assert "strapdown" not in untold


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((["ordinary", "ordinary"], [], [], set()), "scenario ordinary: given twice"),
        ((["nowhere"], [], [], set()), "scenario nowhere: unknown"),
        (([], ["warp"], [], set()), "engine warp: unknown; allowed are profile, jsbsim"),
        (([], [], ["thesis"], set()), "form thesis: unknown; allowed are velocity, paper"),
    ],
)
def test_a_variant_that_does_not_exist_is_refused(arguments, said):
    with pytest.raises(InputError, match=said):
        sahrs_study(*arguments)


# Findings


def test_rows_carry_mean_interval_reference_and_limit():
    found = findings("sahrs", cells("ordinary/profile/uncalibrated"))
    rms = row(found, "heading_rmse_deg")
    assert rms.keys() == {
        *("case", "estimator", "metric", "value", "low", "high", "reference", "limit")
    }
    assert rms["low"] < rms["value"] < rms["high"]
    assert (rms["reference"], rms["limit"]) == (5.0, 1.5)
    worst = row(found, "pitch_max_deg")
    assert (worst["reference"], worst["limit"]) == (5.0, 5.0)
    assert "low" not in worst
    nees = row(found, "nees_attitude")
    assert nees["low"] < 1 < nees["high"]
    assert found.failures == []


def test_one_flight_over_the_papers_limit_is_a_violation():
    found = findings("sahrs", cells("ordinary/jsbsim/calibrated", "sahrs-paper", roll_max_deg=10.5))
    assert row(found, "roll_max_deg")["value"] == 10.5
    assert row(found, "violations") == {
        "case": "ordinary/jsbsim/calibrated",
        "estimator": "sahrs-paper",
        "metric": "violations",
        "value": 1,
        "reference": 0,
        "limit": 0,
    }
    assert len(found.failures) == 2
    assert "roll_max_deg is 10.5, limit 10" in found.verdict


def test_the_paper_form_is_no_failure_where_its_paper_promises_nothing():
    for case in ("hard/profile/calibrated", "turbulence/profile/calibrated"):
        found = findings("sahrs", cells(case, "sahrs-paper", roll_max_deg=45.0))
        assert row(found, "violations")["value"] == 1
        assert found.failures == []
        assert findings("sahrs", cells(case, "sahrs", roll_max_deg=45.0)).failures


def test_after_hard_manoeuvring_the_calm_limits_hold_again():
    case = "hard/jsbsim/uncalibrated"
    found = findings("sahrs", cells(case, after_heading_max_deg=10.5))
    worst = row(found, "heading_max_deg", f"{case}/after")
    assert (worst["value"], worst["limit"]) == (10.5, CALM["heading_max_deg"])
    assert row(found, "violations")["value"] == 1
    assert "limit" not in row(found, "heading_max_deg", f"{case}/during")


def test_a_flight_without_valid_output_is_a_failure_and_not_left_out():
    found = findings("sahrs", cells("ordinary/profile/calibrated", roll_rmse_deg=float("nan")))
    assert row(found, "roll_rmse_deg")["value"] is None
    assert "roll_rmse_deg is nothing" in found.verdict
    json.loads(found.to_json())


def test_the_requirement_table_shows_the_worst_flight_of_each_class_and_form():
    ensembles = [
        *cells("ordinary/profile/calibrated", "sahrs-paper", runs=2, pitch_max_deg=4.5),
        *cells("ordinary/jsbsim/calibrated", "sahrs-paper", runs=3, pitch_max_deg=5.5),
        *cells("hard/jsbsim/calibrated", "sahrs-paper", runs=2, after_roll_rmse_deg=2.25),
    ]
    table = findings("sahrs", ensembles).tables[0]
    calm, hard, after = table.rows
    assert calm[:3] == ("calm", "paper", "2 / 2 / 5")
    assert "/ 5.50 /" in calm[5]
    assert calm[6] == "1 of 5"
    assert (hard[0], hard[2], hard[4], hard[6]) == ("hard", "–", "30 / 20 / –", "0 of 2")
    assert after[3].startswith("2.25 /")
    assert after[6] == "1 of 2"
    assert {(0, 5), (0, 6), (2, 3), (2, 6)} == table.bad


def test_goals_are_those_of_the_calibration_and_of_the_velocity_form_alone():
    assert goals("ordinary/profile/calibrated", "sahrs")["heading_rmse_deg"] == (1.0, 0.8)
    assert goals("ordinary/jsbsim/uncalibrated", "sahrs")["heading_rmse_deg"] == (1.5, 1.1)
    assert goals("hard/jsbsim/calibrated", "sahrs")["roll_max_deg"] == (4.0, 2.0)
    assert goals("hard/jsbsim/calibrated", "sahrs-paper") == {}
    assert goals("ordinary+air/profile/calibrated", "sahrs") == {}


def test_the_report_holds_tables_and_plots(tmp_path):
    ensembles = [
        *cells("hard/jsbsim/calibrated"),
        *cells("hard/jsbsim/calibrated", "sahrs-paper", roll_max_deg=45.0),
    ]
    drawn = plots(ensembles)
    report = write(findings("sahrs", ensembles), drawn, tmp_path).read_text()
    assert "45.00" in report
    assert report.count("<table") == 5
    assert report.count("<img") == len(drawn) == 4
    assert len(list((tmp_path / "plots").glob("*.png"))) == 4


# The command


def test_a_small_campaign_prints_one_object_and_is_redrawn_without_flying(lodestar, tmp_path):
    (tmp_path / "short.toml").write_text('base = "ordinary"\nduration_s = 70\n')
    which = ["--scenario", "short.toml", "--engine", "profile", "--form", "paper", "--calibrated"]
    command = ["monte-carlo", "sahrs", "--runs", 2, *which, "--out", "here"]
    status, out, err = lodestar(*command, "--json")
    assert status == 0, err
    found = json.loads(out)
    assert found.keys() == {"study", "runs", "rows"}
    assert (found["study"], found["runs"]) == ("sahrs", 2)
    assert {(r["case"], r["estimator"]) for r in found["rows"]} == {
        ("short/profile/calibrated", "sahrs-paper")
    }
    metrics = {r["metric"] for r in found["rows"]}
    assert {f"{axis}_{what}_deg" for axis in AXES for what in ("rmse", "max")} <= metrics
    assert {"coverage_1sigma_roll", "coverage_2sigma_heading", "nees_attitude"} <= metrics
    assert json.loads((tmp_path / "here/study.json").read_text()) == found

    flown = sorted((path, path.stat().st_mtime_ns) for path in (tmp_path / "here").glob("*/*.par*"))
    status, out, _ = lodestar(*command, "--redraw")
    assert status == 0
    assert "here/report.html" in out
    assert flown == sorted((path, path.stat().st_mtime_ns) for path, _ in flown)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--engine", "warp"], "engine warp: unknown"),
        (["--scenario", "nowhere"], "scenario nowhere: unknown"),
        (["--redraw"], "holds none of these flights"),
    ],
)
def test_bad_input_is_one_line_and_ends_with_2(lodestar, arguments, said):
    status, out, err = lodestar("monte-carlo", "sahrs", "--runs", "1", "--json", *arguments)
    assert status == 2
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert said in err
    assert out == ""


@pytest.mark.parametrize("study", ["sahrs", "sahrs-faults", "fusion-faults"])
def test_without_the_package_of_jsbsim_one_line_says_what_to_install(lodestar, monkeypatch, study):
    monkeypatch.setitem(sys.modules, "jsbsim", None)
    status, _, err = lodestar("monte-carlo", study, "--engine", "jsbsim")
    assert status == 2
    assert "pip install 'lodestar[jsbsim]'" in err
    assert err.startswith("error: ")
    assert err.count("\n") == 1


@pytest.mark.parametrize("study", ["sahrs", "sahrs-faults", "fusion-faults"])
def test_each_study_has_help_with_an_example(lodestar, study):
    status, out, _ = lodestar("monte-carlo", study, "--help")
    assert status == 0
    assert f"Example: lodestar monte-carlo {study}" in out
