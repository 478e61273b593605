# SPDX-License-Identifier: Apache-2.0
"""What the commands ``lodestar monte-carlo STUDY`` share: their options, and what they do."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from lodestar.cli import progress
from lodestar.cli.common import FLIGHT_FAILED, INTERRUPTED, JsonOption, fail
from lodestar.errors import InputError

if TYPE_CHECKING:
    from lodestar.studies.campaign import Study
    from lodestar.studies.ensemble import Ensemble
    from lodestar.studies.findings import Findings, Plot
    from lodestar.studies.store import ParquetStore


@dataclass(frozen=True)
class Campaign:
    """A study, and how what was flown is told."""

    study: Study
    findings: Callable[[str, Sequence[Ensemble]], Findings]
    plots: Callable[[Sequence[Ensemble]], list[Plot]]


Choose = Callable[..., Campaign]
"""From a study's own options to the study."""


def conduct(
    campaign: Campaign,
    runs: Annotated[int, typer.Option("--runs", min=1, help="Flights of each case.")],
    seed_first: Annotated[
        int,
        typer.Option("--seed-first", min=0, metavar="N", help="Seed of the first; then upwards."),
    ] = 1,
    workers: Annotated[
        int | None,
        typer.Option("--workers", min=1, help="Processes; one for each core by default."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", metavar="DIR", help="Results and report; out/monte-carlo/STUDY if none."
        ),
    ] = None,
    redraw: Annotated[
        bool, typer.Option("--redraw", help="Fly nothing; tabulate what there is.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Fly what is missing, tell and write what was found.

    Raises typer.Exit with FLIGHT_FAILED if a limit was broken.
    """
    from lodestar.studies.ensemble import grouped
    from lodestar.studies.findings import print_findings, write
    from lodestar.studies.store import ParquetStore

    study, seeds = campaign.study, range(seed_first, seed_first + runs)
    folder = out or Path("out/monte-carlo") / study.name
    store = ParquetStore(folder)
    if not redraw:
        _fly(study, seeds, store, workers)
    ensembles = grouped(store.results(study.cells, seeds))
    if not ensembles:
        raise InputError(f"{folder}: holds none of these flights; run it without --redraw")
    found = campaign.findings(study.name, ensembles)
    report = write(found, campaign.plots(ensembles), folder)
    if as_json:
        typer.echo(found.to_json())
    else:
        print_findings(found)
        typer.echo(f"report: {report}")
    if found.failures:
        raise typer.Exit(FLIGHT_FAILED)


def study_command(
    app: typer.Typer, name: str, runs: int, example: str
) -> Callable[[Choose], Choose]:
    """Make a command of ``app`` of what chooses a study: its options and those of ``conduct``.

    ``runs``: so many flights of each case by default; ``example``: options worth showing.
    """

    def register(choose: Choose) -> Choose:
        own = inspect.signature(choose, eval_str=True).parameters
        _, runs_option, *others = inspect.signature(conduct, eval_str=True).parameters.values()

        def command(**given: Any) -> None:
            campaign = choose(**{option: given.pop(option) for option in own})
            conduct(campaign, **given)

        options = [runs_option.replace(default=runs), *own.values(), *others]
        command.__signature__ = inspect.Signature(options)  # type: ignore[attr-defined]
        command.__doc__ = choose.__doc__
        app.command(name, epilog=f"Example: lodestar monte-carlo {name} {example}")(command)
        return choose

    return register


def _fly(study: Study, seeds: range, store: ParquetStore, workers: int | None) -> None:
    from lodestar.studies.campaign import run
    from lodestar.studies.pool import LocalPool

    kept = f"{store.folder} keeps what was flown, and the same command goes on"
    try:
        with store.writing(), progress.flights(f"monte-carlo {study.name}") as advance:
            run(study, seeds, store, LocalPool(workers), advance)
    except KeyboardInterrupt:
        fail(f"stopped by Ctrl-C; {kept}", INTERRUPTED)
    except BrokenProcessPool:
        fail(f"a process ended before its flight did (out of memory?); {kept}", FLIGHT_FAILED)
