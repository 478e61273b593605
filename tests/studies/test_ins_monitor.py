# SPDX-License-Identifier: Apache-2.0
"""False alarms and detection of the INS's faults, on short flights."""

import json
from math import inf

import numpy as np
import pytest

from lodestar.studies import ins_monitor
from lodestar.studies.ins_monitor import Watched, alarm_rows, detection_rows

SEED = 3


@pytest.fixture(scope="module")
def short(tmp_path_factory) -> str:
    """The first 700 s of `ordinary`: straight legs and turns, room for four faults."""
    path = tmp_path_factory.mktemp("scenario") / "short.toml"
    path.write_text('base = "ordinary"\nduration_s = 700\n')
    return str(path)


def test_a_working_ins_raises_no_alarm(short):
    watched = ins_monitor.false_alarms(short, SEED)
    assert watched.alarms == 0
    assert watched.hours == pytest.approx(700 / 3600, rel=0.01)
    assert np.all((watched.closest > 0.0) & (watched.closest < 1.0))


def test_a_threshold_that_is_too_small_raises_alarms_and_they_are_counted(short):
    tight = {"level_threshold_deg": 0.1, "heading_threshold_deg": 0.1, "threshold_sigmas": 1}
    watched = ins_monitor.false_alarms(short, SEED, {"monitor": {"ins": tight}})
    assert watched.alarms > 0
    assert watched.closest.max() > 1.0


def test_every_fault_is_found_before_it_is_dangerous(short):
    found = ins_monitor.detection(short, SEED)
    assert len(found) >= 4
    for detection in found:
        assert detection.time_s < 20.0
        assert np.all(detection.error_deg < list(ins_monitor.LIMITS_DEG.values())), detection
        if detection.fault.kind == "ramp":
            axis = list(ins_monitor.LIMITS_DEG).index(detection.fault.field)
            ramped = ins_monitor.RAMP_DEG_S * detection.time_s
            # One solution of the INS, 33 ms, and its constant error of 0.1 degrees, 1 sigma.
            assert detection.error_deg[axis] == pytest.approx(ramped, abs=0.4)


def test_a_fault_that_is_not_found_is_counted(short):
    blind = {"level_threshold_deg": 45, "level_change_deg": 45, "heading_threshold_deg": 90}
    blind |= {"heading_change_deg": 90, "frozen_turn_deg": 45}
    found = ins_monitor.detection(short, SEED, {"monitor": {"ins": blind}})
    ramps = [detection for detection in found if detection.fault.kind == "ramp"]
    assert ramps
    assert all(detection.time_s == inf for detection in ramps)
    undetected = [r for r in detection_rows("short", ramps) if r["metric"] == "undetected"]
    assert sum(row["value"] for row in undetected) == len(ramps)


def test_rows_add_up_the_flights():
    flights = [Watched(1.0, 0, np.array([0.1, 0.2, 0.3])), Watched(0.5, 2, np.array([0.3, 0.1, 1]))]
    rows = {row["metric"]: row for row in alarm_rows("calm", flights)}
    assert rows["flown_hours"]["value"] == 1.5
    assert rows["false_alarms"]["value"] == 2
    assert rows["false_alarms"]["limit"] == 0
    assert rows["roll_max_of_threshold"]["value"] == 0.3
    assert {row["estimator"] for row in rows.values()} == {"ins-monitor"}
    json.dumps(list(rows.values()))
