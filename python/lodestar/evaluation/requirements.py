# SPDX-License-Identifier: Apache-2.0
"""What the source documents ask for and what they reached."""

from __future__ import annotations

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

# Linköping thesis, tables of chapter 6: heading (deg), wind north and east (m/s), each before and
# after correction. It added wind to the airspeed's magnitude only, so its wind is another quantity.
_THESIS = {
    "ordinary": (3.46, 0.72, 2.42, 1.72, 2.06, 1.33),
    "wind-pulse-6": (3.81, 0.83, 3.62, 1.80, 3.26, 1.45),
    "wind-strong": (3.91, 1.13, 5.89, 1.71, 4.99, 1.50),
    "wind-pulse-12": (3.91, 1.28, 7.68, 1.95, 6.66, 1.58),
    "gps-loss-short": (3.91, 1.29, 7.73, 2.14, 6.61, 1.65),
    "gps-loss-long": (3.91, 1.36, 7.66, 2.63, 6.92, 1.90),
    "vanern": (3.02, 1.22, 7.12, 1.26, 5.90, 1.19),
}
_THESIS_ROWS = (
    ("sahrs", "heading_rmse_deg"),
    ("cascade", "heading_rmse_deg"),
    ("dead-reckoning", "wind_north_rmse_m_s"),
    ("cascade", "wind_north_rmse_m_s"),
    ("dead-reckoning", "wind_east_rmse_m_s"),
    ("cascade", "wind_east_rmse_m_s"),
)


def limit(case: str, estimator: str, metric: str) -> float | None:
    """The most that the SAHRS paper allows, None where it asks for nothing."""
    if estimator != "sahrs":
        return None
    hard = case.split("/")[0].split("+")[0] == "hard"
    return (HARD if hard else CALM).get(metric)


def published(case: str, estimator: str, metric: str) -> float | None:
    """The figure of the Linköping thesis for the same kind of flight, None where it has none."""
    figures = _THESIS.get(case)
    if figures is None or (estimator, metric) not in _THESIS_ROWS:
        return None
    return figures[_THESIS_ROWS.index((estimator, metric))]
