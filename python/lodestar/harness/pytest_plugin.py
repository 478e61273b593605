# SPDX-License-Identifier: Apache-2.0
"""Fixtures for hardware-in-the-loop tests against the real flight computer process.

Every test has a bus of its own, so tests may run side by side. Nothing is imported, and nothing is
started, until a test asks for one of the fixtures.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from lodestar.harness.bus import Bus
    from lodestar.harness.flight_computer import FlightComputer
    from lodestar.harness.scenario import Scenario
    from lodestar.recordings import Recording


@pytest.fixture
def bus_url() -> Iterator[str]:
    """The URL of a bus that only this test is on."""
    from lodestar.harness.isolation import isolated_bus

    with isolated_bus() as url:
        yield url


@pytest.fixture
def bus(bus_url: str) -> Iterator[Bus]:
    """A member of this test's bus that hears every output of the flight computer."""
    from lodestar.harness.bus import Bus

    with Bus(bus_url) as member:
        yield member


@pytest.fixture
def flight_computer(bus: Bus) -> Iterator[FlightComputer]:
    """lodestar-fc, with its default configuration, running on this test's bus."""
    from lodestar.harness.flight_computer import FlightComputer

    with FlightComputer(bus) as computer:
        yield computer


@pytest.fixture
def scenario() -> Callable[..., Scenario]:
    """``scenario(name_or_path, **changes)``: a scenario, with some of its keys changed.

    The changes are fields of ``lodestar.harness.scenario.Scenario``, as in
    ``scenario("ordinary", duration_s=60, faults=[Fault("dropout", "SMDU", start_s=30)])``.
    """
    from lodestar.harness.faults import check_fault
    from lodestar.harness.scenario import load_scenario

    def load(name_or_path: str | Path, **changes: Any) -> Scenario:
        loaded = dataclasses.replace(load_scenario(name_or_path), **changes)
        for fault in loaded.faults:
            check_fault(fault)
        return loaded

    return load


@pytest.fixture
def fly() -> Callable[..., Recording]:
    """``fly(scenario, seed=...)``: fly it in lockstep on a bus of its own, get the recording.

    Takes what ``lodestar.harness.fly.fly`` takes.
    """
    from lodestar.harness.fly import fly

    return fly
