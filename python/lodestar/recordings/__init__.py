# SPDX-License-Identifier: Apache-2.0
"""Recordings: LCM logs, npz files and importers of other people's formats."""

from pathlib import Path

from lodestar.errors import InputError
from lodestar.recordings import log, npz
from lodestar.recordings.recording import Recording

__all__ = ["Recording", "load", "save"]


def load(path: Path, *, strict: bool = True) -> Recording:
    """Read a recording, an LCM log or an npz file as its first bytes say.

    ``strict`` as in log.read_log. Raises InputError for a missing, foreign or damaged file.
    """
    try:
        with path.open("rb") as file:
            head = file.read(len(log.MAGIC))
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    if head == log.MAGIC:
        return log.read_log(path, strict=strict)
    if head.startswith(npz.MAGIC):
        return npz.read_npz(path)
    raise InputError(f"{path}: neither an LCM log nor an npz file")


def save(recording: Recording, path: Path) -> None:
    """Write a recording in the format its suffix names: .lcm or .npz.

    Raises InputError for another suffix and for a file that cannot be written.
    """
    writers = {".lcm": log.write_log, ".npz": npz.write_npz}
    if path.suffix not in writers:
        raise InputError(f"{path}: suffix {path.suffix or 'missing'}, must be .lcm or .npz")
    writers[path.suffix](recording, path)
