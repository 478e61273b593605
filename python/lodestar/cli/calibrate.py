# SPDX-License-Identifier: Apache-2.0
"""Command ``lodestar calibrate``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lodestar.cli.common import FLIGHT_FAILED, ConfigOption, fail, given_or_shipped
from lodestar.errors import InputError
from lodestar.harness import CONFIG, LOG

if TYPE_CHECKING:
    from lodestar.studies.smdu_calibration import Calibration

EXAMPLE = "Example: lodestar calibrate out/ordinary/flight.lcm -o smdu.cal"


def command(
    flight: Annotated[
        Path, typer.Argument(metavar="FLIGHT", help="An LCM log or an npz file with SMDU and INS.")
    ],
    target: Annotated[
        Path | None,
        typer.Option(
            "-o", "--output", metavar="FILE", help="Where to store it; otherwise it is only told."
        ),
    ] = None,
    ground: Annotated[
        bool,
        typer.Option(
            "--ground", help="FLIGHT is a swing through the headings, level on the ground."
        ),
    ] = False,
    config: ConfigOption = None,
    start_s: Annotated[
        float,
        typer.Option("--from", metavar="S", help="Use the flight from this time on, s."),
    ] = float("-inf"),
    end_s: Annotated[
        float, typer.Option("--to", metavar="S", help="Use the flight up to this time, s.")
    ] = float("inf"),
) -> None:
    """Calibrate the magnetic detector by the INS of a flight; for the next flight, not for this.

    Ends with 1, and stores nothing, if the flight is not good enough for it.
    """
    from lodestar import recordings
    from lodestar.studies import smdu_calibration

    result = smdu_calibration.calibrate(
        recordings.load(flight),
        _config_text(flight, config),
        ground=ground,
        window_s=(start_s, end_s),
    )
    _tell(result)
    if not result.good:
        fail(f"{flight}: {result.verdict}; nothing is stored", FLIGHT_FAILED)
    if target is not None:
        smdu_calibration.store(result, target)
        typer.echo(f"stored in {target}")


def _config_text(flight: Path, config: Path | None) -> str:
    """The configuration a person names, or the one that the run of fly left beside its log."""
    path = given_or_shipped(config) if config else flight.parent / CONFIG
    if config is None and (flight.name != LOG or not path.exists()):
        return ""
    try:
        return path.read_text()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot read {path}: {error}") from None


def _tell(calibration: Calibration) -> None:
    from lodestar.studies.smdu_calibration import STATES

    for name, value, sigma in zip(STATES, calibration.x, calibration.sigma, strict=True):
        bias = name.startswith("bias")
        shown = f"{value:9.1f} ± {sigma:.1f} nT" if bias else f"{value:9.5f} ± {sigma:.5f}"
        typer.echo(f"{name:8}{shown}")
    for name, (value, limit) in calibration.checks.items():
        typer.echo(f"{name:15}{value:10.4g}   limit {limit:g}")
    typer.echo(f"verdict: {calibration.verdict}")
