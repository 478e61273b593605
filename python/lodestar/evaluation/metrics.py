# SPDX-License-Identifier: Apache-2.0
"""Figures of merit of a series of errors. Samples that are NaN do not count."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lodestar import _core, rotation

Array = NDArray[np.float64]


def rmse(error: Array) -> float:
    """Root of the mean square; NaN when no sample counts."""
    counted = error[~np.isnan(error)]
    return float(np.sqrt(np.mean(counted**2))) if len(counted) else float("nan")


def maximum(error: Array) -> float:
    """Largest magnitude; NaN when no sample counts."""
    counted = error[~np.isnan(error)]
    return float(np.max(np.abs(counted))) if len(counted) else float("nan")


def coverage(error: Array, sigma: Array, multiple: float) -> float:
    """Share of samples within ``multiple`` sigma; NaN when no sample counts."""
    counted = ~(np.isnan(error) | np.isnan(sigma))
    if not counted.any():
        return float("nan")
    return float(np.mean(np.abs(error[counted]) <= multiple * sigma[counted]))


def north_east_m(lat: Array, lon: Array, ref_lat: Array, ref_lon: Array, ref_h: Array) -> Array:
    """Horizontal offset (n, 2) in m, north and east, of a position from a reference (rad, m)."""
    north = (lat - ref_lat) * (_core.meridian_radius(ref_lat) + ref_h)
    radius = (_core.transverse_radius(ref_lat) + ref_h) * np.cos(ref_lat)
    return np.column_stack([north, rotation.wrap_pi(lon - ref_lon) * radius])


@dataclass(frozen=True)
class Gap:
    """A silence of a sensor, in us: from the first message that did not come to the next that did.

    Where none came any more, to the end.
    """

    start_us: int
    end_us: int

    @property
    def duration_s(self) -> float:
        """Length of the gap."""
        return (self.end_us - self.start_us) * 1e-6


def gaps(time_us: NDArray[np.int64], end_us: int, longest_us: int) -> list[Gap]:
    """Where messages are more than ``longest_us`` apart, or the last is so long before the end."""
    times = np.unique(time_us)
    if len(times) < 2:
        return []
    usual = int(np.median(np.diff(times)))
    edges = np.append(times, max(end_us, int(times[-1])))
    found = np.flatnonzero(np.diff(edges) > longest_us)
    return [Gap(int(edges[i]) + usual, int(edges[i + 1])) for i in found]
