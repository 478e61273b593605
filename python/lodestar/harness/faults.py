# SPDX-License-Identifier: Apache-2.0
"""Faults of sensors and bus, put into a recording before it is flown.

A fault names its kind, the channel, and from when and for how long (flight time, s). What else it
needs is in the table KINDS: ``field`` (a measured quantity of the channel; all of them by default
where the table says so), ``axis`` (0, 1, 2 of a vector; all by default), ``value``, ``interval_s``,
``bearing_deg``. The same recording, faults and seed give the same bits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from math import cos, inf, radians, sin

import numpy as np
from numpy.typing import NDArray

from lodestar import channels as table
from lodestar.errors import InputError
from lodestar.recordings.recording import Channel, Recording
from lodestar.simulation.earth import meridian_radius, transverse_radius
from lodestar.simulation.sensor_errors import random_stream
from lodestar.strict_toml import option

Rows = NDArray[np.bool_]


@dataclass(frozen=True)
class Kind:
    """What a kind of fault does, and what it must be told."""

    doc: str
    value: str = ""
    """Meaning of ``value``; empty where there is none."""
    field: str = ""
    """"one": a field must be named; "all": none means all measured fields; empty: takes none."""
    interval: bool = False
    channel: str = ""
    """The only channel it applies to."""


KINDS: dict[str, Kind] = {
    "dropout": Kind("no messages"),
    "freeze": Kind("values stay as they were; time goes on", field="all"),
    "bias": Kind("a step", value="unit of the field", field="one"),
    "ramp": Kind("an error that grows from zero", value="unit of the field per s", field="one"),
    "noise": Kind("noise becomes value times as strong", value="factor above 1", field="all"),
    "spike": Kind(
        "one message per interval is off", value="unit of the field", field="one", interval=True
    ),
    "saturate": Kind("values stop at plus and minus value", value="unit of the field", field="one"),
    "nan": Kind("values are not numbers", field="all"),
    "time_jump": Kind("time stamps are off", value="s"),
    "duplicate": Kind("every message comes twice"),
    "out_of_order": Kind("every second message comes after the next one"),
    "spoof": Kind(
        "position and velocity are dragged off along bearing_deg", value="m/s", channel="GPS"
    ),
    "malformed": Kind("broken datagrams besides the messages, one per interval", interval=True),
}


@dataclass(frozen=True)
class Fault:
    """[[faults]] of a scenario."""

    kind: str = option(choices=tuple(KINDS), doc="what goes wrong")
    channel: str = option(choices=table.INPUTS, doc="where")
    start_s: float = option(low=0, high=1e6, doc="from when")
    duration_s: float = option(inf, low=0, high=1e6, doc="for how long; to the end by default")
    field: str = option("", doc="measured quantity")
    axis: int = option(-1, low=0, high=2, doc="of a vector; all by default")
    value: float = option(0.0, low=-1e9, high=1e9, doc="size, in the unit that KINDS says")
    interval_s: float = option(1.0, low=0.001, high=1e6, doc="between spikes or bad datagrams")
    bearing_deg: float = option(90.0, low=-180, high=360, doc="true, of a spoofed drift")


@dataclass(frozen=True)
class RawPayload:
    """Bytes to publish as they are on ``channel`` when the flight reaches ``arrival_us``."""

    arrival_us: int
    channel: str
    data: bytes


def check_fault(fault: Fault) -> None:
    """Raise ValueError, saying what is allowed, where a fault's keys do not fit together."""
    kind = KINDS[fault.kind]
    if kind.channel and fault.channel != kind.channel:
        raise ValueError(f"{fault.kind} is for channel {kind.channel} only")
    measured = _measured_fields(fault.channel)
    if kind.field and fault.field and fault.field not in measured:
        raise ValueError(f"field {fault.field!r}: {fault.channel} has {', '.join(measured)}")
    if kind.field == "one" and not fault.field:
        raise ValueError(f"{fault.kind} needs a field: one of {', '.join(measured)}")
    if not kind.field and fault.field:
        raise ValueError(f"{fault.kind} takes no field")
    if kind.value and fault.value == 0.0:
        raise ValueError(f"{fault.kind} needs a value ({kind.value})")
    if fault.kind == "saturate" and fault.value < 0.0:
        raise ValueError("saturate needs a value above 0")
    if fault.kind == "noise" and fault.value <= 1.0:
        raise ValueError("noise needs a value above 1")


def inject(recording: Recording, faults: Iterable[Fault], seed: int) -> Recording:
    """A new recording with the faults in it, applied in order; the given one is not touched.

    Raises InputError for a fault on a channel that the recording does not have.
    """
    faulty = Recording(dict(recording.channels), list(recording.notes))
    for number, fault in enumerate(faults):
        if fault.kind == "malformed":
            continue
        if fault.channel not in faulty:
            raise InputError(
                f"fault {fault.kind}: no channel {fault.channel} in this flight; it has "
                f"{', '.join(faulty.channels)}"
            )
        columns = {name: values.copy() for name, values in faulty[fault.channel].items()}
        rng = random_stream(seed, f"fault {number}")
        columns = _APPLIED_BY[fault.kind](columns, _hit(columns, fault), fault, rng)
        arrival = columns.pop("arrival_us")
        faulty.put(fault.channel, columns, arrival)
    return faulty


def raw_payloads(faults: Iterable[Fault], seed: int, until_s: float) -> list[RawPayload]:
    """Malformed datagrams of the faults, in order of arrival, none from ``until_s`` on.

    Each kind of damage takes its turn: empty, cut short, foreign fingerprint, trailing bytes,
    random bytes, as long as a datagram gets.
    """
    payloads = []
    for number, fault in enumerate(faults):
        if fault.kind != "malformed":
            continue
        rng = random_stream(seed, f"fault {number}")
        end = min(fault.start_s + fault.duration_s, until_s)
        times = np.arange(fault.start_s, end, fault.interval_s)
        for turn, time in enumerate(times):
            data = _malformed(fault.channel, turn, rng)
            payloads.append(RawPayload(round(time * 1e6), fault.channel, data))
    return sorted(payloads, key=lambda payload: payload.arrival_us)


def _malformed(channel: str, turn: int, rng: np.random.Generator) -> bytes:
    good: bytes = table.CHANNELS[channel]().encode()
    damages: tuple[Callable[[], bytes], ...] = (
        lambda: b"",
        lambda: good[: int(rng.integers(1, len(good)))],
        lambda: bytes(8) + good[8:],
        lambda: good + rng.bytes(int(rng.integers(1, 64))),
        lambda: rng.bytes(len(good)),
        lambda: good[:8] + rng.bytes(60_000),
    )
    return damages[turn % len(damages)]()


def _measured_fields(channel: str) -> list[str]:
    return [item.name for item in table.fields(channel) if item.dtype.kind == "f"]


def _fields_of(fault: Fault) -> list[str]:
    return [fault.field] if fault.field else _measured_fields(fault.channel)


def _time(columns: Channel) -> NDArray[np.float64]:
    return np.asarray(columns["time_us"] * 1e-6)


def _hit(columns: Channel, fault: Fault) -> Rows:
    time = _time(columns)
    return np.asarray((time >= fault.start_s) & (time < fault.start_s + fault.duration_s))


def _axes(values: NDArray[np.float64], fault: Fault) -> NDArray[np.float64]:
    """1 where the fault works, 0 on the other axes; the shape of one message."""
    mask = np.ones(values.shape[1:])
    if fault.axis >= 0 and mask.ndim:
        mask[...] = 0.0
        mask[fault.axis] = 1.0
    return mask


def _add(columns: Channel, rows: Rows, fault: Fault, amount: NDArray[np.float64]) -> Channel:
    """Add ``amount`` (one per message) to the field on the rows that are hit."""
    values = columns[fault.field]
    shaped = np.where(rows, amount, 0.0).reshape(-1, *[1] * (values.ndim - 1))
    columns[fault.field] = values + shaped * _axes(values, fault)
    return columns


def _dropout(columns: Channel, rows: Rows, fault: Fault, rng: np.random.Generator) -> Channel:
    return {name: values[~rows] for name, values in columns.items()}


def _freeze(columns: Channel, rows: Rows, fault: Fault, rng: np.random.Generator) -> Channel:
    if rows.any():
        last_good = max(int(np.argmax(rows)) - 1, 0)
        for name in _fields_of(fault):
            columns[name][rows] = columns[name][last_good]
    return columns


def _bias(columns: Channel, rows: Rows, fault: Fault, rng: np.random.Generator) -> Channel:
    return _add(columns, rows, fault, np.full(len(rows), fault.value))


def _ramp(columns: Channel, rows: Rows, fault: Fault, rng: np.random.Generator) -> Channel:
    return _add(columns, rows, fault, fault.value * (_time(columns) - fault.start_s))


def _noise(columns: Channel, rows: Rows, fault: Fault, rng: np.random.Generator) -> Channel:
    for name in _fields_of(fault):
        values = columns[name]
        extra = np.sqrt(fault.value**2 - 1) * _noise_sigma(values)
        drawn = extra * _axes(values, fault) * rng.standard_normal(values.shape)
        columns[name] = np.where(rows.reshape(-1, *[1] * (values.ndim - 1)), values + drawn, values)
    return columns


def _noise_sigma(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """White noise of a signal, per axis, from its third differences.

    They hardly see a smooth signal and have 20 times the variance of the noise; the median is not
    led astray by manoeuvres.
    """
    if len(values) < 4:
        return np.zeros(values.shape[1:])
    spread = np.median(np.abs(np.diff(values, n=3, axis=0)), axis=0)
    return np.asarray(spread / 0.6745 / np.sqrt(20.0))


def _spike(columns: Channel, rows: Rows, fault: Fault, rng: np.random.Generator) -> Channel:
    turn = np.floor((_time(columns) - fault.start_s) / fault.interval_s)
    first = rows & np.concatenate([[True], np.diff(np.where(rows, turn, -1.0)) > 0])
    return _add(columns, first, fault, np.full(len(rows), fault.value))


def _saturate(columns: Channel, rows: Rows, fault: Fault, rng: np.random.Generator) -> Channel:
    values = columns[fault.field]
    hit = rows.reshape(-1, *[1] * (values.ndim - 1)) & (_axes(values, fault) > 0)
    columns[fault.field] = np.where(hit, np.clip(values, -fault.value, fault.value), values)
    return columns


def _nan(columns: Channel, rows: Rows, fault: Fault, rng: np.random.Generator) -> Channel:
    for name in _fields_of(fault):
        hit = rows.reshape(-1, *[1] * (columns[name].ndim - 1)) & (_axes(columns[name], fault) > 0)
        columns[name] = np.where(hit, np.nan, columns[name])
    return columns


def _time_jump(columns: Channel, rows: Rows, fault: Fault, rng: np.random.Generator) -> Channel:
    columns["time_us"][rows] += round(fault.value * 1e6)
    return columns


def _duplicate(columns: Channel, rows: Rows, fault: Fault, rng: np.random.Generator) -> Channel:
    return {name: np.repeat(values, 1 + rows, axis=0) for name, values in columns.items()}


def _out_of_order(columns: Channel, rows: Rows, fault: Fault, rng: np.random.Generator) -> Channel:
    late = np.flatnonzero(rows[:-1])[::2]
    columns["arrival_us"][late] = columns["arrival_us"][late + 1] + 1
    return columns


def _spoof(columns: Channel, rows: Rows, fault: Fault, rng: np.random.Generator) -> Channel:
    north, east = cos(radians(fault.bearing_deg)), sin(radians(fault.bearing_deg))
    way = np.where(rows, fault.value * (_time(columns) - fault.start_s), 0.0)
    lat, h = columns["lat"], columns["h"]
    columns["lon"] = columns["lon"] + way * east / ((transverse_radius(lat) + h) * np.cos(lat))
    columns["lat"] = lat + way * north / (meridian_radius(lat) + h)
    drift = fault.value * np.array([north, east, 0.0])
    columns["v_N"] = columns["v_N"] + (rows & columns["has_velocity"])[:, None] * drift
    return columns


_APPLIED_BY: dict[str, Callable[[Channel, Rows, Fault, np.random.Generator], Channel]] = {
    "dropout": _dropout,
    "freeze": _freeze,
    "bias": _bias,
    "ramp": _ramp,
    "noise": _noise,
    "spike": _spike,
    "saturate": _saturate,
    "nan": _nan,
    "time_jump": _time_jump,
    "duplicate": _duplicate,
    "out_of_order": _out_of_order,
    "spoof": _spoof,
}
