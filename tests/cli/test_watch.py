# SPDX-License-Identifier: Apache-2.0
"""What ``lodestar watch`` shows of the latest messages."""

from rich.console import Console

from lodestar import messages
from lodestar.cli.watch import _table


def shown(latest) -> str:
    console = Console(width=120)
    with console.capture() as capture:
        console.print(_table(latest))
    return capture.get()


def test_a_warning_in_health_is_put_into_words():
    health = messages.health_t()
    assert "WARNING" not in shown({"HEALTH": health})
    health.warning = 1
    assert "WARNING: outside the geomagnetic model's validity" in shown({"HEALTH": health})
    health.warning = 3
    assert "WARNING: realtime scheduling refused" in shown({"HEALTH": health})


def test_what_is_thought_of_the_ins_is_put_into_words():
    monitor = messages.ins_monitor_t()
    monitor.state = 3
    assert "INS: miscompare" in shown({"INS.MONITOR": monitor})
    assert "INS" not in shown({})
