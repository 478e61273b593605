# SPDX-License-Identifier: Apache-2.0
"""What a calibration in one flight is worth in the next.

    python -m lodestar.studies.calibrated_flights --aircraft 8

Each aircraft flies a scenario twice, with the same lasting errors of its magnetic detector and all
else drawn anew. The first flight calibrates it; the second is answered without and with that.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lodestar import navigator, rotation
from lodestar.evaluation.metrics import rmse
from lodestar.evaluation.score import score
from lodestar.harness.scenario import Scenario, estimator_config, load_scenario, simulate
from lodestar.recordings.recording import Recording
from lodestar.simulation.sensor_errors import LASTING, WhiteNoise, measured, random_stream
from lodestar.simulation.suites import SUITES
from lodestar.studies import smdu_calibration
from lodestar.studies.smdu_calibration import Calibration

Array = NDArray[np.float64]

EARLY = "early_heading_rmse_deg"
METRICS = ("roll_rmse_deg", "pitch_rmse_deg", "heading_rmse_deg", EARLY, "coverage_1sigma_yaw_axis")
_EARLY_S = (60.0, 300.0)


@dataclass(frozen=True)
class Pair:
    """Two flights of one aircraft."""

    calibration: Calibration
    """Of the first."""
    nees: float
    """Its error against the truth, squared in units of its covariance; ideally 12."""
    without: dict[str, float]
    """METRICS of SAHRS in the second flight, uncalibrated."""
    with_it: dict[str, float]
    """The same, with the calibration of the first."""


def true_calibration(scenario: Scenario) -> Array:
    """The twelve numbers (12,) that undo the lasting errors of the scenario's detector."""
    models = tuple(
        model if isinstance(model, LASTING) else WhiteNoise(0.0)
        for model in SUITES[scenario.suite].smdu[scenario.calibrated]
    )
    fields = np.vstack([np.zeros(3), np.eye(3)])
    noiseless, lasting = (random_stream(scenario.airframe_seed, "b_B") for _ in range(2))
    raw = measured(fields, models, 1.0, noiseless, lasting)
    inverse = np.linalg.inv((raw[1:] - raw[0]).T)
    D = inverse - np.eye(3)
    off_diagonal = D[~np.eye(3, dtype=bool)]
    return np.concatenate([-inverse @ raw[0], np.diag(D), off_diagonal])


def fly_twice(scenario: Scenario, number: int) -> Pair:
    """Fly aircraft ``number`` twice. Raises ValueError if its first flight is not good enough."""
    scenario = replace(scenario, airframe_seed=number)
    first = simulate(scenario, 10_000 + number)
    calibration = smdu_calibration.calibrate(first, estimator_config(scenario, first))
    second = simulate(scenario, 20_000 + number)
    config = estimator_config(scenario, second)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "smdu.cal")
        smdu_calibration.store(calibration, path)
        stored = path.read_bytes()
    rows = []
    for bytes_ in (b"", stored):
        answered = navigator.run(second, config, bytes_)
        result = score(answered, case=scenario.name)
        row = {name: result.value("sahrs", name) or np.nan for name in METRICS}
        rows.append(row | {EARLY: early_heading_rms(answered)})
    error = calibration.x - true_calibration(scenario)
    nees = float(error @ np.linalg.solve(calibration.P, error))
    return Pair(calibration, nees, rows[0], rows[1])


def early_heading_rms(answered: Recording) -> float:
    """Heading error of SAHRS in deg, rms over the beginning of the flight, where it is valid."""
    sahrs, truth = answered["SAHRS"], answered["TRUTH"]
    time_s = sahrs["time_us"] * 1e-6
    rows = (time_s >= _EARLY_S[0]) & (time_s < _EARLY_S[1]) & sahrs["valid"]
    true = truth["heading"][np.searchsorted(truth["time_us"], sahrs["time_us"][rows])]
    return float(np.rad2deg(rmse(rotation.wrap_pi(sahrs["heading"][rows] - true))))


def main() -> None:
    """Fly the aircraft, print a line each and the means."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0] if __doc__ else "")
    parser.add_argument("--scenario", default="ordinary")
    parser.add_argument("--aircraft", type=int, default=8)
    parser.add_argument("--cold", action="store_true", help="align, rather than start from the INS")
    given = parser.parse_args()
    scenario = load_scenario(given.scenario)
    if given.cold:
        scenario = replace(scenario, initial_heading="cold")
    pairs = []
    print("aircraft  NEES/12   rms of roll, pitch, heading, heading from 60 to 300 s (deg),")
    print("                    share of yaw errors within 1 sigma: without | with")
    for number in range(1, given.aircraft + 1):
        pair = fly_twice(scenario, number)
        pairs.append(pair)
        _tell(f"{number:8d}  {pair.nees / 12:7.2f}", pair.without, pair.with_it)
    mean = {
        which: {name: float(np.mean([getattr(p, which)[name] for p in pairs])) for name in METRICS}
        for which in ("without", "with_it")
    }
    nees = float(np.mean([p.nees for p in pairs])) / 12
    _tell(f"    mean  {nees:7.2f}", mean["without"], mean["with_it"])


def _tell(head: str, *rows: dict[str, float]) -> None:
    shown = ("  ".join(f"{row[name]:6.3f}" for name in METRICS) for row in rows)
    print(head, "  |  ".join(shown), sep="   ", flush=True)


if __name__ == "__main__":
    main()
