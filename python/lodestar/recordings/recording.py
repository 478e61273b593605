# SPDX-License-Identifier: Apache-2.0
"""A flight in memory: arrays over the messages of each channel."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lodestar import channels as table
from lodestar.errors import InputError

Channel = dict[str, NDArray[Any]]

_HELD_BY = {"f": "fiub", "i": "iub", "u": "iub", "b": "iub"}


@dataclass
class Recording:
    """The messages of a flight, by channel and field.

    ``channels["SMDU"]["b_B"]`` has the shape (n, 3) for n messages: the first axis is always the
    message, the rest and the dtype are those of the LCM field. Besides the fields each channel has
    ``arrival_us`` (int64, (n,)): when the message was sent or logged, in the order of the rows.
    """

    channels: dict[str, Channel] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    """What a reader left out, one line each, for a person."""

    def __contains__(self, channel: str) -> bool:
        return channel in self.channels

    def __getitem__(self, channel: str) -> Channel:
        return self.channels[channel]

    def __eq__(self, other: object) -> bool:
        """Equal when every channel holds the same bits (NaN equals NaN); notes do not count."""
        if not isinstance(other, Recording):
            return NotImplemented
        return self.channels.keys() == other.channels.keys() and all(
            _same(mine, other.channels[name]) for name, mine in self.channels.items()
        )

    def put(
        self, channel: str, values: Mapping[str, ArrayLike], arrival_us: ArrayLike | None = None
    ) -> None:
        """Store a channel's messages, checked against the LCM type and put in order of arrival.

        ``values`` holds every field of the message; ``arrival_us`` defaults to ``time_us``.
        Raises InputError for an unknown channel or field, a missing field, a wrong shape or a
        value that the field's type cannot hold.
        """
        if channel not in table.CHANNELS:
            raise InputError(f"channel {channel}: unknown; known are {', '.join(table.CHANNELS)}")
        layout = table.fields(channel)
        unknown = values.keys() - {item.name for item in layout}
        if unknown:
            raise InputError(f"{channel}: unknown field {', '.join(sorted(unknown))}")
        messages = len(np.atleast_1d(np.asarray(values.get("time_us", ()))))
        columns = {
            item.name: _column(channel, item, values.get(item.name), messages) for item in layout
        }
        arrival = _column(
            channel,
            table.Field("arrival_us", np.dtype(">i8"), ()),
            columns["time_us"] if arrival_us is None else arrival_us,
            messages,
        )
        if np.any(arrival[1:] < arrival[:-1]):
            order = np.argsort(arrival, kind="stable")
            arrival = arrival[order]
            columns = {name: column[order] for name, column in columns.items()}
        self.channels[channel] = {**columns, "arrival_us": arrival}

    def events(self) -> Iterator[tuple[int, str, int]]:
        """Yield (arrival_us, channel, row number) of every message in the order of arrival.

        Messages of the same arrival time come in the order of ``channels.EVENT_ORDER``: the body
        rates, which trigger a frame, last among the inputs.
        """
        names = [name for name in table.EVENT_ORDER if name in self.channels]
        arrival, channel, row = self.event_arrays(names)
        for when, index, number in zip(
            arrival.tolist(), channel.tolist(), row.tolist(), strict=True
        ):
            yield when, names[index], number

    def event_arrays(
        self, names: list[str]
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
        """Arrival times, indices into ``names`` and row numbers of all messages, as events()."""
        counts = [len(self.channels[name]["arrival_us"]) for name in names]
        if not counts:
            empty = np.empty(0, np.int64)
            return empty, empty, empty
        arrival = np.concatenate([self.channels[name]["arrival_us"] for name in names])
        channel = np.repeat(np.arange(len(names)), counts)
        row = np.concatenate([np.arange(count) for count in counts])
        order = np.lexsort((row, channel, arrival))
        return arrival[order], channel[order], row[order]

    def subset(self, names: tuple[str, ...]) -> Recording:
        """Only the named channels (those that exist), sharing the arrays."""
        return Recording({name: self.channels[name] for name in names if name in self.channels})

    def duration_s(self) -> float:
        """Seconds from the first to the last time of validity over all channels."""
        times = [one["time_us"] for one in self.channels.values() if len(one["time_us"])]
        if not times:
            return 0.0
        return float(max(t.max() for t in times) - min(t.min() for t in times)) * 1e-6


def _same(a: Channel, b: Channel) -> bool:
    return a.keys() == b.keys() and all(
        a[name].dtype == b[name].dtype
        and a[name].shape == b[name].shape
        and np.ascontiguousarray(a[name]).tobytes() == np.ascontiguousarray(b[name]).tobytes()
        for name in a
    )


def _column(channel: str, item: table.Field, value: ArrayLike | None, count: int) -> NDArray[Any]:
    name = f"{channel}/{item.name}"
    if value is None:
        raise InputError(f"{name}: missing")
    given = np.asarray(value)
    if given.shape != (count, *item.shape):
        raise InputError(f"{name}: shape {given.shape}, must be {(count, *item.shape)}")
    if given.dtype == item.dtype:
        return np.ascontiguousarray(given)
    if given.size and given.dtype.kind not in _HELD_BY[item.dtype.kind]:
        raise InputError(f"{name}: type {given.dtype}, must be {item.dtype}")
    column = given.astype(item.dtype)
    if item.dtype.kind != "f" and np.any(column != given):
        raise InputError(f"{name}: a value does not fit {item.dtype}")
    return column
