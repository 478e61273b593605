# SPDX-License-Identifier: Apache-2.0
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lodestar import channels as table
from lodestar.errors import InputError
from lodestar.recordings.importer import import_recording
from lodestar.recordings.units import QUANTITIES, pressure_altitude

TIME = '[time]\ncolumn = "t"\n'
RALT = """
[channels.RALT]
height = { column = "h", unit = "ft" }
valid = { constant = true }
"""
ADC = """
[channels.ADC]
true_airspeed = { column = "v", unit = "kt" }
alpha = { column = "a", unit = "deg", offset = -0.01 }
beta = { column = "b", unit = "deg", convention = "flank" }
baro_altitude = { column = "p", unit = "hPa" }
static_temperature = { column = "c", unit = "degC" }
valid = { column = "v", min = 20 }
"""


@pytest.fixture
def bring_in(tmp_path):
    """Import columns by the text of a map; as npz, or as CSV when asked."""

    def run(columns, mapping, suffix=".npz"):
        source, map_path = tmp_path / f"source{suffix}", tmp_path / "map.toml"
        map_path.write_text(mapping)
        if suffix == ".npz":
            np.savez(source, **columns)
        else:
            rows = zip(*columns.values(), strict=True)
            lines = [",".join(columns), *(",".join(map(str, row)) for row in rows)]
            source.write_text("\n".join(lines) + "\n")
        return import_recording(source, map_path)

    return run


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
def test_units_offsets_conventions_and_conditions(bring_in, suffix):
    columns = {
        "t": [0.0, 0.1],
        "v": [100.0, 10.0],
        "a": [5.0, 0.0],
        "b": [10.0, 0.0],
        "p": [1013.25, 898.7456],
        "c": [15.0, -50.0],
    }
    recording, report = bring_in(columns, TIME + ADC, suffix)
    adc = recording["ADC"]
    np.testing.assert_array_equal(adc["time_us"], [0, 100_000])
    np.testing.assert_allclose(adc["true_airspeed"], np.array([100, 10]) * 1852 / 3600, rtol=1e-12)
    np.testing.assert_allclose(adc["alpha"], np.deg2rad([5, 0]) - 0.01, rtol=1e-12)
    # ICAO standard atmosphere: 898.7456 hPa at 1000 m of geopotential height (rounded tables).
    np.testing.assert_allclose(adc["baro_altitude"], [0.0, 1000.0], atol=0.01)
    np.testing.assert_allclose(adc["static_temperature"], [288.15, 223.15], rtol=1e-12)
    np.testing.assert_array_equal(adc["valid"], [True, False])
    # A flank angle is atan2(v, u): build the air velocity and take its sideslip.
    u, w = np.cos(adc["alpha"][0]), np.sin(adc["alpha"][0])
    v = u * np.tan(np.deg2rad(10))
    assert adc["beta"][0] == pytest.approx(np.arcsin(v / np.sqrt(u**2 + v**2 + w**2)), abs=1e-12)
    assert report.lines() == ["2 rows read", "ADC: 2 messages"]


@pytest.mark.parametrize(
    ("axes", "expected"),
    [
        ('"FRD"', [1, 2, 3]),
        ('"FLU"', [1, -2, -3]),
        ('"RFU"', [2, 1, -3]),
        ('["-z", "x", "-y"]', [-3, 1, -2]),
    ],
)
def test_axis_conventions_and_sign(bring_in, axes, expected):
    mapping = f"""
[channels."EFCS.LOAD_FACTOR"]
n_B = {{ columns = ["x", "y", "z"], unit = "m/s^2", axes = {axes}, scale = -1 }}
valid = {{ constant = true }}
"""
    columns = {"t": [0.0], "x": [1.0], "y": [2.0], "z": [3.0]}
    recording, _ = bring_in(columns, TIME + mapping)
    n_B = recording["EFCS.LOAD_FACTOR"]["n_B"][0]
    np.testing.assert_allclose(n_B, -np.array(expected) / 9.80665, rtol=1e-12)


def test_held_gps_is_taken_once_at_its_own_time(bring_in):
    mapping = """
[channels.GPS]
new = "new"
require = { column = "sats", min = 4 }
latency_s = 0.2
lat = { column = "lat", unit = "deg" }
lon = { constant = 0.25 }
h = { constant = 100 }
v_N = { constant = [0, 0, 0] }
has_velocity = { constant = false }
sigma_horizontal = { constant = 3 }
sigma_vertical = { constant = 5 }
sigma_velocity = { constant = 1 }
fix_type = { constant = 3 }
satellites = { column = "sats" }
hdop = { constant = 1.5 }
"""
    columns = {
        "t": [1.0, 1.5, 2.0, 2.5, 3.0],
        "new": [1, 0, 1, 0, 1],
        "lat": [57.0, 57.0, 58.0, 58.0, 59.0],
        "sats": [8, 8, 2, 2, 5],
    }
    recording, report = bring_in(columns, TIME + mapping)
    gps = recording["GPS"]
    np.testing.assert_array_equal(gps["time_us"], [800_000, 2_800_000])
    np.testing.assert_array_equal(gps["arrival_us"], [1_000_000, 3_000_000])
    np.testing.assert_allclose(gps["lat"], np.deg2rad([57, 59]), rtol=1e-12)
    np.testing.assert_array_equal(gps["satellites"], [8, 5])
    assert gps["satellites"].dtype == np.int8
    assert gps["v_N"].shape == (2, 3)
    assert report.dropped == {"GPS": {"sats outside what the map requires": 1}}


def test_ins_heading_is_wrapped_and_valid_in_its_window_only(bring_in):
    mapping = """
[channels.INS]
roll = { constant = 0 }
pitch = { constant = 0 }
heading = { column = "y", unit = "deg" }
lat = { constant = 0 }
lon = { constant = 0 }
h = { constant = 0 }
v_N = { constant = [0, 0, 0] }
valid = { during_s = [1, 2] }
"""
    recording, _ = bring_in({"t": [0.0, 1.0, 3.0], "y": [-90.0, 0.0, 180.0]}, TIME + mapping)
    np.testing.assert_allclose(recording["INS"]["heading"], np.deg2rad([270, 0, 180]), rtol=1e-12)
    np.testing.assert_array_equal(recording["INS"]["valid"], [False, True, False])


def test_rows_that_cannot_be_are_dropped_and_said(bring_in):
    nan = float("nan")
    columns = {
        "t": [0.0, 0.1, 0.1, 0.05, nan, 0.2, 0.3, 0.4, 9.0],
        "h": [1.0, 2.0, 3.0, 4.0, 5.0, nan, 1e9, 8.0, 9.0],
    }
    recording, report = bring_in(columns, TIME + "end_s = 5.0\n" + RALT)
    np.testing.assert_array_equal(recording["RALT"]["time_us"], [0, 100_000, 400_000])
    assert report.lines() == [
        "9 rows read",
        "t: 1 dropped: time not finite; 2 dropped: time not later than before; "
        "1 dropped: outside start_s to end_s",
        "RALT: 3 messages; 1 dropped: height missing or not finite; "
        "1 dropped: height outside -100 to 20000 m",
    ]


def test_decimation_and_empty_cells_of_a_csv(bring_in):
    columns = {"t": [0, 1, 2, 3, 4], "h": [0, "", 20, 30, ""]}
    mapping = TIME + RALT.replace("height", "every = 2\nheight")
    recording, report = bring_in(columns, mapping, ".csv")
    np.testing.assert_array_equal(recording["RALT"]["time_us"], [0, 2_000_000])
    assert report.dropped == {"RALT": {"height missing or not finite": 1}}


@given(st.floats(0.0, 10_000.0))
def test_pressure_altitude_inverts_the_standard_atmosphere(altitude):
    pressure = 101325.0 * (1 - 0.0065 * altitude / 288.15) ** (9.80665 / (0.0065 * 287.05287))
    assert pressure_altitude(np.array([pressure]))[0] == pytest.approx(altitude, abs=1e-6)


def test_every_quantity_is_a_field_of_an_input_message():
    names = {field.name for channel in (*table.INPUTS, "TRUTH") for field in table.fields(channel)}
    assert set(QUANTITIES) <= names


@pytest.mark.parametrize(
    ("mapping", "complaint"),
    [
        ("[time]\ncolumn = 1\n[channels]\n", ":1: time: has column = 1, must be str"),
        ("[time]\n[channels]\n", ":2: channels: names no channel"),
        ("[time]\n" + RALT, ":3: channels.RALT: lacks clock, and [time] lacks column"),
        (TIME, ": lacks the table [channels]"),
        (TIME + "unit = 'h'\n" + RALT, ":1: time: has unit = 'h'; allowed are s, ms, us, ns"),
        (TIME + "[channels.CAMERA]\n", ":3: channels.CAMERA: unknown key; allowed are EFCS.RATES,"),
        (TIME + "[channels.SAHRS]\n", ":3: channels.SAHRS: unknown key; allowed are"),
        (TIME + RALT + "color = 1\n", ":7: channels.RALT.color: unknown key; allowed are clock,"),
        (TIME + RALT + "every = 0\n", ":4: channels.RALT: has every = 0, must be at least 1"),
        (
            TIME + RALT.replace("valid = { constant = true }", ""),
            ":4: channels.RALT: lacks field valid",
        ),
        (
            TIME + RALT.replace('"ft"', '"furlong"'),
            ":5: channels.RALT.height: has unit = 'furlong'; allowed are m, km, ft",
        ),
        (
            TIME + RALT.replace('column = "h"', 'columns = ["h", "i"]'),
            ":5: channels.RALT.height: names 2 columns, must name 1",
        ),
        (
            TIME + RALT.replace('"ft"', '"ft", axes = "XYZ"'),
            ":5: channels.RALT.height: has axes = 'XYZ'; allowed are FRD, FLU",
        ),
        (
            TIME + RALT.replace('column = "h", unit = "ft"', ""),
            ":5: channels.RALT.height: must have one of column, columns, constant, during_s",
        ),
        ("[time\n", ":1: not TOML"),
    ],
)
def test_a_wrong_map_is_named_with_line_and_key(bring_in, tmp_path, mapping, complaint):
    with pytest.raises(InputError, match=re.escape(f"{tmp_path / 'map.toml'}{complaint}")):
        bring_in({"t": [0.0], "h": [1.0]}, mapping)


@pytest.mark.parametrize(
    ("columns", "suffix", "complaint"),
    [
        ({"t": [0.0], "x": [1.0]}, ".npz", "no column 'h'; it has t, x"),
        ({"t": [0.0], "x": [1.0]}, ".csv", "no column 'h'; it has t, x"),
        ({"t": [0.0], "h": [[1.0]]}, ".npz", "h has shape (1, 1), must be (1,) numbers"),
        ({"t": [0.0], "h": ["high"]}, ".csv", "line 2: h is 'high', not a number"),
        ({"t": [0.0, 1.0], "h": [0.0, "1,2"]}, ".csv", "line 3 has 3 cells, header 2"),
        ({"t": [0.0], "h": [1e9]}, ".csv", "nothing left of RALT"),
    ],
)
def test_a_wrong_source_is_named_with_its_place(bring_in, tmp_path, columns, suffix, complaint):
    with pytest.raises(InputError, match=re.escape(f"{tmp_path / 'source'}{suffix}: {complaint}")):
        bring_in(columns, TIME + RALT, suffix)


@pytest.mark.parametrize("name", ["missing.csv", "missing.npz", "foreign.npz", "empty.csv"])
def test_a_missing_or_foreign_source_is_named(tmp_path, name):
    (tmp_path / "map.toml").write_text(TIME + RALT)
    (tmp_path / "foreign.npz").write_text("hello")
    (tmp_path / "empty.csv").write_text("")
    with pytest.raises(InputError, match=re.escape(str(tmp_path / name))):
        import_recording(tmp_path / name, tmp_path / "map.toml")
