# SPDX-License-Identifier: Apache-2.0
"""A hardware-in-the-loop test of one's own. Run it with: pytest examples/my_hil_test.py"""

from lodestar.evaluation.score import score
from lodestar.harness.faults import Fault


def test_roll_and_pitch_hold_without_the_magnetic_detector(fly, scenario):
    lost = Fault("dropout", "SMDU", start_s=60)
    flight = fly(scenario("ordinary", duration_s=180, faults=[lost]), seed=7)
    result = score(flight, case="SMDU lost")
    assert result.value("sahrs", "roll_rmse_deg") < 2.0
    assert result.value("sahrs", "pitch_rmse_deg") < 2.0
