# SPDX-License-Identifier: Apache-2.0
"""LCM messages to arrays and back, a whole channel at a time.

Every type on the flight bus has a fixed size, so a channel's messages are one NumPy structured
array of big-endian records behind the 8-byte fingerprint.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodestar import channels as table

_HEAD = "fingerprint"


@cache
def wire_dtype(channel: str) -> np.dtype[Any]:
    """The packed record of one message of the channel, fingerprint first.

    Booleans are bytes here: only 0 and 1 may become a bool.
    """
    layout: list[tuple[str, Any, tuple[int, ...]]] = [(_HEAD, ">u8", ())]
    for item in table.fields(channel):
        dtype = np.dtype("u1") if item.wire_dtype.kind == "b" else item.wire_dtype
        layout.append((item.name, dtype, item.shape))
    return np.dtype(layout)


def encode(channel: str, columns: Mapping[str, NDArray[Any]]) -> list[bytes]:
    """The LCM encoding of every message of the channel, fingerprint included."""
    records = np.empty(len(columns["time_us"]), wire_dtype(channel))
    records[_HEAD] = table.fingerprint(channel)
    for item in table.fields(channel):
        records[item.name] = columns[item.name]
    wire = records.tobytes()
    size = records.itemsize
    return [wire[start : start + size] for start in range(0, len(wire), size)]


def faults(channel: str, wire: NDArray[np.uint8]) -> dict[int, str]:
    """What is wrong with which rows of ``wire`` (n, message size): fingerprint or a boolean."""
    records = _records(channel, wire)
    expected = table.fingerprint(channel)
    found = {
        int(row): f"fingerprint {int(records[_HEAD][row]):#018x}, must be {expected:#018x}"
        for row in np.flatnonzero(records[_HEAD] != expected)
    }
    for item in table.fields(channel):
        if item.wire_dtype.kind == "b":
            for row in np.flatnonzero(records[item.name] > 1):
                found.setdefault(
                    int(row), f"{item.name} is {records[item.name][row]}, must be 0 or 1"
                )
    return found


def decode(channel: str, wire: NDArray[np.uint8]) -> dict[str, NDArray[Any]]:
    """The fields of faultless messages ``wire`` (n, message size), as arrays over the messages."""
    records = _records(channel, wire)
    return {item.name: records[item.name].astype(item.dtype) for item in table.fields(channel)}


def _records(channel: str, wire: NDArray[np.uint8]) -> NDArray[Any]:
    return np.ascontiguousarray(wire).reshape(-1).view(wire_dtype(channel))
