# SPDX-License-Identifier: Apache-2.0
"""Tables of the study of navigation about losses of GPS."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodestar.evaluation.fusion_requirements import EKF2, PEER_SCENARIO
from lodestar.evaluation.summary import NONE, Table
from lodestar.studies.ensemble import Ensemble, with_half
from lodestar.studies.fusion_book import Book, has, peer_value, rms, scenario_of
from lodestar.studies.fusion_score import LOSSES_S
from lodestar.studies.fusion_setups import FILTERS

Array = NDArray[np.float64]

_PEER_NAMES = {
    "aided_roll_rmse_deg": "GPS on: roll rms, °",
    "aided_pitch_rmse_deg": "GPS on: pitch rms, °",
    "aided_heading_rmse_deg": "GPS on: heading rms, °",
    "aided_wind_rmse_m_s": "GPS on: wind rms (norm), m/s",
    "lost_roll_rmse_deg": "GPS off: roll rms, °",
    "lost_pitch_rmse_deg": "GPS off: pitch rms, °",
    "lost_heading_rmse_deg": "GPS off: heading rms, °",
    "lost_60s_m": "60 s after the loss, m",
    "lost_300s_m": "300 s after the loss, m",
    "lost_540s_m": "540 s after the loss, m",
}


def losses(book: Book) -> Table:
    """Error at the end of losses of GPS, and what was stated of it."""
    body: list[tuple[str, ...]] = []
    for case in book.cases:
        filters = [one for name in FILTERS for one in [book.of(case, name)] if one]
        for length in LOSSES_S:
            known = [one for one in filters if has(one, f"end_{length}s_m")]
            for one in known:
                body.append((case, _duration(length), one.cell.estimator, *_ends(one, length)))
            for one in known[:1]:
                ends = _growth(one.figure(f"frozen_end_{length}s_m"), length)
                body.append((case, _duration(length), "SAHRS alone", *ends, NONE, NONE, NONE))
    header = (
        "case",
        "GPS lost",
        "filter",
        "error at the end, m",
        "worst, m",
        "m/min",
        "σ, m",
        "error / σ",
        "protection level, m",
    )
    title = "Losses of GPS: horizontal error at the end (SAHRS alone: wind as last estimated)"
    return Table(title, header, body)


def _ends(ensemble: Ensemble, length: int) -> tuple[str, ...]:
    error, sigma, level = (
        ensemble.figure(f"{name}_{length}s_m") for name in ("end", "sigma_end", "protection_end")
    )
    stated = f"{np.nanmean(level):.0f}" if np.isfinite(level).any() else NONE
    return (*_growth(error, length), f"{rms(sigma):.0f}", f"{rms(error / sigma):.2f}", stated)


def _growth(error: Array, length: int) -> tuple[str, ...]:
    rate = float(np.mean(error)) / (length / 60)
    return with_half(error, ".0f"), f"{np.max(error):.0f}", f"{rate:.1f}"


def _duration(length: int) -> str:
    return f"{length} s" if length < 120 else f"{length / 60:g} min"


def peer(book: Book) -> Table:
    """Against PX4's EKF2 on the same kind of flight."""
    cells = [one for one in book.filters() if scenario_of(one.cell.case) == PEER_SCENARIO]
    body: list[tuple[str, ...]] = []
    bad = set()
    for metric, reached in EKF2.items() if cells else ():
        values = [peer_value(metric, one.figure(metric)) for one in cells]
        for column, (one, value) in enumerate(zip(cells, values, strict=True), start=2):
            if one.cell.estimator == "integrated" and not value <= reached:
                bad.add((len(body), column))
        body.append((_PEER_NAMES[metric], f"{reached:g}", *(f"{value:.3g}" for value in values)))
    header = ("figure", "EKF2", *(f"{one.cell.case} {one.cell.estimator}" for one in cells))
    title = "Small unmanned aircraft that loses GPS: PX4's EKF2 (14 flights) beside ours"
    return Table(title, header, body, frozenset(bad))
