# SPDX-License-Identifier: Apache-2.0
import ctypes
import os
import threading
import traceback
from collections.abc import Callable

import pytest

from lodestar.errors import InputError
from lodestar.harness import isolation, namespace

NOBODY = 65534
PR_SET_DUMPABLE = 4


def network() -> str:
    return os.readlink("/proc/thread-self/ns/net")


def in_child(body: Callable[[], None]) -> bool:
    """Whether ``body`` ran without an exception in a child process, which has one thread only."""
    child = os.fork()
    if child == 0:
        status = 1
        try:
            body()
            status = 0
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(status)
    return os.waitpid(child, 0)[1] == 0


def drop_privileges() -> None:
    if os.geteuid() == 0:
        os.setgroups([])
        os.setresgid(NOBODY, NOBODY, NOBODY)
        os.setresuid(NOBODY, NOBODY, NOBODY)
        # As after an exec: else the kernel lets only root write this process's id maps.
        ctypes.CDLL(None).prctl(PR_SET_DUMPABLE, 1)


needs_namespaces = pytest.mark.skipif(
    not in_child(namespace.move_to_own_network), reason="this machine permits no namespaces"
)


@needs_namespaces
def test_an_isolated_bus_is_another_network_and_is_left_at_the_end():
    def body() -> None:
        namespace.move_to_own_network()
        before = network()
        with isolation.isolated_bus() as url:
            inside = network()
            assert isolation.multicast_fault(url) is None
        assert inside != before
        assert network() == before

    assert in_child(body)


@needs_namespaces
def test_a_failure_inside_leads_back_out_too():
    def body() -> None:
        namespace.move_to_own_network()
        before = network()
        with pytest.raises(KeyError), isolation.isolated_bus():
            raise KeyError
        assert network() == before

    assert in_child(body)


@needs_namespaces
def test_a_process_without_privileges_moves_as_a_whole_and_keeps_its_user():
    def body() -> None:
        drop_privileges()
        user, before = os.getuid(), network()
        with isolation.isolated_bus(whole_process=True) as url:
            assert url == isolation.DEFAULT_URL
            assert network() != before
            assert os.getuid() == user
            assert isolation.multicast_fault(url) is None

    assert in_child(body)


@needs_namespaces
def test_without_privileges_a_library_takes_a_port_of_its_own_and_stays(monkeypatch):
    def refuse() -> None:
        raise PermissionError

    def body() -> None:
        namespace.move_to_own_network()
        before = network()
        monkeypatch.setattr(namespace, "own_network", refuse)
        with isolation.isolated_bus() as url:
            assert url != isolation.DEFAULT_URL
            assert url.endswith("?ttl=0")
            assert isolation.multicast_fault(url) is None
            assert network() == before

    assert in_child(body)


@needs_namespaces
def test_a_network_without_multicast_is_refused_with_what_mends_it(monkeypatch):
    monkeypatch.setattr(namespace, "loopback_with_multicast", lambda: None)

    def body() -> None:
        namespace._move()
        with pytest.raises(InputError, match=r"ip route add 224\.0\.0\.0/4 dev lo") as caught:
            isolation.require_multicast(isolation.DEFAULT_URL)
        assert "\n" not in str(caught.value)
        assert "lodestar doctor" in str(caught.value)

    assert in_child(body)


def test_a_process_with_threads_is_left_where_it_is():
    before = network()
    second = threading.Event()
    thread = threading.Thread(target=second.wait)
    thread.start()
    try:
        with pytest.raises(OSError, match=r"not allowed|Invalid argument"):
            namespace.move_to_own_network()
    finally:
        second.set()
        thread.join()
    assert network() == before


def test_private_urls_differ():
    assert len({isolation.private_url() for _ in range(20)}) == 20


@pytest.mark.parametrize(
    "url",
    [
        "",
        "tcpq://127.0.0.1:7700",
        "udpm://239.255.76.67",
        "udpm://239.255.76.67:0",
        "udpm://239.255.76.67:65536",
        "udpm://192.168.1.1:7667",
        "udpm://999.255.76.67:7667",
    ],
)
def test_a_url_that_is_no_multicast_bus_is_refused_by_name(url):
    with pytest.raises(InputError, match="bus") as caught:
        isolation.parse_url(url)
    assert repr(url) in str(caught.value)


def test_a_good_url_gives_group_and_port():
    assert isolation.parse_url("udpm://239.255.76.67:7667?ttl=0") == ("239.255.76.67", 7667)
