# SPDX-License-Identifier: Apache-2.0
"""The study of SAHRS with bad input: the fault is put in, counted, told."""

import numpy as np
import pytest

from lodestar.errors import InputError
from lodestar.studies.ensemble import grouped
from lodestar.studies.sahrs_faults import (
    FAULTS,
    LENGTH_S,
    MEASUREMENTS,
    START_S,
    WHAT,
    sahrs_faults_study,
)
from lodestar.studies.sahrs_faults_findings import findings, plots

STUDY = sahrs_faults_study([], [])


@pytest.fixture(scope="module")
def flown():
    """One flight with and without a stuck vane, both forms."""
    cells = [c for c in STUDY.cells if c.case.endswith(("/none", "/stuck-beta"))]
    return grouped(STUDY.fly(cells, 1))


def of(flown, fault, estimator):
    (one,) = [e for e in flown if e.cell.case.endswith(fault) and e.cell.estimator == estimator]
    return one


def test_every_fault_is_flown_in_both_forms_and_said_in_words():
    assert len(STUDY.cells) == 2 * len(FAULTS)
    assert WHAT.keys() == FAULTS.keys()
    for faults in FAULTS.values():
        assert all((f.start_s, f.duration_s) == (START_S, LENGTH_S) for f in faults)


def test_a_stuck_vane_is_refused_and_counted_by_name(flown):
    stuck, sound = (of(flown, fault, "sahrs") for fault in ("/stuck-beta", "/none"))
    beta = f"refused_{MEASUREMENTS['velocity'].index('beta')}"
    assert sound.figure(beta)[0] == 0
    assert stuck.figure(beta)[0] == pytest.approx(30 * LENGTH_S, rel=0.1)  # air data at 30 Hz
    paper = of(flown, "/stuck-beta", "sahrs-paper")
    assert paper.figure("check live flow")[0] > 1000


def test_before_the_fault_a_flight_is_the_one_without_it(flown):
    for estimator in ("sahrs", "sahrs-paper"):
        stuck, sound = (of(flown, fault, estimator) for fault in ("/stuck-beta", "/none"))
        before = stuck.series("time_s")[0] < START_S
        for name in ("error_heading_deg", "sigma_roll_deg"):
            one, other = stuck.series(name)[0], sound.series(name)[0]
            np.testing.assert_array_equal(one[before], other[before])
            assert (one[~before] != other[~before]).any()


def test_rows_tell_errors_during_and_after_and_what_was_refused(flown):
    found = findings("sahrs-faults", flown)
    rows = {(r["case"], r["estimator"], r["metric"]): r for r in found.rows}
    case = "ordinary/profile/stuck-beta"
    assert rows[f"{case}/after", "sahrs", "heading_max_deg"]["limit"] == 10.0
    assert "limit" not in rows[f"{case}/during", "sahrs", "heading_max_deg"]
    assert rows[f"{case}/during", "sahrs", "roll_max_deg"]["limit"] == 30.0
    assert "limit" not in rows[f"{case}/during", "sahrs-paper", "roll_max_deg"]
    assert rows[f"{case}/during", "sahrs", "rejected_beta"]["value"] > 3000
    assert rows[f"{case}/during", "sahrs-paper", "rejected_check_live_flow"]["value"] > 1000
    assert ("ordinary/profile/none/during", "sahrs", "rejected_beta") not in rows
    refused = found.tables[1]
    assert any("beta" in row[-1] for row in refused.rows)
    assert {plot.name for plot in plots(flown)} == {
        "errors-ordinary-profile-sahrs",
        "errors-ordinary-profile-sahrs-paper",
    }


def test_an_engine_that_does_not_exist_is_refused():
    with pytest.raises(InputError, match="engine warp: unknown"):
        sahrs_faults_study(["warp"], [])
