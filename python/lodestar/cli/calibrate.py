# SPDX-License-Identifier: Apache-2.0
"""Command ``lodestar calibrate``."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

EXAMPLE = "Example: lodestar calibrate thor75.lcm --year 2012.78 --from 405 --to 575 -o thor75.toml"


class Model(StrEnum):
    """Names of the geomagnetic models."""

    igrf14 = "igrf14"
    wmm2025 = "wmm2025"


def command(
    flight: Annotated[
        Path, typer.Argument(metavar="FLIGHT", help="An LCM log or an npz file with SMDU and INS.")
    ],
    year: Annotated[
        float, typer.Option("--year", metavar="YEAR", help="Date of the flight, decimal year.")
    ],
    target: Annotated[
        Path, typer.Option("-o", "--output", metavar="FILE", help="The calibration, TOML.")
    ],
    start_s: Annotated[
        float, typer.Option("--from", metavar="S", help="Use the flight from this time on, s.")
    ] = float("-inf"),
    end_s: Annotated[
        float, typer.Option("--to", metavar="S", help="Use the flight up to this time, s.")
    ] = float("inf"),
    model: Annotated[
        Model, typer.Option("--model", help="Model of the Earth's field.")
    ] = Model.igrf14,
) -> None:
    """Calibrate the magnetic detector by the INS of a flight; for the next flight, not for this."""
    from lodestar import recordings
    from lodestar.studies.calibration import calibrate, write_calibration

    result = calibrate(recordings.load(flight), year, (start_s, end_s), model.value)
    write_calibration(result, target)
    bias = ", ".join(f"{v:.0f} ± {s:.0f}" for v, s in zip(result.x, result.sigma[:3], strict=False))
    residual = ", ".join(f"{v:.0f}" for v in result.residual_rms)
    typer.echo(f"{target}: {result.samples} samples, observability {result.observability:.3g}")
    typer.echo(f"bias {bias} nT; residual rms {residual} nT")
