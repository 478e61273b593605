# SPDX-License-Identifier: Apache-2.0
"""The flight computer process itself: how it starts, what it believes, how it ends."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterable
from pathlib import Path

import pytest
from lodestar.messages import body_rates_t, magnetic_field_t, truth_t

from lodestar import channels as table
from lodestar.errors import InputError
from lodestar.harness.bus import Bus
from lodestar.harness.flight_computer import FlightComputer, find_executable

# Columns of health_t.rejected.
SIZE, FINGERPRINT, DECODE, NOT_FINITE = range(4)


def rates(time_us: int, roll_rate: float = 0.0) -> body_rates_t:
    message = body_rates_t()
    message.time_us, message.valid = time_us, True
    message.omega_B = [roll_rate, 0.0, 0.0]
    return message


def field(time_us: int) -> magnetic_field_t:
    message = magnetic_field_t()
    message.time_us, message.valid = time_us, True
    message.b_B = [16_000.0, 1_000.0, 48_000.0]
    return message


def fly_to_health(bus: Bus, channel: str = "", strays: Iterable[bytes] = ()):
    """Fly a second, with a stray before each of the first frames; the HEALTH at its end."""
    waiting = list(strays)
    for time_us in range(0, 1_100_000, 20_000):
        if waiting:
            bus.publish(channel, waiting.pop())
        # Rates that change: the same for a second would be a stuck sensor.
        bus.publish("EFCS.RATES", rates(time_us, roll_rate=time_us * 1e-9))
        bus.wait_for("SAHRS", lambda answer, at=time_us: answer.time_us == at)
    return bus.wait_for("HEALTH", lambda health: health.time_us >= 1_000_000)


def count(health, channel: str, reason: int) -> int:
    return health.rejected[table.INPUTS.index(channel)][reason]


def test_it_answers_every_frame_with_sahrs_and_nav_of_its_time(bus, flight_computer):
    for time_us in (1_000_000, 1_020_000, 1_040_000):
        bus.publish("EFCS.RATES", rates(time_us))
        assert bus.wait_for("SAHRS").time_us == time_us
        assert bus.wait_for("NAV").time_us == time_us


def test_sigterm_ends_it_in_order(bus):
    with FlightComputer(bus) as computer:
        assert computer.exit_status is None
        os.kill(computer.pid, signal.SIGTERM)
        assert computer.stop() == 0


def test_sigint_ends_it_in_order(bus):
    with FlightComputer(bus) as computer:
        os.kill(computer.pid, signal.SIGINT)
        while computer.exit_status is None:
            time.sleep(0.005)
        assert computer.exit_status == 0


def test_it_ends_with_the_process_that_started_it(bus_url):
    script = (
        "import os, signal\n"
        "from lodestar.harness.bus import Bus\n"
        "from lodestar.harness.flight_computer import FlightComputer\n"
        f"with Bus({bus_url!r}) as bus, FlightComputer(bus) as computer:\n"
        "    print(computer.pid, flush=True)\n"
        "    os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    said = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert said.returncode == -signal.SIGKILL
    assert_ends(int(said.stdout))


def assert_ends(pid: int) -> None:
    stat = Path(f"/proc/{pid}/stat")
    for _ in range(1000):
        # Z: it has ended, and nobody has asked for its status.
        if not stat.exists() or stat.read_text().rpartition(")")[2].split()[0] == "Z":
            return
        time.sleep(0.01)
    os.kill(pid, signal.SIGKILL)
    pytest.fail(f"process {pid} went on without its parent")


def test_a_bad_configuration_is_refused_with_file_line_and_key(bus, tmp_path):
    config = tmp_path / "my.toml"
    config.write_text("[earth]\nepoch_year = 2026.5\nepoch_yeer = 2027\n")
    with pytest.raises(InputError, match=r"my\.toml:3:.*epoch_yeer") as caught:
        FlightComputer(bus, config=config).start()
    assert "\n" not in str(caught.value)
    assert bus.collect("HEALTH") == []


def test_a_missing_configuration_is_refused_by_name(bus, tmp_path):
    with pytest.raises(InputError, match=r"nothing\.toml"):
        FlightComputer(bus, config=tmp_path / "nothing.toml").start()


def test_a_bus_that_is_none_is_refused_in_one_line():
    ended = subprocess.run(
        [find_executable(), "--lcm-url", "udpm://no-such-host:1"],
        capture_output=True,
        text=True,
        timeout=20,
    )
    assert ended.returncode == 2
    assert "udpm://no-such-host:1" in ended.stderr.strip().splitlines()[-1]


@pytest.mark.parametrize(
    ("damage", "reason"),
    [
        (lambda good: b"", SIZE),
        (lambda good: good[:-1], SIZE),
        (lambda good: good + b"\0", SIZE),
        (lambda good: good + bytes(60_000), SIZE),
        (lambda good: bytes(8) + good[8:], FINGERPRINT),
        (lambda good: good[:-1] + b"\2", DECODE),
        (lambda good: good[:16] + b"\x7f\xf8" + good[18:], NOT_FINITE),
    ],
    ids=["empty", "short", "trailing", "huge", "fingerprint", "boolean", "nan"],
)
def test_a_bad_datagram_is_counted_and_does_nothing_else(bus, flight_computer, damage, reason):
    health = fly_to_health(bus, "SMDU", [damage(field(10_000).encode())] * 3)
    assert count(health, "SMDU", reason) == 3
    assert health.received[table.INPUTS.index("SMDU")] == 3
    assert health.used[table.INPUTS.index("SMDU")] == 0
    assert flight_computer.exit_status is None


def test_truth_is_never_listened_to(bus, flight_computer):
    message = truth_t()
    for time_us in range(0, 500_000, 10_000):
        message.time_us = time_us
        bus.publish("TRUTH", message)
    first = fly_to_health(bus)
    frames = first.received[0]
    assert list(first.received) == [frames] + [0] * (len(table.INPUTS) - 1)
    assert sum(map(sum, first.rejected)) == 0
