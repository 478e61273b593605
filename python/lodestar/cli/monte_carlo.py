# SPDX-License-Identifier: Apache-2.0
"""Commands ``lodestar monte-carlo STUDY``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from lodestar.cli import progress
from lodestar.cli.common import FLIGHT_FAILED, INTERRUPTED, JsonOption, fail
from lodestar.errors import InputError

if TYPE_CHECKING:
    from lodestar.studies.campaign import Study
    from lodestar.studies.ensemble import Ensemble
    from lodestar.studies.findings import Findings, Plot
    from lodestar.studies.store import ParquetStore

SAHRS_EXAMPLE = "Example: lodestar monte-carlo sahrs --runs 20 --scenario hard --engine jsbsim"
FAULTS_EXAMPLE = "Example: lodestar monte-carlo sahrs-faults --runs 20 --form velocity"
FUSION_FAULTS_EXAMPLE = "Example: lodestar monte-carlo fusion-faults --runs 6 --seed-first 301"
INS_MONITOR_EXAMPLE = "Example: lodestar monte-carlo ins-monitor --runs 27 --form velocity"
FUSION_EXAMPLE = "Example: lodestar monte-carlo fusion --runs 10 --scenario ordinary --start init"

app = typer.Typer(
    help="Fly a study many times, on all cores, and tabulate it. It may be stopped and run again.",
    no_args_is_help=True,
)

RunsOption = Annotated[int, typer.Option("--runs", min=1, help="Flights of each case.")]
FirstSeedOption = Annotated[
    int, typer.Option("--seed-first", min=0, metavar="N", help="Seed of the first; then upwards.")
]
WorkersOption = Annotated[
    int | None, typer.Option("--workers", min=1, help="Processes; one for each core by default.")
]
FolderOption = Annotated[
    Path | None,
    typer.Option("--out", metavar="DIR", help="Results and report; out/monte-carlo/STUDY if none."),
]
RedrawOption = Annotated[
    bool, typer.Option("--redraw", help="Fly nothing; tabulate what there is.")
]
ScenarioOption = Annotated[
    list[str] | None,
    typer.Option(
        "--scenario",
        metavar="NAME|FILE",
        help="Once for each; ordinary, turbulence and hard by default.",
    ),
]
EngineOption = Annotated[
    list[str] | None,
    typer.Option("--engine", metavar="profile|jsbsim", help="profile by default."),
]
FormOption = Annotated[
    list[str] | None,
    typer.Option("--form", metavar="velocity|paper", help="Of SAHRS; both by default."),
]


@app.command("sahrs", epilog=SAHRS_EXAMPLE)
def sahrs(
    runs: RunsOption = 100,
    scenario: ScenarioOption = None,
    engine: Annotated[
        list[str] | None,
        typer.Option("--engine", metavar="profile|jsbsim", help="Both by default."),
    ] = None,
    form: FormOption = None,
    calibrated: Annotated[
        bool | None,
        typer.Option("--calibrated/--uncalibrated", help="The SMDU; both by default."),
    ] = None,
    seed_first: FirstSeedOption = 1,
    workers: WorkersOption = None,
    out: FolderOption = None,
    redraw: RedrawOption = False,
    as_json: JsonOption = False,
) -> None:
    """SAHRS against truth: errors, maxima, and whether its sigma tells the truth."""
    from lodestar.studies import sahrs as study
    from lodestar.studies.sahrs_findings import findings
    from lodestar.studies.sahrs_plots import plots

    _conduct(
        study.sahrs_study(
            scenario or (), engine or (), form or (), set() if calibrated is None else {calibrated}
        ),
        findings,
        plots,
        range(seed_first, seed_first + runs),
        workers,
        out,
        redraw=redraw,
        as_json=as_json,
    )


@app.command("fusion", epilog=FUSION_EXAMPLE)
def fusion(
    runs: RunsOption = 50,
    scenario: Annotated[
        list[str] | None,
        typer.Option(
            "--scenario",
            metavar="NAME|FILE",
            help="Once for each; those with a goal by default.",
        ),
    ] = None,
    engine: EngineOption = None,
    filter_: Annotated[
        list[str] | None,
        typer.Option("--filter", metavar="cascade|integrated", help="Both by default."),
    ] = None,
    start: Annotated[
        list[str] | None,
        typer.Option(
            "--start",
            metavar="init|cold",
            help="From the INS's last attitude, or aligned in flight; where there is a goal.",
        ),
    ] = None,
    option: Annotated[
        list[str] | None,
        typer.Option(
            "--option",
            metavar="KEY=VALUE,...",
            help="Fly another configuration beside the shipped one; once for each.",
        ),
    ] = None,
    course: Annotated[
        str,
        typer.Option(
            "--course",
            metavar="drawn|filed",
            help="Routes in another direction for every seed, or as their files have them.",
        ),
    ] = "drawn",
    seed_first: FirstSeedOption = 1,
    workers: WorkersOption = None,
    out: FolderOption = None,
    redraw: RedrawOption = False,
    as_json: JsonOption = False,
) -> None:
    """GPS with SAHRS: heading, wind, position, losses of GPS, against the thesis and a peer."""
    from lodestar.studies.fusion import fusion_study
    from lodestar.studies.fusion_findings import findings
    from lodestar.studies.fusion_plots import plots

    variants = (scenario or (), engine or (), filter_ or (), start or (), option or ())
    _conduct(
        fusion_study(*variants, course),
        findings,
        partial(plots, course=course),
        range(seed_first, seed_first + runs),
        workers,
        out,
        redraw=redraw,
        as_json=as_json,
    )


@app.command("sahrs-faults", epilog=FAULTS_EXAMPLE)
def sahrs_faults(
    runs: RunsOption = 20,
    engine: EngineOption = None,
    form: FormOption = None,
    seed_first: FirstSeedOption = 1,
    workers: WorkersOption = None,
    out: FolderOption = None,
    redraw: RedrawOption = False,
    as_json: JsonOption = False,
) -> None:
    """SAHRS with bad input: a magnet, frozen airspeed, stuck vane, baro spikes, gyro saturation."""
    from lodestar.studies.sahrs_faults import sahrs_faults_study
    from lodestar.studies.sahrs_faults_findings import findings, plots

    _conduct(
        sahrs_faults_study(engine or (), form or ()),
        findings,
        plots,
        range(seed_first, seed_first + runs),
        workers,
        out,
        redraw=redraw,
        as_json=as_json,
    )


@app.command("fusion-faults", epilog=FUSION_FAULTS_EXAMPLE)
def fusion_faults(
    runs: RunsOption = 20,
    engine: EngineOption = None,
    filter_: Annotated[
        list[str] | None,
        typer.Option("--filter", metavar="NAME", help="Of the fusion; all by default."),
    ] = None,
    seed_first: FirstSeedOption = 1,
    workers: WorkersOption = None,
    out: FolderOption = None,
    redraw: RedrawOption = False,
    as_json: JsonOption = False,
) -> None:
    """Fusion with bad fixes: spoofed by jumps and drag-offs, wrong time, frozen, scattered, NaN."""
    from lodestar.studies.fusion_faults import fusion_faults_study
    from lodestar.studies.fusion_faults_findings import findings, plots

    _conduct(
        fusion_faults_study(engine or (), filter_ or ()),
        findings,
        plots,
        range(seed_first, seed_first + runs),
        workers,
        out,
        redraw=redraw,
        as_json=as_json,
    )


@app.command("ins-monitor", epilog=INS_MONITOR_EXAMPLE)
def ins_monitor(
    runs: RunsOption = 27,
    scenario: ScenarioOption = None,
    engine: EngineOption = None,
    form: FormOption = None,
    seed_first: FirstSeedOption = 1,
    workers: WorkersOption = None,
    out: FolderOption = None,
    redraw: RedrawOption = False,
    as_json: JsonOption = False,
) -> None:
    """The INS watched by SAHRS: false alarms, and how soon ramps and a frozen INS are told."""
    from lodestar.studies.ins_monitor import ins_monitor_study
    from lodestar.studies.ins_monitor_findings import findings, plots

    _conduct(
        ins_monitor_study(scenario or (), engine or (), form or ()),
        findings,
        plots,
        range(seed_first, seed_first + runs),
        workers,
        out,
        redraw=redraw,
        as_json=as_json,
    )


def _conduct(
    study: Study,
    findings: Callable[[str, Sequence[Ensemble]], Findings],
    plots: Callable[[Sequence[Ensemble]], list[Plot]],
    seeds: range,
    workers: int | None,
    out: Path | None,
    *,
    redraw: bool,
    as_json: bool,
) -> None:
    """Fly what is missing, tell and write what was found.

    Raises typer.Exit with FLIGHT_FAILED if a limit was broken.
    """
    from lodestar.studies.ensemble import grouped
    from lodestar.studies.findings import print_findings, write
    from lodestar.studies.store import ParquetStore

    folder = out or Path("out/monte-carlo") / study.name
    store = ParquetStore(folder)
    if not redraw:
        _fly(study, seeds, store, workers)
    ensembles = grouped(store.results(study.cells, seeds))
    if not ensembles:
        raise InputError(f"{folder}: holds none of these flights; run it without --redraw")
    found = findings(study.name, ensembles)
    report = write(found, plots(ensembles), folder)
    if as_json:
        typer.echo(found.to_json())
    else:
        print_findings(found)
        typer.echo(f"report: {report}")
    if found.failures:
        raise typer.Exit(FLIGHT_FAILED)


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
