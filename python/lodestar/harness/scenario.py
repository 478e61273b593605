# SPDX-License-Identifier: Apache-2.0
"""Scenarios: one TOML file says which route is flown, in what air, with what sensors and faults.

``load_scenario("ordinary")`` finds a shipped scenario by its name, ``load_scenario("my.toml")`` a
file. ``<name>+air`` is the scenario in living air: its wind wanders (1 m/s, 120 s) and light Dryden
turbulence (0.7 m/s) is added. ``simulate`` flies it: the same scenario and seed give the same bits.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from math import degrees, pi, sqrt, tau
from pathlib import Path
from typing import Any

import numpy as np

from lodestar import strict_toml
from lodestar.errors import InputError
from lodestar.harness.faults import Fault, RawPayload, check_fault, inject, raw_payloads
from lodestar.paths import config_path, config_root, shipped
from lodestar.recordings.recording import Recording
from lodestar.simulation.flight_path import FlightError, FlightPath
from lodestar.simulation.jsbsim_engine import fly_jsbsim
from lodestar.simulation.profile import flight_path, read_profile, turned
from lodestar.simulation.sensor_errors import random_stream
from lodestar.simulation.sensors import GpsService, sense
from lodestar.simulation.suites import SUITES
from lodestar.simulation.trajectory import Aircraft, Trajectory, fly_path
from lodestar.simulation.wind import Turbulence, Wind
from lodestar.strict_toml import option

LIVING_AIR = "+air"
ENGINES = ("profile", "jsbsim")
COURSES = ("filed", "drawn")
_LAST_INS_SIGMA_DEG = 0.1  # of its attitude and heading


@dataclass(frozen=True)
class WindTable:
    """[wind]: velocity of the air over the ground."""

    north_m_s: float = option(0.0, low=-60, high=60, doc="steady wind towards the north")
    east_m_s: float = option(0.0, low=-60, high=60, doc="steady wind towards the east")
    pulse_north_m_s: float = option(0.0, low=-60, high=60, doc="added in every second interval")
    pulse_east_m_s: float = option(0.0, low=-60, high=60, doc="added in every second interval")
    pulse_interval_s: float = option(300.0, low=20, high=36000, doc="length of an interval")
    wander_sigma_m_s: float = option(0.0, low=0, high=20, doc="Gauss-Markov part, both axes")
    wander_tau_s: float = option(120.0, low=20, high=36000, doc="its correlation time")


@dataclass(frozen=True)
class TurbulenceTable:
    """[turbulence]: Dryden's."""

    sigma_m_s: float = option(0.0, low=0, high=10, doc="per axis")
    length_m: float = option(533.4, low=10, high=2000, doc="length scale")


@dataclass(frozen=True)
class OutageTable:
    """[[gps.outages]]: no fix at all."""

    start_s: float = option(low=0, high=1e6, doc="begin")
    duration_s: float = option(low=0, high=1e6, doc="length")


@dataclass(frozen=True)
class GpsTable:
    """[gps]: the receiver in this scenario."""

    errors: str = option("markov", choices=("markov", "white"), doc="kind of position errors")
    velocity: bool = option(False, doc="the receiver gives velocity")
    latency_s: float = option(0.2, low=0, high=1, doc="from validity to arrival")
    outages: tuple[OutageTable, ...] = option((), doc="times without any fix")


@dataclass(frozen=True)
class Air:
    """What of the air makes a flight: wind, turbulence, date (for its field), random numbers."""

    wind: Wind
    turbulence: Turbulence
    epoch_year: float
    seed: int


@dataclass(frozen=True)
class Scenario:
    """A scenario as its file says it; keys with a unit in their name are in that unit."""

    route: str = option(doc="profile: shipped name, or a file beside the scenario's")
    duration_s: float = option(low=1, high=36000, doc="length of the flight")
    description: str = option("", doc="one line for lists and reports")
    rate_hz: int = option(60, low=30, high=1000, doc="of body rates and load factor; tens")
    suite: str = option("gripen", choices=tuple(SUITES), doc="sensor suite")
    calibrated: bool = option(False, doc="the magnetic detector has been calibrated")
    airframe_seed: int = option(
        -1, low=-1, high=2**31, doc="of the detector's lasting errors; -1: the flight's own seed"
    )
    epoch_year: float = option(2026.5, low=2025, high=2030, doc="decimal year of the flight")
    course: str = option(
        "filed",
        choices=COURSES,
        doc="the route as its file has it, or turned about its start by an angle that each seed "
        "draws",
    )
    initial_heading: str = option(
        "init", choices=("init", "cold"), doc="start from the INS's last attitude, or align"
    )
    wind: WindTable = option(WindTable(), doc="wind")
    turbulence: TurbulenceTable = option(TurbulenceTable(), doc="turbulence")
    gps: GpsTable = option(GpsTable(), doc="GPS")
    faults: tuple[Fault, ...] = option((), doc="faults of sensors and bus")
    estimator: dict[str, Any] = option(factory=dict, doc="configuration of the flight computer")
    base: str = option("", doc="shipped scenario whose keys hold where this one has none")
    name: str = option("", doc="what reports call it; the file's name by default")

    def gps_outages(self) -> tuple[tuple[float, float], ...]:
        """(start, duration) in s."""
        return tuple((outage.start_s, outage.duration_s) for outage in self.gps.outages)


def scenario_names() -> list[str]:
    """Names of the shipped scenarios (each also exists as <name>+air)."""
    return shipped("scenarios", ".toml")


def load_scenario(name_or_path: str | Path) -> Scenario:
    """A shipped scenario by name, or one from a .toml file; with +air behind it, in living air.

    Raises InputError for an unknown name, and naming file, line and key for a bad file.
    """
    text = str(name_or_path)
    name = text.removesuffix(LIVING_AIR)
    path = Path(name) if name.endswith(".toml") else _shipped_scenario(name)
    document, values = _merged(path)
    missing = [key for key in strict_toml.required_keys(Scenario) if key not in values]
    if missing:
        raise InputError(f"{path}: {', '.join(missing)} missing")
    scenario = strict_toml.build(values, Scenario)
    scenario = replace(
        scenario,
        name=scenario.name or path.stem,
        route=str(_route(path, scenario.route)),
    )
    _check_sense(document, scenario)
    return in_living_air(scenario) if text.endswith(LIVING_AIR) else scenario


def in_living_air(scenario: Scenario) -> Scenario:
    """The scenario with wandering wind and at least light turbulence."""
    return replace(
        scenario,
        name=scenario.name + LIVING_AIR,
        wind=replace(scenario.wind, wander_sigma_m_s=1.0, wander_tau_s=120.0),
        turbulence=replace(scenario.turbulence, sigma_m_s=max(0.7, scenario.turbulence.sigma_m_s)),
    )


def fly_truth(scenario: Scenario, seed: int, engine: str = "profile") -> Trajectory:
    """The truth of the flight. Raises InputError where the route cannot be flown.

    ``engine``: "profile" flies the route to the digit, "jsbsim" as JSBSim's F-16 can.
    """
    if engine not in ENGINES:
        raise InputError(f"engine {engine}: unknown; allowed are {', '.join(ENGINES)}")
    turn = drawn_turn(seed) if scenario.course == "drawn" else 0.0
    way = _Way(scenario.route, scenario.rate_hz, turn)
    path = _path(way)
    count = round(scenario.duration_s * scenario.rate_hz) + 1
    if count > len(path.airspeed):
        raise InputError(
            f"{scenario.route}: lasts {path.duration:.1f} s, scenario {scenario.name} asks for "
            f"{scenario.duration_s:g} s"
        )
    w = scenario.wind
    wind = Wind(
        steady=(w.north_m_s, w.east_m_s),
        pulse=(w.pulse_north_m_s, w.pulse_east_m_s),
        pulse_interval=w.pulse_interval_s,
        wander_sigma=w.wander_sigma_m_s,
        wander_tau=w.wander_tau_s,
    )
    turbulence = Turbulence(scenario.turbulence.sigma_m_s, scenario.turbulence.length_m)
    # In calm air every seed flies a way to the same digit.
    calm = wind.wander_sigma == 0.0 and turbulence.sigma == 0.0
    aircraft = SUITES[scenario.suite].aircraft
    air = Air(wind, turbulence, scenario.epoch_year, 0 if calm else seed)
    return _truth(way, count, aircraft, air, engine)


def simulate(scenario: Scenario, seed: int, engine: str = "profile") -> Recording:
    """Fly the scenario: the sensors' messages, faults included, and TRUTH.

    Raises InputError where the route cannot be flown or a fault does not fit the flight.
    """
    return measure(scenario, fly_truth(scenario, seed, engine), seed)


def measure(scenario: Scenario, trajectory: Trajectory, seed: int) -> Recording:
    """What the scenario's sensors give on a flight, faults included, and TRUTH.

    Raises InputError where a fault does not fit the flight.
    """
    gps = GpsService(
        scenario.gps.errors,
        scenario.gps.velocity,
        scenario.gps.latency_s,
        scenario.gps_outages(),
    )
    channels = sense(
        trajectory,
        SUITES[scenario.suite],
        gps,
        calibrated=scenario.calibrated,
        seed=seed,
        airframe_seed=None if scenario.airframe_seed < 0 else scenario.airframe_seed,
    )
    recording = Recording()
    for channel, columns in channels.items():
        fields = {name: values for name, values in columns.items() if name != "arrival_us"}
        recording.put(channel, fields, columns.get("arrival_us"))
    return inject(recording, scenario.faults, seed)


def malformed_datagrams(scenario: Scenario, seed: int) -> list[RawPayload]:
    """Payloads that the scenario's faults put on the bus besides the recording's messages."""
    return raw_payloads(scenario.faults, seed, scenario.duration_s)


def estimator_config(
    scenario: Scenario, recording: Recording, overrides: Mapping[str, Any] | None = None
) -> str:
    """The configuration (TOML text) of the flight computer for a simulated flight.

    The date is the scenario's. With ``initial_heading = "init"`` and an INS on board the start is
    the INS's first solution; otherwise the flight computer aligns itself. The scenario's own
    [estimator] goes before that, and ``overrides`` (tables as tomllib gives them) before both.
    """
    tables: dict[str, Any] = {"earth": {"epoch_year": scenario.epoch_year}}
    if scenario.initial_heading == "init" and "INS" in recording:
        first = {name: values[0] for name, values in recording["INS"].items()}
        tables["initial"] = {
            f"{name}_deg": degrees(first[name]) for name in ("lat", "lon", "roll", "pitch")
        } | {
            "h_m": float(first["h"]),
            "heading_deg": degrees(first["heading"]),
            "heading_sigma_deg": _LAST_INS_SIGMA_DEG,
            "attitude_sigma_deg": _LAST_INS_SIGMA_DEG,
        }
    return _toml_text(_merge(_merge(tables, scenario.estimator), overrides or {}))


def _shipped_scenario(name: str) -> Path:
    if name not in scenario_names():
        raise InputError(
            f"scenario {name}: unknown; shipped are {', '.join(scenario_names())}, each also with "
            f"{LIVING_AIR} behind it; or give the path of a .toml file"
        )
    return config_path(f"scenarios/{name}.toml")


def _merged(path: Path) -> tuple[strict_toml.Document, dict[str, Any]]:
    """The checked values of a scenario file over those of its base."""
    document = strict_toml.read(path)
    strict_toml.check(document, Scenario)
    base = document.values.get("base", "")
    if not base:
        return document, document.values
    if base not in scenario_names() or base == path.stem:
        raise document.error(
            ("base",), f"{base!r} is no shipped scenario; they are {', '.join(scenario_names())}"
        )
    _, inherited = _merged(config_path(f"scenarios/{base}.toml"))
    return document, _merge(inherited, document.values)


def _merge(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    merged = dict(below)
    for key, value in above.items():
        old = merged.get(key)
        both = isinstance(old, dict) and isinstance(value, dict)
        merged[key] = _merge(old or {}, value) if both else value
    return merged


def _check_sense(document: strict_toml.Document, scenario: Scenario) -> None:
    """What one key alone does not show."""
    if scenario.rate_hz % 10:
        raise document.error(("rate_hz",), f"{scenario.rate_hz}: must be a multiple of 10")
    for number, fault in enumerate(scenario.faults):
        try:
            check_fault(fault)
        except ValueError as error:
            raise document.error(("faults", number), str(error)) from None


def _route(scenario_file: Path, route: str) -> Path:
    """The profile a scenario names: beside its own file, or shipped."""
    beside = scenario_file.parent / route
    if route.endswith(".profile") and beside.is_file():
        return beside
    name = route.removesuffix(".profile")
    if name not in shipped("routes", ".profile"):
        raise InputError(
            f"{scenario_file}: route {route!r}: no such file, and not one of the shipped routes "
            f"{', '.join(shipped('routes', '.profile'))}"
        )
    return config_root() / "routes" / f"{name}.profile"


@dataclass(frozen=True)
class _Way:
    """A route, how it is sampled, and by what angle (rad) it is turned to the right."""

    route: str
    rate_hz: int
    turn: float


def drawn_turn(seed: int) -> float:
    """The angle (rad, 0 to 2 pi) by which a seed turns a route whose course is drawn.

    A multiple of the golden angle: however few seeds in a row there are, they look everywhere.
    """
    golden_angle = pi * (3 - sqrt(5))
    return seed * golden_angle % tau


@lru_cache(maxsize=4)
def _path(way: _Way) -> FlightPath:
    """The path of a way: many seeds fly the same, so kept."""
    return flight_path(turned(read_profile(Path(way.route)), way.turn), way.rate_hz)


def _beginning(path: FlightPath, count: int) -> FlightPath:
    """The first samples of a path."""
    return replace(
        path,
        airspeed=path.airspeed[:count],
        path_angle=path.path_angle[:count],
        track=path.track[:count],
        bank=path.bank[:count],
    )


@lru_cache(maxsize=2)
def _truth(way: _Way, count: int, aircraft: Aircraft, air: Air, engine: str) -> Trajectory:
    """A flight of the first ``count`` samples: seconds of work, so kept, its arrays read-only."""
    path = _beginning(_path(way), count)
    wind, turbulence = air.wind, air.turbulence
    if engine == "jsbsim":
        try:
            trajectory = fly_jsbsim(path, wind, turbulence, air.epoch_year, air.seed)
        except FlightError as error:
            raise InputError(f"{way.route}: {error}") from None
    else:
        interval = 1 / way.rate_hz
        time = interval * np.arange(count, dtype=np.float64)
        mean_airspeed = float(np.mean(path.airspeed))
        gusts = random_stream(air.seed, "turbulence")
        trajectory = fly_path(
            path,
            wind.velocity_N(time, random_stream(air.seed, "wind")),
            turbulence.gust_B(count, interval, mean_airspeed, gusts),
            aircraft,
            air.epoch_year,
        )
    for values in vars(trajectory).values():
        if isinstance(values, np.ndarray):
            values.setflags(write=False)
    return trajectory


def _toml_text(tables: Mapping[str, Any], prefix: str = "") -> str:
    """Nested tables of plain values as TOML."""
    # JSON writes texts, numbers, truth values and lists as TOML does.
    plain = [
        f"{k} = {json.dumps(v, default=str)}\n"
        for k, v in tables.items()
        if not isinstance(v, Mapping)
    ]
    text = (f"[{prefix}]\n" if prefix and plain else "") + "".join(plain)
    for key, value in tables.items():
        if isinstance(value, Mapping):
            text += _toml_text(value, f"{prefix}.{key}" if prefix else key)
    return text
