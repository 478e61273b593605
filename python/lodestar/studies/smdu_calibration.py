# SPDX-License-Identifier: Apache-2.0
"""The flight computer's own calibration of the magnetic detector, over a recording.

``b_cal = (I + D) b_raw + bias`` (SAHRS paper §5). In flight a Kalman filter of all twelve numbers
with the INS as reference, on the ground bias and one common scale from a swing through the
headings: the same C++ code as in lodestar-fc, and the same file.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodestar import _core
from lodestar.errors import InputError
from lodestar.recordings.recording import Channel, Recording

Array = NDArray[np.float64]

STATES = (
    *(f"bias {axis}" for axis in "xyz"),
    *(f"D {row}{column}" for row, column in ("xx", "yy", "zz")),
    *(f"D {row}{column}" for row, column in ("xy", "xz", "yx", "yz", "zx", "zy")),
)
"""What x is made of: bias in nT, the diagonal of D, its other elements row by row."""


@dataclass(frozen=True)
class Calibration:
    """A calibration, how well it is known, and whether it is worth storing."""

    x: Array
    """(12,), see STATES."""
    P: Array
    """(12, 12), covariance of x."""
    verdict: str
    """"good", or why not."""
    checks: dict[str, tuple[float, float]]
    """Value and limit."""
    airframe: str
    time_us: int
    epoch_year: float
    ground: bool

    @property
    def sigma(self) -> Array:
        """(12,), standard deviations of x."""
        sigma: Array = np.sqrt(np.diag(self.P))
        return sigma

    @property
    def matrix(self) -> Array:
        """(3, 3), I + D."""
        matrix: Array = np.diag(1.0 + self.x[3:6])
        matrix[~np.eye(3, dtype=bool)] = self.x[6:]
        return matrix

    def apply(self, b_B: Array) -> Array:
        """Calibrated field (n, 3) in nT of the raw field (n, 3)."""
        calibrated: Array = b_B @ self.matrix.T + self.x[:3]
        return calibrated

    @property
    def good(self) -> bool:
        """Whether it is worth storing."""
        return self.verdict == "good"


def calibrate(
    recording: Recording,
    config: str = "",
    *,
    ground: bool = False,
    window_s: tuple[float, float] = (-np.inf, np.inf),
) -> Calibration:
    """Calibrate SMDU by INS over a recording, of a flight or (``ground``) of a swing.

    ``config`` is the TOML text of the flight computer; ``window_s`` are times of validity.
    Raises InputError when a channel is missing or the configuration is bad.
    """
    for name in ("SMDU", "INS"):
        if name not in recording:
            raise InputError(f"calibration: the recording has no {name}")
    ins, smdu = (_between(recording[name], window_s) for name in ("INS", "SMDU"))
    run = _core.calibrate_ground if ground else _core.calibrate_flight
    try:
        result: dict[str, Any] = run(config, ins, smdu)
    except _core.ConfigError as error:
        raise InputError(str(error)) from None
    return Calibration(**result, ground=ground)


def _between(channel: Channel, window_s: tuple[float, float]) -> Channel:
    time_s = channel["time_us"] * 1e-6
    rows = (time_s >= window_s[0]) & (time_s <= window_s[1])
    return {name: values[rows] for name, values in channel.items()}


def store(calibration: Calibration, path: Path) -> None:
    """Store a good calibration for lodestar-fc; the one before is kept as ``path``.previous.

    Raises ValueError if it is not good, and InputError where it cannot be written.
    """
    if not calibration.good:
        raise ValueError(f"calibration: {calibration.verdict}")
    c = calibration
    try:
        _core.store_calibration(str(path), c.airframe, c.time_us, c.epoch_year, c.ground, c.x, c.P)
    except _core.StorageError as error:
        raise InputError(str(error)) from None
