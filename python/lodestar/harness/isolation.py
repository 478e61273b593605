# SPDX-License-Identifier: Apache-2.0
"""A bus that nobody else is on.

In order of preference: an own network namespace; else an own multicast group and port on this
host. LCM has no authentication, so either way nothing leaves the host (``ttl=0``).
"""

from __future__ import annotations

import contextlib
import random
import re
import socket
import struct
from collections.abc import Iterator

from lodestar.errors import InputError
from lodestar.harness import namespace

DEFAULT_URL = "udpm://239.255.76.67:7667?ttl=0"

ROUTE_ADVICE = "sudo ip link set lo multicast on; sudo ip route add 224.0.0.0/4 dev lo"


@contextlib.contextmanager
def isolated_bus(*, whole_process: bool = False) -> Iterator[str]:
    """Yield the URL of a bus that only the caller and its children are on.

    ``whole_process`` lets a process without privileges move into namespaces of its own for the
    rest of its life, which works only before it starts a thread (NumPy starts some on import);
    then it has no other network. It is for programs, not for libraries.

    Raises InputError where no multicast reaches this host itself.
    """
    with contextlib.ExitStack() as stack:
        if _enter_namespace(stack, whole_process):
            yield DEFAULT_URL
        else:
            url = private_url()
            require_multicast(url)
            yield url


def _enter_namespace(stack: contextlib.ExitStack, whole_process: bool) -> bool:
    try:
        stack.enter_context(namespace.own_network())
    except OSError:
        if not whole_process:
            return False
    else:
        return True
    try:
        namespace.move_to_own_network()
    except OSError:
        return False
    return True


def private_url() -> str:
    """The URL of a multicast group and a UDP port that nobody uses now."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("", 0))
        port = probe.getsockname()[1]
    # Not a result of any flight: an unseeded choice is the point.
    group = random.SystemRandom()
    return f"udpm://239.255.{group.randrange(256)}.{group.randrange(1, 255)}:{port}?ttl=0"


def parse_url(url: str) -> tuple[str, int]:
    """Multicast group and port of an LCM URL. Raises InputError for anything but udpm."""
    match = re.fullmatch(r"udpm://(\d+\.\d+\.\d+\.\d+):(\d+)(\?.*)?", url)
    if match is None or not 0 < int(match[2]) < 65536:
        raise InputError(f"bus {url!r}: must be udpm://GROUP:PORT?ttl=0, as {DEFAULT_URL}")
    try:
        multicast = 224 <= socket.inet_aton(match[1])[0] < 240
    except OSError:
        multicast = False
    if not multicast:
        raise InputError(f"bus {url!r}: {match[1]} is no multicast group (224.0.0.0/4)")
    return match[1], int(match[2])


def multicast_fault(url: str = DEFAULT_URL, timeout_s: float = 0.5) -> str | None:
    """Why a datagram to the group of ``url`` does not come back to this host; None if it does."""
    group, _ = parse_url(url)
    token = random.SystemRandom().randbytes(16)
    try:
        with (
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver,
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender,
        ):
            # Another port of the same group, so that nobody on the bus sees the probe.
            receiver.bind(("", 0))
            member = struct.pack("=4sI", socket.inet_aton(group), socket.INADDR_ANY)
            receiver.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)
            receiver.settimeout(timeout_s)
            sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
            sender.sendto(token, (group, receiver.getsockname()[1]))
            while receiver.recv(64) != token:
                pass
    except TimeoutError:
        return f"no multicast of {group} comes back to this host (firewall?)"
    except OSError as error:
        return f"no multicast route for {group} ({error.strerror})"
    return None


def require_multicast(url: str) -> None:
    """Raise InputError, with what mends it, where no multicast of ``url`` reaches this host."""
    fault = multicast_fault(url)
    if fault is not None:
        raise InputError(f"bus: {fault}; mend with: {ROUTE_ADVICE} (see lodestar doctor)")
