# SPDX-License-Identifier: Apache-2.0
"""What corrected navigation has to reach, and what others reached: figures, as data."""

from __future__ import annotations

THESIS: dict[str, dict[str, tuple[float, float]]] = {
    "ordinary": {
        "heading": (3.46, 0.72),
        "wind_north": (2.42, 1.72),
        "wind_east": (2.06, 1.33),
    },
    "wind-pulse-6": {
        "heading": (3.81, 0.83),
        "wind_north": (3.62, 1.80),
        "wind_east": (3.26, 1.45),
    },
    "wind-strong": {
        "heading": (3.91, 1.13),
        "wind_north": (5.89, 1.71),
        "wind_east": (4.99, 1.50),
    },
    "wind-pulse-12": {
        "heading": (3.91, 1.28),
        "wind_north": (7.68, 1.95),
        "wind_east": (6.66, 1.58),
    },
    "gps-loss-short": {
        "heading": (3.91, 1.29),
        "wind_north": (7.73, 2.14),
        "wind_east": (6.61, 1.65),
    },
    "gps-loss-long": {
        "heading": (3.91, 1.36),
        "wind_north": (7.66, 2.63),
        "wind_east": (6.92, 1.90),
    },
    "vanern": {
        "heading": (3.02, 1.22),
        "wind_north": (7.12, 1.26),
        "wind_east": (5.90, 1.19),
    },
}
"""Linköping thesis, tables of chapter 6: rmse (before, after correction), deg and m/s, by scenario.

Its wind is what is missing between true and calculated velocity, in effect an error of ground
velocity, and was added to the magnitude of the airspeed only: a figure to look at, not the same
experiment. ``vanern`` stands for its real flight.
"""

THESIS_GPS_M = (10.51, 10.07)
"""The thesis's real flight: error of latitude of GPS itself, and corrected, m."""

Goals = dict[str, tuple[float, float]]
"""(must, stretch) by metric."""

# Heading, deg: cascade from the INS's last heading, cascade cold, integrated likewise and cold;
# wind north and east, m/s, of integrated from the INS's last heading.
_Pair = tuple[float, float]
_STEADY: dict[str, tuple[_Pair, _Pair, _Pair, _Pair, _Pair, _Pair]] = {
    "ordinary": (
        *((0.72, 0.40), (0.85, 0.60), (0.25, 0.13), (0.65, 0.55)),
        *((0.60, 0.50), (0.65, 0.55)),
    ),
    "wind-pulse-6": (
        *((0.80, 0.42), (0.85, 0.60), (0.25, 0.13), (0.65, 0.55)),
        *((0.75, 0.62), (0.80, 0.68)),
    ),
    "wind-strong": (
        *((0.80, 0.40), (0.85, 0.60), (0.25, 0.13), (0.65, 0.55)),
        *((0.60, 0.50), (0.65, 0.55)),
    ),
    "wind-pulse-12": (
        *((0.95, 0.42), (1.00, 0.60), (0.25, 0.13), (0.65, 0.55)),
        *((1.00, 0.85), (1.05, 0.90)),
    ),
    "gps-loss-short": (
        *((0.95, 0.42), (1.00, 0.60), (0.25, 0.13), (0.65, 0.55)),
        *((1.70, 1.55), (1.75, 1.58)),
    ),
    "gps-loss-long": (
        *((1.00, 0.47), (1.05, 0.65), (0.27, 0.14), (0.65, 0.56)),
        *((3.70, 3.50), (3.70, 3.50)),
    ),
}
_COLUMN = {
    ("cascade", "init"): 0,
    ("cascade", "cold"): 1,
    ("integrated", "init"): 2,
    ("integrated", "cold"): 3,
}
_TURBULENCE: dict[str, _Pair] = {"init": (0.40, 0.28), "cold": (0.60, 0.46)}
_LIVING_AIR: dict[str, _Pair] = {"init": (0.35, 0.25), "cold": (0.75, 0.60)}
_CONSTANT_WIND_LOSS = "gps-loss-steady"
_LOSS: Goals = {"end_120s_m": (60.0, 40.0), "end_300s_m": (90.0, 60.0)}

SCENARIOS_WITH_GOALS = (*_STEADY, "turbulence", _CONSTANT_WIND_LOSS)
"""Besides these, those of the thesis in living air."""

OVER_LIMIT: _Pair = (1.5, 1.1)
"""rmse of heading of ``integrated`` over its limit."""


def goals(scenario: str, start: str, estimator: str) -> Goals:
    """Ours, for means over many flights; empty where there is no goal.

    ``estimator``: "cascade" or "integrated"; ``start``: "init" (the INS's last heading) or "cold".
    """
    if (estimator, start) not in _COLUMN:
        return {}
    found: Goals = {}
    integrated = estimator == "integrated"
    steady, living = scenario.removesuffix("+air"), scenario.endswith("+air")
    if integrated and living and steady in (*THESIS, "turbulence", "hard"):
        found["heading_rmse_deg"] = _LIVING_AIR[start]
    elif integrated and scenario == "turbulence":
        found["heading_rmse_deg"] = _TURBULENCE[start]
    elif scenario in _STEADY:
        row = _STEADY[scenario]
        found["heading_rmse_deg"] = row[_COLUMN[estimator, start]]
        if integrated and start == "init":
            found |= {"wind_north_rmse_m_s": row[4], "wind_east_rmse_m_s": row[5]}
    elif integrated and scenario == _CONSTANT_WIND_LOSS:
        found |= _LOSS
    return found


PEER_SCENARIO = "uav-gps-loss"
EKF2: dict[str, float] = {
    "aided_roll_rmse_deg": 0.070,
    "aided_pitch_rmse_deg": 0.069,
    "aided_heading_rmse_deg": 0.16,
    "aided_wind_rmse_m_s": 0.50,
    "lost_roll_rmse_deg": 0.10,
    "lost_pitch_rmse_deg": 0.14,
    "lost_heading_rmse_deg": 0.25,
    "lost_60s_m": 25.0,
    "lost_300s_m": 185.0,
    "lost_540s_m": 297.0,
}
"""PX4's EKF2 (v1.15), measured on 14 flights like ``uav-gps-loss``.

Mean rms of attitude and of wind (norm of two axes) with GPS, from 100 s on, and without; median
horizontal error so long after the loss. ``integrated`` has to be better in each.
"""
