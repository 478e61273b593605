# SPDX-License-Identifier: Apache-2.0
"""Recordings as LCM logs, the format of lcm-logger and lcm-logplayer."""

from __future__ import annotations

import struct
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import lcm
import numpy as np
from numpy.typing import NDArray

from lodestar import channels as table
from lodestar.errors import InputError
from lodestar.recordings import codec
from lodestar.recordings.recording import Recording

MAGIC = b"\xed\xa1\xda\x01"
# Sync word, event number, timestamp (us), length of the channel name, length of the payload.
_HEADER = struct.Struct(">4sqqii")
_LONGEST_CHANNEL_NAME = 63


@dataclass
class _Payloads:
    """Where the payloads of one channel lie in the file."""

    event: list[int] = field(default_factory=list)
    timestamp: list[int] = field(default_factory=list)
    start: list[int] = field(default_factory=list)
    size: list[int] = field(default_factory=list)


def write_log(recording: Recording, path: Path) -> None:
    """Write the recording as an LCM log; the time of each event is its ``arrival_us``.

    Raises InputError when the file cannot be written.
    """
    names = [name for name in table.EVENT_ORDER if name in recording]
    payloads = [codec.encode(name, recording[name]) for name in names]
    arrival, channel, row = recording.event_arrays(names)
    try:
        log = lcm.EventLog(path, "w", overwrite=True)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    try:
        for when, index, number in zip(
            arrival.tolist(), channel.tolist(), row.tolist(), strict=True
        ):
            log.write_event(when, names[index], payloads[index][number])
    finally:
        log.close()


def read_log(path: Path, *, strict: bool = True) -> Recording:
    """Read an LCM log; the timestamps of the log become ``arrival_us``.

    Messages of unknown channels are left out, counted and said in ``notes``. So are malformed
    messages on known channels unless ``strict``: a flight with an injected malformed datagram can
    still be scored.

    Raises InputError for a file that is missing, foreign or truncated, and, when ``strict``, for a
    message with the wrong size or fingerprint.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    found = _index(path, data)
    recording = Recording()
    unknown = {name: len(found.pop(name).event) for name in sorted(found.keys() - table.CHANNELS)}
    if unknown:
        what = ", ".join(f"{name} {count}" for name, count in unknown.items())
        recording.notes.append(f"{path}: messages of unknown channels left out: {what}")
    malformed: Counter[str] = Counter()
    wire = np.frombuffer(data, np.uint8)
    for name in table.CHANNELS:
        if name in found:
            malformed[name] = _decode_channel(path, name, found[name], wire, recording, strict)
    if malformed.total():
        what = ", ".join(f"{name} {count}" for name, count in (+malformed).items())
        recording.notes.append(f"{path}: malformed messages left out: {what}")
    return recording


def _index(path: Path, data: bytes) -> dict[str, _Payloads]:
    """The payloads of every channel, found by walking the event headers."""
    if not data:
        raise InputError(f"{path}: empty, must be an LCM log")
    if not data.startswith(MAGIC):
        raise InputError(f"{path}: not an LCM log (its first bytes are not {MAGIC.hex()})")
    found: dict[bytes, _Payloads] = {}
    offset, event = 0, 0
    while offset < len(data):
        if offset + _HEADER.size > len(data):
            raise InputError(f"{path}: truncated in event {event} (byte {offset})")
        magic, _, timestamp, name_size, size = _HEADER.unpack_from(data, offset)
        if magic != MAGIC or not 0 < name_size <= _LONGEST_CHANNEL_NAME or size < 0:
            raise InputError(f"{path}: damaged at event {event} (byte {offset})")
        start = offset + _HEADER.size + name_size
        offset = start + size
        if offset > len(data):
            raise InputError(f"{path}: truncated in event {event} (byte {start})")
        payloads = found.setdefault(data[start - name_size : start], _Payloads())
        payloads.event.append(event)
        payloads.timestamp.append(timestamp)
        payloads.start.append(start)
        payloads.size.append(size)
        event += 1
    return {name.decode("ascii", "backslashreplace"): one for name, one in found.items()}


def _decode_channel(
    path: Path,
    name: str,
    payloads: _Payloads,
    data: NDArray[np.uint8],
    recording: Recording,
    strict: bool,
) -> int:
    """Put the channel into the recording; returns how many malformed messages were left out."""
    width = codec.wire_dtype(name).itemsize
    complaints = {
        row: f"{size} bytes, must be {width}"
        for row, size in enumerate(payloads.size)
        if size != width
    }
    right_size = np.array(payloads.size) == width
    rows = np.flatnonzero(right_size)
    start = np.array(payloads.start, np.int64)[rows]
    wire = np.empty((0, width), np.uint8)
    if len(rows):
        wire = np.lib.stride_tricks.sliding_window_view(data, width)[start]
    faults = codec.faults(name, wire)
    complaints |= {int(rows[row]): reason for row, reason in faults.items()}
    if strict and complaints:
        row = min(complaints)
        raise InputError(f"{path}: event {payloads.event[row]} on {name}: {complaints[row]}")
    good = np.delete(np.arange(len(rows)), list(faults))
    if len(good):
        arrival = np.array(payloads.timestamp, np.int64)[rows[good]]
        recording.put(name, codec.decode(name, wire[good]), arrival)
    return len(complaints)
