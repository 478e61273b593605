# SPDX-License-Identifier: Apache-2.0
"""Configurations that the study of navigation compares: data.

Options are ``key=value`` with the whole key, several of them with commas between.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from lodestar import _core
from lodestar.errors import InputError

FILTERS = ("cascade", "integrated")


@dataclass(frozen=True)
class Setup:
    """A filter with the shipped configuration, or with other values of some keys."""

    name: str
    """What rows call it."""
    filter: str
    options: str = ""

    def tables(self) -> dict[str, Any]:
        """Tables of the configuration. Raises InputError for an option without a value."""
        made: dict[str, Any] = {"fusion": {"filter": self.filter}}
        for key, value in _pairs(self.options):
            *sections, last = key.split(".")
            table = made
            for section in sections:
                table = table.setdefault(section, {})
            table[last] = value
        return made


BEFORE = (
    Setup("cascade-paper", "cascade", "sahrs.form=paper"),
    Setup(
        "cascade-thesis",
        "cascade",
        "sahrs.form=paper,sahrs.field_bias_sigma_nT=0.1,sahrs.field_matrix_sigma=0",
    ),
)
"""`cascade` behind the SAHRS paper's form, and behind one like the thesis's.

That takes the magnetic detector for free of bias, which its states then do not estimate.
"""

LIMIT = Setup(
    "limit",
    "integrated",
    # The shipped values are the suite's, but for what they add for the model of the field.
    "earth.geomagnetic_model=wmm2025,strapdown.field_drift_sigma_nT=60",
)
"""`integrated` that knows the error model exactly; the wind it has to assume."""

ABLATIONS: tuple[tuple[str, str, str], ...] = (
    ("cascade", "fusion.cascade.linearisation=linearised", "linearised, as the thesis had it too"),
    ("cascade", "fusion.cascade.covariance=ud", "UD form of the covariance"),
    (
        "cascade",
        "fusion.cascade.wind_sigma_m_s=5,fusion.cascade.wind_tau_s=400",
        "the thesis's model of wind, 5 m/s and 400 s",
    ),
    ("cascade", "fusion.cascade.wind_change_false_alarm=1e-12", "hardly looks for steps of wind"),
    (
        "cascade",
        "fusion.cascade.use_initial_heading=false",
        "heading error not started from the INS's last heading",
    ),
    (
        "cascade",
        "fusion.cascade.heading_turn_gain=10,fusion.cascade.wind_turn_gain=10",
        "noise of heading error and wind raised in turns, 10 times at 3°/s",
    ),
    (
        "cascade",
        "fusion.cascade.heading_deviation_sigma_deg=1",
        "heading error as the magnetic components give it, 1°",
    ),
    ("cascade", "fusion.cascade.attitude_error=small_angle", "one small rotation in N"),
    ("integrated", "strapdown.field_drift_sigma_nT=0", "without magnetometer Gauss-Markov"),
    ("integrated", "strapdown.field_matrix_sigma=0", "without magnetometer matrix"),
    ("integrated", "strapdown.field_bias_sigma_nT=0", "without magnetometer bias"),
    ("integrated", "strapdown.load_bias_sigma_g=0", "without load-factor bias"),
    (
        "integrated",
        "strapdown.airspeed_scale_sigma=0,strapdown.airspeed_bias_sigma_m_s=0",
        "without TAS scale and bias",
    ),
    ("integrated", "strapdown.flow_bias_sigma_deg=0", "without α/β bias"),
    ("integrated", "strapdown.flow_scale_sigma=0", "without α/β scale"),
    (
        "integrated",
        "strapdown.gyro_scale_sigma=0,strapdown.gyro_misalignment_sigma_deg=0",
        "without gyro matrix",
    ),
    ("integrated", "strapdown.gyro_drift_sigma_deg_s=0", "without gyro Gauss-Markov"),
    ("integrated", "fusion.integrated.gps_error_sigma_m=0.01", "without GPS Gauss-Markov"),
    ("integrated", "strapdown.field_noise_nT=1e5", "without the magnetometer"),
    (
        "integrated",
        "strapdown.airspeed_noise_m_s=20,strapdown.flow_noise_deg=10",
        "with hardly any air data",
    ),
)
"""Filter, options and what they mean."""


def shipped(name: str) -> Setup:
    """A filter as it is shipped."""
    return Setup(name, name)


def variation(name: str, options: str) -> Setup:
    """A filter with other options; what rows call it holds them, so it stands for nothing else."""
    return Setup(f"{name}:{options}", name, options)


def told(estimator: str) -> str:
    """What a setup is called where a person reads it."""
    for name, options, meaning in ABLATIONS:
        if estimator == variation(name, options).name:
            return meaning
    return estimator.split(":", 1)[-1]


def variations(options: str, filters: tuple[str, ...]) -> Iterator[Setup]:
    """The options given by a person, for each filter that has a use for them.

    Raises InputError for options that are no configuration.
    """
    for name in filters:
        others = (f"fusion.{other}." for other in FILTERS if other != name)
        if any(key.startswith(tuple(others)) for key, _ in _pairs(options)):
            continue
        yield variation(name, options)


def check(setup: Setup, text: str) -> None:
    """Raise InputError if the configuration ``text`` of a setup is not valid."""
    try:
        _core.check_config(text, f"option {setup.options}" if setup.options else setup.name)
    except _core.ConfigError as error:
        raise InputError(str(error)) from None


def _pairs(options: str) -> Iterator[tuple[str, Any]]:
    for option in filter(None, options.split(",")):
        key, equals, value = option.partition("=")
        if not (key and equals and value):
            raise InputError(f"option {option}: must be key=value, such as sahrs.form=paper")
        yield key, _value(value)


def _value(text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text
