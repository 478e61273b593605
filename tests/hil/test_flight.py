# SPDX-License-Identifier: Apache-2.0
"""Whole flights through the real process over real LCM."""

import os
import signal
import subprocess
from dataclasses import replace

import numpy as np
import pytest

from lodestar import navigator
from lodestar.evaluation.score import score
from lodestar.harness import CONFIG, LOG
from lodestar.harness.faults import Fault
from lodestar.harness.flight_computer import FlightComputerError, find_executable
from lodestar.harness.fly import Plan, fly_plan, prepare
from lodestar.harness.isolation import isolated_bus
from lodestar.harness.replay import replay
from lodestar.recordings.log import read_log
from lodestar.rotation import wrap_pi

DURATION_S = 60


@pytest.fixture(scope="module")
def plan():
    from lodestar.harness.scenario import load_scenario

    return prepare(replace(load_scenario("ordinary"), duration_s=DURATION_S), seed=3)


@pytest.fixture(scope="module")
def run(plan, tmp_path_factory):
    """The folder of one flight in lockstep."""
    folder = tmp_path_factory.mktemp("run")
    with isolated_bus() as url:
        fly_plan(plan, url, folder)
    return folder


@pytest.fixture(scope="module")
def flight(run):
    return read_log(run / LOG)


def same_bits(one, other, channel):
    assert one[channel].keys() == other[channel].keys()
    for name in one[channel].keys() - {"arrival_us"}:
        assert one[channel][name].tobytes() == other[channel][name].tobytes(), (channel, name)


def test_every_frame_is_answered_once_and_in_order(flight):
    frames = flight["EFCS.RATES"]["time_us"]
    assert len(frames) == DURATION_S * 60 + 1
    for channel in ("SAHRS", "NAV"):
        np.testing.assert_array_equal(flight[channel]["time_us"], frames)


def test_health_comes_once_a_second(flight):
    assert len(flight["HEALTH"]["time_us"]) == pytest.approx(DURATION_S, abs=1)


def test_what_was_sent_is_what_was_logged(plan, flight):
    for channel in plan.inputs.channels:
        same_bits(plan.inputs, flight, channel)
        np.testing.assert_array_equal(
            plan.inputs[channel]["arrival_us"], flight[channel]["arrival_us"]
        )


def test_everything_that_was_sent_was_received(plan, flight):
    last = {name: values[-1] for name, values in flight["HEALTH"].items()}
    sent = plan.inputs["SMDU"]["arrival_us"]
    assert last["received"][2] == np.sum(sent <= last["time_us"])
    # A gate lets go of a good innovation now and then; nothing else may be refused.
    *refused, gated = last["rejected"].sum(axis=0)
    assert sum(refused) == 0
    assert gated < 10


def test_the_attitude_is_that_of_the_aircraft(flight):
    result = score(flight, case="ordinary", seed=3)
    # A minute after the INS's last word, the paper's own limits are far away.
    assert result.value("sahrs", "roll_rmse_deg") < 2.0
    assert result.value("sahrs", "pitch_rmse_deg") < 2.0
    error = wrap_pi(flight["SAHRS"]["heading"] - flight["TRUTH"]["heading"])
    assert np.degrees(np.abs(error)).max() < 5.0


def test_flown_replayed_and_in_process_are_the_same_bits(plan, run, flight):
    replayed = replay(run / LOG, config=run / CONFIG).recording
    in_process = navigator.run(plan.inputs, plan.config)
    for channel in ("SAHRS", "NAV"):
        same_bits(flight, replayed, channel)
        same_bits(flight, in_process, channel)


def test_two_replays_are_the_same_file(run, tmp_path):
    outputs = [tmp_path / "a.lcm", tmp_path / "b.lcm"]
    for output in outputs:
        command = [find_executable(), "--replay", run / LOG, "--output", output]
        subprocess.run([*command, "--config", run / CONFIG], check=True, capture_output=True)
    assert outputs[0].read_bytes() == outputs[1].read_bytes()


def test_an_npz_replays_as_the_log_does(run, flight, tmp_path):
    from lodestar import recordings

    recordings.save(flight, tmp_path / "flight.npz")
    replayed = replay(tmp_path / "flight.npz", config=run / CONFIG).recording
    for channel in ("SAHRS", "NAV"):
        same_bits(flight, replayed, channel)


def test_realtime_answers_every_frame_too(plan, tmp_path):
    short = Plan(first_seconds(plan.inputs, 2.0), (), plan.config)
    with isolated_bus() as url:
        fly_plan(short, url, tmp_path, realtime=True)
    flown = read_log(tmp_path / LOG)
    np.testing.assert_array_equal(flown["SAHRS"]["time_us"], flown["EFCS.RATES"]["time_us"])
    latency = flown["SAHRS"]["arrival_us"] - flown["EFCS.RATES"]["arrival_us"]
    assert (latency >= 0).all()


def test_malformed_datagrams_are_counted_and_leave_the_answers_as_they_are(plan, flight, tmp_path):
    from lodestar.harness.faults import raw_payloads

    faults = [
        Fault("malformed", channel, start_s=1.0, duration_s=3.0, interval_s=0.25)
        for channel in ("EFCS.RATES", "SMDU", "GPS")
    ]
    strays = raw_payloads(faults, seed=1, until_s=6.0)
    disturbed = Plan(first_seconds(plan.inputs, 6.0), strays, plan.config)
    with isolated_bus() as url:
        fly_plan(disturbed, url, tmp_path)
    flown = read_log(tmp_path / LOG, strict=False)
    assert flown["HEALTH"]["rejected"][-1][:, :3].sum() == len(strays)
    frames = len(flown["EFCS.RATES"]["time_us"])
    assert frames == 6 * 60 + 1
    for name in ("q_NB", "sigma_B", "gyro_bias_B"):
        assert flown["SAHRS"][name].tobytes() == flight["SAHRS"][name][:frames].tobytes()


def test_a_jump_in_the_master_clock_does_not_hold_up_the_flight(plan, tmp_path):
    from lodestar.harness.faults import inject

    jump = [Fault("time_jump", "EFCS.RATES", start_s=2.0, duration_s=0.5, value=100.0)]
    jumped = Plan(inject(first_seconds(plan.inputs, 5.0), jump, seed=1), (), plan.config)
    with isolated_bus() as url:
        fly_plan(jumped, url, tmp_path)
    flown = read_log(tmp_path / LOG)
    assert flown["SAHRS"]["time_us"][-1] == flown["EFCS.RATES"]["time_us"][-1]


def test_a_flight_computer_that_dies_is_said_and_the_log_kept(plan, tmp_path):
    def kill_at_ten_seconds(time_us):
        if time_us >= 10_000_000:
            (child,) = children()
            os.kill(child, signal.SIGKILL)

    with isolated_bus() as url, pytest.raises(FlightComputerError, match="status -9"):
        fly_plan(plan, url, tmp_path, progress=kill_at_ten_seconds)
    kept = read_log(tmp_path / LOG)
    assert kept["SAHRS"]["time_us"][-1] >= 9_900_000


def test_an_interrupt_stops_the_process_and_keeps_the_log(plan, tmp_path):
    started = []

    def interrupt_at_ten_seconds(time_us):
        started[:] = children()
        if time_us >= 10_000_000:
            raise KeyboardInterrupt

    with isolated_bus() as url, pytest.raises(KeyboardInterrupt):
        fly_plan(plan, url, tmp_path, progress=interrupt_at_ten_seconds)
    assert len(started) == 1
    assert children() == []
    kept = read_log(tmp_path / LOG)
    assert kept["SAHRS"]["time_us"][-1] == kept["EFCS.RATES"]["time_us"][-1]


def children() -> list[int]:
    """Ids of this process's flight computers."""
    listed = subprocess.run(
        ["ps", "-o", "pid=,comm=", "--ppid", str(os.getpid())], capture_output=True, text=True
    )
    rows = (line.split() for line in listed.stdout.splitlines())
    return [int(pid) for pid, name in rows if name == "lodestar-fc"]


def first_seconds(recording, seconds):
    from lodestar.recordings import Recording

    cut = Recording()
    for name, columns in recording.channels.items():
        rows = columns["time_us"] <= seconds * 1e6
        cut.channels[name] = {field: values[rows] for field, values in columns.items()}
    return cut
