# SPDX-License-Identifier: Apache-2.0
"""Linux network namespaces by system call, so that no tool (iproute2, util-linux) is needed.

A new namespace has nothing but a loopback interface that is down; `loopback_with_multicast` makes
it a bus. Only the calling thread moves; threads and processes it starts afterwards follow.
"""

from __future__ import annotations

import contextlib
import ctypes
import errno
import os
import socket
import struct
from collections.abc import Iterator
from pathlib import Path

_CLONE_NEWUSER = 0x10000000
_CLONE_NEWNET = 0x40000000
_OWN_NETWORK = "/proc/thread-self/ns/net"

# linux/rtnetlink.h, linux/netlink.h
_RTM_NEWLINK, _RTM_NEWROUTE = 16, 24
_NLM_F_REQUEST, _NLM_F_ACK, _NLM_F_CREATE = 0x1, 0x4, 0x400
_RTA_DST, _RTA_OIF = 1, 4
_RT_TABLE_MAIN, _RTPROT_BOOT, _RT_SCOPE_LINK, _RTN_UNICAST = 254, 3, 253, 1
_IFF_UP, _IFF_MULTICAST = 0x1, 0x1000

_libc = ctypes.CDLL(None, use_errno=True)


@contextlib.contextmanager
def own_network() -> Iterator[None]:
    """Put the calling thread into a new network namespace, and back at the end.

    Raises OSError (EPERM) where the process may not: it takes CAP_SYS_ADMIN.
    """
    before = os.open(_OWN_NETWORK, os.O_RDONLY | os.O_CLOEXEC)
    try:
        _unshare(_CLONE_NEWNET)
        try:
            loopback_with_multicast()
            yield
        finally:
            _check(_libc.setns(before, _CLONE_NEWNET), "setns")
    finally:
        os.close(before)


def move_to_own_network() -> None:
    """Put the whole process into a new user and network namespace, for the rest of its life.

    For a process without privileges: as the owner of the new user namespace it may set up the new
    network, and keeps its own user id there. Raises OSError, and leaves the process where it is,
    where user namespaces are not allowed (EPERM) or the process has a second thread (EINVAL).
    """
    # There is no way back, and some systems grant the namespace but no rights in it: a child tries.
    child = os.fork()
    if child == 0:
        status = 1
        try:
            _move()
            status = 0
        finally:
            os._exit(status)
    if os.waitpid(child, 0)[1] != 0:
        raise PermissionError(errno.EPERM, "user namespaces are not allowed")
    _move()


def _move() -> None:
    uid, gid = os.geteuid(), os.getegid()
    _unshare(_CLONE_NEWUSER | _CLONE_NEWNET)
    Path("/proc/self/setgroups").write_text("deny")
    Path("/proc/self/uid_map").write_text(f"{uid} {uid} 1")
    Path("/proc/self/gid_map").write_text(f"{gid} {gid} 1")
    loopback_with_multicast()


def loopback_with_multicast() -> None:
    """Bring up ``lo`` with multicast and route 224.0.0.0/4 to it. Raises OSError."""
    loopback = socket.if_nametoindex("lo")
    flags = _IFF_UP | _IFF_MULTICAST
    interface = struct.pack("=BxHiII", socket.AF_UNSPEC, 0, loopback, flags, flags)
    route = struct.pack(
        "=8BI",
        *(socket.AF_INET, 4, 0, 0, _RT_TABLE_MAIN, _RTPROT_BOOT, _RT_SCOPE_LINK, _RTN_UNICAST),
        0,
    )
    route += struct.pack("=HH4s", 8, _RTA_DST, socket.inet_aton("224.0.0.0"))
    route += struct.pack("=HHi", 8, _RTA_OIF, loopback)
    with socket.socket(socket.AF_NETLINK, socket.SOCK_RAW) as kernel:
        _ask(kernel, _RTM_NEWLINK, 0, interface)
        _ask(kernel, _RTM_NEWROUTE, _NLM_F_CREATE, route)


def _ask(kernel: socket.socket, kind: int, flags: int, body: bytes) -> None:
    header = struct.Struct("=IHHII")
    flags |= _NLM_F_REQUEST | _NLM_F_ACK
    kernel.send(header.pack(header.size + len(body), kind, flags, 1, 0) + body)
    (error,) = struct.unpack_from("=i", kernel.recv(4096), header.size)
    if error:
        raise OSError(-error, os.strerror(-error))


def _unshare(flags: int) -> None:
    _check(_libc.unshare(flags), "unshare")


def _check(result: int, call: str) -> None:
    if result != 0:
        error = ctypes.get_errno()
        raise OSError(error, f"{call}: {os.strerror(error)}")
