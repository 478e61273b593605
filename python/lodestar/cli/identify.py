# SPDX-License-Identifier: Apache-2.0
"""Command ``lodestar identify``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lodestar.cli import outcome
from lodestar.cli.common import JsonOption, OutOption
from lodestar.errors import InputError
from lodestar.harness import LOG

if TYPE_CHECKING:
    from lodestar.studies.identification import ErrorSeries

EXAMPLE = "Example: lodestar identify out/ordinary/flight.lcm --validate out/other/flight.lcm"
OBJECT = "identification.json"
PLOTS = "plots"


def command(
    flight: Annotated[
        Path,
        typer.Argument(metavar="FLIGHT", help="An LCM log or an npz file with SAHRS's answers."),
    ],
    validate: Annotated[
        Path | None,
        typer.Option("--validate", metavar="FLIGHT", help="Another flight, to test the models on."),
    ] = None,
    interval_s: Annotated[
        float, typer.Option("--ts", metavar="S", min=0.001, max=3600.0, help="Sampling time, s.")
    ] = 1.0,
    reference: Annotated[
        str, typer.Option("--reference", metavar="ins|truth", help="What SAHRS is compared with.")
    ] = "ins",
    out: OutOption = None,
    as_json: JsonOption = False,
) -> None:
    """Identify the error models of SAHRS: time constants of heading, pitch and roll error."""
    from lodestar.evaluation.tables import print_tables
    from lodestar.studies.identification import REFERENCES, identify, tables, to_json
    from lodestar.studies.identification_plots import write_plots

    if reference not in REFERENCES:
        raise InputError(f"reference {reference}: unknown; allowed are {', '.join(REFERENCES)}")
    series = _errors(flight, reference, interval_s)
    other = _errors(validate, reference, interval_s) if validate else None
    found = identify(series, other, reference)
    text = json.dumps(to_json(found), indent=2)
    folder = out or Path("out") / f"{_stem(flight)}-identify"
    write_plots(found, folder / PLOTS)
    try:
        (folder / OBJECT).write_text(text + "\n")
    except OSError as error:
        raise InputError(f"{folder / OBJECT}: {error.strerror}") from None
    if as_json:
        typer.echo(text)
        return
    print_tables(tables(found))
    typer.echo(f"plots: {folder / PLOTS}")


def _errors(flight: Path, reference: str, interval_s: float) -> ErrorSeries:
    from lodestar import recordings
    from lodestar.studies.identification import error_series

    return error_series(
        recordings.load(flight), str(flight), reference=reference, interval_s=interval_s
    )


def _stem(flight: Path) -> str:
    """What the flight is called: the log of a run of fly as its scenario."""
    before = outcome.read_summary(flight.parent) if flight.name == LOG else {}
    return before.get("scenario") or flight.stem
