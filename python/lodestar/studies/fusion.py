# SPDX-License-Identifier: Apache-2.0
"""The study of navigation: GPS with SAHRS (``cascade``), and inside it (``integrated``).

Cases are ``scenario/engine/start``: ``init`` from the INS's last attitude, ``cold`` aligned by
itself. Estimators are the filters, and the same with other configurations (fusion_setups). One
flight is simulated once for all of them, and all see the same messages.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from lodestar.errors import InputError
from lodestar.evaluation.fusion_requirements import PEER_SCENARIO, THESIS, goals
from lodestar.harness.scenario import (
    COURSES,
    ENGINES,
    LIVING_AIR,
    Scenario,
    estimator_config,
    fly_truth,
    load_scenario,
    measure,
)
from lodestar.navigator import run
from lodestar.recordings.recording import Recording
from lodestar.simulation.suites import SUITES
from lodestar.studies import fusion_score
from lodestar.studies.campaign import Cell, Result
from lodestar.studies.fusion_score import Flight, figures, series
from lodestar.studies.fusion_setups import (
    ABLATIONS,
    BEFORE,
    FILTERS,
    LIMIT,
    Setup,
    check,
    shipped,
    variation,
    variations,
)
from lodestar.studies.sahrs import chosen, describe

STARTS = ("init", "cold")
LOSSES = ("gps-loss-steady", "gps-loss-10min", "gps-loss-60min")
"""Losses of GPS of 2, 5, 10 and 60 min in constant wind."""
_IN_LIVING_AIR = (*(name for name in THESIS if name != "vanern"), *LOSSES)
SCENARIOS = (
    *THESIS,
    "turbulence",
    "hard",
    *LOSSES,
    *(name + LIVING_AIR for name in _IN_LIVING_AIR),
    PEER_SCENARIO,
)
ABLATED = ("ordinary", "wind-pulse-12")
"""Where options are compared with the shipped configuration."""

BEFORE_RUNS = 20
ABLATION_RUNS = 10
LIMIT_RUNS = 10
"""Differences from the same flights, and sigmas, need fewer flights than means."""

_NAMED = (*BEFORE, LIMIT)


@dataclass(frozen=True)
class Variant:
    """What a cell stands for."""

    scenario: Scenario
    engine: str
    start: str
    setup: Setup
    most_runs: int | None = None

    @property
    def cell(self) -> Cell:
        """The cell of this variant."""
        flight = f"{self.scenario.name}/{self.engine}"
        return Cell(flight, f"{flight}/{self.start}", self.setup.name, self.most_runs)

    def config(self, sensed: Recording) -> str:
        """The configuration (TOML text) of the flight computer."""
        started = replace(self.scenario, initial_heading=self.start)
        return estimator_config(started, sensed, self.setup.tables())


@dataclass(frozen=True)
class FusionStudy:
    """See campaign.Study."""

    scenarios: tuple[Scenario, ...]
    engines: tuple[str, ...] = ("profile",)
    filters: tuple[str, ...] = FILTERS
    starts: tuple[str, ...] = ()
    """Those that have a goal if none."""
    options: tuple[str, ...] = ()
    """Further variations of the filters."""
    name: str = "fusion"

    @cached_property
    def variants(self) -> dict[Cell, Variant]:
        """All cells and what they stand for."""
        return {
            variant.cell: variant
            for scenario in self.scenarios
            for engine in self.engines
            for variant in self._of_flight(scenario, engine)
        }

    @property
    def cells(self) -> Sequence[Cell]:
        """See campaign.Study."""
        return tuple(self.variants)

    def fly(self, cells: Sequence[Cell], seed: int) -> list[Result]:
        """See campaign.Study."""
        variants = [self.variants[cell] for cell in cells]
        scenario, engine = variants[0].scenario, variants[0].engine
        sensed = measure(scenario, fly_truth(scenario, seed, engine), seed)
        results = []
        for variant in variants:
            flight = Flight.of(run(sensed, variant.config(sensed)), scenario)
            results.append(Result(variant.cell, seed, dict(figures(flight)), dict(series(flight))))
        return results

    def inputs(self, flight: str) -> str:
        """See campaign.Study."""
        variants = [v for v in self.variants.values() if v.cell.flight == flight]
        scored = Path(str(fusion_score.__file__)).read_text()
        # The other setups have their options in their names.
        return "\n".join([describe(variants[0].scenario, variants[0].engine), scored, repr(_NAMED)])

    def _of_flight(self, scenario: Scenario, engine: str) -> Iterator[Variant]:
        for start in self._starts_of(scenario):
            for setup, most_runs in self._setups(scenario, start):
                yield Variant(scenario, engine, start, setup, most_runs)

    def _starts_of(self, scenario: Scenario) -> tuple[str, ...]:
        # Without an INS on board there is none to start from.
        return (self.starts or STARTS) if SUITES[scenario.suite].ins else ("cold",)

    def _setups(self, scenario: Scenario, start: str) -> Iterator[tuple[Setup, int | None]]:
        name = scenario.name
        flown = self._filters_of(scenario, start)
        yield from ((shipped(one), None) for one in flown)
        if start == "init" and "cascade" in flown and name in THESIS:
            yield from ((setup, BEFORE_RUNS) for setup in BEFORE)
        if start == "init" and name in ABLATED:
            for one, options, _ in ABLATIONS:
                if one in flown:
                    yield variation(one, options), ABLATION_RUNS
        if LIMIT.filter in flown and goals(name, start, LIMIT.filter):
            yield LIMIT, LIMIT_RUNS
        for options in self.options:
            yield from ((setup, None) for setup in variations(options, flown))

    def _filters_of(self, scenario: Scenario, start: str) -> tuple[str, ...]:
        """A shipped scenario is flown from the second start where that has a goal."""
        first = start == self._starts_of(scenario)[0]
        if first or self.starts or scenario.name not in SCENARIOS:
            return self.filters
        return tuple(one for one in self.filters if goals(scenario.name, start, one))


def fusion_study(
    scenarios: Sequence[str],
    engines: Sequence[str],
    filters: Sequence[str],
    starts: Sequence[str],
    options: Sequence[str],
    course: str = "drawn",
) -> FusionStudy:
    """The study of these variants, all of them where none is named.

    ``course``: whether each seed flies the routes in a direction of its own (Scenario.course).
    How well a magnetic heading holds without GPS depends on where the aircraft goes: routes that
    always go the same way prove that way.

    Raises InputError for one that does not exist, a scenario that is named twice, or options that
    the flight computer does not have.
    """
    (course,) = chosen("course", (course,), COURSES)
    loaded = [replace(load_scenario(name), course=course) for name in scenarios or SCENARIOS]
    names = [scenario.name for scenario in loaded]
    study = FusionStudy(
        tuple(loaded[names.index(name)] for name in chosen("scenario", names, names)),
        chosen("engine", engines or ("profile",), ENGINES),
        chosen("filter", filters, FILTERS),
        chosen("start", starts, STARTS) if starts else (),
        tuple(options),
    )
    for given in options:
        if not list(variations(given, study.filters)):
            raise InputError(f"option {given}: is of none of {', '.join(study.filters)}")
    for setup in {variant.setup: None for variant in study.variants.values()}:
        check(setup, estimator_config(loaded[0], Recording(), setup.tables()))
    return study
