# SPDX-License-Identifier: Apache-2.0
"""All cores of this machine, one process each."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed

from lodestar.studies.campaign import Result, Task


class LocalPool:
    """A pool of processes; see campaign.Pool."""

    def __init__(self, workers: int | None = None) -> None:
        """``workers``: as many as there are cores by default."""
        self._workers = workers or len(os.sched_getaffinity(0))

    def work(
        self, function: Callable[[Task], list[Result]], tasks: Sequence[Task]
    ) -> Iterator[list[Result]]:
        """The results, as they come. However it ends, no process is left behind."""
        if not tasks:
            return
        strangers = multiprocessing.active_children()
        # Forked, a process would inherit locks that another thread of this one holds just then.
        executor = ProcessPoolExecutor(
            min(self._workers, len(tasks)), multiprocessing.get_context("spawn"), _stay_with_parent
        )
        try:
            for future in as_completed([executor.submit(function, task) for task in tasks]):
                yield future.result()
        except BaseException:
            # What is being flown would take its time to end, and nobody wants it any more.
            for process in multiprocessing.active_children():
                if process not in strangers:
                    process.terminate()
            raise
        finally:
            executor.shutdown(cancel_futures=True)


def _stay_with_parent() -> None:
    """Leave Ctrl-C to the parent, and end when it ends, however it does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()

    def watch() -> None:
        if parent is not None:
            parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
