# SPDX-License-Identifier: Apache-2.0
"""A study's command has its own options and those of every study."""

from pathlib import Path
from types import SimpleNamespace
from typing import Annotated

import pytest
import typer
from typer.testing import CliRunner

from lodestar.cli import study_command as module
from lodestar.cli.study_command import Campaign, study_command


def test_each_option_goes_where_it_belongs(monkeypatch: pytest.MonkeyPatch) -> None:
    conducted: list[tuple[object, dict[str, object]]] = []
    app = typer.Typer()

    @study_command(app, "walks", 7, "--pace slow")
    def walks(pace: Annotated[str, typer.Option("--pace")] = "fast") -> Campaign:
        """Walks."""
        return SimpleNamespace(study=pace)  # type: ignore[return-value]

    monkeypatch.setattr(
        module, "conduct", lambda chosen, **given: conducted.append((chosen.study, given))
    )
    for words in ([], ["--pace", "slow", "--runs", "2", "--seed-first", "40", "--out", "here"]):
        assert CliRunner().invoke(app, words, catch_exceptions=False).exit_code == 0

    common = {"workers": None, "redraw": False, "as_json": False}
    assert conducted == [
        ("fast", {"runs": 7, "seed_first": 1, "out": None, **common}),
        ("slow", {"runs": 2, "seed_first": 40, "out": Path("here"), **common}),
    ]


def test_help_tells_the_options_of_both_and_the_example() -> None:
    app = typer.Typer()

    @study_command(app, "walks", 7, "--pace slow")
    def walks(pace: Annotated[str, typer.Option("--pace")] = "fast") -> Campaign:
        """Walks."""
        raise AssertionError

    told = CliRunner().invoke(app, ["--help"]).output

    assert "Walks." in told
    assert "--pace" in told
    assert "--seed-first" in told
    assert "Example: lodestar monte-carlo walks --pace slow" in told
