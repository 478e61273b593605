# SPDX-License-Identifier: Apache-2.0
"""The study of the INS monitor: alarms are counted, faults put in, found and told."""

from dataclasses import replace
from math import inf

import numpy as np
import pytest

from lodestar.errors import InputError
from lodestar.harness.faults import Fault
from lodestar.harness.scenario import load_scenario, simulate
from lodestar.studies import ins_monitor
from lodestar.studies.ensemble import grouped
from lodestar.studies.ins_monitor import KINDS, InsMonitorStudy, ins_monitor_study
from lodestar.studies.ins_monitor_findings import LIMITS_DEG, findings
from lodestar.studies.sahrs import AXES

SEED = 3
SCENARIO = replace(load_scenario("ordinary"), duration_s=700.0)
TIGHT = {"level_threshold_deg": 0.1, "heading_threshold_deg": 0.1, "threshold_sigmas": 1}
BLIND = {
    "level_threshold_deg": 45,
    "level_change_deg": 45,
    "heading_threshold_deg": 90,
    "heading_change_deg": 90,
    "level_departure_deg": 45,
    "heading_departure_deg": 90,
    "frozen_turn_deg": 45,
}


@pytest.fixture(scope="module")
def flight():
    return simulate(SCENARIO, SEED)


@pytest.fixture(scope="module")
def flown():
    study = InsMonitorStudy((SCENARIO,), forms=("velocity",))
    return grouped(study.fly(study.cells, SEED))


def with_monitor(**keys):
    return {"monitor": {"ins": keys}}


def test_a_working_ins_raises_no_alarm(flight):
    watched = ins_monitor.false_alarms(SCENARIO, flight, {})
    assert watched.alarms == 0
    assert watched.hours == pytest.approx(700 / 3600, rel=0.02)
    assert np.all((watched.closest > 0.0) & (watched.closest < 1.0))


def test_thresholds_that_are_too_small_raise_alarms_and_they_are_counted(flight):
    watched = ins_monitor.false_alarms(SCENARIO, flight, with_monitor(**TIGHT))
    assert watched.alarms > 0
    assert watched.closest.max() > 1.0


def test_every_fault_is_told_before_it_is_dangerous(flight):
    found = ins_monitor.detection(SCENARIO, flight, SEED, {})
    assert len(found) >= 4
    for detection in found:
        assert detection.time_s < 20.0
        assert np.all(detection.error_deg < list(LIMITS_DEG.values())), detection
        assert np.all(detection.believed_deg <= detection.error_deg), detection
        if detection.fault.kind == "ramp":
            error = detection.error_deg[AXES.index(detection.fault.field)]
            # One solution of the INS, 33 ms, and its constant error of 0.1 degrees, 1 sigma.
            ramped = ins_monitor.RAMP_DEG_S * detection.time_s
            assert error == pytest.approx(ramped, abs=0.4)


def test_the_solution_that_brings_the_alarm_is_not_one_that_was_believed():
    fault = Fault("freeze", "INS", 1.0, 1.0)
    monitor = {
        "time_us": np.array([900_000, 1_100_000]),
        "state": np.array([1, 3], np.uint8),
    }
    ins_us = np.array([1_000_000, 1_050_000, 1_100_000, 1_150_000])
    error = np.array([[0.1, 0, 0], [-0.2, 0, 0], [6.0, 0, 0], [9.0, 0, 0]])
    found = ins_monitor._detected(fault, monitor, ins_us, error)
    assert found.time_s == pytest.approx(0.1)
    assert found.believed_deg[0] == 0.2
    assert found.error_deg[0] == 6.0


def test_a_fault_that_nobody_sees_is_counted(flight):
    found = ins_monitor.detection(SCENARIO, flight, SEED, with_monitor(**BLIND))
    ramps = [detection for detection in found if detection.fault.kind == "ramp"]
    assert ramps
    assert all(detection.time_s == inf for detection in ramps)


def test_rows_and_verdict_tell_of_both_cases(flown):
    found = findings("ins-monitor", flown)
    assert found.failures == []
    rows = {(row["case"], row["metric"]): row for row in found.rows}
    working = rows["ordinary/profile/working", "false_alarms"]
    assert (working["value"], working["limit"], working["estimator"]) == (0, 0, "ins-monitor")
    faults = sum(row["value"] for (_, metric), row in rows.items() if metric == "faults")
    assert faults >= 4
    assert all(row["value"] == 0 for (_, metric), row in rows.items() if metric == "undetected")
    assert [table.title for table in found.tables] == [
        "An INS that works",
        "An INS that fails: until the alarm",
    ]


@pytest.mark.parametrize(
    ("case", "changed", "said"),
    [
        ("working", {"alarms": 2.0}, "working ins-monitor false_alarms is 2, limit 0"),
        (
            "failing",
            {"freeze_roll_deg": 5.1},
            "failing/freeze ins-monitor roll_at_alarm_max_deg is 5.1, limit 5",
        ),
    ],
)
def test_an_alarm_that_is_false_or_late_fails_the_study(flown, case, changed, said):
    (ensemble,) = [one for one in flown if one.cell.case.endswith(f"/{case}")]
    (result,) = ensemble.results
    worse = replace(result, figures=result.figures | changed)
    found = findings("ins-monitor", [replace(ensemble, results=(worse,))])
    assert found.failures == [f"ordinary/profile/{said}"]


def test_kinds_are_those_that_are_flown():
    faults = ins_monitor._faults(SEED, 3000.0)
    kinds = {"-".join(filter(None, (fault.kind, fault.field))) for fault in faults}
    assert kinds == set(KINDS)


def test_what_does_not_exist_is_refused_by_name():
    with pytest.raises(InputError, match="form"):
        ins_monitor_study([], [], ["none"])
