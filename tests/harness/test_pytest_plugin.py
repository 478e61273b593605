# SPDX-License-Identifier: Apache-2.0
import os
import subprocess
import sys
from pathlib import Path

import pytest

from lodestar.errors import InputError
from lodestar.harness.faults import Fault

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "my_hil_test.py"


def pytest_run(path: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(path)]
    return subprocess.run(
        command,
        capture_output=True,
        text=True,
        cwd=path.parent,
        env={**os.environ, **environment},
        timeout=200,
    )


def test_the_example_of_a_hil_test_passes_as_it_is():
    ended = pytest_run(EXAMPLE)
    assert ended.returncode == 0, ended.stdout
    assert "1 passed" in ended.stdout


def test_the_plugin_imports_nothing_heavy():
    script = (
        "import sys, lodestar.harness.pytest_plugin\n"
        "print(sorted({'numpy', 'lcm', 'scipy', 'matplotlib', 'rich'} & set(sys.modules)))"
    )
    said = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert said.stdout.strip() == "[]"


def test_without_the_process_only_the_tests_that_want_it_fail_and_say_why(tmp_path):
    path = tmp_path / "test_mine.py"
    path.write_text("def test_a(bus): pass\ndef test_b(flight_computer): pass\n")
    ended = pytest_run(path, LODESTAR_FC=str(tmp_path / "nothing"))
    assert "1 passed" in ended.stdout
    assert "1 error" in ended.stdout
    assert "lodestar-fc: not found at" in ended.stdout


def test_a_scenario_can_be_changed(scenario):
    changed = scenario("ordinary", duration_s=60)
    assert (changed.name, changed.duration_s) == ("ordinary", 60)


def test_a_fault_that_does_not_fit_is_refused(scenario):
    with pytest.raises(ValueError, match="GPS"):
        scenario("ordinary", faults=[Fault("spoof", "SMDU", start_s=1, value=2.0)])


def test_an_unknown_scenario_is_refused_by_name(fly):
    with pytest.raises(InputError, match="scenario nowhere: unknown"):
        fly("nowhere")
