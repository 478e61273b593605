# SPDX-License-Identifier: Apache-2.0
"""Command ``lodestar replay``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lodestar.cli import outcome
from lodestar.cli.common import FLIGHT_FAILED, JsonOption, OutOption, fail, given_or_shipped
from lodestar.errors import InputError
from lodestar.harness import CONFIG, LOG

if TYPE_CHECKING:
    from lodestar.recordings import Recording

EXAMPLE = "Example: lodestar replay thor75.lcm --calibration smdu.cal --from 230 --to 575"


def command(
    flight: Annotated[Path, typer.Argument(metavar="FLIGHT", help="An LCM log or an npz file.")],
    config: Annotated[
        Path | None,
        typer.Option(
            "--config",
            metavar="FILE",
            help="Configuration of the flight computer (TOML); the run's own where FLIGHT is the "
            "log of a run of fly.",
        ),
    ] = None,
    calibration: Annotated[
        Path | None,
        typer.Option(
            "--calibration",
            metavar="FILE",
            help="Calibration of the magnetic detector, a stored one or TOML; it stays as it is.",
        ),
    ] = None,
    start_s: Annotated[
        float,
        typer.Option("--from", metavar="S", help="Score from this time on, s.", show_default=False),
    ] = float("-inf"),
    end_s: Annotated[
        float,
        typer.Option("--to", metavar="S", help="Score up to this time, s.", show_default=False),
    ] = float("inf"),
    out: OutOption = None,
    as_json: JsonOption = False,
) -> None:
    """Run a recording through the flight computer; score it if it has TRUTH or INS."""
    from lodestar.evaluation.score import score
    from lodestar.harness.flight_computer import FlightComputerError
    from lodestar.harness.replay import replay
    from lodestar.recordings.log import write_log

    own_config = flight.parent / CONFIG
    if config is not None:
        config = given_or_shipped(config)
    elif flight.name == LOG and own_config.exists():
        config = own_config
    before = outcome.read_summary(flight.parent) if flight.name == LOG else {}
    case = before.get("scenario") or flight.stem
    try:
        replayed = replay(flight, config=config, calibration=calibration)
    except FlightComputerError as error:
        fail(str(error), FLIGHT_FAILED)
    recording = replayed.recording
    for note in recording.notes:
        typer.echo(note, err=True)
    folder = outcome.run_folder(out or Path("out") / f"{case}-replay")
    write_log(recording, folder / LOG)
    if "TRUTH" not in recording and "INS" not in recording:
        typer.echo(
            f"{folder / LOG} has the answers; without TRUTH or INS there is no score", err=True
        )
        return
    scored = _between(recording, start_s, end_s)
    result = score(
        scored,
        case=case,
        seed=before.get("seed"),
        realtime_factor=recording.duration_s() / replayed.seconds,
    )
    outcome.write(scored, result, folder)
    outcome.tell(result, folder, as_json=as_json)


def _between(recording: Recording, start_s: float, end_s: float) -> Recording:
    """The messages of a span of time. Raises InputError where there are none."""
    from lodestar.recordings import Recording

    cut = Recording(notes=recording.notes)
    for name, columns in recording.channels.items():
        time_s = columns["time_us"] * 1e-6
        rows = (time_s >= start_s) & (time_s <= end_s)
        if rows.any():
            cut.channels[name] = {field: values[rows] for field, values in columns.items()}
    if "SAHRS" not in cut:
        time_s = recording["EFCS.RATES"]["time_us"] * 1e-6
        raise InputError(
            f"--from {start_s:g} --to {end_s:g}: no part of the flight, which is from "
            f"{time_s.min():.1f} to {time_s.max():.1f} s"
        )
    return cut
