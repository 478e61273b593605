# SPDX-License-Identifier: Apache-2.0
"""lodestar-fc --calibration, from flight to flight."""

import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from lodestar import channels, recordings
from lodestar.errors import InputError
from lodestar.harness import flight_computer
from lodestar.harness.replay import replay
from lodestar.harness.scenario import load_scenario, simulate
from lodestar.recordings.log import write_log

CONFIG = '[airframe]\nid = "39-101"\n[earth]\nepoch_year = 2026.5\n'


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    scenario = replace(load_scenario("ordinary"), duration_s=1500, airframe_seed=5)
    path = tmp_path_factory.mktemp("flight") / "inputs.lcm"
    write_log(simulate(scenario, 11).subset(channels.INPUTS), path)
    return path


@pytest.fixture
def config(tmp_path: Path) -> Path:
    path = tmp_path / "config.toml"
    path.write_text(CONFIG)
    return path


def calibration_id(answers: Path) -> int:
    return int(recordings.load(answers)["HEALTH"]["calibration_id"][-1])


def test_a_flight_stores_what_the_next_one_uses(log, config, tmp_path):
    stored = tmp_path / "smdu.cal"
    ids = []
    for _ in range(2):
        flight_computer.replay(log, tmp_path / "a.lcm", config=config, calibration=stored)
        ids.append(calibration_id(tmp_path / "a.lcm"))
    assert ids[0] == 0
    assert ids[1] != 0
    # The same flight calibrates to the same bits, whatever SAHRS made of it.
    assert stored.read_bytes() == (tmp_path / "smdu.cal.previous").read_bytes()


def test_a_damaged_or_foreign_file_is_named_and_the_previous_one_used(log, config, tmp_path):
    stored = tmp_path / "smdu.cal"
    answers = tmp_path / "a.lcm"
    for _ in range(2):
        flight_computer.replay(log, answers, config=config, calibration=stored)
    used = calibration_id(answers)
    damaged = bytearray(stored.read_bytes())
    damaged[200] ^= 1
    stored.write_bytes(damaged)
    command = [flight_computer.find_executable(), "--replay", log, "--output", answers]
    command += ["--config", config, "--calibration", stored]
    ended = subprocess.run(command, capture_output=True, text=True)
    assert ended.returncode == 0
    assert "smdu.cal: damaged: its checksum is wrong; the previous one is used" in ended.stderr
    assert "SMDU calibration: good, stored in" in ended.stderr
    assert calibration_id(answers) == used
    assert (tmp_path / "smdu.cal.refused").read_bytes() == damaged
    config.write_text(CONFIG.replace("101", "102"))
    with pytest.raises(InputError, match=r"smdu\.cal: of another airframe than '39-102'"):
        flight_computer.replay(log, answers, config=config, calibration=stored)


def test_lodestar_replay_leaves_the_file_as_it_is(log, config, tmp_path):
    stored = tmp_path / "smdu.cal"
    flight_computer.replay(log, tmp_path / "a.lcm", config=config, calibration=stored)
    before = stored.read_bytes()
    answered = replay(log, config=config, calibration=stored).recording
    assert answered["HEALTH"]["calibration_id"][-1] != 0
    assert stored.read_bytes() == before
    assert not (tmp_path / "smdu.cal.previous").exists()
    with pytest.raises(InputError, match=r"cannot read .*none\.cal: No such file"):
        replay(log, config=config, calibration=tmp_path / "none.cal")
