# SPDX-License-Identifier: Apache-2.0
"""The flight computer's core in this process."""

from dataclasses import replace

import numpy as np
import pytest

from lodestar.channels import fields
from lodestar.evaluation.flight_facts import computer
from lodestar.harness.faults import Fault, inject
from lodestar.harness.scenario import estimator_config, load_scenario, simulate
from lodestar.navigator import run


@pytest.fixture(scope="module")
def flight():
    return simulate(replace(load_scenario("ordinary"), duration_s=30.0), 1)


def test_answers_have_the_fields_and_types_of_their_messages(flight):
    answered = run(flight)
    for channel in ("SAHRS", "NAV", "INS.MONITOR", "HEALTH"):
        for field in fields(channel):
            column = answered[channel][field.name]
            assert column.dtype == field.dtype, (channel, field.name)
            assert column.shape[1:] == field.shape, (channel, field.name)


def test_the_ins_is_watched_ten_times_a_second(flight):
    monitor = run(flight)["INS.MONITOR"]
    assert len(monitor["time_us"]) == pytest.approx(301, abs=2)
    assert np.all(np.diff(monitor["time_us"]) > 0)
    assert monitor["state"][-1] == 1


@pytest.mark.parametrize(
    ("earth", "warned"),
    [
        ("epoch_year = 2026.5", False),
        ("epoch_year = 2031.0", True),
        ('epoch_year = 2024.0\ngeomagnetic_model = "wmm2025"', True),
        ("epoch_year = 2024.0", False),
    ],
)
def test_a_flight_outside_the_geomagnetic_model_says_so_in_its_report(flight, earth, warned):
    answered = run(flight, f"[earth]\n{earth}\n")
    assert set(answered["HEALTH"]["warning"]) == {int(warned)}
    assert ("outside the geomagnetic model's validity" in computer(answered)) == warned


def navigation_of_a_minute(scenario, *faults):
    """NAV of the first minute from the INS's last attitude."""
    scenario = replace(load_scenario(scenario), duration_s=60.0, initial_heading="init")
    flight = inject(simulate(scenario, 1), faults, 1)
    return run(flight, estimator_config(scenario, flight))["NAV"]


@pytest.mark.parametrize(
    ("scenario", "calm"), [("ordinary", True), ("ordinary+air", False), ("turbulence", False)]
)
def test_navigation_goes_on_with_the_start_that_the_air_is_like(scenario, calm):
    nav = navigation_of_a_minute(scenario)
    changed = np.flatnonzero(np.diff(nav["reset_count"]))
    assert len(changed) == nav["reset_count"][-1] == int(calm)
    if calm:
        at = changed[0]
        assert nav["time_us"][at] * 1e-6 == pytest.approx(20.0, abs=2.0)
        assert nav["sigma_attitude"][at + 1, 2] < 0.8 * nav["sigma_attitude"][at, 2]


def test_without_air_data_nobody_knows_that_the_air_is_calm():
    nav = navigation_of_a_minute("ordinary", Fault("dropout", "ADC", 0.0))
    assert nav["valid"][-1]
    assert nav["reset_count"][-1] == 0
