# SPDX-License-Identifier: Apache-2.0
"""A study that writes to a file says how far it is, once a minute."""

from __future__ import annotations

import pytest

from lodestar.cli.progress import Lines, flights


def told(calls: list[tuple[float, int]], total: int = 100) -> list[str]:
    """What is written when so many flights are done at these times (s)."""
    written: list[str] = []
    times = iter([time_s for time_s, _ in calls])
    lines = Lines("study", written.append, clock=lambda: next(times))
    for _, done in calls:
        lines(done, total)
    return written


def test_a_line_a_minute_says_what_is_done_and_what_is_left() -> None:
    assert told([(5.0, 0), (35.0, 5), (65.0, 10), (95.0, 15), (125.0, 20)]) == [
        "study: 10 of 100 flights after 0:01:00, 0:09:00 left",
        "study: 20 of 100 flights after 0:02:00, 0:08:00 left",
    ]


def test_flights_of_an_earlier_go_do_not_shorten_what_is_left() -> None:
    assert told([(0.0, 80), (120.0, 90)]) == [
        "study: 90 of 100 flights after 0:02:00, 0:02:00 left"
    ]


def test_before_the_first_flight_nobody_knows_what_is_left() -> None:
    assert told([(0.0, 50), (60.0, 50)]) == ["study: 50 of 100 flights after 0:01:00, ? left"]


def test_a_short_study_writes_nothing() -> None:
    assert told([(0.0, 0), (20.0, 50), (40.0, 100)]) == []


def test_where_there_is_no_terminal_lines_are_written(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("FORCE_COLOR", raising=False)
    with flights("study") as advance:
        assert isinstance(advance, Lines)
