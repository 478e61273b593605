# SPDX-License-Identifier: Apache-2.0
"""The command line program: its subcommands, and how it ends when something is wrong."""

from __future__ import annotations

from typing import Annotated

import typer

import lodestar
from lodestar.cli import (
    calibrate,
    convert,
    doctor,
    fly,
    identify,
    import_,
    monte_carlo,
    replay,
    score,
    spy,
    watch,
)
from lodestar.cli.common import BAD_INPUT, fail
from lodestar.errors import InputError

app = typer.Typer(
    help="An open flight computer for synthetic attitude, heading and navigation.",
    epilog="Exit codes: 0 good, 1 the flight failed its score, 2 bad input, 130 stopped by Ctrl-C.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command("fly", epilog=fly.EXAMPLE)(fly.command)
app.command("replay", epilog=replay.EXAMPLE)(replay.command)
app.command("score", epilog=score.EXAMPLE)(score.command)
app.command("convert", epilog=convert.EXAMPLE)(convert.command)
app.command("import", epilog=import_.EXAMPLE)(import_.command)
app.command("calibrate", epilog=calibrate.EXAMPLE)(calibrate.command)
app.command("identify", epilog=identify.EXAMPLE)(identify.command)
app.add_typer(monte_carlo.app, name="monte-carlo")
app.command("spy", epilog=spy.EXAMPLE)(spy.command)
app.command("watch", epilog=watch.EXAMPLE)(watch.command)
app.command("doctor", epilog=doctor.EXAMPLE)(doctor.command)


def _version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"lodestar {lodestar.__version__}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Say the version.")
    ] = False,
) -> None:
    pass


def main() -> None:
    """Run the command and exit; an error that a person can mend is one line on stderr."""
    try:
        app()
    except InputError as error:
        fail(str(error), BAD_INPUT)
