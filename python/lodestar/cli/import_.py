# SPDX-License-Identifier: Apache-2.0
"""Command ``lodestar import``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from lodestar.cli.common import given_or_shipped

EXAMPLE = "Example: lodestar import thor75.npz --map umn_thor75.toml -o thor75.lcm"


def command(
    source: Annotated[Path, typer.Argument(metavar="FILE", help="A CSV, npz or ULog file.")],
    map_path: Annotated[
        Path,
        typer.Option(
            "--map",
            metavar="MAP",
            help="Which column is which field, in which unit and axes: a TOML file, or the name "
            "of a shipped one.",
        ),
    ],
    target: Annotated[
        Path, typer.Option("-o", "--output", metavar="OUT", help="A path in .lcm or .npz.")
    ],
) -> None:
    """Make a recording out of anyone's data, and say what was dropped."""
    from lodestar import recordings
    from lodestar.recordings.importer import import_recording

    recording, report = import_recording(source, given_or_shipped(map_path))
    recordings.save(recording, target)
    for line in report.lines():
        typer.echo(line)
