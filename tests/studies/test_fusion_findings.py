# SPDX-License-Identifier: Apache-2.0
"""What the study of navigation says of flights whose figures are known."""

import json

import numpy as np
import pytest

from lodestar.evaluation.fusion_requirements import EKF2, THESIS, goals
from lodestar.studies.campaign import Cell, Result
from lodestar.studies.ensemble import grouped
from lodestar.studies.findings import write
from lodestar.studies.fusion_findings import findings
from lodestar.studies.fusion_plots import plots

GOOD = {
    **{f"{angle}_rmse_deg": 0.1 for angle in ("roll", "pitch", "heading")},
    "before_heading_rmse_deg": 1.0,
    **{f"wind_{axis}_rmse_m_s": 0.4 for axis in ("north", "east")},
    **{f"velocity_{axis}_rmse_m_s": 0.2 for axis in ("north", "east")},
    **{f"before_velocity_{axis}_rmse_m_s": 7.0 for axis in ("north", "east")},
    **{f"position_{axis}_rmse_m": 6.0 for axis in ("north", "east")},
    **{f"aided_position_{axis}_rmse_m": 5.0 for axis in ("north", "east")},
    **{f"gps_{axis}_rmse_m": 5.1 for axis in ("north", "east")},
    **{
        f"coverage_{multiple}sigma_{name}": share
        for multiple, share in ((1, 0.68), (2, 0.95))
        for name in ("heading", "wind_north", "wind_east", "position_north", "position_east")
    },
    **{"nees_heading": 1.0, "nees_wind": 1.0, "sigma_heading_rms_deg": 0.1, "valid_share": 1.0},
    **{"protected_h": 0.0, "beyond_protection_h": 0.0, "largest_of_protection": np.nan},
    **{
        f"{name}_{length}s_m": np.nan
        for name in ("end", "sigma_end", "protection_end", "frozen_end")
        for length in (10, 20, 120, 300, 600, 3600)
    },
    **{metric: value / 2 for metric, value in EKF2.items()},
}
TIME = np.arange(0, 1000, 5.0)
SERIES = {
    "time_s": TIME,
    "frozen_error_m": np.where((TIME >= 400) & (TIME < 520), 1 + TIME - 400, np.nan),
    **{
        name: np.sin(TIME / 50) + 2
        for name in ("heading_error_deg", "heading_sigma_deg", "heading_before_deg")
    },
    **dict.fromkeys(("position_before_m", "protection_m"), 5 + TIME / 100),
    **{
        name.format(axis): 3 + np.cos(TIME / 30)
        for axis in ("north", "east")
        for name in (
            *("wind_{}_m_s", "wind_{}_error_m_s", "wind_{}_sigma_m_s"),
            *("position_{}_error_m", "position_{}_sigma_m"),
        )
    },
}
KEPT = {name: values.astype(np.float32) for name, values in SERIES.items()}


def flights(case, estimator, runs=4, **changed):
    """``runs`` good flights; a changed figure is one number for all, or one for each."""
    values = {name: np.broadcast_to(value, (runs,)) for name, value in changed.items()}
    cell = Cell(case.rsplit("/", 1)[0], case, estimator)
    return [
        Result(cell, seed, GOOD | {n: float(v[seed]) for n, v in values.items()}, KEPT)
        for seed in range(runs)
    ]


def found(*groups):
    return findings("fusion", grouped([one for group in groups for one in group]))


def row(one, metric, estimator="integrated"):
    (only,) = [r for r in one.rows if (r["estimator"], r["metric"]) == (estimator, metric)]
    return only


def table(one, title):
    (only,) = [t for t in one.tables if t.title.startswith(title)]
    return only


INIT = "ordinary/profile/init"

# The verdict


def test_good_flights_pass_with_reference_limit_and_stretch_in_their_rows():
    one = found(flights(INIT, "integrated", heading_rmse_deg=[0.1, 0.2, 0.1, 0.2]))
    assert one.failures == []
    heading = row(one, "heading_rmse_deg")
    # By hand: mean 0.15, standard deviation 0.1 / sqrt(3), t(3) = 3.182.
    half = 3.1824 * (0.1 / np.sqrt(3)) / np.sqrt(4)
    assert heading["value"] == pytest.approx(0.15)
    assert heading["high"] - heading["value"] == pytest.approx(half, rel=1e-4)
    assert (heading["limit"], heading["stretch"], heading["reference"]) == (0.25, 0.13, 0.72)
    velocity = row(one, "velocity_north_rmse_m_s")
    assert (velocity["reference"], "limit" in velocity) == (1.72, False)
    assert "reference" not in row(one, "wind_north_rmse_m_s")
    assert row(one, "wind_east_rmse_m_s")["limit"] == 0.65
    json.loads(one.to_json())


@pytest.mark.parametrize(
    ("case", "estimator", "changed", "said"),
    [
        (INIT, "integrated", {"heading_rmse_deg": 0.2501}, "heading_rmse_deg is 0.25, limit 0.25"),
        (INIT, "cascade", {"heading_rmse_deg": 0.73}, "heading_rmse_deg is 0.73, limit 0.72"),
        (INIT, "integrated", {"wind_north_rmse_m_s": 0.61}, "wind_north_rmse_m_s is 0.61"),
        # One flight without an answer is not left out of the mean.
        (INIT, "integrated", {"heading_rmse_deg": [0.1, 0.1, np.nan, 0.1]}, "is nothing, limit"),
        # A small error with a wrong sigma does not count, on neither side.
        (INIT, "integrated", {"nees_heading": 3.0}, "nees_heading is 3, limit"),
        (INIT, "cascade", {"nees_wind": 0.05}, "nees_wind is 0.05, at least"),
        (INIT, "integrated", {"nees_wind": np.nan}, "nees_wind is nothing"),
        (
            "ordinary/profile/cold",
            "integrated",
            {"heading_rmse_deg": 0.66},
            "heading_rmse_deg is 0.66, limit 0.65",
        ),
        (
            "hard+air/profile/init",
            "integrated",
            {"heading_rmse_deg": 0.36},
            "heading_rmse_deg is 0.36, limit 0.35",
        ),
        (
            "gps-loss-steady/profile/init",
            "integrated",
            {"end_120s_m": 61.0, "end_300s_m": 10.0},
            "end_120s_m is 61, limit 60",
        ),
        # A loss that nothing was said about.
        (
            "gps-loss-steady/profile/init",
            "integrated",
            {"end_120s_m": 1.0},
            "end_300s_m is nothing",
        ),
        (
            "hard/profile/init",
            "integrated",
            {"protected_h": 1.0, "beyond_protection_h": [0.0, 0.1, 0.0, 0.0]},
            "flights_beyond_protection is 1, limit 0",
        ),
        (
            "uav-gps-loss/profile/cold",
            "integrated",
            {"lost_540s_m": [1.0, 300.0, 300.0, 1e4]},
            "lost_540s_m is 300, limit 297",
        ),
    ],
)
def test_what_is_beyond_its_must_is_a_failure(case, estimator, changed, said):
    one = found(flights(case, estimator, **changed))
    assert len(one.failures) == 1
    assert said in one.verdict
    assert one.verdict.startswith("failed")


def test_where_there_is_no_goal_nothing_fails():
    bad = {"heading_rmse_deg": 20.0, "nees_heading": 50.0, "lost_60s_m": 1e4}
    for case, estimator in (
        ("vanern/profile/init", "cascade"),
        (INIT, "cascade-paper"),
        (INIT, "integrated:strapdown.load_bias_sigma_g=0"),
        ("turbulence/profile/init", "cascade"),
        ("uav-gps-loss/profile/cold", "cascade"),
    ):
        one = found(flights(case, estimator, **bad))
        assert (one.failures, one.verdict) == ([], "passed: no limit applies")


def test_the_ratio_to_the_limit_is_that_of_root_mean_squares_over_all_flights():
    integrated = flights(INIT, "integrated", heading_rmse_deg=[0.14, 0.02, 0.14, 0.02])
    limit = flights(INIT, "limit", runs=2, sigma_heading_rms_deg=[0.05, 0.07])
    one = found(integrated, limit)
    expected = np.sqrt((0.14**2 + 0.02**2) / 2) / np.sqrt((0.05**2 + 0.07**2) / 2)
    ratio = row(one, "heading_over_limit")
    assert ratio["value"] == pytest.approx(expected)
    assert (ratio["limit"], ratio["stretch"]) == (1.5, 1.1)
    assert expected > 1.5
    assert len(one.failures) == 1
    assert table(one, "Heading").rows[0][-2:] == ("0.061", f"{expected:.2f}")


# Tables


def test_the_thesiss_figures_stand_beside_ours():
    one = found(
        flights(INIT, "cascade", before_heading_rmse_deg=0.8, heading_rmse_deg=0.5, nees_wind=9.0),
        flights(INIT, "cascade-paper", before_heading_rmse_deg=1.3, heading_rmse_deg=0.4),
        flights(INIT, "cascade-thesis", before_heading_rmse_deg=2.5, heading_rmse_deg=0.6),
        flights(INIT, "integrated", velocity_north_rmse_m_s=[0.1, 0.3, 0.1, 0.3]),
    )
    assert table(one, "Heading").rows == [
        (
            INIT,
            "3.46 → 0.72",
            *("0.80 ± 0.00", "1.30 ± 0.00", "2.50 ± 0.00"),
            *("0.50 ± 0.00", "0.40 ± 0.00", "0.60 ± 0.00", "0.10 ± 0.00"),
            *("–", "–"),
        )
    ]
    (wind,) = table(one, "The thesis's wind").rows
    assert wind[:5] == (INIT, "2.42 → 1.72", "7.00 ± 0.00", "0.20 ± 0.00", "0.20 ± 0.18")
    position = table(one, "Error of wind")
    assert position.rows[0][4:7] == ("5.10 / 5.10", "5.00 / 5.00", "0.980 / 0.980")


def test_the_verdict_of_a_cell_is_its_worst_and_tells_a_wrong_sigma():
    cold = "ordinary/profile/cold"
    one = found(
        flights(INIT, "integrated", wind_north_rmse_m_s=0.55),
        flights(INIT, "cascade", nees_heading=4.0),
        flights(cold, "integrated", heading_rmse_deg=0.7),
        flights(cold, "cascade"),
    )
    verdicts = table(one, "Ours")
    assert [line[-1] for line in verdicts.rows] == ["must", "stretch, σ wrong", "missed", "stretch"]
    assert verdicts.rows[0][2:5] == (
        *("0.1 (0.25 / 0.13)", "0.55 (0.6 / 0.5)", "0.4 (0.65 / 0.55)"),
    )
    assert verdicts.bad == {(1, 8), (1, 10), (2, 2), (2, 10)}


def test_consistency_marks_what_is_outside():
    one = found(
        flights(INIT, "integrated", coverage_1sigma_wind_east=0.60, nees_wind=2.9),
        flights("hard/profile/init", "integrated", protected_h=0.5),
    )
    shown = table(one, "Consistency")
    # Chi-squared with 4 and with 8 degrees of freedom.
    assert "0.12 to 2.79 and 0.27 to 2.19" in shown.title
    assert shown.rows[0][3:] == (
        "2.90",
        "68 / 68 / 60 / 68 / 68",
        "95 / 95 / 95 / 95 / 95",
        "100.0",
        "–",
    )
    assert shown.bad == {(0, 3), (0, 4)}
    assert shown.rows[1][-1] == "0 of 4, in 2.0 h"


def test_growth_in_a_loss_is_per_minute_and_sigma_is_compared_flight_by_flight():
    case = "gps-loss-10min/profile/init"
    one = found(
        flights(
            *(case, "cascade", 2),
            end_600s_m=[300.0, 500.0],
            sigma_end_600s_m=[300.0, 250.0],
            frozen_end_600s_m=[100.0, 100.0],
            protection_end_600s_m=[1000.0, 2000.0],
        )
    )
    ours, alone = table(one, "Losses").rows
    # t(1) = 12.706; the ratios are 1 and 2.
    assert ours[:2] == (case, "10 min")
    assert ours[3:] == ("400 ± 1271", "500", "40.0", "276", f"{np.sqrt(2.5):.2f}", "1500")
    assert alone[2:] == ("SAHRS alone", "100 ± 0", "100", "10.0", "–", "–", "–")
    assert row(one, "end_600s_m", "cascade")["value"] == 400.0


def test_options_are_compared_on_the_seeds_they_share():
    name = "cascade:fusion.cascade.covariance=ud"
    one = found(
        flights(INIT, "cascade", heading_rmse_deg=[0.1, 0.3, 9.0, 9.0]),
        flights(INIT, name, runs=2, heading_rmse_deg=[0.4, 0.6]),
    )
    shipped, other = table(one, "What the options").rows
    assert shipped[:4] == (INIT, "cascade", "2", "0.200")
    assert other[:4] == (INIT, "cascade", "2", "0.500")
    assert other[-2:] == (f"{np.hypot(5, 5):.2f}", "UD form of the covariance")
    assert shipped[-1] == "as shipped"


def test_the_peer_is_compared_by_mean_rms_and_median_position():
    case = "uav-gps-loss/profile/cold"
    one = found(
        flights(case, "integrated", lost_60s_m=[1.0, 20.0, 24.0, 1e4], aided_roll_rmse_deg=0.08)
    )
    shown = table(one, "Small unmanned aircraft")
    assert shown.rows[0] == ("GPS on: roll rms, °", "0.07", "0.08")
    assert ("60 s after the loss, m", "25", "22") in shown.rows
    assert shown.bad == {(0, 2)}
    assert len(shown.rows) == len(EKF2)


def test_an_incomplete_study_says_so():
    one = found(flights(INIT, "cascade"), flights("hard/profile/init", "cascade", runs=2))
    assert one.runs == 2
    assert any("Incomplete: the cases have 2 to 4 flights." in note for note in one.notes)
    assert any("50 flights" in note for note in one.notes)


def test_the_thesis_and_our_goals_name_the_same_steady_flights():
    assert [name for name in THESIS if not goals(name, "init", "cascade")] == ["vanern"]


def test_the_report_holds_tables_and_plots(tmp_path):
    ensembles = grouped(
        [
            *flights(INIT, "cascade", runs=2),
            *flights(INIT, "integrated", runs=2),
            *flights("ordinary/profile/cold", "integrated", runs=2),
            *flights("ordinary+air/profile/init", "integrated", runs=2),
            *flights(
                *("gps-loss-10min/profile/init", "cascade", 2),
                end_600s_m=300.0,
                frozen_end_600s_m=400.0,
            ),
        ]
    )
    drawn = plots(ensembles)
    assert [plot.name for plot in drawn] == [
        "flight-ordinary-profile-init",
        "flight-ordinary+air-profile-init",
        "flight-gps-loss-10min-profile-init",
        *("heading-steady", "wind-steady", "position-steady"),
        *("heading-living", "wind-living", "position-living"),
        *("gps-loss", "gps-loss-rate"),
    ]
    report = write(findings("fusion", ensembles), drawn, tmp_path).read_text()
    assert report.count("<img") == len(drawn)
    assert report.count("<table") == 6
