# SPDX-License-Identifier: Apache-2.0
"""The score in the terminal."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table as RichTable

from lodestar.evaluation import summary
from lodestar.evaluation.score import Score

_WIDEST = 160  # characters; some tables are wider than most terminals say they are


def print_table(score: Score, console: Console | None = None) -> None:
    """Print what was flown, the errors, the losses of GPS, the notes and the verdict."""
    out = console or Console()
    out.print(f"[bold]{escape(summary.headline(score))}[/bold]", end="\n\n")
    for table in (summary.error_table(score), summary.loss_table(score)):
        if table is not None:
            out.print(rich_table(table))
            out.print()
    for note in summary.notes(score):
        out.print(escape(note), style="dim", highlight=False)
    style = "bold green" if score.passed else "bold red"
    out.print(escape(summary.verdict(score)), style=style, highlight=False)


def print_tables(tables: Iterable[summary.Table]) -> None:
    """Print tables that may be wider than the terminal, each under its title."""
    # Cut off by a narrow terminal's edge a table is of no use; wrapped by it, it still can be read.
    out = Console(width=max(Console().width, _WIDEST))
    for table in tables:
        out.print(f"[bold]{escape(table.title)}[/bold]")
        out.print(rich_table(table))
        out.print()


def rich_table(table: summary.Table) -> RichTable:
    """The table for a terminal; what breaks a limit is red."""
    made = RichTable(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, collapse_padding=True)
    for index, name in enumerate(table.header):
        # Broken at its first word, so that the columns are no wider than their figures.
        heading = name.replace(" ", "\n", 1) if index else name
        folds = table.wide and index == len(table.header) - 1
        side: Literal["left", "right"] = "left" if folds or index == 0 else "right"
        made.add_column(heading, justify=side, no_wrap=not folds)
    for row, cells in enumerate(table.rows):
        made.add_row(
            *(
                f"[bold red]{escape(cell)}[/bold red]" if (row, column) in table.bad else cell
                for column, cell in enumerate(cells)
            )
        )
    return made
