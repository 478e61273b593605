# SPDX-License-Identifier: Apache-2.0
"""Command ``lodestar convert``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

EXAMPLE = "Example: lodestar convert out/ordinary/flight.lcm flight.npz"


def command(
    source: Annotated[Path, typer.Argument(metavar="FROM", help="An LCM log or an npz file.")],
    target: Annotated[Path, typer.Argument(metavar="TO", help="A path that ends in .lcm or .npz.")],
) -> None:
    """Convert a recording between an LCM log and an npz file with keys CHANNEL/field."""
    from lodestar import recordings

    recording = recordings.load(source)
    for note in recording.notes:
        typer.echo(note, err=True)
    recordings.save(recording, target)
    typer.echo(f"{target}: {sum(len(c['time_us']) for c in recording.channels.values())} messages")
