# SPDX-License-Identifier: Apache-2.0
"""The flight bus from Python: publish and collect typed messages by channel name."""

from __future__ import annotations

import select
import time
from collections import deque
from collections.abc import Callable, Iterable
from typing import Any

import lcm

from lodestar import channels as table
from lodestar.errors import InputError
from lodestar.harness import isolation
from lodestar.recordings import codec

Message = Any
"""An instance of a class of ``lodestar.messages``."""

# Messages that wait unread on one channel: minutes of flight, but not all memory.
_LONGEST_QUEUE = 100_000


class Bus:
    """A member of the bus at ``url`` that hears the given channels.

    Channels are subscribed by name, never by pattern: a stray datagram on another channel cannot
    reach Python. Payloads of the wrong size or fingerprint are counted in ``malformed`` and dropped
    when they are decoded. Use it as a context manager, from one thread.

    Raises InputError for a channel that does not exist and where the bus cannot be joined.
    """

    def __init__(
        self, url: str = isolation.DEFAULT_URL, channels: Iterable[str] = table.OUTPUTS
    ) -> None:
        isolation.require_multicast(url)
        self.url = url
        self.malformed: dict[str, int] = {}
        self._inbox: dict[str, deque[bytes]] = {}
        self._tap: Callable[[str, bytes], None] | None = None
        try:
            self._lcm: Any = lcm.LCM(url)
        except RuntimeError as error:
            raise InputError(f"bus {url}: {error}") from None
        self._subscriptions = [self._subscribe(channel) for channel in channels]

    def __enter__(self) -> Bus:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Leave the bus; what was received can still be read."""
        for subscription in self._subscriptions:
            self._lcm.unsubscribe(subscription)
        self._subscriptions = []
        self._lcm = None

    def publish(self, channel: str, message: Message | bytes) -> None:
        """Send a message, or bytes as they are (to send what no encoder would make)."""
        data = message if isinstance(message, bytes) else message.encode()
        self._lcm.publish(channel, data)

    def tap(self, listener: Callable[[str, bytes], None] | None) -> None:
        """Hand each received payload to ``listener`` in order of arrival instead of keeping it."""
        self._tap = listener

    def fileno(self) -> int:
        """The descriptor that becomes readable when a message waits (for select)."""
        return int(self._lcm.fileno())

    def receive(self, timeout_s: float = 0.0) -> bool:
        """Take in what has arrived, waiting at most ``timeout_s`` for the first message."""
        if self._lcm is None:
            return False
        # Wait here, not inside LCM, where a signal would end the wait as an error of its own.
        if timeout_s > 0:
            select.select([self._lcm], [], [], timeout_s)
        heard = False
        while self._lcm.handle_timeout(0):
            heard = True
        return heard

    def collect(self, channel: str) -> list[Message]:
        """Take the messages of a channel that have arrived since the last call, oldest first."""
        self.receive()
        inbox = self._inbox[channel]
        found = []
        while inbox:
            message = self._decode(channel, inbox.popleft())
            if message is not None:
                found.append(message)
        return found

    def wait_for(
        self,
        channel: str,
        accept: Callable[[Message], bool] = lambda message: True,
        timeout_s: float = 5.0,
    ) -> Message:
        """Take messages of a channel up to and with the first one that ``accept`` likes.

        Raises TimeoutError, with the channel's name, if none comes in time.
        """
        deadline = time.monotonic() + timeout_s
        inbox = self._inbox[channel]
        while True:
            while inbox:
                message = self._decode(channel, inbox.popleft())
                if message is not None and accept(message):
                    return message
            left = deadline - time.monotonic()
            if left <= 0:
                raise TimeoutError(f"{channel}: no such message within {timeout_s:g} s")
            self.receive(left)

    def _subscribe(self, channel: str) -> Any:
        if channel not in table.CHANNELS:
            raise InputError(f"channel {channel}: unknown; known are {', '.join(table.CHANNELS)}")
        self._inbox[channel] = deque(maxlen=_LONGEST_QUEUE)
        # LCM reads the name as a regular expression.
        subscription = self._lcm.subscribe(channel.replace(".", "\\."), self._on_message)
        subscription.set_queue_capacity(_LONGEST_QUEUE)
        return subscription

    def _on_message(self, channel: str, data: bytes) -> None:
        if self._tap is None:
            self._inbox[channel].append(data)
        else:
            self._tap(channel, data)

    def _decode(self, channel: str, data: bytes) -> Message | None:
        """The message, or None (and counted) if the payload is not exactly one of the channel."""
        if len(data) == codec.wire_dtype(channel).itemsize:
            try:
                return table.CHANNELS[channel].decode(data)
            except ValueError:
                pass
        self.malformed[channel] = self.malformed.get(channel, 0) + 1
        return None
