# SPDX-License-Identifier: Apache-2.0
"""What fly, replay and score end with: the score, told and written into the run folder."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from lodestar.cli.common import FLIGHT_FAILED
from lodestar.errors import InputError
from lodestar.harness import CONFIG, LOG

if TYPE_CHECKING:
    from lodestar.evaluation.score import Score
    from lodestar.recordings import Recording

SCORE = "score.json"
REPORT = "report.html"
PLOTS = "plots"


def write(recording: Recording, score: Score, folder: Path, description: str = "") -> None:
    """Write score, report and plots of a run into its folder."""
    from lodestar.evaluation.plots import render, write_plots
    from lodestar.evaluation.report import write_report

    (folder / SCORE).write_text(_json(score) + "\n")
    images = render(recording, score)
    write_plots(recording, score, folder / PLOTS, images)
    write_report(recording, score, folder / REPORT, description=description, images=images)


def tell(score: Score, folder: Path, *, as_json: bool) -> None:
    """Print the table, or the JSON object.

    Raises typer.Exit with FLIGHT_FAILED if the flight failed its score.
    """
    from lodestar.evaluation.tables import print_table

    if as_json:
        typer.echo(_json(score))
    else:
        print_table(score)
        typer.echo(f"report: {folder / REPORT}")
    if not score.passed:
        raise typer.Exit(FLIGHT_FAILED)


def _json(score: Score) -> str:
    return json.dumps(score.to_json(), indent=2)


def run_folder(path: Path) -> Path:
    """Make the folder of a run, without what an earlier run left there.

    Raises InputError where it cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
        for old in (LOG, CONFIG, SCORE, REPORT):
            (path / old).unlink(missing_ok=True)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    return path


def read_summary(folder: Path) -> dict[str, Any]:
    """What a run said of itself; nothing for one that was stopped.

    Raises InputError for a file that is not what fly writes.
    """
    path = folder / SCORE
    if not path.exists():
        return {}
    try:
        summary = json.loads(path.read_text())
    except (OSError, ValueError):
        summary = None
    if not isinstance(summary, dict):
        raise InputError(f"{path}: not the JSON object that lodestar fly writes")
    return summary
