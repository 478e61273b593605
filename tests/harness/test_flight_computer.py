# SPDX-License-Identifier: Apache-2.0
"""How the harness treats a process that misbehaves; the real one is in tests/hil."""

import signal
import time
from pathlib import Path

import pytest

from lodestar.errors import InputError
from lodestar.harness.flight_computer import (
    FlightComputer,
    FlightComputerError,
    find_executable,
    replay,
)


@pytest.fixture
def impostor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Puts a shell script in the place of lodestar-fc."""

    def install(script: str) -> Path:
        path = tmp_path / "lodestar-fc"
        path.write_text(f"#!/bin/sh\n{script}\n")
        path.chmod(0o755)
        monkeypatch.setenv("LODESTAR_FC", str(path))
        return path

    return install


def wait_for_file(path: Path) -> None:
    while not path.exists():
        time.sleep(0.001)


def gone(pid: int) -> bool:
    return not Path(f"/proc/{pid}").exists()


def test_bad_input_is_said_in_the_words_of_the_process(bus, impostor):
    impostor("echo 'starting' >&2; echo 'lodestar-fc: my.toml:3: key x: unknown' >&2; exit 2")
    with pytest.raises(InputError) as caught:
        FlightComputer(bus).start()
    assert str(caught.value) == "my.toml:3: key x: unknown"


def test_an_early_end_is_said_with_status_and_last_words(bus, impostor):
    impostor("echo 'out of luck' >&2; exit 7")
    with pytest.raises(FlightComputerError, match=r"status 7: out of luck"):
        FlightComputer(bus).start()


def test_silence_is_an_error_and_the_process_is_stopped(bus, impostor):
    impostor("exec sleep 60")
    computer = FlightComputer(bus, timeout_s=0.2)
    with pytest.raises(FlightComputerError, match="no HEALTH"):
        computer.start()
    assert computer.exit_status == -signal.SIGTERM
    assert gone(computer.pid)


def test_a_process_that_does_not_listen_is_killed(bus, impostor, tmp_path, monkeypatch):
    impostor(f"trap '' TERM; touch {tmp_path}/deaf; while true; do sleep 0.05; done")
    monkeypatch.setattr(
        FlightComputer, "_wait_for_health", lambda self: wait_for_file(tmp_path / "deaf")
    )
    computer = FlightComputer(bus)
    computer.start()
    assert computer.stop(timeout_s=0.1) == -signal.SIGKILL


def test_options_reach_the_command_line(bus, impostor, tmp_path):
    impostor(f'echo "$@" > {tmp_path}/said; exit 7')
    computer = FlightComputer(bus, config=Path("a.toml"), calibration=Path("b"), realtime=True)
    with pytest.raises(FlightComputerError):
        computer.start()
    said = (tmp_path / "said").read_text().strip()
    assert said == f"--lcm-url {bus.url} --config a.toml --calibration b --realtime"


def test_stderr_can_be_read_after_the_end(bus, impostor):
    impostor("echo first >&2; echo second >&2; exit 7")
    computer = FlightComputer(bus)
    with pytest.raises(FlightComputerError):
        computer.start()
    assert computer.stderr == "first\nsecond\n"
    assert computer.stop() == 7


def test_not_started_has_no_status(bus, impostor):
    impostor("exit 0")
    with pytest.raises(RuntimeError, match="not started"):
        _ = FlightComputer(bus).exit_status


def test_a_missing_executable_is_named(monkeypatch, tmp_path):
    monkeypatch.setenv("LODESTAR_FC", str(tmp_path / "nothing"))
    with pytest.raises(InputError, match=r"nothing \(\$LODESTAR_FC\)"):
        find_executable()


def test_a_directory_is_no_executable(monkeypatch, tmp_path):
    monkeypatch.setenv("LODESTAR_FC", str(tmp_path))
    with pytest.raises(InputError, match="not found"):
        find_executable()


def test_a_replay_that_is_refused_says_why(impostor, tmp_path):
    impostor("echo 'lodestar-fc: in.lcm: truncated' >&2; exit 2")
    with pytest.raises(InputError, match=r"^in\.lcm: truncated$"):
        replay(tmp_path / "in.lcm", tmp_path / "out.lcm")


def test_a_replay_that_dies_says_how(impostor, tmp_path):
    impostor("kill -SEGV $$")
    with pytest.raises(FlightComputerError, match=rf"status -{int(signal.SIGSEGV)}"):
        replay(tmp_path / "in.lcm", tmp_path / "out.lcm")
