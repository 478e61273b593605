# SPDX-License-Identifier: Apache-2.0
"""PX4's ULog as named columns: ``topic.field``, with ``topic#1.field`` for a second instance.

Every topic has its own clock, ``topic.timestamp`` in us since boot. Added to what the log holds:
``roll``, ``pitch`` and ``heading`` (rad) wherever a topic has a quaternion ``q``, and the degrees
and metres of newer GPS topics where an older one has integers.
"""

from __future__ import annotations

import contextlib
import io
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodestar import rotation
from lodestar.errors import InputError

MAGIC = b"ULog\x01\x12\x35"

_GPS_TOPICS = ("vehicle_gps_position", "sensor_gps")
_OLD_GPS = {
    "latitude_deg": ("lat", 1e-7),
    "longitude_deg": ("lon", 1e-7),
    "altitude_ellipsoid_m": ("alt_ellipsoid", 1e-3),
}


def read_topics(path: Path) -> dict[str, NDArray[np.float64]]:
    """All columns of a ULog by name.

    Raises InputError for a foreign or damaged file, and where pyulog is not installed.
    """
    with path.open("rb") as file:
        if file.read(len(MAGIC)) != MAGIC:
            raise InputError(f"{path}: not a ULog file")
    try:
        from pyulog import ULog
    except ImportError:
        raise InputError(f"{path}: reading a ULog needs pyulog: pip install pyulog") from None
    # It reports damage on the standard output, and by whatever its decoding stumbles over.
    with contextlib.redirect_stdout(io.StringIO()) as said:
        try:
            log: Any = ULog(str(path))
        except Exception as error:
            raise InputError(f"{path}: damaged ULog ({error})") from None
    if log.file_corruption:
        raise InputError(f"{path}: damaged ULog ({' '.join(said.getvalue().split())})")
    columns: dict[str, NDArray[np.float64]] = {}
    for topic in log.data_list:
        name = topic.name if topic.multi_id == 0 else f"{topic.name}#{topic.multi_id}"
        fields = {key: np.asarray(value, np.float64) for key, value in topic.data.items()}
        all_fields = _derived(topic.name, fields) | fields
        columns |= {f"{name}.{key}": value for key, value in all_fields.items()}
    return columns


def clock_of(name: str) -> str:
    """The column that times another of the same topic."""
    return f"{name.rpartition('.')[0]}.timestamp"


def _derived(topic: str, fields: dict[str, NDArray[np.float64]]) -> dict[str, NDArray[np.float64]]:
    made = {}
    if topic in _GPS_TOPICS:
        made = {new: scale * fields[old] for new, (old, scale) in _OLD_GPS.items() if old in fields}
    if "q[3]" in fields:
        q_NB = np.column_stack([fields[f"q[{i}]"] for i in range(4)])
        angles = rotation.euler_from_C_NB(rotation.C_NB_from_q_NB(q_NB))
        made |= dict(zip(("roll", "pitch", "heading"), angles, strict=True))
    return made
