# SPDX-License-Identifier: Apache-2.0
"""The process under test: start lodestar-fc, stop it, and know how it ended."""

from __future__ import annotations

import ctypes
import os
import shutil
import signal
import subprocess
import sys
import sysconfig
import tempfile
import time
from pathlib import Path
from typing import IO

from lodestar.errors import InputError
from lodestar.harness.bus import Bus

_PR_SET_PDEATHSIG = 1
_BAD_INPUT = 2
_SAYS = "lodestar-fc: "

_libc = ctypes.CDLL(None)


class FlightComputerError(RuntimeError):
    """The flight computer ended, or fell silent, when it should not have."""


def find_executable() -> Path:
    """lodestar-fc: $LODESTAR_FC, else the one installed with this Python, else the one on PATH.

    Raises InputError when there is none.
    """
    given = os.environ.get("LODESTAR_FC")
    beside = [Path(sys.executable).parent, Path(sysconfig.get_path("scripts"))]
    places = [Path(given)] if given else [folder / "lodestar-fc" for folder in beside]
    on_path = None if given else shutil.which("lodestar-fc")
    places += [Path(on_path)] if on_path else []
    for place in places:
        if os.access(place, os.X_OK) and place.is_file():
            return place
    raise InputError(
        f"lodestar-fc: not found at {given} ($LODESTAR_FC)"
        if given
        else "lodestar-fc: not found beside Python nor on PATH; install lodestar or set LODESTAR_FC"
    )


class FlightComputer:
    """lodestar-fc on the bus of ``bus``, as a context manager.

    Entering starts the process and waits for its first HEALTH; leaving stops it. It dies with this
    process, and Ctrl-C in a terminal reaches this process alone, which stops it in order.
    """

    def __init__(
        self,
        bus: Bus,
        *,
        config: Path | None = None,
        calibration: Path | None = None,
        realtime: bool = False,
        timeout_s: float = 10.0,
    ) -> None:
        self._bus = bus
        self._command = [str(find_executable()), "--lcm-url", bus.url]
        self._command += ["--config", str(config)] if config else []
        self._command += ["--calibration", str(calibration)] if calibration else []
        self._command += ["--realtime"] if realtime else []
        self._timeout_s = timeout_s
        self._process: subprocess.Popen[bytes] | None = None
        self._errors: IO[bytes] = tempfile.TemporaryFile()  # noqa: SIM115 (closed by stop)
        self._said = ""

    def __enter__(self) -> FlightComputer:
        self.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()

    @property
    def pid(self) -> int:
        """Process id. Raises RuntimeError before start()."""
        return self._started().pid

    @property
    def exit_status(self) -> int | None:
        """Exit status, negative for a signal; None while it runs."""
        return self._started().poll()

    @property
    def stderr(self) -> str:
        """What the process has written on its standard error."""
        if not self._errors.closed:
            self._said = os.pread(self._errors.fileno(), 1 << 20, 0).decode(errors="replace")
        return self._said

    def start(self) -> None:
        """Start the process and wait for its first HEALTH.

        Raises InputError, in the process's own words, if it refuses what it was given, and
        FlightComputerError if it ends or is silent for ``timeout_s``.
        """
        self._process = subprocess.Popen(
            self._command,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=self._errors,
            start_new_session=True,
            preexec_fn=_die_with_parent,
        )
        try:
            self._wait_for_health()
        except BaseException:
            self.stop()
            raise

    def stop(self, timeout_s: float = 5.0) -> int:
        """Ask the process to end (SIGTERM), kill it if it does not, and return its exit status."""
        process = self._started()
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
            try:
                process.wait(timeout_s)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        _ = self.stderr
        self._errors.close()
        return process.returncode

    def require_running(self) -> None:
        """Raise FlightComputerError, with its last words, if the process has ended."""
        status = self.exit_status
        if status is not None:
            raise FlightComputerError(f"lodestar-fc ended with status {status}: {self._last_words}")

    @property
    def _last_words(self) -> str:
        lines = self.stderr.strip().splitlines()
        return lines[-1] if lines else "it said nothing"

    def _wait_for_health(self) -> None:
        deadline = time.monotonic() + self._timeout_s
        while time.monotonic() < deadline:
            try:
                self._bus.wait_for("HEALTH", timeout_s=0.05)
            except TimeoutError:
                if self.exit_status == _BAD_INPUT:
                    raise InputError(self._last_words.removeprefix(_SAYS)) from None
                self.require_running()
            else:
                return
        raise FlightComputerError(
            f"lodestar-fc: no HEALTH within {self._timeout_s:g} s on {self._bus.url}"
        )

    def _started(self) -> subprocess.Popen[bytes]:
        if self._process is None:
            raise RuntimeError("lodestar-fc: not started")
        return self._process


def _die_with_parent() -> None:
    _libc.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)


def replay(
    log: Path, output: Path, *, config: Path | None = None, calibration: Path | None = None
) -> None:
    """Run an LCM log through the flight computer, as fast as it goes, into the LCM log ``output``.

    Raises InputError, in the process's own words, if it refuses what it was given, and
    FlightComputerError if it ends in any other way than well.
    """
    command = [str(find_executable()), "--replay", str(log), "--output", str(output)]
    command += ["--config", str(config)] if config else []
    command += ["--calibration", str(calibration)] if calibration else []
    ended = subprocess.run(
        command, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace"
    )
    last_words = (ended.stderr.strip().splitlines() or ["it said nothing"])[-1]
    if ended.returncode == _BAD_INPUT:
        raise InputError(last_words.removeprefix(_SAYS))
    if ended.returncode != 0:
        raise FlightComputerError(
            f"lodestar-fc --replay ended with status {ended.returncode}: {last_words}"
        )
