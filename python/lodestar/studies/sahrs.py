# SPDX-License-Identifier: Apache-2.0
"""The study of SAHRS: both forms, calibrated and not, in simulated flights whose truth is known.

Cases are ``scenario/engine/calibrated`` (or ``uncalibrated``). One flight is simulated once for all
of them: the calibrations differ by the error of the magnetic detector alone, drawn from the same
random numbers, and the forms by nothing but their own equations.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodestar.errors import InputError
from lodestar.evaluation.comparison import compare_sahrs
from lodestar.evaluation.metrics import coverage, maximum, rmse
from lodestar.evaluation.requirements import SETTLING_S, is_hard
from lodestar.harness.scenario import (
    ENGINES,
    Scenario,
    estimator_config,
    fly_truth,
    load_scenario,
    measure,
)
from lodestar.navigator import run
from lodestar.recordings.recording import Channel, Recording
from lodestar.simulation import jsbsim_engine
from lodestar.simulation.earth import STANDARD_GRAVITY
from lodestar.studies.campaign import Cell, Result

Array = NDArray[np.float64]
Rows = NDArray[np.bool_]

SCENARIOS = ("ordinary", "turbulence", "hard")
AXES = ("roll", "pitch", "heading")
WINDOWS = ("during", "after")
"""Of hard manoeuvring: from its first to its last moment; from RECOVERY_S after that to the end."""

RECOVERY_S = 10.0
SERIES_S = 5.0
"""Between the samples that are kept of a series."""


@dataclass(frozen=True)
class Form:
    """A form of SAHRS: its estimator's name in rows, and its section of the configuration."""

    estimator: str
    section: str


FORMS = {"velocity": Form("sahrs", "strapdown"), "paper": Form("sahrs-paper", "sahrs")}

FORM_OF = {form.estimator: name for name, form in FORMS.items()}

# What is left of the magnetic detector's errors after a calibration, as an estimator is told.
_CALIBRATED = {"field_bias_sigma_nT": 75.0, "field_matrix_sigma": 0.0005}


@dataclass(frozen=True)
class Variant:
    """What a cell stands for."""

    scenario: Scenario
    engine: str
    form: str
    calibrated: bool

    @property
    def cell(self) -> Cell:
        """The cell of this variant."""
        flight = f"{self.scenario.name}/{self.engine}"
        calibrated = "calibrated" if self.calibrated else "uncalibrated"
        return Cell(flight, f"{flight}/{calibrated}", FORMS[self.form].estimator)

    @property
    def flown(self) -> Scenario:
        """The scenario with the magnetic detector of this variant."""
        return replace(self.scenario, calibrated=self.calibrated)

    def config(self) -> dict[str, Any]:
        """Tables of the configuration that make the variant."""
        # Of NAV only the place counts here, which the quicker filter knows as well.
        tables: dict[str, Any] = {"sahrs": {"form": self.form}, "fusion": {"filter": "cascade"}}
        if self.calibrated:
            tables.setdefault(FORMS[self.form].section, {}).update(_CALIBRATED)
        return tables


@dataclass(frozen=True)
class SahrsStudy:
    """See campaign.Study."""

    scenarios: tuple[Scenario, ...]
    engines: tuple[str, ...] = ENGINES
    forms: tuple[str, ...] = tuple(FORMS)
    calibrated: tuple[bool, ...] = (False, True)
    name: str = "sahrs"

    @cached_property
    def variants(self) -> dict[Cell, Variant]:
        """All cells and what they stand for."""
        return {
            variant.cell: variant
            for scenario in self.scenarios
            for engine in self.engines
            for calibrated in self.calibrated
            for form in self.forms
            for variant in [Variant(scenario, engine, form, calibrated)]
        }

    @property
    def cells(self) -> Sequence[Cell]:
        """See campaign.Study."""
        return tuple(self.variants)

    def fly(self, cells: Sequence[Cell], seed: int) -> list[Result]:
        """See campaign.Study."""
        variants = [self.variants[cell] for cell in cells]
        truth = fly_truth(variants[0].scenario, seed, variants[0].engine)
        inputs = {v.calibrated: measure(v.flown, truth, seed) for v in variants}
        results = []
        for variant in variants:
            sensed = inputs[variant.calibrated]
            config = estimator_config(variant.flown, sensed, variant.config())
            answered = run(sensed, config)
            errors = Errors.of(answered)
            name = variant.scenario.name
            windows = hard_windows(name, answered["TRUTH"], errors.time_us)
            figures = dict(score(errors, windows))
            results.append(Result(variant.cell, seed, figures, dict(series(errors))))
        return results

    def inputs(self, flight: str) -> str:
        """See campaign.Study."""
        variants = [v for v in self.variants.values() if v.cell.flight == flight]
        return describe(variants[0].scenario, variants[0].engine)


def sahrs_study(
    scenarios: Sequence[str], engines: Sequence[str], forms: Sequence[str], calibrated: set[bool]
) -> SahrsStudy:
    """The study of these variants, all of them where none is named.

    Raises InputError for one that does not exist, or a scenario that is named twice.
    """
    loaded = tuple(load_scenario(name) for name in scenarios or SCENARIOS)
    names = [scenario.name for scenario in loaded]
    return SahrsStudy(
        tuple(loaded[names.index(name)] for name in chosen("scenario", names, names)),
        chosen("engine", engines, ENGINES),
        chosen("form", forms, tuple(FORMS)),
        tuple(sorted(calibrated or {False, True})),
    )


def chosen(what: str, given: Sequence[str], allowed: Sequence[str]) -> tuple[str, ...]:
    """The given names, or all. Raises InputError for one that is not allowed or given twice."""
    for name in given:
        if name not in allowed:
            raise InputError(f"{what} {name}: unknown; allowed are {', '.join(allowed)}")
        if given.count(name) > 1:
            raise InputError(f"{what} {name}: given twice")
    return tuple(given or allowed)


def describe(scenario: Scenario, engine: str) -> str:
    """Scenario, route, engine and how flights are scored here: changes with any of them.

    Raises InputError for an engine that is not installed.
    """
    version = jsbsim_engine.version() if engine == "jsbsim" else ""
    texts = [Path(name).read_text() for name in (scenario.route, __file__)]
    return "\n".join([repr(scenario), engine, version, *texts])


@dataclass(frozen=True)
class Errors:
    """Errors of SAHRS in one flight, NaN where there is no valid output; angles in deg."""

    time_us: NDArray[np.int64]
    attitude: Array
    """Roll, pitch, heading, (n, 3)."""
    rotation: Array
    """About the body axes, (n, 3), whatever the attitude."""
    sigma: Array
    """Of the rotation, as published."""
    valid_share: float

    @classmethod
    def of(cls, answered: Recording) -> Errors:
        """Of a recording with SAHRS and TRUTH."""
        estimates = compare_sahrs(answered)
        attitude, rotation = estimates.attitude, estimates.rotation
        assert attitude is not None
        assert rotation is not None
        assert rotation.sigma is not None
        return cls(
            time_us=estimates.time_us,
            attitude=np.rad2deg(attitude.error),
            rotation=np.rad2deg(rotation.error),
            sigma=np.rad2deg(rotation.sigma),
            valid_share=estimates.available,
        )

    @property
    def settled(self) -> Rows:
        """Samples after the time in which an error may be of any size."""
        return np.asarray(self.time_us >= self.time_us[0] + SETTLING_S * 1e6)


def score(errors: Errors, windows: dict[str, Rows]) -> Iterator[tuple[str, float]]:
    """The figures of one flight, by name: those of the whole, and those of each window."""
    whole = np.ones(len(errors.time_us), bool)
    yield from attitude_figures("", errors, whole, errors.settled)
    for name, rows in windows.items():
        yield from attitude_figures(f"{name}_", errors, rows, rows)
    for index, axis in enumerate(AXES):
        for multiple in (1, 2):
            share = coverage(errors.rotation[:, index], errors.sigma[:, index], multiple)
            yield f"coverage_{multiple}sigma_{axis}", share
    yield "nees_attitude", float(np.nanmean(nees(errors.rotation, errors.sigma)))
    yield "rotation_max_deg", maximum(np.linalg.norm(errors.rotation[errors.settled], axis=1))
    yield "valid_share", errors.valid_share


def attitude_figures(
    prefix: str, errors: Errors, for_rms: Rows, for_max: Rows
) -> Iterator[tuple[str, float]]:
    """Rms and largest error of each axis over the given samples."""
    for index, axis in enumerate(AXES):
        yield f"{prefix}{axis}_rmse_deg", rmse(errors.attitude[for_rms, index])
        yield f"{prefix}{axis}_max_deg", maximum(errors.attitude[for_max, index])


def nees(error: Array, sigma: Array) -> Array:
    """Normalised squared error over its number of axes: 1 on average where sigma is the truth.

    Of the covariance only its diagonal is published. Correlation between the axes leaves the
    average as it is, and widens the spread.
    """
    return np.asarray(np.mean((error / sigma) ** 2, axis=-1))


def hard_windows(scenario: str, truth: Channel, time_us: NDArray[np.int64]) -> dict[str, Rows]:
    """Which of the times are during and which after hard manoeuvring; none in a calm scenario.

    Hard is a load factor above 1.8 or below 0.2, a body rate above 40 deg/s, or a pitch above
    30 deg: what no calm route does, and every hard manoeuvre begins and ends with.
    """
    load = -truth["f_B"][:, 2] / STANDARD_GRAVITY
    hard = (load > 1.8) | (load < 0.2)
    hard |= np.linalg.norm(truth["omega_B"], axis=1) > np.deg2rad(40.0)
    hard |= np.abs(truth["pitch"]) > np.deg2rad(30.0)
    moments = truth["time_us"][hard]
    if not is_hard(scenario) or not len(moments):
        return dict.fromkeys(WINDOWS, np.zeros(len(time_us), bool))
    return {
        "during": (time_us >= moments[0]) & (time_us <= moments[-1]),
        "after": time_us > moments[-1] + RECOVERY_S * 1e6,
    }


def series(errors: Errors) -> Iterator[tuple[str, NDArray[np.float32]]]:
    """Error and sigma about the body axes (deg) every SERIES_S, with their times (s)."""
    time = (errors.time_us - errors.time_us[0]) * 1e-6
    kept = np.searchsorted(time, np.arange(0.0, time[-1] + 1e-9, SERIES_S))
    yield "time_s", time[kept].astype(np.float32)
    for name, values in (("error", errors.rotation), ("sigma", errors.sigma)):
        for index, axis in enumerate(AXES):
            yield f"{name}_{axis}_deg", values[kept, index].astype(np.float32)
