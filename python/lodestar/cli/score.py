# SPDX-License-Identifier: Apache-2.0
"""Command ``lodestar score``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from lodestar.cli import outcome
from lodestar.cli.common import JsonOption
from lodestar.errors import InputError
from lodestar.harness import LOG

EXAMPLE = "Example: lodestar score out/ordinary"


def command(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="The folder of a run of fly.")],
    as_json: JsonOption = False,
) -> None:
    """Score a flight again, from its log, and write its report again."""
    from lodestar.evaluation.score import score
    from lodestar.recordings.log import read_log

    if not run.is_dir():
        raise InputError(f"{run}: no such folder; lodestar score wants the folder of a run")
    before = outcome.read_summary(run)
    recording = read_log(run / LOG, strict=False)
    result = score(
        recording,
        case=before.get("scenario", run.resolve().name),
        seed=before.get("seed"),
        realtime_factor=before.get("realtime_factor"),
    )
    outcome.write(recording, result, run)
    outcome.tell(result, run, as_json=as_json)
