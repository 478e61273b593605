# SPDX-License-Identifier: Apache-2.0
"""Command ``lodestar fly``."""

from __future__ import annotations

import contextlib
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lodestar.cli import outcome
from lodestar.cli.common import (
    FLIGHT_FAILED,
    INTERRUPTED,
    CalibrationOption,
    ConfigOption,
    JsonOption,
    OutOption,
    bus_url,
    fail,
    given_or_shipped,
)
from lodestar.harness import LOG
from lodestar.harness.isolation import isolated_bus

if TYPE_CHECKING:
    from rich.progress import Progress

    from lodestar.harness.scenario import Scenario

EXAMPLE = "Example: lodestar fly gps-loss-long --seed 7 --out out/seed7"


def command(
    scenario: Annotated[
        str, typer.Argument(metavar="[SCENARIO]", help="A shipped scenario, or a TOML file.")
    ] = "ordinary",
    realtime: Annotated[
        bool, typer.Option("--realtime", help="At the pace of the clock on the wall.")
    ] = False,
    seed: Annotated[int, typer.Option("--seed", min=0, help="Of all that is random.")] = 1,
    engine: Annotated[
        str,
        typer.Option(
            "--engine",
            metavar="profile|jsbsim",
            help="What flies the route: our kinematics, or the F-16 of JSBSim (an extra).",
        ),
    ] = "profile",
    out: OutOption = None,
    bus: Annotated[
        str | None,
        typer.Option(
            "--bus",
            metavar="URL",
            help="Fly where spy and watch can see it: an LCM URL, or 'default'. Otherwise the bus "
            "is isolated.",
        ),
    ] = None,
    config: ConfigOption = None,
    calibration: CalibrationOption = None,
    as_json: JsonOption = False,
) -> None:
    """Fly a scenario through the flight computer, score it, write a report.

    Ctrl-C stops the flight computer, keeps what was recorded, and ends with 130.
    """
    with contextlib.ExitStack() as stack:
        # First of all: namespaces are only for a process that has no second thread yet.
        isolated = None if bus else stack.enter_context(isolated_bus(whole_process=True))
        url = isolated or bus_url(bus or "")

        from lodestar.evaluation.score import score
        from lodestar.harness.flight_computer import FlightComputerError
        from lodestar.harness.scenario import load_scenario
        from lodestar.recordings.log import read_log

        flown = load_scenario(scenario)
        folder = outcome.run_folder(out or Path("out") / flown.name)
        try:
            with _progress() as progress:
                factor = _fly(
                    flown, seed, engine, url, folder, config, calibration, realtime, progress
                )
                progress.add_task("score and report", total=None)
                recording = read_log(folder / LOG, strict=False)
                result = score(recording, case=flown.name, seed=seed, realtime_factor=factor)
                outcome.write(recording, result, folder, flown.description)
        except KeyboardInterrupt:
            fail(f"stopped by Ctrl-C; {_kept(folder / LOG)}", INTERRUPTED)
        except FlightComputerError as error:
            fail(f"{error}; {_kept(folder / LOG)}", FLIGHT_FAILED)
    outcome.tell(result, folder, as_json=as_json)


def _fly(
    scenario: Scenario,
    seed: int,
    engine: str,
    url: str,
    folder: Path,
    config: Path | None,
    calibration: Path | None,
    realtime: bool,
    progress: Progress,
) -> float:
    """Simulate and fly; returns how many times faster than real time it flew."""
    from lodestar.harness.fly import fly_plan, prepare

    simulating = progress.add_task("simulate", total=None)
    plan = prepare(scenario, seed, given_or_shipped(config) if config else None, engine)
    progress.remove_task(simulating)
    flying = progress.add_task(f"fly {scenario.name}", total=scenario.duration_s)
    start = time.monotonic()
    fly_plan(
        plan,
        url,
        folder,
        calibration=calibration,
        realtime=realtime,
        progress=lambda time_us: progress.update(flying, completed=time_us * 1e-6),
    )
    progress.remove_task(flying)
    return scenario.duration_s / (time.monotonic() - start)


def _kept(log: Path) -> str:
    return f"{log} keeps what was recorded" if log.exists() else "nothing was recorded yet"


def _progress() -> Progress:
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

    return Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:.0f} s"),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
    )
