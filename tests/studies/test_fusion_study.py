# SPDX-License-Identifier: Apache-2.0
"""The study of navigation: what it flies, what it scores, what it calls a failure."""

import json
from dataclasses import replace

import numpy as np
import pytest

from lodestar.errors import InputError
from lodestar.evaluation import fusion_requirements
from lodestar.evaluation.comparison import Estimates, Series
from lodestar.evaluation.dead_reckoning import air_velocity_N
from lodestar.evaluation.fusion_requirements import EKF2, SCENARIOS_WITH_GOALS, goals
from lodestar.evaluation.metrics import Gap
from lodestar.harness.faults import Fault, inject
from lodestar.harness.scenario import fly_truth, load_scenario, measure
from lodestar.navigator import run
from lodestar.studies import fusion
from lodestar.studies.fusion import SCENARIOS, FusionStudy, fusion_study
from lodestar.studies.fusion_score import Flight, figures, series, unseen_steps
from lodestar.studies.fusion_setups import ABLATIONS, BEFORE, LIMIT, Setup, shipped, told, variation

RNG = np.random.default_rng(11)
N = 15_000
TIME_S = 0.2 * np.arange(N)
NOWHERE = np.full((N, 2), np.nan)


def normal(sigma, scale=1.0):
    """Series of errors that are ``scale`` times what sigma says."""
    stated = np.tile(sigma, (N, 1)).astype(float)
    return scale * stated * RNG.normal(size=stated.shape), stated


def flight(scale=1.0, **changed):
    """A flight of 3000 s with errors that are ``scale`` times what sigma says."""
    angles, winds, places = (
        normal(np.radians([0.1, 0.1, 0.5]), scale),
        normal([1.0, 1.5], scale),
        normal([5.0, 6.0], scale),
    )
    nav = Estimates(
        time_us=(TIME_S * 1e6).astype(np.int64),
        available=1.0,
        attitude=Series(("roll", "pitch", "heading"), *angles),
        position=Series(("position_north", "position_east"), *places),
        velocity=Series(("velocity_north", "velocity_east"), *normal([0.5, 0.7])),
        wind=Series(("wind_north", "wind_east"), *winds),
    )
    before = replace(nav, velocity=Series(("velocity_north", "velocity_east"), 10 * nav.wind.error))
    kept = {
        "time_s": TIME_S,
        "nav": nav,
        "before": before,
        "heading_before": np.radians(np.full(N, 2.0)),
        "wind": np.zeros((N, 2)),
        "protection": np.full(N, np.nan),
        "gps": np.array([[3.0, 4.0], [-3.0, -4.0]]),
        "losses": (),
        "frozen": NOWHERE.copy(),
        "unseen": np.zeros(N, bool),
    }
    return Flight(**(kept | changed))


def scored(one):
    return dict(figures(one))


# Scores


def test_errors_that_are_what_sigma_says_are_consistent():
    found = scored(flight())
    # 15 000 samples: three sigma of a share is 1.1 %, of a mean square 3.5 %.
    assert found["nees_heading"] == pytest.approx(1.0, abs=0.035)
    assert found["nees_wind"] == pytest.approx(1.0, abs=0.025)
    for name in ("heading", "wind_north", "position_east"):
        assert found[f"coverage_1sigma_{name}"] == pytest.approx(0.683, abs=0.012)
        assert found[f"coverage_2sigma_{name}"] == pytest.approx(0.954, abs=0.006)
    assert found["heading_rmse_deg"] == pytest.approx(0.5, rel=0.02)
    assert found["wind_east_rmse_m_s"] == pytest.approx(1.5, rel=0.02)
    assert found["before_heading_rmse_deg"] == pytest.approx(2.0)
    assert found["sigma_heading_rms_deg"] == pytest.approx(0.5)
    assert (found["gps_north_rmse_m"], found["gps_east_rmse_m"]) == (3.0, 4.0)


def test_a_sigma_that_is_half_the_error_shows_in_nees_and_coverage():
    found = scored(flight(2.0))
    assert found["nees_heading"] == pytest.approx(4.0, rel=0.035)
    assert found["coverage_1sigma_heading"] == pytest.approx(0.383, abs=0.012)


def test_the_thesiss_wind_is_the_error_of_ground_velocity_and_not_that_of_wind():
    one = flight()
    found = scored(one)
    expected = np.sqrt(np.mean(one.nav.velocity.error[:, 0] ** 2))
    assert found["velocity_north_rmse_m_s"] == pytest.approx(expected)
    assert found["velocity_north_rmse_m_s"] == pytest.approx(0.5, rel=0.03)
    assert found["before_velocity_east_rmse_m_s"] == pytest.approx(15.0, rel=0.03)


def test_a_step_that_cannot_have_been_seen_does_not_count_in_nees_but_does_in_rms():
    unseen = (TIME_S >= 300) & (TIME_S < 315)
    one = flight(unseen=unseen)
    one.nav.wind.error[unseen] = 12.0
    found = scored(one)
    assert found["nees_wind"] == pytest.approx(1.0, abs=0.025)
    assert found["wind_north_rmse_m_s"] > 1.2
    assert scored(replace(one, unseen=np.zeros(N, bool)))["nees_wind"] > 1.4


def test_steps_of_the_wind_are_unseen_until_5_s_after_them_and_10_s_after_gps_is_back():
    scenario = load_scenario("wind-pulse-12")
    gap = Gap(595_000_000, 700_000_000)  # around the step at 600 s, none other
    rows = unseen_steps(TIME_S, scenario, (gap,))
    for inside, outside in ((300.2, 299.8), (314.8, 315.2), (600.2, 599.8), (709.8, 710.2)):
        assert rows[round(inside / 0.2)]
        assert not rows[round(outside / 0.2)]
    assert np.sum(rows) * 0.2 == pytest.approx(8 * 15 + 110, abs=2)  # nine steps in 3000 s
    assert not unseen_steps(TIME_S, load_scenario("gps-loss-steady"), (gap,)).any()


def test_the_end_of_a_loss_is_its_last_sample_and_losses_of_one_length_are_averaged():
    losses = tuple(Gap(start * 1_000_000, (start + 120) * 1_000_000) for start in (100, 1000))
    one = flight(losses=losses)
    one.nav.position.error[round(219.8 / 0.2)] = [30.0, 40.0]
    one.nav.position.error[round(1119.8 / 0.2)] = [60.0, 80.0]
    one.frozen[round(219.8 / 0.2)] = one.frozen[round(1119.8 / 0.2)] = [0.0, 7.0]
    found = scored(one)
    assert found["end_120s_m"] == 75.0
    assert found["frozen_end_120s_m"] == 7.0
    assert found["sigma_end_120s_m"] == pytest.approx(np.hypot(5, 6))
    assert np.isnan(found["end_300s_m"])
    # With GPS: neither the losses nor the 10 s after them.
    aided = (TIME_S < 100) | ((TIME_S >= 230) & (TIME_S < 1000)) | (TIME_S >= 1130)
    expected = np.sqrt(np.mean(one.nav.position.error[aided, 1] ** 2))
    assert found["aided_position_east_rmse_m"] == pytest.approx(expected)


def test_time_beyond_the_protection_level_is_counted():
    level = np.full(N, 100.0)
    level[:5000] = np.nan
    one = flight(protection=level)
    one.nav.position.error[:] = 0.0
    one.nav.position.error[4000:4010] = 1e4  # none was stated
    one.nav.position.error[6000:6018] = [90.0, 120.0]
    found = scored(one)
    assert found["protected_h"] == pytest.approx(2000 / 3600)
    assert found["beyond_protection_h"] == pytest.approx(3.6 / 3600)
    assert found["largest_of_protection"] == 1.5
    assert scored(flight())["protected_h"] == 0.0


def test_the_peers_figures_are_those_before_and_in_the_first_loss():
    one = flight(losses=(Gap(300_000_000, 900_000_000),))
    one.nav.attitude.error[:, 0] = np.radians(np.where(TIME_S < 100, 9.0, 0.5))
    one.nav.attitude.error[TIME_S >= 300, 0] = np.radians(0.25)
    one.nav.wind.error[(TIME_S >= 100) & (TIME_S < 300)] = [0.3, -0.4]
    for since in (60, 300, 540):
        one.nav.position.error[round((300 + since) / 0.2)] = [since, 0.0]
    found = scored(one)
    assert found["aided_roll_rmse_deg"] == pytest.approx(0.5)
    assert found["lost_roll_rmse_deg"] == pytest.approx(0.25)
    assert found["aided_wind_rmse_m_s"] == pytest.approx(0.5)
    assert [found[f"lost_{since}s_m"] for since in (60, 300, 540)] == [60, 300, 540]
    assert set(EKF2) <= set(found)


def test_every_flight_has_the_same_names_and_sparse_series():
    lost = flight(losses=(Gap(1_400_000_000, 2_000_000_000),))
    assert scored(lost).keys() == scored(flight()).keys()
    kept = dict(series(lost))
    assert {values.dtype for values in kept.values()} == {np.dtype(np.float32)}
    assert {len(values) for values in kept.values()} == {600}


# Setups and variants


def test_options_become_tables_with_their_types():
    options = "sahrs.form=paper,fusion.cascade.wind_tau_s=400,smdu_calibration_filter.enabled=0"
    assert Setup("x", "cascade", options).tables() == {
        "fusion": {"filter": "cascade", "cascade": {"wind_tau_s": 400}},
        "sahrs": {"form": "paper"},
        "smdu_calibration_filter": {"enabled": 0},
    }


def test_an_ablation_is_told_in_words_and_an_option_as_it_was_given():
    name, options, meaning = ABLATIONS[0]
    assert told(variation(name, options).name) == meaning
    assert told(variation("cascade", "a.b=1").name) == "a.b=1"
    assert len({variation(*one[:2]) for one in ABLATIONS}) == len(ABLATIONS)


def cells_of(name, **changed):
    study = FusionStudy((load_scenario(name),), **changed)
    return {(c.case.rsplit("/", 1)[1], c.estimator): c.most_runs for c in study.cells}


def test_a_scenario_is_flown_from_both_starts_where_there_are_goals():
    found = cells_of("wind-strong")
    assert {one for one, most in found.items() if most is None} == {
        (start, name) for start in ("init", "cold") for name in ("cascade", "integrated")
    }
    assert {("init", setup.name) for setup in BEFORE} <= found.keys()
    assert {("init", LIMIT.name), ("cold", LIMIT.name)} <= found.keys()
    assert not any(":" in name for _, name in found)
    assert cells_of("gps-loss-10min+air").keys() == {("init", "cascade"), ("init", "integrated")}
    assert ("cold", "cascade") not in cells_of("ordinary+air")
    assert ("cold", "integrated") in cells_of("ordinary+air")
    assert cells_of("hard", starts=("cold",)).keys() == {
        ("cold", "cascade"),
        ("cold", "integrated"),
    }


def test_without_an_ins_there_is_only_a_cold_start():
    assert cells_of("uav-gps-loss").keys() == {("cold", "cascade"), ("cold", "integrated")}


def test_results_depend_on_what_the_named_setups_are_but_not_on_which_are_flown(monkeypatch):
    study = FusionStudy((load_scenario("ordinary"),))
    made_from = study.inputs("ordinary/profile")
    assert replace(study, filters=("cascade",)).inputs("ordinary/profile") == made_from
    assert replace(study, options=("sahrs.form=paper",)).inputs("ordinary/profile") == made_from
    monkeypatch.setattr(fusion, "_NAMED", ())
    assert study.inputs("ordinary/profile") != made_from


def test_each_seed_flies_on_a_course_of_its_own_unless_routes_are_to_be_as_filed():
    arguments = (["ordinary"], [], ["integrated"], ["init"], [])
    assert [one.course for one in fusion_study(*arguments).scenarios] == ["drawn"]
    filed = fusion_study(*arguments, course="filed")
    assert [one.course for one in filed.scenarios] == ["filed"]
    assert filed.inputs("ordinary/profile") != fusion_study(*arguments).inputs("ordinary/profile")
    with pytest.raises(InputError, match="course north: unknown; allowed are filed, drawn"):
        fusion_study(*arguments, course="north")


def test_ablations_are_flown_with_fewer_seeds_in_two_scenarios():
    found = cells_of("wind-pulse-12", filters=("cascade",))
    others = {name: most for (_, name), most in found.items() if ":" in name}
    assert others == {variation(*one[:2]).name: 10 for one in ABLATIONS if one[0] == "cascade"}


def test_an_option_is_flown_with_the_filters_that_have_it():
    own = cells_of("hard", options=("fusion.cascade.step_s=0.2",))
    assert [name for _, name in own if ":" in name] == ["cascade:fusion.cascade.step_s=0.2"]
    shared = cells_of("hard", options=("strapdown.flow_bias_sigma_deg=0",))
    # From one start alone: hard has no goal for the other.
    assert sum(":" in name for _, name in shared) == 2


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((["ordinary", "ordinary"], [], [], [], []), "scenario ordinary: given twice"),
        (([], ["warp"], [], [], []), "engine warp: unknown"),
        (([], [], ["ekf"], [], []), "filter ekf: unknown; allowed are cascade, integrated"),
        (([], [], [], ["warm"], []), "start warm: unknown; allowed are init, cold"),
        ((["hard"], [], ["cascade"], [], ["nonsense"]), "option nonsense: must be key=value"),
        ((["hard"], [], ["cascade"], [], ["sahrs.tau=3"]), "sahrs.tau: unknown key"),
        (
            (["hard"], [], ["integrated"], [], ["fusion.cascade.step_s=0.2"]),
            "option fusion.cascade.step_s=0.2: is of none of integrated",
        ),
    ],
)
def test_a_variant_that_does_not_exist_is_refused(arguments, said):
    with pytest.raises(InputError, match=said):
        fusion_study(*arguments)


def test_every_goal_has_a_flight():
    assert set(SCENARIOS_WITH_GOALS) <= set(SCENARIOS)
    for name in SCENARIOS_WITH_GOALS:
        assert goals(name, "init", "integrated")
    assert goals("turbulence", "cold", "integrated") == {"heading_rmse_deg": (0.60, 0.46)}
    assert goals("wind-pulse-6+air", "init", "integrated") == {"heading_rmse_deg": (0.35, 0.25)}
    assert goals("wind-pulse-6+air", "init", "cascade") == {}
    assert goals("gps-loss-long", "init", "integrated") == {
        "heading_rmse_deg": (0.27, 0.14),
        "wind_north_rmse_m_s": (3.7, 3.5),
        "wind_east_rmse_m_s": (3.7, 3.5),
    }


# Flights


@pytest.fixture(scope="module")
def short():
    """A flight of 150 s that is without GPS for 20 s: the scenario and what was answered."""
    scenario = load_scenario("ordinary")
    outage = type(load_scenario("gps-loss-10min").gps.outages[0])(100.0, 20.0)
    scenario = replace(
        scenario, duration_s=150, name="short", gps=replace(scenario.gps, outages=(outage,))
    )
    sensed = measure(scenario, fly_truth(scenario, 3), 3)
    study = FusionStudy((scenario,), filters=("cascade",), starts=("init",))
    (variant,) = study.variants.values()
    return study, sensed, run(sensed, variant.config(sensed))


def test_a_flight_gives_the_same_figures_however_it_is_flown(short):
    study, _, answered = short
    (result,) = study.fly(study.cells, 3)
    assert result.cell.case == "short/profile/init"
    expected = scored(Flight.of(answered, study.scenarios[0]))
    np.testing.assert_equal(result.figures, expected)
    assert 0 < result.figures["end_20s_m"] < 100
    assert result.figures["heading_rmse_deg"] < 2


def test_sahrs_alone_drifts_by_its_velocity_and_the_wind_at_the_loss(short):
    study, _, answered = short
    one = Flight.of(answered, study.scenarios[0])
    inside = np.flatnonzero(np.isfinite(one.frozen[:, 0]))
    assert one.time_s[inside[[0, -1]]] == pytest.approx([100.0, 119.8], abs=0.2)
    sahrs, truth, nav = (answered[name] for name in ("SAHRS", "TRUTH", "NAV"))
    rows = (sahrs["time_us"] >= 100_000_000) & (sahrs["time_us"] < 120_000_000)
    wind = nav["wind_N"][np.searchsorted(nav["time_us"], 100_000_000)]
    v_N = air_velocity_N({k: v[rows] for k, v in sahrs.items()}, answered["ADC"]) + wind
    true = truth["v_N"][np.isin(truth["time_us"], sahrs["time_us"][rows])]
    drift = np.trapezoid((v_N - true)[:, :2], sahrs["time_us"][rows] * 1e-6, axis=0)
    # On a flat Earth, and the last of the samples 0.2 s before the end.
    np.testing.assert_allclose(one.frozen[inside[-1]] - one.frozen[inside[0]], drift, atol=1.5)


def test_a_flight_without_air_data_is_scored_but_for_what_they_would_give(short):
    study, sensed, _ = short
    (scenario,) = study.scenarios
    silent = inject(sensed, [Fault("dropout", "ADC", 0.0, scenario.duration_s)], 3)
    flown = FusionStudy((scenario,), filters=("integrated",), starts=("init",))
    (variant,) = flown.variants.values()
    got = scored(Flight.of(run(silent, variant.config(silent)), scenario))
    assert got["valid_share"] > 0.9
    assert got["heading_rmse_deg"] < 2
    assert got["aided_position_north_rmse_m"] < 15
    assert 0 < got["end_20s_m"] < 100
    assert np.isnan([got["before_velocity_north_rmse_m_s"], got["frozen_end_20s_m"]]).all()


# The command

SHORT = """
base = "ordinary"
duration_s = 150
[gps]
outages = [{ start_s = 100, duration_s = 20 }]
"""


def command(*arguments):
    which = ["--scenario", "short.toml", "--filter", "cascade", "--out", "here"]
    return ["monte-carlo", "fusion", *which, *arguments]


def test_a_small_campaign_is_resumed_redrawn_and_judged(lodestar, tmp_path, monkeypatch):
    (tmp_path / "short.toml").write_text(SHORT)
    init = ["--start", "init"]
    status, out, err = lodestar(*command("--runs", 1, *init, "--json"))
    assert status == 0, err
    assert json.loads(out)["runs"] == 1
    (first,) = (tmp_path / "here/flights").glob("*.parquet")
    flown = first.stat().st_mtime_ns

    status, out, err = lodestar(*command("--runs", 2, *init, "--json"))
    assert status == 0, err
    found = json.loads(out)
    assert (found["study"], found["runs"]) == ("fusion", 2)
    assert first.stat().st_mtime_ns == flown
    assert len(list((tmp_path / "here/flights").glob("*.parquet"))) == 2
    (heading,) = [r for r in found["rows"] if r["metric"] == "heading_rmse_deg"]
    assert (heading["case"], heading["estimator"]) == ("short/profile/init", "cascade")
    assert heading["low"] < heading["value"] < heading["high"]

    # The same flights, with a goal that they miss.
    tight = {"short": (((0.001, 0.0005),) * 6)}
    monkeypatch.setattr(fusion_requirements, "_STEADY", tight)
    status, out, _ = lodestar(*command("--runs", 2, *init, "--redraw"))
    assert status == 1
    assert "failed: short/profile/init cascade heading_rmse_deg is" in out
    assert {path.name for path in (tmp_path / "here/plots").glob("*.png")} == {
        "flight-short-profile-init.png",
        *(f"{name}-steady.png" for name in ("heading", "wind", "position")),
    }


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--start", "warm"], "start warm: unknown"),
        (["--option", "sahrs.form=thesis"], "must be one of"),
        (["--redraw"], "holds none of these flights"),
    ],
)
def test_bad_input_is_one_line_and_ends_with_2(lodestar, tmp_path, arguments, said):
    (tmp_path / "short.toml").write_text(SHORT)
    status, out, err = lodestar(*command("--runs", 1, "--json", *arguments))
    assert status == 2
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert said in err
    assert out == ""


def test_the_study_has_help_with_an_example(lodestar):
    status, out, _ = lodestar("monte-carlo", "fusion", "--help")
    assert status == 0
    assert "Example: lodestar monte-carlo fusion" in out
    assert shipped("cascade").tables() == {"fusion": {"filter": "cascade"}}
