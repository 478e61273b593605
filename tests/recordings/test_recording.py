# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from lodestar import channels as table
from lodestar.errors import InputError
from lodestar.recordings import Recording


def ralt(time_us):
    count = len(time_us)
    return {"time_us": time_us, "height": np.arange(float(count)), "valid": [True] * count}


def test_health_counts_the_inputs_in_the_order_of_the_table():
    shape = {field.name: field.shape for field in table.fields("HEALTH")}["received"]
    assert len(table.INPUTS) == shape[0]
    assert table.INPUTS[0] == table.MASTER


def test_event_order_names_every_channel_once_with_the_trigger_last_of_the_inputs():
    assert sorted(table.EVENT_ORDER) == sorted(table.CHANNELS)
    assert table.EVENT_ORDER.index(table.MASTER) == len(table.INPUTS) - 1


def test_a_late_message_comes_at_its_arrival():
    recording = Recording()
    rates = {"time_us": [0, 10, 20], "omega_B": np.zeros((3, 3)), "valid": [True] * 3}
    recording.put("EFCS.RATES", rates)
    recording.put("RALT", ralt([0, 10]), [10, 20])
    assert list(recording.events()) == [
        (0, "EFCS.RATES", 0),
        (10, "RALT", 0),
        (10, "EFCS.RATES", 1),
        (20, "RALT", 1),
        (20, "EFCS.RATES", 2),
    ]


def test_rows_are_put_in_order_of_arrival():
    recording = Recording()
    recording.put("RALT", ralt([0, 1, 2]), [30, 20, 20])
    assert recording["RALT"]["time_us"].tolist() == [1, 2, 0]
    assert recording["RALT"]["height"].tolist() == [1.0, 2.0, 0.0]
    assert recording["RALT"]["arrival_us"].tolist() == [20, 20, 30]


def test_an_empty_channel_and_an_empty_recording_are_possible():
    recording = Recording()
    assert list(recording.events()) == []
    assert recording.duration_s() == 0.0
    recording.put("RALT", {"time_us": [], "height": [], "valid": []})
    assert list(recording.events()) == []
    assert recording["RALT"]["time_us"].dtype == np.int64


def test_equality_sees_a_single_bit_and_takes_nan_as_itself():
    one, other = Recording(), Recording()
    one.put("RALT", ralt([1, 2]))
    other.put("RALT", ralt([1, 2]))
    one["RALT"]["height"][0] = other["RALT"]["height"][0] = np.nan
    assert one == other
    other["RALT"]["height"][1] = np.nextafter(1.0, 2.0)
    assert one != other


def test_duration_spans_all_channels():
    recording = Recording()
    recording.put("RALT", ralt([1_000_000, 2_000_000]))
    assert recording.duration_s() == pytest.approx(1.0, abs=1e-12)


def test_unknown_channel_is_named():
    with pytest.raises(InputError, match=r"channel CAMERA: unknown; known are EFCS\.RATES,"):
        Recording().put("CAMERA", {})
