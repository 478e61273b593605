# SPDX-License-Identifier: Apache-2.0
"""What tests of more than one folder use."""

import sys

import pytest

from lodestar.cli.main import main


@pytest.fixture
def lodestar(monkeypatch, capfd, tmp_path):
    """Runs the program in this process, in a folder of its own: (exit status, stdout, stderr)."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["lodestar", *map(str, arguments)])
        with pytest.raises(SystemExit) as ended:
            main()
        out, err = capfd.readouterr()
        return ended.value.code or 0, out, err

    return run
