# SPDX-License-Identifier: Apache-2.0
"""What the studies of bad input share: when a fault lasts, and what HEALTH counted meanwhile."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lodestar.channels import INPUTS
from lodestar.evaluation.health_plots import REASONS
from lodestar.harness.faults import Fault
from lodestar.recordings.recording import Recording

Rows = NDArray[np.bool_]

RECOVERY_S = 30.0
"""After the end of a fault, from when on the errors count as those after it."""


@dataclass(frozen=True)
class Window:
    """From when to when something is wrong, s of flight time."""

    start_s: float
    end_s: float

    @classmethod
    def of(cls, faults: Sequence[Fault]) -> Window:
        """From the first to the last moment of the faults."""
        return cls(
            min(fault.start_s for fault in faults),
            max(fault.start_s + fault.duration_s for fault in faults),
        )

    def rows(self, time_us: NDArray[np.int64]) -> dict[str, Rows]:
        """Which of the times are ``during`` it, and which RECOVERY_S or more ``after`` it."""
        return {
            "during": (time_us >= self.start_s * 1e6) & (time_us < self.end_s * 1e6),
            "after": time_us >= (self.end_s + RECOVERY_S) * 1e6,
        }

    def grown(self, answered: Recording, counter: str) -> NDArray[np.int64]:
        """By how much a counter of HEALTH grew meanwhile."""
        health = answered["HEALTH"]
        first, last = np.searchsorted(health["time_us"] * 1e-6, [self.start_s, self.end_s])
        counts = health[counter]
        return np.asarray(counts[min(last, len(counts) - 1)] - counts[first])


def reasons(channels: Sequence[str]) -> list[str]:
    """Names of the figures of refused_messages."""
    return [f"{channel} {reason}" for channel in channels for reason in REASONS]


def refused_messages(
    answered: Recording, window: Window, channels: Sequence[str]
) -> Iterator[tuple[str, float]]:
    """How many messages were refused meanwhile, by channel and reason."""
    rejected = window.grown(answered, "rejected")
    counts = (count for channel in channels for count in rejected[INPUTS.index(channel)])
    for name, count in zip(reasons(channels), counts, strict=True):
        yield name, float(count)
