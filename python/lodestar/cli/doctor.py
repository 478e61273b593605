# SPDX-License-Identifier: Apache-2.0
"""Command ``lodestar doctor``."""

from __future__ import annotations

import os
import re
import resource
import shutil
import subprocess
import sys
from collections.abc import Callable
from importlib import metadata
from pathlib import Path
from typing import NamedTuple

import typer

import lodestar
from lodestar.cli.common import FLIGHT_FAILED, JsonOption
from lodestar.errors import InputError
from lodestar.harness.isolation import DEFAULT_URL, ROUTE_ADVICE, multicast_fault

EXAMPLE = "Example: lodestar doctor"

_LCM_NEEDED = (1, 5, 3)
_BUFFER_BYTES = 2 << 20  # a second of every channel at 1000 Hz, with what the kernel adds
_IFF_MULTICAST = 0x1000


class Finding(NamedTuple):
    """What a check found; ``mend`` is empty where all is well."""

    found: str
    mend: str = ""
    needed: bool = True
    """A flight cannot do without."""


def command(as_json: JsonOption = False) -> None:
    """Check what a flight needs of this machine, and say how to mend what is missing.

    Ends with 0 if a flight can be flown, else with 1.
    """
    findings = {name: check() for name, check in CHECKS.items()}
    if as_json:
        import json

        typer.echo(json.dumps({name: one._asdict() for name, one in findings.items()}))
    else:
        _print(findings)
    if any(one.mend and one.needed for one in findings.values()):
        raise typer.Exit(FLIGHT_FAILED)


def _print(findings: dict[str, Finding]) -> None:
    for name, one in findings.items():
        mark = "ok" if not one.mend else "NO" if one.needed else "--"
        typer.echo(f"{mark}  {name}: {one.found}")
        if one.mend:
            typer.echo(f"    mend: {one.mend}")


def _flight_computer() -> Finding:
    from lodestar.harness.flight_computer import find_executable

    try:
        path = find_executable()
    except InputError as error:
        return Finding(str(error), "pip install . in the checkout, or make build")
    try:
        ended = subprocess.run([path, "--version"], capture_output=True, text=True, timeout=10)
    except (OSError, subprocess.TimeoutExpired) as error:
        return Finding(f"{path}: {error}", "make build")
    version = ended.stdout.strip()
    if ended.returncode != 0 or lodestar.__version__ not in version.split():
        said = version or ended.stderr.strip()
        return Finding(f"{path} says {said!r}, not {lodestar.__version__}", "make build")
    return Finding(f"{path}, {version}")


def _lcm() -> Finding:
    version = metadata.version("lcm")
    needed = ".".join(map(str, _LCM_NEEDED))
    if tuple(int(part) for part in re.findall(r"\d+", version)[:3]) < _LCM_NEEDED:
        return Finding(f"LCM {version}", f"{sys.executable} -m pip install lcm=={needed}")
    return Finding(f"LCM {version}")


def _isolation() -> Finding:
    # In a child: a process cannot come back out of a user namespace.
    script = (
        "from lodestar.harness import isolation\n"
        "with isolation.isolated_bus(whole_process=True) as url: print(url)"
    )
    ended = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    if ended.returncode != 0:
        return Finding("none is possible", ROUTE_ADVICE)
    if ended.stdout.strip() == DEFAULT_URL:
        return Finding("own network namespace")
    return Finding(
        "own port on the host's network: namespaces are not permitted",
        _namespace_advice(),
        needed=False,
    )


def _namespace_advice() -> str:
    """The kernel settings that forbid namespaces here, as commands that allow them."""
    allowed = {
        "kernel.apparmor_restrict_unprivileged_userns": "0",
        "kernel.unprivileged_userns_clone": "1",
        "user.max_user_namespaces": "10000",
    }
    wrong = []
    for name, value in allowed.items():
        path = Path("/proc/sys", *name.split("."))
        if path.exists() and (path.read_text().strip() == "0") == (value != "0"):
            wrong.append(f"{name}={value}")
    return f"sudo sysctl -w {' '.join(wrong)}" if wrong else "docker run --cap-add=SYS_ADMIN"


def _host_bus() -> Finding:
    fault = multicast_fault(DEFAULT_URL)
    if fault is None:
        return Finding(f"multicast comes back ({DEFAULT_URL})")
    return Finding(f"{fault}; only --bus needs it", ROUTE_ADVICE, needed=False)


def _loopback() -> Finding:
    flags = int(Path("/sys/class/net/lo/flags").read_text(), 16)
    if flags & _IFF_MULTICAST:
        return Finding("lo has multicast")
    return Finding(
        "lo has no multicast; only --bus without another network needs it",
        "sudo ip link set lo multicast on",
        needed=False,
    )


def _buffer() -> Finding:
    size = int(Path("/proc/sys/net/core/rmem_max").read_text())
    found = f"net.core.rmem_max is {size} bytes"
    if size >= _BUFFER_BYTES:
        return Finding(found)
    return Finding(
        f"{found}; a busy bus at 1000 Hz may lose messages",
        f"sudo sysctl -w net.core.rmem_max={_BUFFER_BYTES}",
        needed=False,
    )


def _java() -> Finding:
    missing = [name for name in ("java", "javac", "jar") if shutil.which(name) is None]
    if not missing:
        return Finding("java and javac found")
    return Finding(
        f"{', '.join(missing)} not found; only lodestar spy needs it",
        "sudo apt install default-jdk",
        needed=False,
    )


def _scheduling() -> Finding:
    script = "import os; os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))"
    ended = subprocess.run([sys.executable, "-c", script], capture_output=True)
    locked = resource.getrlimit(resource.RLIMIT_MEMLOCK)[0]
    unlimited = locked == resource.RLIM_INFINITY or os.geteuid() == 0
    if ended.returncode == 0 and unlimited:
        return Finding("SCHED_FIFO and locked memory permitted")
    what = [] if ended.returncode == 0 else ["SCHED_FIFO"]
    what += [] if unlimited else ["unlimited locked memory"]
    return Finding(
        f"{' and '.join(what)} not permitted; only --realtime wants it",
        "rtprio 90 and memlock unlimited for your user in /etc/security/limits.conf",
        needed=False,
    )


CHECKS: dict[str, Callable[[], Finding]] = {
    "lodestar-fc": _flight_computer,
    "LCM": _lcm,
    "isolated bus": _isolation,
    "host bus": _host_bus,
    "loopback": _loopback,
    "receive buffer": _buffer,
    "Java": _java,
    "realtime": _scheduling,
}
