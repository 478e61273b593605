# SPDX-License-Identifier: Apache-2.0
"""A recording through the flight computer once more."""

from __future__ import annotations

import shutil
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from lodestar import channels as table
from lodestar import recordings
from lodestar.errors import InputError
from lodestar.harness import flight_computer
from lodestar.recordings import Recording
from lodestar.recordings.log import MAGIC, read_log, write_log


@dataclass(frozen=True)
class Replay:
    """A recording with the outputs that the flight computer gives to it now."""

    recording: Recording
    seconds: float
    """How long the flight computer took, its start included."""


def replay(flight: Path, *, config: Path | None = None, calibration: Path | None = None) -> Replay:
    """Run an LCM log or npz file through lodestar-fc; outputs that it holds already are replaced.

    ``calibration`` is used and stays as it is: what a flight is answered with must not depend on
    how often it was replayed.

    Raises InputError for a file that is missing, foreign or damaged and for a bad configuration,
    and FlightComputerError if the flight computer ends badly.
    """
    recording = recordings.load(flight, strict=False)
    with tempfile.TemporaryDirectory() as folder:
        log, answers = Path(folder, "inputs.lcm"), Path(folder, "answers.lcm")
        if _is_log(flight):
            log = flight  # as it is: what is malformed in it is replayed, too
        else:
            write_log(recording.subset(table.INPUTS), log)
        calibration = calibration and _copied(calibration, Path(folder))
        start = time.monotonic()
        flight_computer.replay(log, answers, config=config, calibration=calibration)
        seconds = time.monotonic() - start
        outputs = read_log(answers)
    kept = {name: one for name, one in recording.channels.items() if name not in table.OUTPUTS}
    return Replay(Recording(kept | outputs.channels, recording.notes), seconds)


def _copied(file: Path, folder: Path) -> Path:
    try:
        return Path(shutil.copy(file, folder))
    except OSError as error:
        raise InputError(f"cannot read {file}: {error.strerror}") from None


def _is_log(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(len(MAGIC)) == MAGIC
