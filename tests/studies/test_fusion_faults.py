# SPDX-License-Identifier: Apache-2.0
"""The study of fusion with bad fixes: the fault is put in, told or not, and what it cost."""

import numpy as np
import pytest

from lodestar import channels
from lodestar.errors import InputError
from lodestar.studies.campaign import Result
from lodestar.studies.ensemble import Ensemble, grouped
from lodestar.studies.fault_window import Window
from lodestar.studies.fusion_faults import (
    BROKEN,
    CASES,
    FILTERS,
    SPOOFED,
    START_S,
    Flown,
    fusion_faults_study,
)
from lodestar.studies.fusion_faults_findings import findings, plots, verdict

STUDY = fusion_faults_study([], ["cascade"])
FLOWN = ("none", "jump-200m", "drag-5-lost", "nan")


@pytest.fixture(scope="module")
def flown():
    """One flight with some of the faults."""
    cells = [cell for cell in STUDY.cells if cell.case.split("/")[-1] in FLOWN]
    return {one.cell.case.split("/")[-1]: one for one in grouped(STUDY.fly(cells, 1))}


def test_every_case_is_flown_with_every_filter_and_said_in_words():
    everything = fusion_faults_study([], [])
    assert len(everything.cells) == len(CASES) * len(FILTERS)
    assert set(CASES) == {"none", *SPOOFED, *BROKEN}
    for name, case in CASES.items():
        assert case.what
        assert bool(case.faults) == (name != "none")
        assert case.window.start_s == START_S
        assert all(fault.channel == "GPS" for fault in case.faults)
    assert CASES["drag-5-lost"].window.end_s == CASES["drag-5"].window.end_s + 60.0


def test_before_the_fault_a_flight_is_the_one_without_it(flown):
    sound = flown["none"]
    for name in FLOWN[1:]:
        before = flown[name].series("time_s")[0] < START_S
        one, other = (e.series("position_m")[0] for e in (flown[name], sound))
        np.testing.assert_array_equal(one[before], other[before])
        assert (one[~before] != other[~before]).any()


def test_a_flight_without_a_fault_is_not_told_to_have_one(flown):
    sound = flown["none"]
    assert np.isnan(sound.figure("detect_s")[0])
    assert sound.figure("fixes_refused_share")[0] < 0.05
    assert sound.figure("believe_s")[0] == pytest.approx(0.2, abs=0.05)  # latency of a fix
    assert sound.figure("during_position_max_m")[0] < 40.0


def test_a_jump_is_told_and_measured_and_ended(flown):
    jump = flown["jump-200m"]
    # The jump itself, and a few metres of error that were there before.
    assert jump.figure("during_position_max_m")[0] == pytest.approx(200.0, abs=25.0)
    assert jump.figure("detect_s")[0] < 5.0
    assert 0.2 < jump.figure("believe_s")[0] < 10.0
    assert jump.figure("GPS gate")[0] > 0
    assert jump.figure("resets")[0] >= 1
    assert jump.figure("after_position_max_m")[0] < 40.0
    assert verdict(jump) == f"bounded by {jump.figure('during_position_max_m')[0]:.0f} m"


def test_fixes_without_numbers_are_all_refused_and_counted_by_reason(flown):
    broken = flown["nan"]
    assert broken.figure("fixes_refused_share")[0] == 1.0
    assert broken.figure("GPS not finite")[0] == 120.0
    assert broken.figure("during_not_aiding_share")[0] > 0.9
    assert verdict(broken) == "detected"


def test_a_loss_behind_a_drag_off_is_part_of_the_fault(flown):
    lost = flown["drag-5-lost"]
    # 5 m/s for 300 s, and the wind that was believed of it for 60 s more.
    assert 1500.0 < lost.figure("during_position_max_m")[0] < 2200.0
    assert 0.2 < lost.figure("believe_s")[0] < 10.0
    # Of the fixes that did not come, none was refused.
    assert lost.figure("fixes_refused_share")[0] < 0.1


def test_rows_tell_errors_detection_and_what_was_refused(flown):
    found = findings("fusion-faults", list(flown.values()))
    rows = {(r["case"], r["estimator"], r["metric"]): r for r in found.rows}
    jump = "ordinary/profile/jump-200m"
    for window in ("during", "after"):
        for metric in ("position_max_m", "velocity_max_m_s", "wind_max_m_s", "heading_max_deg"):
            assert rows[f"{jump}/{window}", "cascade", metric]["value"] > 0
    assert rows[jump, "cascade", "undetected"]["value"] == 0
    assert rows[jump, "cascade", "believe_s"]["limit"] == 10.0
    sound = "ordinary/profile/none"
    assert rows[sound, "cascade", "undetected"]["value"] == 1
    assert (sound, "cascade", "detect_s") not in rows
    nan = "ordinary/profile/nan/during"
    assert rows[nan, "cascade", "rejected_GPS_not_finite"]["value"] == 120.0
    assert not found.failures
    assert [len(table.rows) for table in found.tables] == [len(FLOWN)] * 3
    assert {plot.name for plot in plots(list(flown.values()))} == {
        "spoofed-ordinary-profile-cascade",
        "broken-ordinary-profile-cascade",
    }


def test_good_fixes_that_are_not_used_again_break_the_limit(flown):
    jump = flown["jump-200m"]
    for seconds in (12.0, np.nan):
        figures = jump.results[0].figures | {"believe_s": seconds}
        locked_out = Ensemble(jump.cell, (Result(jump.cell, 1, figures, jump.results[0].series),))
        found = findings("fusion-faults", [locked_out])
        (failure,) = found.failures
        assert "believe_s" in failure
        assert found.tables[1].bad


# Figures of flights made by hand: 100 s of NAV at 10 Hz, fixes and HEALTH at 1 Hz, fault 40 to 60 s

WINDOW = Window(40.0, 60.0)


def by_hand(**nav):
    time_us = np.arange(0, 100_000_001, 100_000)
    latest_fix_us = time_us - time_us % 1_000_000
    sound = {
        "time_us": time_us,
        "gps_age": (time_us - latest_fix_us) * 1e-6,
        "mode": np.ones(len(time_us), np.int8),
        "valid": np.ones(len(time_us), bool),
        "reset_count": np.zeros(len(time_us), np.int16),
        "horizontal_protection_level": np.full(len(time_us), -1.0),
    }
    health_us = np.arange(0, 100_000_001, 1_000_000)
    health = {"time_us": health_us, "rejected": np.zeros((len(health_us), 10, 12), np.int64)}
    error = np.full(len(time_us), 20.0)
    errors = dict.fromkeys(("position", "velocity", "wind", "heading"), error)
    gps = {"time_us": health_us, "arrival_us": health_us}
    return Flown(sound | nav, gps, health, errors, error / 5.0)


def count_refused(flown, *seconds):
    rejected = flown.health["rejected"]
    for second in seconds:
        rejected[second:, channels.INPUTS.index("GPS"), 11] += 1


def figures(flown):
    return dict(flown.figures(WINDOW))


def test_resets_are_counted_from_the_fault_on():
    count = np.zeros(1001, np.int16)
    count[100:] = 1  # before the fault
    count[500:] = 3
    count[700:] = 4
    assert figures(by_hand(reset_count=count))["resets"] == 3.0


def test_one_refused_fix_is_no_detection_and_two_in_succession_are():
    once, apart, twice = by_hand(), by_hand(), by_hand()
    count_refused(once, 45)
    count_refused(apart, 45, 47, 58)
    count_refused(twice, 45, 46)
    assert np.isnan(figures(once)["detect_s"])
    assert np.isnan(figures(apart)["detect_s"])
    assert figures(twice)["detect_s"] == pytest.approx(6.0)


def test_examined_fixes_are_a_detection_only_during_the_fault():
    modes = {second: np.ones(1001, np.int8) for second in (30, 52, 70)}
    for second, mode in modes.items():
        mode[10 * second : 10 * second + 5] = 3
    detected = {second: figures(by_hand(mode=mode))["detect_s"] for second, mode in modes.items()}
    assert detected[52] == pytest.approx(12.0)
    assert np.isnan([detected[30], detected[70]]).all()


def test_good_fixes_count_as_used_from_the_first_that_was_measured_after_the_fault():
    age = by_hand().nav["gps_age"]
    time_s = np.arange(1001) * 0.1
    kept_out = np.where((time_s >= 40.0) & (time_s < 63.5), time_s - 39.0, age)
    told = figures(by_hand(gps_age=kept_out))
    assert told["fixes_refused_share"] == 1.0
    assert told["believe_s"] == pytest.approx(3.5)
    assert figures(by_hand())["fixes_refused_share"] == pytest.approx(0.0, abs=0.051)
    never = figures(by_hand(gps_age=np.where(time_s >= 40.0, time_s - 39.0, age)))
    assert np.isnan(never["believe_s"])


def test_time_beyond_the_protection_level_counts_where_one_is_stated():
    level = np.full(1001, 30.0)
    level[400:700] = 10.0
    level[700:] = -1.0

    def beyond(level):
        return figures(by_hand(horizontal_protection_level=level))["beyond_hpl_share"]

    assert beyond(level) == 1.0
    level[550:700] = 30.0
    assert beyond(level) == pytest.approx(0.5)
    assert np.isnan(figures(by_hand())["beyond_hpl_share"])


def test_what_does_not_exist_is_refused():
    with pytest.raises(InputError, match="engine warp: unknown"):
        fusion_faults_study(["warp"], [])
    with pytest.raises(InputError, match="filter particle: unknown; allowed are cascade"):
        fusion_faults_study([], ["particle"])
