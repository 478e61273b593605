# SPDX-License-Identifier: Apache-2.0
"""What the source documents ask for and what they reached."""

from __future__ import annotations

from lodestar.evaluation.fusion_requirements import THESIS

SETTLING_S = 60.0
"""The SAHRS paper's "never beyond" holds from here on; rmse is over the whole valid output."""

CALM = {
    "roll_rmse_deg": 2.0,
    "pitch_rmse_deg": 2.0,
    "heading_rmse_deg": 5.0,
    "roll_max_deg": 10.0,
    "pitch_max_deg": 5.0,
    "heading_max_deg": 10.0,
}
"""SAHRS paper, requirement in calm manoeuvring."""

HARD = {"roll_max_deg": 30.0, "pitch_max_deg": 20.0}
"""SAHRS paper, requirement in hard manoeuvring."""

GOALS: dict[str, dict[str, tuple[float, float]]] = {
    "ordinary/uncalibrated": {
        "roll_rmse_deg": (0.5, 0.3),
        "pitch_rmse_deg": (0.5, 0.25),
        "heading_rmse_deg": (1.5, 1.1),
    },
    "ordinary/calibrated": {
        "roll_rmse_deg": (0.5, 0.25),
        "pitch_rmse_deg": (0.5, 0.2),
        "heading_rmse_deg": (1.0, 0.8),
    },
    "turbulence": {
        "roll_rmse_deg": (0.7, 0.4),
        "pitch_rmse_deg": (0.5, 0.2),
        "heading_rmse_deg": (2.0, 1.4),
    },
    "hard": {
        "roll_rmse_deg": (0.5, 0.2),
        "pitch_rmse_deg": (0.5, 0.2),
        "heading_rmse_deg": (1.2, 0.6),
        "roll_max_deg": (4.0, 2.0),
        "pitch_max_deg": (3.0, 1.0),
        "heading_max_deg": (6.0, 3.0),
    },
}
"""Ours for the velocity form, (must, stretch), by scenario or scenario/calibration.

rmse is the mean over many flights, max the largest of all.
"""

_THESIS_QUANTITIES = {
    "heading_rmse_deg": "heading",
    "wind_north_rmse_m_s": "wind_north",
    "wind_east_rmse_m_s": "wind_east",
}


def is_hard(case: str) -> bool:
    """Whether the case is of hard manoeuvring, as the SAHRS paper tells it from calm."""
    return case.split("/")[0].split("+")[0] == "hard"


def is_turbulent(case: str) -> bool:
    """Whether the air of the case is turbulent; the SAHRS paper requires nothing there."""
    scenario = case.split("/")[0]
    return scenario == "turbulence" or scenario.endswith("+air")


def is_calm(case: str) -> bool:
    """Whether both manoeuvring and air are calm."""
    return not (is_hard(case) or is_turbulent(case))


def paper(case: str) -> dict[str, float]:
    """What the SAHRS paper requires in a case, by metric."""
    return HARD if is_hard(case) else CALM


def limit(case: str, estimator: str, metric: str) -> float | None:
    """The most that the SAHRS paper allows, None where it asks for nothing."""
    return paper(case).get(metric) if estimator == "sahrs" else None


def goals(case: str, estimator: str) -> dict[str, tuple[float, float]]:
    """(must, stretch) by metric for a case of the SAHRS study; empty where there is no goal."""
    if estimator != "sahrs":
        return {}
    scenario, *_, calibration = case.split("/")
    return GOALS.get(f"{scenario}/{calibration}", GOALS.get(scenario, {}))


def published(case: str, estimator: str, metric: str) -> float | None:
    """The figure of the Linköping thesis for the same kind of flight, None where it has none."""
    quantity = _THESIS_QUANTITIES.get(metric)
    if quantity is None or case not in THESIS:
        return None
    before, after = THESIS[case][quantity]
    if estimator in ("cascade", "integrated"):
        return after
    # Its wind before correction is no figure of SAHRS.
    return before if estimator == "sahrs" and quantity == "heading" else None
