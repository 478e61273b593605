# SPDX-License-Identifier: Apache-2.0
"""Recordings as one npz file whose keys are ``CHANNEL/field``, for work in NumPy."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodestar import channels as table
from lodestar.errors import InputError
from lodestar.recordings.recording import Recording

MAGIC = b"PK"


def write_npz(recording: Recording, path: Path) -> None:
    """Write every field, and ``arrival_us``, of every channel. Raises InputError if it cannot."""
    arrays: dict[str, Any] = {
        f"{name}/{field}": column
        for name, columns in recording.channels.items()
        for field, column in columns.items()
    }
    try:
        with path.open("wb") as file:
            np.savez(file, **arrays)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None


def read_npz(path: Path) -> Recording:
    """Read a file of write_npz, or one made by hand with the same keys.

    ``CHANNEL/arrival_us`` may be missing: messages then arrive at their ``time_us``. Keys of
    unknown channels are left out and said in ``notes``.

    Raises InputError for a file that is missing, foreign or truncated, and for a channel whose
    fields do not agree with the LCM type.
    """
    by_channel: dict[str, dict[str, NDArray[Any]]] = {}
    unknown = []
    for key, column in _arrays(path).items():
        name, _, field = key.rpartition("/")
        if name in table.CHANNELS:
            by_channel.setdefault(name, {})[field] = column
        else:
            unknown.append(key)
    recording = Recording()
    if unknown:
        recording.notes.append(f"{path}: unknown keys left out: {', '.join(sorted(unknown))}")
    if not by_channel:
        raise InputError(f"{path}: no key is CHANNEL/field of a known channel")
    for name, columns in by_channel.items():
        arrival = columns.pop("arrival_us", None)
        try:
            recording.put(name, columns, arrival)
        except InputError as error:
            raise InputError(f"{path}: {error}") from None
    return recording


def _arrays(path: Path) -> dict[str, NDArray[Any]]:
    try:
        with path.open("rb") as file:
            if file.read(len(MAGIC)) != MAGIC:
                raise InputError(f"{path}: not an npz file")
        with np.load(path, allow_pickle=False) as archive:
            return {key: archive[key] for key in archive.files}
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}") from None
    except (zipfile.BadZipFile, ValueError, EOFError, KeyError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{path}: damaged npz file ({error})") from None
