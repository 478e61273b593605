# SPDX-License-Identifier: Apache-2.0
import socket

import pytest
from lodestar.messages import attitude_t, body_rates_t, navigation_t

from lodestar.errors import InputError
from lodestar.harness.bus import Bus
from lodestar.harness.isolation import isolated_bus, parse_url


def attitude(time_us: int, roll: float = 0.0) -> attitude_t:
    message = attitude_t()
    message.time_us, message.roll, message.valid = time_us, roll, True
    return message


@pytest.fixture
def sender(bus_url):
    with Bus(bus_url, ()) as member:
        yield member


def test_a_message_arrives_as_it_was_sent(bus, sender):
    sender.publish("SAHRS", attitude(123, roll=-0.25))
    received = bus.wait_for("SAHRS")
    assert (received.time_us, received.roll, received.valid) == (123, -0.25, True)


def test_messages_of_a_channel_keep_their_order_and_none_is_lost(bus, sender):
    for time_us in range(100):
        sender.publish("SAHRS", attitude(time_us))
    sender.publish("NAV", navigation_t())
    bus.wait_for("NAV")
    assert [message.time_us for message in bus.collect("SAHRS")] == list(range(100))
    assert bus.collect("SAHRS") == []


def test_waiting_passes_over_what_is_not_accepted(bus, sender):
    for time_us in (1, 2, 3):
        sender.publish("SAHRS", attitude(time_us))
    assert bus.wait_for("SAHRS", lambda message: message.time_us == 2).time_us == 2
    assert bus.wait_for("SAHRS").time_us == 3


def test_waiting_in_vain_names_the_channel(bus):
    with pytest.raises(TimeoutError, match="HEALTH"):
        bus.wait_for("HEALTH", timeout_s=0.01)


def test_only_the_asked_channels_are_heard(bus_url, sender):
    with Bus(bus_url, ["SAHRS"]) as listener:
        sender.publish("EFCS.RATES", body_rates_t())
        sender.publish("SAHRS", attitude(1))
        assert listener.wait_for("SAHRS").time_us == 1
        with pytest.raises(KeyError):
            listener.collect("EFCS.RATES")


def test_a_dot_in_a_name_is_a_dot(bus_url, sender):
    with Bus(bus_url, ["EFCS.RATES", "SAHRS"]) as listener:
        sender.publish("EFCS_RATES", body_rates_t())
        sender.publish("SAHRS", attitude(1))
        listener.wait_for("SAHRS")
        assert listener.collect("EFCS.RATES") == []


@pytest.mark.parametrize(
    "payload",
    [b"", b"short", attitude_t().encode() + b"\0", navigation_t().encode(), bytes(8)],
    ids=["empty", "short", "trailing", "foreign", "zeros"],
)
def test_a_malformed_payload_is_counted_and_dropped(bus, sender, payload):
    sender.publish("SAHRS", payload)
    sender.publish("SAHRS", attitude(7))
    assert bus.wait_for("SAHRS").time_us == 7
    assert bus.malformed == {"SAHRS": 1}


def test_a_datagram_without_a_channel_does_no_harm(bus, sender):
    group, port = parse_url(bus.url)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        stranger.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        for junk in (b"LC02\0\0\0\1", b"LC02", b"", b"LC03" + bytes(20), bytes(40)):
            stranger.sendto(junk, (group, port))
    sender.publish("SAHRS", attitude(7))
    assert bus.wait_for("SAHRS").time_us == 7
    assert bus.malformed == {}


def test_a_tap_hears_everything_in_the_order_of_arrival(bus, sender):
    heard = []
    bus.tap(lambda channel, payload: heard.append((channel, payload)))
    sent = [("SAHRS", attitude(1).encode()), ("NAV", b"junk"), ("SAHRS", attitude(2).encode())]
    for channel, payload in sent:
        sender.publish(channel, payload)
    while len(heard) < len(sent):
        assert bus.receive(5.0)
    assert heard == sent
    assert bus.collect("SAHRS") == []


def test_two_isolated_buses_do_not_hear_each_other(bus):
    with isolated_bus() as other_url, Bus(other_url) as other:
        other.publish("SAHRS", attitude(1))
        assert other.wait_for("SAHRS").time_us == 1
    bus.publish("SAHRS", attitude(2))
    assert bus.wait_for("SAHRS").time_us == 2


def test_what_was_received_can_be_read_after_leaving(bus, sender):
    sender.publish("SAHRS", attitude(5))
    assert bus.receive(5.0)
    bus.close()
    assert [message.time_us for message in bus.collect("SAHRS")] == [5]


def test_an_unknown_channel_is_refused_by_name(bus_url):
    with pytest.raises(InputError, match=r"channel SAHRZ: unknown"):
        Bus(bus_url, ["SAHRZ"])
