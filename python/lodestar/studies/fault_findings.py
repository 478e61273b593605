# SPDX-License-Identifier: Apache-2.0
"""What the findings of the studies of bad input share: what was refused, and errors over time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from matplotlib.axes import Axes

from lodestar.evaluation import drawing
from lodestar.evaluation.score import Row
from lodestar.evaluation.summary import NONE
from lodestar.studies.ensemble import Ensemble
from lodestar.studies.findings import row

Named = Iterable[tuple[str, str]]
"""Names of counts for people, each with its figure."""


def counts(ensemble: Ensemble, named: Named) -> list[tuple[str, float]]:
    """What occurred, by name: the mean of the flights."""
    means = [(name, float(np.mean(ensemble.figure(figure)))) for name, figure in named]
    return [(name, mean) for name, mean in means if mean]


def rejected_rows(ensemble: Ensemble, named: Named) -> Iterator[Row]:
    """A row ``rejected_...`` for each count that occurred."""
    for name, count in counts(ensemble, named):
        metric = "rejected_" + name.replace(" ", "_")
        yield row(f"{ensemble.cell.case}/during", ensemble.cell.estimator, metric, count)


def told(ensemble: Ensemble, *groups: Named) -> str:
    """What occurred, in words; groups apart from each other."""
    parts = [
        ", ".join(f"{name} {count:.4g}" for name, count in counts(ensemble, named))
        for named in groups
    ]
    return "; ".join(filter(None, parts)) or NONE


def rms_lines(axis: Axes, ensembles: Sequence[Ensemble], series: str) -> None:
    """The rms of a series over the flights, a line for each case."""
    for ensemble, colour in zip(ensembles, drawing.PALETTE, strict=False):
        rms = np.sqrt(np.mean(ensemble.series(series) ** 2, axis=0))
        label = ensemble.cell.case.split("/")[-1]
        axis.plot(ensemble.series("time_s")[0], rms, color=colour, label=label)
