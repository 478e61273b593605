# SPDX-License-Identifier: Apache-2.0
"""Error models of SAHRS from flights: reference minus SAHRS, angle by angle (thesis appendix B).

The thesis took its Gauss-Markov models of heading, pitch and roll error from four flights with an
INS as reference, each fitted on one flight and validated on another. Angles are in rad here.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodestar.errors import InputError
from lodestar.evaluation.comparison import compare_sahrs
from lodestar.evaluation.metrics import rmse
from lodestar.evaluation.summary import NONE, Table
from lodestar.recordings.recording import Recording
from lodestar.studies.innovations_model import CONFIDENCE, LAGS, Fit, Residuals, fit, residuals

Array = NDArray[np.float64]

ANGLES = ("heading", "pitch", "roll")
REFERENCES = {"ins": "INS", "truth": "TRUTH"}


@dataclass(frozen=True)
class ErrorSeries:
    """Reference minus SAHRS, evenly sampled; NaN where either is missing or has no meaning."""

    flight: str
    interval_s: float
    time_us: NDArray[np.int64]
    errors: dict[str, Array]
    """By angle, rad."""


@dataclass(frozen=True)
class AngleModel:
    """What was found for one angle."""

    angle: str
    series: Array
    fit: Fit
    own: Residuals
    validation: Residuals | None


@dataclass(frozen=True)
class Identification:
    """The models of all angles, from one flight, validated on another if there is one."""

    reference: str
    flight: ErrorSeries
    validated_on: ErrorSeries | None
    angles: list[AngleModel]


def error_series(
    recording: Recording, flight: str, *, reference: str = "ins", interval_s: float = 1.0
) -> ErrorSeries:
    """The errors of a flight that is called ``flight``; reference is a key of REFERENCES.

    Raises InputError where SAHRS or the reference is missing, or where the interval is shorter than
    that of SAHRS.
    """
    channel = REFERENCES[reference]
    if "SAHRS" not in recording or not len(recording["SAHRS"]["time_us"]):
        raise InputError(f"{flight}: has no SAHRS; lodestar replay writes a log that has")
    _check_reference(recording, flight, channel)
    estimates = compare_sahrs(recording, channel)
    assert estimates.attitude is not None
    time_us = estimates.time_us
    usual_us = float(np.median(np.diff(time_us))) if len(time_us) > 1 else 0.0
    if not interval_s * 1e6 >= usual_us:
        raise InputError(
            f"{flight}: SAHRS answers every {usual_us * 1e-6:.3g} s; a sampling time of "
            f"{interval_s:g} s is shorter"
        )
    grid = np.arange(time_us[0], time_us[-1] + 1, round(interval_s * 1e6))
    row = _nearest(time_us, grid)
    # Evenly spaced answers are at most half their interval away; what jitters is a little more.
    missing = np.abs(time_us[row] - grid) > 0.75 * usual_us
    errors = {}
    for name, column in zip(estimates.attitude.names, estimates.attitude.error.T, strict=True):
        errors[name] = np.where(missing, np.nan, -column[row])
    return ErrorSeries(flight, interval_s, grid, {angle: errors[angle] for angle in ANGLES})


def _nearest(time_us: NDArray[np.int64], wanted_us: NDArray[np.int64]) -> NDArray[np.int64]:
    """Row of the nearest of the times."""
    after = np.searchsorted(time_us, wanted_us).clip(0, len(time_us) - 1)
    before = np.maximum(after - 1, 0)
    is_before = wanted_us - time_us[before] < time_us[after] - wanted_us
    return np.asarray(np.where(is_before, before, after))


def _check_reference(recording: Recording, flight: str, channel: str) -> None:
    there = channel in recording and len(recording[channel]["time_us"]) > 0
    if there and (channel != "INS" or recording["INS"]["valid"].any()):
        return
    other = "; --reference truth takes TRUTH" if channel == "INS" and "TRUTH" in recording else ""
    raise InputError(f"{flight}: has no valid {channel} to compare with{other}")


def identify(flight: ErrorSeries, validate: ErrorSeries | None, reference: str) -> Identification:
    """Fit a model to each angle, and see how well it predicts the other flight.

    Raises InputError for a flight that is too short, or without errors.
    """
    angles = [_angle_model(angle, flight, validate) for angle in ANGLES]
    return Identification(REFERENCES[reference], flight, validate, angles)


def _angle_model(angle: str, flight: ErrorSeries, validate: ErrorSeries | None) -> AngleModel:
    told = flight.flight
    try:
        y = flight.errors[angle]
        found = fit(y, flight.interval_s)
        own = residuals(found.model, y, own=True)
        other = None
        if validate is not None:
            told = validate.flight
            other = residuals(found.model, validate.errors[angle], own=False)
    except InputError as error:
        raise InputError(f"{told}: {angle} error: {error}") from None
    return AngleModel(angle, y, found, own, other)


def to_json(found: Identification) -> dict[str, Any]:
    """The object that ``--json`` prints; angles in deg."""
    return {
        "flight": found.flight.flight,
        "validated_on": found.validated_on.flight if found.validated_on else None,
        "reference": found.reference,
        "interval_s": found.flight.interval_s,
        "angles": [_angle_json(one) for one in found.angles],
    }


def _angle_json(one: AngleModel) -> dict[str, Any]:
    found, model = one.fit, one.fit.model
    low, high = found.tau_interval_s
    return {
        "angle": one.angle,
        "samples": found.samples,
        "mean_deg": degrees(float(np.nanmean(one.series))),
        "rms_deg": degrees(rmse(one.series)),
        "A": model.A,
        "A_sigma": _number(found.A_sigma),
        "K": model.K,
        "K_sigma": _number(found.K_sigma),
        "e_variance_deg2": degrees(model.e_sigma) ** 2,
        "tau_s": model.tau_s,
        "tau_sigma_s": _number(found.tau_sigma_s),
        "tau_low_s": low,
        "tau_high_s": _number(high),
        "sigma_deg": degrees(model.sigma),
        "process_sigma_deg": degrees(model.process_sigma),
        "noise_sigma_deg": degrees(model.noise_sigma),
        "residuals": _residuals_json(one.own),
        "validation": _residuals_json(one.validation) if one.validation else None,
    }


def _residuals_json(left: Residuals) -> dict[str, Any]:
    return {
        "rms_deg": degrees(left.rms),
        "fit_percent": _number(100.0 * left.explained),
        "autocorrelation": left.autocorrelation.tolist(),
        "bounds": left.bounds.tolist(),
        "outside": left.outside,
        "portmanteau": left.portmanteau,
        "portmanteau_limit": left.portmanteau_limit,
        "white": left.white,
    }


def _number(value: float) -> float | None:
    """What JSON has no number for is null."""
    return value if np.isfinite(value) else None


def tables(found: Identification) -> list[Table]:
    """The models, and what is left of each flight after them."""
    title = f"{found.reference} − SAHRS in {found.flight.flight}, every {_ts(found)} s"
    header = (
        "angle", "samples", "mean, °", "rms, °", "A", "K", "e σ, °",
        "τ, s", "τ 95 %, s", "process σ, °", "noise σ, °",
    )  # fmt: skip
    models = Table(title, header, [_model_cells(one) for one in found.angles])
    flights = [(found.flight.flight, [one.own for one in found.angles])]
    if found.validated_on is not None:
        others = [one.validation for one in found.angles if one.validation is not None]
        flights.append((found.validated_on.flight, others))
    return [models, *(_residual_table(flight, left) for flight, left in flights)]


def _ts(found: Identification) -> str:
    return f"{found.flight.interval_s:g}"


def _model_cells(one: AngleModel) -> tuple[str, ...]:
    found, model = one.fit, one.fit.model
    low, high = found.tau_interval_s
    known = np.isfinite(high)
    return (
        one.angle,
        str(found.samples),
        f"{degrees(float(np.nanmean(one.series))):.3f}",
        f"{degrees(rmse(one.series)):.3f}",
        _with_error(model.A, found.A_sigma),
        _with_error(model.K, found.K_sigma),
        f"{degrees(model.e_sigma):.4f}",
        f"{model.tau_s:.3g} ± {found.tau_sigma_s:.2g}" if known else f"{model.tau_s:.3g}",
        f"{low:.3g} to {high:.3g}" if known else NONE,
        f"{degrees(model.process_sigma):.3f}",
        f"{degrees(model.noise_sigma):.3f}",
    )


def _with_error(value: float, sigma: float) -> str:
    return f"{value:.4f} ± {sigma:.2g}" if np.isfinite(sigma) else f"{value:.4f}"


def _residual_table(flight: str, left: list[Residuals]) -> Table:
    body: list[tuple[str, ...]] = [
        (
            angle,
            f"{degrees(one.rms):.4f}",
            f"{100 * one.explained:.1f}",
            f"{one.autocorrelation[0]:.2f}",
            f"{one.outside} of {LAGS}",
            f"{one.portmanteau:.0f}",
            f"{one.portmanteau_limit:.0f}",
            "white" if one.white else "not white",
        )
        for angle, one in zip(ANGLES, left, strict=True)
    ]
    header = (
        "angle", "residual rms, °", "fit, %", "correlation at lag 1",
        "out of bounds", "portmanteau", "its limit", "verdict",
    )  # fmt: skip
    title = f"One-step prediction of {flight}; bounds of whiteness {100 * CONFIDENCE:.0f} %"
    return Table(title, header, body)
