# SPDX-License-Identifier: Apache-2.0
"""The clocks against a bus that answers, or does not, as each test wants."""

import lcm
import pytest
from lodestar.messages import attitude_t, body_rates_t, magnetic_field_t, navigation_t

from lodestar.channels import MASTER
from lodestar.harness import clock
from lodestar.harness.clock import Event, Link
from lodestar.harness.flight_computer import FlightComputerError

JUNK = b"no such message"


class AnsweringBus:
    """Answers a frame with SAHRS and NAV of its time, unless ``answers`` says no."""

    def __init__(self, answers=lambda channel, time_us: True):
        self._answers = answers
        self._waiting = []
        self._listener = None

    def tap(self, listener):
        self._listener = listener

    def publish(self, channel, payload):
        if channel != MASTER or payload == JUNK:
            return
        time_us = body_rates_t.decode(payload).time_us
        for name, kind in (("SAHRS", attitude_t), ("NAV", navigation_t)):
            if self._answers(name, time_us):
                self._waiting.append((name, stamped(kind, time_us)))

    def receive(self, timeout_s=0.0):
        arrived, self._waiting = self._waiting, []
        for channel, payload in arrived:
            self._listener(channel, payload)
        return bool(arrived)


class RunningComputer:
    status = None

    def require_running(self):
        if self.status is not None:
            raise FlightComputerError(f"ended with status {self.status}")


def stamped(kind, time_us: int) -> bytes:
    message = kind()
    message.time_us = time_us
    return message.encode()


def frame(time_us: int) -> Event:
    return Event(time_us, MASTER, stamped(body_rates_t, time_us), makes_frame=True)


def field(time_us: int) -> Event:
    return Event(time_us, "SMDU", stamped(magnetic_field_t, time_us), makes_frame=False)


def logged(path) -> list[tuple[int, str]]:
    return [(event.timestamp, event.channel) for event in lcm.EventLog(path, "r")]


@pytest.fixture
def log(tmp_path):
    return tmp_path / "flight.lcm"


def test_lockstep_waits_for_both_answers_before_it_goes_on(log):
    with Link(AnsweringBus(), log) as link:
        clock.lockstep([field(10), frame(20), field(30), frame(40)], link, RunningComputer())
    assert logged(log) == [
        (10, "SMDU"),
        (20, MASTER),
        (20, "SAHRS"),
        (20, "NAV"),
        (30, "SMDU"),
        (40, MASTER),
        (40, "SAHRS"),
        (40, "NAV"),
    ]


@pytest.mark.parametrize(
    ("silent", "missing"),
    [({"SAHRS"}, "no SAHRS within"), ({"NAV"}, "no NAV within"), ({"SAHRS", "NAV"}, "SAHRS and")],
)
def test_lockstep_names_the_answer_that_is_missing_and_its_frame(log, silent, missing):
    bus = AnsweringBus(lambda channel, time_us: time_us < 2_000 or channel not in silent)
    with Link(bus, log) as link, pytest.raises(FlightComputerError, match=missing) as caught:
        clock.lockstep([frame(1_000), frame(2_000)], link, RunningComputer(), timeout_s=0.02)
    assert "EFCS.RATES of 0.002000 s" in str(caught.value)
    assert logged(log)[-1][1] in {MASTER, "SAHRS", "NAV"}


def test_lockstep_says_that_the_process_ended_rather_than_what_is_missing(log):
    computer = RunningComputer()
    computer.status = -11
    with (
        Link(AnsweringBus(lambda *_: False), log) as link,
        pytest.raises(FlightComputerError, match="status -11"),
    ):
        clock.lockstep([frame(1_000)], link, computer, timeout_s=0.02)


def test_lockstep_goes_on_past_times_that_make_no_frame(log):
    """Backwards and more than 1 s ahead: the flight computer does not answer these at once."""
    refused = {5_000_000, 500}
    bus = AnsweringBus(lambda channel, time_us: time_us not in refused)
    times = [1_000, 2_000, 5_000_000, 3_000, 500, 4_000]
    events = [frame(time_us) for time_us in times]
    with Link(bus, log) as link:
        clock.lockstep(events, link, RunningComputer(), timeout_s=0.05)
    answers = [timestamp for timestamp, channel in logged(log) if channel == "NAV"]
    assert answers == [1_000, 2_000, 3_000, 4_000]


def test_lockstep_follows_a_jump_once_it_is_answered(log):
    bus = AnsweringBus(lambda channel, time_us: time_us != 9_000_000)
    events = [frame(1_000), frame(9_000_000), frame(9_001_000), frame(9_002_000)]
    with Link(bus, log) as link:
        clock.lockstep(events, link, RunningComputer(), timeout_s=0.05)
    answers = [timestamp for timestamp, channel in logged(log) if channel == "NAV"]
    assert answers == [1_000, 9_001_000, 9_002_000]


def test_a_malformed_message_of_the_master_clock_is_not_waited_for(log):
    junk = Event(15, MASTER, JUNK, makes_frame=False)
    with Link(AnsweringBus(lambda *_: True), log) as link:
        clock.lockstep([frame(10), junk, frame(20)], link, RunningComputer(), timeout_s=0.05)
    assert [channel for _, channel in logged(log)].count(MASTER) == 3


def test_lockstep_tells_its_progress_once_a_second_of_flight(log):
    told = []
    events = [frame(time_us) for time_us in range(0, 3_000_001, 250_000)]
    with Link(AnsweringBus(), log) as link:
        clock.lockstep(events, link, RunningComputer(), progress=told.append)
    assert told == [0, 1_000_000, 2_000_000, 3_000_000]


def test_realtime_sends_nothing_before_its_time_and_logs_in_order(log, bus_url):
    from lodestar.harness.bus import Bus

    events = [field(0), frame(20_000), field(30_000), frame(40_000)]
    with Bus(bus_url) as bus, Link(bus, log) as link:
        clock.realtime(events, link, RunningComputer())
    written = logged(log)
    assert [channel for _, channel in written] == ["SMDU", MASTER, "SMDU", MASTER]
    assert all(at >= event.arrival_us for (at, _), event in zip(written, events, strict=True))
    assert [at for at, _ in written] == sorted(at for at, _ in written)
