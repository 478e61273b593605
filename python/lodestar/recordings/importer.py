# SPDX-License-Identifier: Apache-2.0
"""Anyone's CSV, npz or ULog as a recording, by a map file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lodestar import channels as table
from lodestar.errors import InputError
from lodestar.recordings.field_map import ChannelMap, FieldMap, Map, Require, read_map
from lodestar.recordings.recording import Recording
from lodestar.recordings.source import NoColumn, Source, Values, open_source
from lodestar.recordings.units import TIME, quantity

Mask = NDArray[np.bool_]
Columns = Callable[[str], Values]


@dataclass
class ImportReport:
    """What became of the rows of the source."""

    rows: int = 0
    kept: dict[str, int] = field(default_factory=dict)
    dropped: dict[str, dict[str, int]] = field(default_factory=dict)
    """By channel, or clock for rows of no use to any channel, then by reason."""
    left_out: list[str] = field(default_factory=list)
    """Optional channels that the source does not have, and why."""

    def drop(self, channel: str, reason: str, count: int) -> None:
        """Count dropped rows, if there are any."""
        if count:
            self.dropped.setdefault(channel, {})[reason] = count

    def lines(self) -> list[str]:
        """The report for a person."""
        told = [f"{self.rows} rows read"]
        clocks = [name for name in self.dropped if name not in self.kept]
        for channel in (*clocks, *self.kept):
            reasons = self.dropped.get(channel, {})
            dropped = "; ".join(f"{count} dropped: {why}" for why, count in reasons.items())
            if channel in self.kept:
                dropped = f"{self.kept[channel]} messages" + ("; " if dropped else "") + dropped
            if dropped:
                told.append(f"{channel}: {dropped}")
        return told + self.left_out


def import_recording(path: Path, map_path: Path) -> tuple[Recording, ImportReport]:
    """Read a CSV file (with a header line), an npz file of columns or a ULog, by the map.

    A row that no message can be made of is dropped and reported: its time is not finite or not
    later than that of the rows before it, a value is missing, not finite or out of physical range.

    Raises InputError for a file that cannot be read, a column that does not exist, a map that is
    wrong, or a channel of which nothing is left.
    """
    plan = read_map(map_path)
    source = open_source(path)
    report = ImportReport()
    clocks: dict[str, _Clock] = {}
    recording = Recording()
    for name, one in plan.channels.items():
        try:
            if one.clock not in clocks:
                clocks[one.clock] = _clock(source, one.clock, plan, report)
            _import_channel(recording, name, one, source, clocks[one.clock], report)
        except NoColumn as error:
            if not one.optional:
                raise
            report.left_out.append(f"{name} left out: {error}")
            continue
        if not report.kept[name]:
            raise InputError(f"{path}: nothing left of {name}: {report.dropped.get(name, {})}")
    return recording, report


@dataclass(frozen=True)
class _Clock:
    """A column of times, in s, and the rows of it that are of use."""

    seconds: Values
    rows: NDArray[np.int64]


def _clock(source: Source, name: str, plan: Map, report: ImportReport) -> _Clock:
    seconds = TIME[plan.time_unit](source.read(name))
    report.rows += len(seconds)
    finite = np.isfinite(seconds)
    report.drop(name, "time not finite", int(np.sum(~finite)))
    rows = np.flatnonzero(finite)
    if len(rows):
        latest = np.maximum.accumulate(seconds[rows])
        later = np.concatenate([[True], seconds[rows][1:] > latest[:-1]])
        report.drop(name, "time not later than before", int(np.sum(~later)))
        rows = rows[later]
    inside = (seconds[rows] >= plan.start_s) & (seconds[rows] <= plan.end_s)
    report.drop(name, "outside start_s to end_s", int(np.sum(~inside)))
    return _Clock(seconds, rows[inside])


def _import_channel(
    recording: Recording,
    name: str,
    plan: ChannelMap,
    source: Source,
    clock: _Clock,
    report: ImportReport,
) -> None:
    def columns(column: str) -> Values:
        return source.at(column, plan.clock)

    rows = clock.rows
    if plan.new is not None:
        rows = rows[columns(plan.new)[rows] != 0]
    rows = rows[:: plan.every]
    if plan.require is not None:
        good = _within(plan.require, columns, rows)
        reason = f"{plan.require.column} outside what the map requires"
        report.drop(name, reason, int(np.sum(~good)))
        rows = rows[good]
    items = [item for item in table.fields(name) if item.name != "time_us"]
    values = {
        item.name: _value(item, plan.fields[item.name], columns, clock.seconds[rows], rows)
        for item in items
    }
    if "beta" in values and plan.fields["beta"].flank:
        # A flank-angle vane measures atan2(v, u), sideslip is asin(v / V).
        values["beta"] = np.arctan(np.tan(values["beta"]) * np.cos(values["alpha"]))
    if "heading" in values:
        values["heading"] = np.mod(values["heading"], 2 * pi)
    keep = np.ones(len(rows), bool)
    for item in items:
        keep &= _plausible(name, item, values[item.name], keep, report)
    arrival = np.rint(clock.seconds[rows] * 1e6).astype(np.int64)[keep]
    kept: dict[str, NDArray[Any]] = {"time_us": arrival - round(plan.latency_s * 1e6)}
    for item in items:
        kept[item.name] = _as_type(values[item.name][keep], item)
    recording.put(name, kept, arrival)
    report.kept[name] = len(arrival)


def _value(
    item: table.Field, plan: FieldMap, columns: Columns, seconds: Values, rows: NDArray[np.int64]
) -> NDArray[Any]:
    shape = (len(rows), *item.shape)
    if plan.constant is not None:
        try:
            return np.broadcast_to(np.asarray(plan.constant, float), shape)
        except (TypeError, ValueError):
            raise InputError(
                f"{item.name}: constant {plan.constant!r} has not the shape {item.shape}"
            ) from None
    if plan.during_s is not None:
        start, end = plan.during_s
        return (seconds >= start) & (seconds <= end)
    if plan.condition is not None:
        return _within(plan.condition, columns, rows)
    source = np.stack([columns(one)[rows] for one in plan.columns], axis=-1)
    if plan.axes:
        source = np.stack([sign * source[:, axis] for axis, sign in plan.axes], axis=-1)
    converted = quantity(item.name).units[plan.unit](source)
    value: Values = (plan.scale * converted + plan.offset).reshape(shape)
    return value


def _within(plan: Require, columns: Columns, rows: NDArray[np.int64]) -> Mask:
    value = columns(plan.column)[rows]
    inside: Mask = (value >= plan.low) & (value <= plan.high)
    return inside


def _plausible(
    channel: str, item: table.Field, values: NDArray[Any], keep: Mask, report: ImportReport
) -> Mask:
    """Which messages have a finite value in physical range; the rest is counted once."""
    flat = values.reshape(len(values), -1)
    finite = np.isfinite(flat).all(axis=1)
    report.drop(channel, f"{item.name} missing or not finite", int(np.sum(keep & ~finite)))
    limits = quantity(item.name)
    low, high = limits.low, limits.high
    if item.dtype.kind == "i":
        low, high = np.iinfo(item.dtype).min, np.iinfo(item.dtype).max
    inside = ((flat >= low) & (flat <= high)).all(axis=1)
    unit = next(iter(limits.units))
    reason = f"{item.name} outside {low:.6g} to {high:.6g} {unit}"
    report.drop(channel, reason, int(np.sum(keep & finite & ~inside)))
    good: Mask = finite & inside
    return good


def _as_type(values: NDArray[Any], item: table.Field) -> NDArray[Any]:
    if item.dtype.kind == "f":
        return values.astype(item.dtype)
    whole: NDArray[Any] = np.rint(np.nan_to_num(values)).astype(np.int64)
    return whole != 0 if item.dtype.kind == "b" else whole.astype(item.dtype)
