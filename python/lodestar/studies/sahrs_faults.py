# SPDX-License-Identifier: Apache-2.0
"""The study of SAHRS with bad input: one sensor at fault for two minutes of a calm flight.

The window holds what brings a fault to light: 20 m/s of speed change, and a turn that is rolled
into and out of with 25 deg/s. Case ``none`` is the same flight without a fault.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import radians

import numpy as np

from lodestar.evaluation.metrics import maximum
from lodestar.harness.faults import Fault, inject
from lodestar.harness.scenario import (
    ENGINES,
    Scenario,
    estimator_config,
    fly_truth,
    load_scenario,
    measure,
)
from lodestar.navigator import run
from lodestar.recordings.recording import Recording
from lodestar.studies.campaign import Cell, Result
from lodestar.studies.fault_window import Rows, Window, refused_messages
from lodestar.studies.sahrs import FORMS, Errors, attitude_figures, chosen, describe, series

DURATION_S = 1200.0
START_S = 575.0
LENGTH_S = 120.0
WINDOW = Window(START_S, START_S + LENGTH_S)


def _fault(
    kind: str, channel: str, field: str, value: float = 0.0, interval_s: float = 1.0
) -> Fault:
    return Fault(kind, channel, START_S, LENGTH_S, field=field, value=value, interval_s=interval_s)


FAULTS: dict[str, tuple[Fault, ...]] = {
    "none": (),
    # On all three axes: it lengthens the field by 20 % and turns it by 10 degrees.
    "magnet": (_fault("bias", "SMDU", "b_B", 10_500.0),),
    "frozen-airspeed": (_fault("freeze", "ADC", "true_airspeed"),),
    "stuck-beta": (
        _fault("freeze", "ADC", "beta"),
        _fault("bias", "ADC", "beta", radians(5.0)),
    ),
    "baro-spike": (_fault("spike", "ADC", "baro_altitude", 300.0, interval_s=5.0),),
    "gyro-saturation": (_fault("saturate", "EFCS.RATES", "omega_B", radians(15.0)),),
}
WHAT = {
    "none": "no fault",
    "magnet": "10.5 µT on each axis: field norm 20 % off",
    "frozen-airspeed": "true airspeed stays as it was",
    "stuck-beta": "β stands at 5°",
    "baro-spike": "one baro altitude in 5 s is 300 m off",
    "gyro-saturation": "body rates stop at 15°/s, of 25 in the rolls",
}

MEASUREMENTS = {
    "velocity": ("field x", "field y", "field z", "airspeed", "alpha", "beta", "baro altitude"),
    "paper": ("field north", "field east", "field down", "pitch", "roll"),
}
"""Bits of SAHRS.rejected."""

CHECKS = (
    "airspeed",
    "climb rate",
    "steady velocity",
    "sideslip",
    "lateral load",
    "body rate",
    "pitch angle",
    "balance",
    "field strength",
    "live flow",
)
"""Columns of HEALTH.assumption_rejects."""

CHANNELS = ("EFCS.RATES", "EFCS.LOAD_FACTOR", "SMDU", "ADC")
_MOST_MEASUREMENTS = max(len(names) for names in MEASUREMENTS.values())


@dataclass(frozen=True)
class SahrsFaultsStudy:
    """See campaign.Study."""

    scenario: Scenario
    engines: tuple[str, ...] = ("profile",)
    forms: tuple[str, ...] = tuple(FORMS)
    name: str = "sahrs-faults"

    @cached_property
    def variants(self) -> dict[Cell, tuple[str, str, str]]:
        """Engine, fault and form of every cell."""
        return {
            self._cell(engine, fault, form): (engine, fault, form)
            for engine in self.engines
            for fault in FAULTS
            for form in self.forms
        }

    def _cell(self, engine: str, fault: str, form: str) -> Cell:
        flight = f"{self.scenario.name}/{engine}"
        return Cell(flight, f"{flight}/{fault}", FORMS[form].estimator)

    @property
    def cells(self) -> Sequence[Cell]:
        """See campaign.Study."""
        return tuple(self.variants)

    def fly(self, cells: Sequence[Cell], seed: int) -> list[Result]:
        """See campaign.Study."""
        engine, _, _ = self.variants[cells[0]]
        sound = measure(self.scenario, fly_truth(self.scenario, seed, engine), seed)
        results = []
        for cell in cells:
            _, fault, form = self.variants[cell]
            sensed = inject(sound, FAULTS[fault], seed)
            config = estimator_config(self.scenario, sensed, {"sahrs": {"form": form}})
            answered = run(sensed, config)
            errors = Errors.of(answered)
            figures = dict(_figures(errors, answered))
            results.append(Result(cell, seed, figures, dict(series(errors))))
        return results

    def inputs(self, flight: str) -> str:
        """See campaign.Study."""
        return describe(self.scenario, flight.split("/")[-1])


def sahrs_faults_study(engines: Sequence[str], forms: Sequence[str]) -> SahrsFaultsStudy:
    """The study with these engines (profile if none) and forms (all if none).

    Raises InputError for one that does not exist.
    """
    scenario = replace(load_scenario("ordinary"), duration_s=DURATION_S)
    return SahrsFaultsStudy(
        scenario,
        chosen("engine", engines or ("profile",), ENGINES),
        chosen("form", forms, tuple(FORMS)),
    )


def _figures(errors: Errors, answered: Recording) -> Iterator[tuple[str, float]]:
    windows = WINDOW.rows(errors.time_us)
    for name, rows in windows.items():
        yield from attitude_figures(f"{name}_", errors, rows, rows)
    during = windows["during"]
    yield "during_rotation_max_deg", maximum(np.linalg.norm(errors.rotation[during], axis=1))
    yield "during_valid_share", float(np.mean(answered["SAHRS"]["valid"][during]))
    yield "resets", float(answered["SAHRS"]["reset_count"][-1])
    yield from _refused(answered, during)
    yield from refused_messages(answered, WINDOW, CHANNELS)
    checks = WINDOW.grown(answered, "assumption_rejects")
    for check, count in zip(CHECKS, checks, strict=True):
        yield f"check {check}", float(count)


def _refused(answered: Recording, during: Rows) -> Iterator[tuple[str, float]]:
    """How often each measurement was refused during the fault."""
    bits = answered["SAHRS"]["rejected"][during]
    for number in range(_MOST_MEASUREMENTS):
        yield f"refused_{number}", float(np.sum(bits >> number & 1))
