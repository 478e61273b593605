# SPDX-License-Identifier: Apache-2.0
"""The two ways time passes in a flight over the bus.

In *lockstep* each message of the master clock waits for its answer: nothing is lost, the order is
always the same, and a flight takes a fraction of its time. In *realtime* each message is sent when
its time has come, whatever the flight computer does.
"""

from __future__ import annotations

import select
import struct
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

import lcm

from lodestar import channels as table
from lodestar.harness.bus import Bus
from lodestar.harness.flight_computer import FlightComputer, FlightComputerError

AWAITED = ("SAHRS", "NAV")
"""What the flight computer answers to every frame."""

# Where every message carries its time: behind the fingerprint, big-endian.
_TIME = slice(8, 16)

# The flight computer takes such a step of the master clock as a frame at once.
_LONGEST_STEP_US = 1_000_000
# How long an answer that may not come is waited for (a time stamp that is refused has none).
_GRACE_S = 0.005
# How often a silent flight computer is looked after.
_LOOK_S = 0.1
# How long realtime listens after the last message.
_LAST_ANSWERS_US = 100_000


class Event(NamedTuple):
    """One message to send: when it arrives at the flight computer, where, what."""

    arrival_us: int
    channel: str
    payload: bytes
    makes_frame: bool
    """A well-formed message of the master clock."""


class Link:
    """A bus whose every message, sent or heard, goes into an LCM log.

    ``now_us`` is the flight time that the log gives to a message. What is heard before the first
    message is sent (the flight computer saying that it is there) is left out.
    """

    def __init__(self, bus: Bus, log: Path) -> None:
        self.bus = bus
        self.now_us: int | None = None
        self.answer_times = dict.fromkeys(AWAITED, b"")
        self._log = lcm.EventLog(log, "w", overwrite=True)
        bus.tap(self._heard)

    def __enter__(self) -> Link:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Take in what is still on its way and close the log."""
        self.bus.receive(_GRACE_S)
        self.bus.tap(None)
        self._log.close()

    def send(self, now_us: int, channel: str, payload: bytes) -> None:
        """Log and publish."""
        self.now_us = now_us
        self._log.write_event(now_us, channel, payload)
        self.bus.publish(channel, payload)

    def missing(self, frame_time: bytes) -> list[str]:
        """The awaited channels that have not answered the frame of this time yet."""
        return [name for name, latest in self.answer_times.items() if latest != frame_time]

    def _heard(self, channel: str, payload: bytes) -> None:
        if self.now_us is None:
            return
        self._log.write_event(self.now_us, channel, payload)
        if channel in self.answer_times:
            self.answer_times[channel] = payload[_TIME]


Progress = Callable[[int], None]
"""Called now and then with the flight time (us) that has been reached."""


def lockstep(
    events: Iterable[Event],
    link: Link,
    computer: FlightComputer,
    *,
    timeout_s: float = 5.0,
    progress: Progress = lambda time_us: None,
) -> None:
    """Send each frame's messages and wait for its answers before going on.

    A frame whose time the flight computer need not accept (not a step of up to 1 s from the last
    answered one) is given a moment only. Raises FlightComputerError, naming what was missing, if
    any other frame is not answered within ``timeout_s``.
    """
    last_answered_us: int | None = None
    next_progress_us: int | None = None
    for event in events:
        link.send(event.arrival_us, event.channel, event.payload)
        if not event.makes_frame:
            continue
        time_us = _time_us(event.payload)
        step_us = 1 if last_answered_us is None else time_us - last_answered_us
        due = 0 < step_us <= _LONGEST_STEP_US
        if _await_answer(link, computer, event.payload[_TIME], timeout_s if due else _GRACE_S):
            last_answered_us = time_us
        elif due:
            missing = " and ".join(link.missing(event.payload[_TIME]))
            raise FlightComputerError(
                f"no {missing} within {timeout_s:g} s for {table.MASTER} of {time_us / 1e6:.6f} s"
            )
        if next_progress_us is None or event.arrival_us >= next_progress_us:
            next_progress_us = event.arrival_us + 1_000_000
            progress(event.arrival_us)


def realtime(
    events: Iterable[Event],
    link: Link,
    computer: FlightComputer,
    *,
    progress: Progress = lambda time_us: None,
) -> None:
    """Send each message when its time has come and log what is heard when it is heard.

    Raises FlightComputerError if the flight computer ends.
    """
    offset_us: int | None = None
    now_us = 0
    next_progress_us: int | None = None
    for event in events:
        if offset_us is None:
            offset_us = event.arrival_us - _wall_us()
        now_us = _listen_until(event.arrival_us, offset_us, link)
        link.send(now_us, event.channel, event.payload)
        if next_progress_us is None or event.arrival_us >= next_progress_us:
            next_progress_us = event.arrival_us + 200_000
            computer.require_running()
            progress(event.arrival_us)
    if offset_us is not None:
        _listen_until(now_us + _LAST_ANSWERS_US, offset_us, link)


def _await_answer(
    link: Link, computer: FlightComputer, frame_time: bytes, timeout_s: float
) -> bool:
    deadline = None
    times = link.answer_times
    while any(latest != frame_time for latest in times.values()):
        now = time.monotonic()
        deadline = deadline or now + timeout_s
        if now >= deadline:
            computer.require_running()
            return False
        if not link.bus.receive(min(deadline - now, _LOOK_S)):
            computer.require_running()
    return True


def _listen_until(until_us: int, offset_us: int, link: Link) -> int:
    """Log what is heard until the flight time has come; returns the time it is then."""
    while True:
        now_us = _wall_us() + offset_us
        if link.now_us is not None:
            link.now_us = now_us
        link.bus.receive()
        if now_us >= until_us:
            return now_us
        select.select([link.bus], [], [], (until_us - now_us) * 1e-6)


def _time_us(payload: bytes) -> int:
    return int(struct.unpack(">q", payload[_TIME])[0])


def _wall_us() -> int:
    return time.monotonic_ns() // 1000
