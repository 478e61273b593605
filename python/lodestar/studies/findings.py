# SPDX-License-Identifier: Apache-2.0
"""What a study found: rows for scripts, tables and plots for people, and the verdict."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from math import isnan
from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure
from rich.console import Console
from rich.markup import escape

from lodestar.errors import InputError
from lodestar.evaluation import drawing, page
from lodestar.evaluation.score import Row
from lodestar.evaluation.summary import Table
from lodestar.evaluation.tables import print_tables

REPORT = "report.html"
OBJECT = "study.json"
PLOTS = "plots"
_MOST_TOLD = 12
_DPI = 110  # a campaign has dozens of plots


@dataclass(frozen=True)
class Plot:
    """A figure, the stem of its file, its heading and what it shows."""

    name: str
    title: str
    caption: str
    figure: Figure


@dataclass(frozen=True)
class Findings:
    """The outcome of a study."""

    study: str
    title: str
    runs: int
    """Flights of each cell; of the one with the fewest, where they differ."""
    rows: list[Row]
    tables: list[Table]
    notes: list[str]

    @property
    def failures(self) -> list[str]:
        """The rows over their limit, or under what they must at least be, one line each."""
        return [
            f"{row['case']} {row['estimator']} {row['metric']} is {_told(row['value'])}, {bound}"
            for row in self.rows
            for bound in [_broken_bound(row)]
            if bound
        ]

    @property
    def verdict(self) -> str:
        """Passed or failed, and why, in one line."""
        failures = self.failures
        if not failures:
            judged = any("limit" in row for row in self.rows)
            return "passed: every limit was kept" if judged else "passed: no limit applies"
        more = len(failures) - _MOST_TOLD
        told = failures[:_MOST_TOLD] + ([f"and {more} more"] if more > 0 else [])
        return f"failed: {'; '.join(told)}"

    def to_json(self) -> str:
        """The object that ``--json`` prints."""
        return json.dumps({"study": self.study, "runs": self.runs, "rows": self.rows}, indent=2)


def row(
    case: str,
    estimator: str,
    metric: str,
    value: float,
    *,
    interval: tuple[float, float] | None = None,
    reference: float | None = None,
    limit: float | None = None,
    least: float | None = None,
    stretch: float | None = None,
) -> Row:
    """A row for scripts; what is not known is left out, and a value that does not exist is null.

    The value must not be above ``limit`` nor below ``least``; ``stretch`` is what it aims at.
    """
    made: Row = {
        "case": case,
        "estimator": estimator,
        "metric": metric,
        "value": None if isnan(value) else value,
    }
    if interval is not None and not isnan(interval[0]):
        made |= {"low": interval[0], "high": interval[1]}
    if reference is not None:
        made["reference"] = reference
    for name, bound in (("limit", limit), ("least", least), ("stretch", stretch)):
        if bound is not None:
            made[name] = bound
    return made


def print_findings(findings: Findings) -> None:
    """Print the tables, the notes and the verdict."""
    print_tables(findings.tables)
    console = Console()
    for note in findings.notes:
        console.print(escape(note), style="dim", highlight=False)
    style = "bold red" if findings.failures else "bold green"
    console.print(escape(findings.verdict), style=style, highlight=False)


def write(findings: Findings, plots: Sequence[Plot], folder: Path) -> Path:
    """Write JSON object, report and plots; returns the report's path.

    Raises InputError where they cannot be written.
    """
    with mpl.rc_context(drawing.STYLE | {"savefig.dpi": _DPI}):
        images = {plot.name: drawing.png(plot.figure) for plot in plots}
    drawing.write_images(images, folder / PLOTS)
    try:
        (folder / OBJECT).write_text(findings.to_json() + "\n")
    except OSError as error:
        raise InputError(f"{folder / OBJECT}: {error.strerror}") from None
    headline = f"{findings.runs} flights of each case"
    parts = [page.head(findings.title, headline, findings.verdict, passed=not findings.failures)]
    parts += [page.table(table.title, table) for table in findings.tables]
    parts.append(page.paragraphs(findings.notes))
    parts += [page.figure(p.name, p.title, p.caption, images[p.name]) for p in plots]
    page.write(findings.title, parts, folder / REPORT)
    return folder / REPORT


def _broken_bound(row: Row) -> str | None:
    """The bound that a row breaks, in words; a value that does not exist breaks any."""
    value = row["value"]
    if "limit" in row and not (value is not None and value <= row["limit"]):
        return f"limit {row['limit']:g}"
    if "least" in row and not (value is not None and value >= row["least"]):
        return f"at least {row['least']:g}"
    return None


def _told(value: float | None) -> str:
    return "nothing" if value is None else f"{value:.3g}"
