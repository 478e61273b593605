# SPDX-License-Identifier: Apache-2.0
"""A flight of a scenario through lodestar-fc over LCM."""

from __future__ import annotations

import contextlib
import heapq
import tempfile
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from lodestar import _core
from lodestar import channels as table
from lodestar.errors import InputError
from lodestar.harness import CONFIG, LOG, clock
from lodestar.harness.bus import Bus
from lodestar.harness.clock import Event, Link, Progress
from lodestar.harness.faults import RawPayload
from lodestar.harness.flight_computer import FlightComputer
from lodestar.harness.isolation import isolated_bus
from lodestar.harness.scenario import (
    Scenario,
    estimator_config,
    load_scenario,
    malformed_datagrams,
    simulate,
)
from lodestar.recordings import Recording, codec
from lodestar.recordings.log import read_log


@dataclass(frozen=True)
class Plan:
    """What is flown: all that goes onto the bus, and the flight computer's configuration."""

    inputs: Recording
    """The sensors' messages, and TRUTH."""
    strays: Sequence[RawPayload]
    """Malformed datagrams, in order of arrival."""
    config: str
    """TOML text."""


def fly(
    scenario: Scenario | str | Path,
    seed: int = 1,
    *,
    engine: str = "profile",
    realtime: bool = False,
    url: str | None = None,
    config: Path | None = None,
    calibration: Path | None = None,
) -> Recording:
    """Simulate a scenario, fly it, and return everything that went over the bus.

    ``scenario`` may be a shipped one's name or a TOML file; ``engine`` is one of
    harness.scenario.ENGINES; ``config`` is a TOML file whose keys go before those of the scenario;
    ``calibration`` is used and, after a good flight, replaced, as by lodestar-fc. The bus is an
    isolated one unless ``url`` names another.

    Raises InputError for a bad scenario or configuration, or where there is no bus, and
    FlightComputerError if the flight computer ends or falls silent.
    """
    if not isinstance(scenario, Scenario):
        scenario = load_scenario(scenario)
    plan = prepare(scenario, seed, config, engine)
    with contextlib.ExitStack() as stack:
        url = url or stack.enter_context(isolated_bus())
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        fly_plan(plan, url, folder, calibration=calibration, realtime=realtime)
        return read_log(folder / LOG, strict=False)


def prepare(
    scenario: Scenario, seed: int, config: Path | None = None, engine: str = "profile"
) -> Plan:
    """Simulate the flight. Raises InputError for a bad scenario, engine or configuration."""
    overrides = {} if config is None else _read_config(config)
    inputs = simulate(scenario, seed, engine)
    return Plan(
        inputs,
        malformed_datagrams(scenario, seed),
        estimator_config(scenario, inputs, overrides),
    )


def fly_plan(
    plan: Plan,
    url: str,
    folder: Path,
    *,
    calibration: Path | None = None,
    realtime: bool = False,
    progress: Progress = lambda time_us: None,
) -> None:
    """Fly the plan; leave LOG and CONFIG in ``folder``. Otherwise as fly_over_bus."""
    (folder / CONFIG).write_text(plan.config)
    fly_over_bus(
        plan.inputs,
        url,
        folder / LOG,
        strays=plan.strays,
        config=folder / CONFIG,
        calibration=calibration,
        realtime=realtime,
        progress=progress,
    )


def fly_over_bus(
    inputs: Recording,
    url: str,
    log: Path,
    *,
    strays: Sequence[RawPayload] = (),
    config: Path | None = None,
    calibration: Path | None = None,
    realtime: bool = False,
    progress: Progress = lambda time_us: None,
) -> None:
    """Send inputs (and TRUTH) through a flight computer; log all that goes over the bus.

    However it ends, the process is stopped and ``log`` holds whole messages only.

    Raises InputError where there is no bus or the flight computer refuses ``config``, and
    FlightComputerError if it ends or falls silent.
    """
    script = events(inputs, strays)
    run = clock.realtime if realtime else clock.lockstep
    with (
        Bus(url) as bus,
        FlightComputer(bus, config=config, calibration=calibration, realtime=realtime) as computer,
        Link(bus, log) as link,
    ):
        run(script, link, computer, progress=progress)


def events(inputs: Recording, strays: Sequence[RawPayload] = ()) -> Iterator[Event]:
    """Everything to send, in order of arrival; what the recording has of outputs is left out."""
    malformed = (Event(s.arrival_us, s.channel, s.data, makes_frame=False) for s in strays)
    return heapq.merge(malformed, _messages(inputs), key=lambda event: event.arrival_us)


def _messages(inputs: Recording) -> Iterator[Event]:
    names = [name for name in table.EVENT_ORDER if name in inputs and name not in table.OUTPUTS]
    payloads = [codec.encode(name, inputs[name]) for name in names]
    makes_frame = [name == table.MASTER for name in names]
    arrays = inputs.event_arrays(names)
    return (
        Event(when, names[index], payloads[index][row], makes_frame[index])
        for when, index, row in zip(*(array.tolist() for array in arrays), strict=True)
    )


def _read_config(path: Path) -> dict[str, object]:
    """The tables of a configuration file, checked by the flight computer's own reader."""
    try:
        text = path.read_text()
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not UTF-8 text"
        raise InputError(f"{path}: {reason}") from None
    try:
        _core.check_config(text, str(path))
    except _core.ConfigError as error:
        raise InputError(str(error)) from None
    return tomllib.loads(text)
