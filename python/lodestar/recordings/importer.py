# SPDX-License-Identifier: Apache-2.0
"""Anyone's CSV or npz as a recording, by a map file."""

from __future__ import annotations

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
from lodestar.recordings.source import Columns, Values, open_source
from lodestar.recordings.units import TIME, quantity

Mask = NDArray[np.bool_]


@dataclass
class ImportReport:
    """What became of the rows of the source."""

    rows: int
    kept: dict[str, int] = field(default_factory=dict)
    dropped: dict[str, dict[str, int]] = field(default_factory=dict)
    """By channel (``time``: rows of no use to any channel), then by reason."""

    def drop(self, channel: str, reason: str, count: int) -> None:
        """Count dropped rows, if there are any."""
        if count:
            self.dropped.setdefault(channel, {})[reason] = count

    def lines(self) -> list[str]:
        """The report for a person."""
        told = [f"{self.rows} rows read"]
        for channel in ("time", *self.kept):
            reasons = self.dropped.get(channel, {})
            dropped = "; ".join(f"{count} dropped: {why}" for why, count in reasons.items())
            if channel in self.kept:
                dropped = f"{self.kept[channel]} messages" + ("; " if dropped else "") + dropped
            if dropped:
                told.append(f"{channel}: {dropped}")
        return told


def import_recording(path: Path, map_path: Path) -> tuple[Recording, ImportReport]:
    """Read a CSV file (with a header line) or an npz file of columns, by the map.

    A row that no message can be made of is dropped and reported: its time is not finite or not
    later than that of the rows before it, a value is missing, not finite or out of physical range.

    Raises InputError for a file that cannot be read, a column that does not exist, a map that is
    wrong, or a channel of which nothing is left.
    """
    plan = read_map(map_path)
    columns, rows = open_source(path)
    report = ImportReport(rows)
    clock = TIME[plan.time_unit](columns(plan.time_column))
    usable = _usable_rows(clock, plan, report)
    recording = Recording()
    for name, one in plan.channels.items():
        _import_channel(recording, name, one, columns, clock, usable, report)
        if not report.kept[name]:
            raise InputError(f"{path}: nothing left of {name}: {report.dropped.get(name, {})}")
    return recording, report


def _usable_rows(clock: Values, plan: Map, report: ImportReport) -> NDArray[np.int64]:
    finite = np.isfinite(clock)
    report.drop("time", "time not finite", int(np.sum(~finite)))
    rows = np.flatnonzero(finite)
    if len(rows):
        latest = np.maximum.accumulate(clock[rows])
        later = np.concatenate([[True], clock[rows][1:] > latest[:-1]])
        report.drop("time", "time not later than before", int(np.sum(~later)))
        rows = rows[later]
    inside = (clock[rows] >= plan.start_s) & (clock[rows] <= plan.end_s)
    report.drop("time", "outside start_s to end_s", int(np.sum(~inside)))
    return rows[inside]


def _import_channel(
    recording: Recording,
    name: str,
    plan: ChannelMap,
    columns: Columns,
    clock: Values,
    rows: NDArray[np.int64],
    report: ImportReport,
) -> None:
    if plan.new is not None:
        rows = rows[columns(plan.new)[rows] != 0]
    rows = rows[:: plan.every]
    if plan.require is not None:
        good = _within(plan.require, columns, rows)
        report.drop(
            name, f"{plan.require.column} outside what the map requires", int(np.sum(~good))
        )
        rows = rows[good]
    values: dict[str, NDArray[Any]] = {}
    for item in table.fields(name):
        if item.name != "time_us":
            values[item.name] = _value(item, plan.fields[item.name], columns, clock, rows)
    if "beta" in values and plan.fields["beta"].flank:
        # A flank-angle vane measures atan2(v, u), sideslip is asin(v / V).
        values["beta"] = np.arctan(np.tan(values["beta"]) * np.cos(values["alpha"]))
    if "heading" in values:
        values["heading"] = np.mod(values["heading"], 2 * pi)
    keep = np.ones(len(rows), bool)
    for item in table.fields(name):
        if item.name != "time_us":
            keep &= _plausible(name, item, values[item.name], keep, report)
    arrival = np.rint(clock[rows] * 1e6).astype(np.int64)
    columns_kept: dict[str, NDArray[Any]] = {"time_us": arrival - round(plan.latency_s * 1e6)}
    for item in table.fields(name)[1:]:
        columns_kept[item.name] = _as_type(values[item.name], item)
    columns_kept = {key: value[keep] for key, value in columns_kept.items()}
    recording.put(name, columns_kept, arrival[keep])
    report.kept[name] = int(np.sum(keep))


def _value(
    item: table.Field, plan: FieldMap, columns: Columns, clock: Values, rows: NDArray[np.int64]
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
        return (clock[rows] >= start) & (clock[rows] <= end)
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
