# SPDX-License-Identifier: Apache-2.0
import re
from pathlib import Path

import lcm
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from lodestar import channels as table
from lodestar import recordings
from lodestar.errors import InputError
from lodestar.recordings import Recording, codec
from lodestar.recordings.log import read_log, write_log
from lodestar.recordings.npz import read_npz, write_npz

ON_DISK = settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)


@st.composite
def channel_columns(draw, channel):
    count = draw(st.integers(0 if channel == "RALT" else 1, 4))
    columns = {
        field.name: draw(hnp.arrays(field.dtype, (count, *field.shape)))
        for field in table.fields(channel)
    }
    arrival = draw(hnp.arrays(np.int64, count, elements=st.integers(-5, 5)))
    return columns, np.sort(arrival)


@st.composite
def any_recording(draw):
    names = draw(st.lists(st.sampled_from(list(table.CHANNELS)), unique=True, min_size=1))
    recording = Recording()
    for name in names:
        recording.put(name, *draw(channel_columns(name)))
    return recording


def small_flight():
    recording = Recording()
    time_us = np.arange(10) * 16_667
    for name in table.CHANNELS:
        columns = {
            field.name: np.arange(10 * int(np.prod(field.shape)))
            .reshape(10, *field.shape)
            .astype(field.dtype)
            for field in table.fields(name)
        }
        recording.put(name, {**columns, "time_us": time_us}, time_us + 5)
    return recording


@ON_DISK
@given(recording=any_recording())
def test_npz_keeps_every_bit(tmp_path, recording):
    write_npz(recording, tmp_path / "flight.npz")
    assert read_npz(tmp_path / "flight.npz") == recording


@ON_DISK
@given(recording=any_recording())
def test_log_keeps_every_bit(tmp_path, recording):
    write_log(recording, tmp_path / "flight.lcm")
    # A log cannot hold a channel without messages.
    filled = {name: one for name, one in recording.channels.items() if len(one["time_us"])}
    if filled:
        assert read_log(tmp_path / "flight.lcm") == Recording(filled)


def test_log_to_npz_and_back_is_the_same_file(tmp_path):
    recordings.save(small_flight(), tmp_path / "a.lcm")
    recordings.save(recordings.load(tmp_path / "a.lcm"), tmp_path / "b.npz")
    recordings.save(recordings.load(tmp_path / "b.npz"), tmp_path / "c.lcm")
    assert (tmp_path / "c.lcm").read_bytes() == (tmp_path / "a.lcm").read_bytes()


@pytest.mark.parametrize("channel", table.CHANNELS)
def test_codec_agrees_with_the_generated_class(channel):
    generator = np.random.default_rng(7)
    columns = {}
    for field in table.fields(channel):
        size = (3, *field.shape)
        if field.dtype.kind == "f":
            columns[field.name] = generator.normal(size=size)
        elif field.dtype.kind == "b":
            columns[field.name] = generator.integers(0, 2, size).astype(bool)
        else:
            info = np.iinfo(field.dtype)
            columns[field.name] = generator.integers(info.min, info.max, size, field.dtype, True)
    payloads = codec.encode(channel, columns)
    for row, payload in enumerate(payloads):
        message = table.CHANNELS[channel].decode(payload)
        assert message.encode() == payload
        for name, column in columns.items():
            value = getattr(message, name)
            value = list(value) if isinstance(value, bytes) else value
            np.testing.assert_array_equal(np.asarray(value), column[row])
    wire = np.frombuffer(b"".join(payloads), np.uint8).reshape(3, -1)
    decoded = codec.decode(channel, wire)
    assert all(np.array_equal(decoded[name], columns[name]) for name in columns)
    assert all(decoded[name].dtype == columns[name].dtype for name in columns)


def test_lcm_reads_the_log_in_order_of_arrival_with_the_trigger_last(tmp_path):
    write_log(small_flight(), tmp_path / "flight.lcm")
    events = list(lcm.EventLog(tmp_path / "flight.lcm"))
    assert [event.eventnum for event in events] == list(range(len(events)))
    assert [event.timestamp for event in events] == sorted(event.timestamp for event in events)
    first = [event.channel for event in events[: len(table.CHANNELS)]]
    assert first.index("EFCS.RATES") == len(table.INPUTS) - 1
    assert set(first) == set(table.CHANNELS)


def test_unknown_channels_are_left_out_counted_and_said(tmp_path):
    path = tmp_path / "flight.lcm"
    log = lcm.EventLog(path, "w")
    for index in range(3):
        log.write_event(index, "CAMERA", b"whatever")
    log.write_event(4, "SMDU", codec.encode("SMDU", small_flight()["SMDU"])[0])
    log.close()
    recording = read_log(path)
    assert list(recording.channels) == ["SMDU"]
    assert recording.notes == [f"{path}: messages of unknown channels left out: CAMERA 3"]


def smdu_payload():
    return codec.encode("SMDU", small_flight()["SMDU"])[0]


@pytest.mark.parametrize(
    ("payload", "complaint"),
    [
        (b"\x00" * 8 + smdu_payload()[8:], "event 1 on SMDU: fingerprint 0x0000000000000000, must"),
        (smdu_payload()[:-1], "event 1 on SMDU: 40 bytes, must be 41"),
        (smdu_payload() + b"x", "event 1 on SMDU: 42 bytes, must be 41"),
        (smdu_payload()[:-1] + b"\x02", "event 1 on SMDU: valid is 2, must be 0 or 1"),
    ],
)
def test_malformed_message_is_named_or_left_out(tmp_path, payload, complaint):
    path = tmp_path / "flight.lcm"
    log = lcm.EventLog(path, "w")
    for each in (smdu_payload(), payload, smdu_payload()):
        log.write_event(1, "SMDU", each)
    log.close()
    with pytest.raises(InputError, match=re.escape(f"{path}: {complaint}")):
        read_log(path)
    lenient = read_log(path, strict=False)
    assert len(lenient["SMDU"]["time_us"]) == 2
    assert lenient.notes == [f"{path}: malformed messages left out: SMDU 1"]


@pytest.mark.parametrize("suffix", [".lcm", ".npz"])
def test_every_truncation_is_refused(tmp_path, suffix):
    whole = tmp_path / f"whole{suffix}"
    flight = small_flight().subset(("SMDU", "RALT"))
    recordings.save(flight, whole)
    data = whole.read_bytes()
    cut = tmp_path / f"cut{suffix}"
    # One event of SMDU is 28 + 4 + 41 bytes, of RALT 28 + 4 + 25: a log cut between two is whole.
    boundaries = np.cumsum([73, 57] * 10) if suffix == ".lcm" else []
    for size in range(0, len(data), 7):
        if size in boundaries:
            continue
        cut.write_bytes(data[:size])
        with pytest.raises(InputError, match=re.escape(str(cut))):
            recordings.load(cut)


def test_damage_in_the_middle_of_a_log_is_found(tmp_path):
    path = tmp_path / "flight.lcm"
    write_log(small_flight(), path)
    data = bytearray(path.read_bytes())
    second = data.index(b"\xed\xa1\xda\x01", 4)
    data[second] = 0
    path.write_bytes(data)
    with pytest.raises(InputError, match=rf"damaged at event 1 \(byte {second}\)"):
        read_log(path)


@pytest.mark.parametrize("name", ["missing.lcm", "missing.npz", "foreign.lcm", "folder"])
def test_missing_and_foreign_files_are_named(tmp_path, name):
    path = tmp_path / name
    if name == "foreign.lcm":
        path.write_text("time,value\n0,1\n")
    elif name == "folder":
        path.mkdir()
    with pytest.raises(InputError, match=re.escape(str(path))):
        recordings.load(path)


def test_unwritable_and_unknown_targets_are_named(tmp_path):
    flight = small_flight()
    for target in ("no/such/folder.lcm", "no/such/folder.npz", "flight.csv"):
        with pytest.raises(InputError, match=re.escape(target)):
            recordings.save(flight, tmp_path / target)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"SMDU/b_B": np.zeros((2, 2))}, r"SMDU/b_B: shape (2, 2), must be (2, 3)"),
        ({"SMDU/b_B": np.array([["a"] * 3] * 2)}, "SMDU/b_B: type <U1, must be float64"),
        ({"SMDU/time_us": np.array([0.0, 1.0])}, "SMDU/time_us: type float64, must be int64"),
        ({"SMDU/valid": np.array([0, 2])}, "SMDU/valid: a value does not fit bool"),
        ({"SMDU/extra": np.zeros(2)}, "SMDU: unknown field extra"),
        ({"SMDU/valid": None}, "SMDU/valid: missing"),
    ],
)
def test_npz_that_disagrees_with_the_type_is_refused(tmp_path, change, complaint):
    arrays = {
        "SMDU/time_us": np.array([0, 1]),
        "SMDU/b_B": np.zeros((2, 3)),
        "SMDU/valid": np.array([True, True]),
    }
    arrays = {key: value for key, value in (arrays | change).items() if value is not None}
    path = tmp_path / "flight.npz"
    np.savez(path, **arrays)
    with pytest.raises(InputError, match=re.escape(f"{path}: {complaint}")):
        read_npz(path)


def test_npz_by_hand_may_leave_arrival_out_and_carry_other_keys(tmp_path):
    path = tmp_path / "flight.npz"
    np.savez(
        path,
        **{"RALT/time_us": [3, 4], "RALT/height": [1, 2], "RALT/valid": [1, 0], "note": [1]},
    )
    recording = read_npz(path)
    assert recording["RALT"]["arrival_us"].tolist() == [3, 4]
    assert recording["RALT"]["height"].dtype == np.float64
    assert recording.notes == [f"{path}: unknown keys left out: note"]


def test_npz_never_unpickles(tmp_path: Path):
    path = tmp_path / "flight.npz"
    np.savez(path, **{"RALT/time_us": np.array([object()])})
    with pytest.raises(InputError, match="damaged npz"):
        read_npz(path)
