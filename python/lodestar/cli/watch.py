# SPDX-License-Identifier: Apache-2.0
"""Command ``lodestar watch``."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from lodestar.cli.common import BusOption, bus_url

if TYPE_CHECKING:
    from rich.table import Table

EXAMPLE = "Example: lodestar watch, and lodestar fly --realtime --bus default in another terminal"

_PERIOD_S = 0.2
_CHANNELS = ("SAHRS", "NAV", "TRUTH", "HEALTH", "INS.MONITOR")


def command(
    bus: BusOption = "default",
) -> None:
    """Show attitude, navigation and health of a flight on the host's bus, until Ctrl-C."""
    from rich.live import Live

    from lodestar.harness.bus import Bus

    latest: dict[str, Any] = {}
    with Bus(bus_url(bus), _CHANNELS) as member, Live(auto_refresh=False) as live:
        while True:
            deadline = time.monotonic() + _PERIOD_S
            while (left := deadline - time.monotonic()) > 0:
                member.receive(left)
            for channel in _CHANNELS:
                for message in member.collect(channel)[-1:]:
                    latest[channel] = message
            live.update(_table(latest), refresh=True)


def _table(latest: dict[str, Any]) -> Table:
    from math import degrees

    from rich.table import Table

    from lodestar.channels import INS_STATES, WARNINGS

    table = Table(title="Waiting for a flight" if not latest else None)
    for name in ("", *_CHANNELS[:3]):
        table.add_column(name, justify="right", min_width=12)
    rows: list[tuple[str, str, Callable[[Any], str]]] = [
        ("time s", "time_us", lambda t: f"{t * 1e-6:.2f}"),
        ("roll deg", "roll", lambda a: f"{degrees(a):.2f}"),
        ("pitch deg", "pitch", lambda a: f"{degrees(a):.2f}"),
        ("heading deg", "heading", lambda a: f"{degrees(a):.2f}"),
        ("latitude deg", "lat", lambda a: f"{degrees(a):.6f}"),
        ("longitude deg", "lon", lambda a: f"{degrees(a):.6f}"),
        ("height m", "h", lambda h: f"{h:.1f}"),
        ("wind m/s", "wind_N", lambda w: f"{w[0]:.1f} {w[1]:.1f}"),
        ("mode", "mode", str),
    ]
    for label, field, show in rows:
        found = [getattr(latest.get(name), field, None) for name in _CHANNELS[:3]]
        table.add_row(label, *("" if value is None else show(value) for value in found))
    health = latest.get("HEALTH")
    if health is not None:
        caption = (
            f"received {sum(health.received)}, used {sum(health.used)}, "
            f"rejected {sum(map(sum, health.rejected))}, "
            f"frame {health.cycle_mean * 1e6:.1f} us mean, {health.cycle_max * 1e6:.1f} us max"
        )
        for bit, text in WARNINGS.items():
            if health.warning & bit:
                caption += f"\nWARNING: {text}"
        table.caption = caption
    monitor = latest.get("INS.MONITOR")
    if monitor is not None:
        table.title = f"INS: {INS_STATES[monitor.state]}"
    return table
