# SPDX-License-Identifier: Apache-2.0
"""Commands ``lodestar monte-carlo STUDY``."""

from __future__ import annotations

from functools import partial
from typing import Annotated

import typer

from lodestar.cli.study_command import Campaign, study_command

app = typer.Typer(
    help="Fly a study many times, on all cores, and tabulate it. It may be stopped and run again.",
    no_args_is_help=True,
)

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


@study_command(app, "sahrs", 100, "--runs 20 --scenario hard --engine jsbsim")
def sahrs(
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
) -> Campaign:
    """SAHRS against truth: errors, maxima, and whether its sigma tells the truth."""
    from lodestar.studies import sahrs as study
    from lodestar.studies.sahrs_findings import findings
    from lodestar.studies.sahrs_plots import plots

    return Campaign(
        study.sahrs_study(
            scenario or (), engine or (), form or (), set() if calibrated is None else {calibrated}
        ),
        findings,
        plots,
    )


@study_command(app, "fusion", 50, "--runs 10 --scenario ordinary --start init")
def fusion(
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
) -> Campaign:
    """GPS with SAHRS: heading, wind, position, losses of GPS, against the thesis and a peer."""
    from lodestar.studies.fusion import fusion_study
    from lodestar.studies.fusion_findings import findings
    from lodestar.studies.fusion_plots import plots

    variants = (scenario or (), engine or (), filter_ or (), start or (), option or ())
    return Campaign(fusion_study(*variants, course), findings, partial(plots, course=course))


@study_command(app, "sahrs-faults", 20, "--runs 20 --form velocity")
def sahrs_faults(engine: EngineOption = None, form: FormOption = None) -> Campaign:
    """SAHRS with bad input: a magnet, frozen airspeed, stuck vane, baro spikes, gyro saturation."""
    from lodestar.studies.sahrs_faults import sahrs_faults_study
    from lodestar.studies.sahrs_faults_findings import findings, plots

    return Campaign(sahrs_faults_study(engine or (), form or ()), findings, plots)


@study_command(app, "fusion-faults", 20, "--runs 6 --seed-first 301")
def fusion_faults(
    engine: EngineOption = None,
    filter_: Annotated[
        list[str] | None,
        typer.Option("--filter", metavar="NAME", help="Of the fusion; all by default."),
    ] = None,
) -> Campaign:
    """Fusion with bad fixes: spoofed by jumps and drag-offs, wrong time, frozen, scattered, NaN."""
    from lodestar.studies.fusion_faults import fusion_faults_study
    from lodestar.studies.fusion_faults_findings import findings, plots

    return Campaign(fusion_faults_study(engine or (), filter_ or ()), findings, plots)


@study_command(app, "ins-monitor", 27, "--runs 27 --form velocity")
def ins_monitor(
    scenario: ScenarioOption = None,
    engine: EngineOption = None,
    form: FormOption = None,
) -> Campaign:
    """The INS watched by SAHRS: false alarms, and how soon ramps and a frozen INS are told."""
    from lodestar.studies.ins_monitor import ins_monitor_study
    from lodestar.studies.ins_monitor_findings import findings, plots

    return Campaign(ins_monitor_study(scenario or (), engine or (), form or ()), findings, plots)
