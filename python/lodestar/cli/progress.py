# SPDX-License-Identifier: Apache-2.0
"""How far a study is: a bar in a terminal, a line a minute in a file."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import timedelta

import typer

EVERY_S = 60.0

Advance = Callable[[int, int], None]
"""Told how many flights are done, and of how many."""


class Lines:
    """Writes a line whenever a minute has gone by: done, time gone, time left.

    The time that is left goes by the flights since the first call: what was there before cost none.
    """

    def __init__(
        self,
        name: str,
        write: Callable[[str], None],
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._name = name
        self._write = write
        self._clock = clock
        self._begin: tuple[float, int] | None = None
        self._written_s = 0.0

    def __call__(self, done: int, total: int) -> None:
        """So many flights are done."""
        now = self._clock()
        if self._begin is None:
            self._begin = (now, done)
            self._written_s = now
        if now - self._written_s < EVERY_S:
            return
        begin_s, before = self._begin
        gone = now - begin_s
        left = gone * (total - done) / (done - before) if done > before else None
        self._write(
            f"{self._name}: {done} of {total} flights after {_clock_time(gone)}, "
            f"{'?' if left is None else _clock_time(left)} left"
        )
        self._written_s = now


@contextmanager
def flights(name: str) -> Iterator[Advance]:
    """Shows on stderr how far the study ``name`` is."""
    from rich.console import Console
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    console = Console(stderr=True)
    if not console.is_terminal:
        yield Lines(name, lambda line: typer.echo(line, err=True))
        return
    with Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("flights"),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        console=console,
        transient=True,
        # Flights take seconds; the time that is left is told from the last ten minutes of them.
        speed_estimate_period=600,
    ) as progress:
        bar = progress.add_task(name, total=None)
        yield lambda done, total: progress.update(bar, completed=done, total=total)


def _clock_time(seconds: float) -> str:
    return str(timedelta(seconds=round(seconds)))
