# SPDX-License-Identifier: Apache-2.0
"""What the subcommands share: exit codes, errors, options."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, NoReturn

import typer

from lodestar.harness.isolation import DEFAULT_URL

FLIGHT_FAILED = 1
BAD_INPUT = 2
INTERRUPTED = 130

ConfigOption = Annotated[
    Path | None,
    typer.Option(
        "--config",
        metavar="FILE",
        help="Configuration of the flight computer: a TOML file, or the name of a shipped one.",
    ),
]
CalibrationOption = Annotated[
    Path | None,
    typer.Option(
        "--calibration",
        metavar="FILE",
        help="Calibration of the magnetic detector: a stored one, which a good flight replaces, or "
        "TOML.",
    ),
]
OutOption = Annotated[
    Path | None,
    typer.Option("--out", metavar="DIR", help="The run folder; one in out/ by default."),
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]
BusOption = Annotated[
    str,
    typer.Option("--bus", metavar="URL", help="An LCM URL; 'default' is LCM's own on this host."),
]


def given_or_shipped(path: Path) -> Path:
    """The file that a person names, or the shipped one of that name.

    Raises InputError where there is neither.
    """
    from lodestar.paths import config_path

    return path if path.exists() or path.parent != Path() else config_path(path.name)


def bus_url(given: str) -> str:
    """The LCM URL that a person means."""
    return DEFAULT_URL if given == "default" else given


def fail(message: str, status: int) -> NoReturn:
    """Say one line on stderr and exit."""
    print(f"error: {' '.join(message.split())}", file=sys.stderr)
    sys.exit(status)
