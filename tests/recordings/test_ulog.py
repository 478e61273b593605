# SPDX-License-Identifier: Apache-2.0
import re
import struct
from pathlib import Path

import numpy as np
import pytest

from lodestar import rotation
from lodestar.errors import InputError
from lodestar.recordings.importer import import_recording
from lodestar.recordings.ulog import MAGIC, read_topics

PX4 = Path(__file__).parents[2] / "config" / "maps" / "px4.toml"
CODES = {"uint64_t": "Q", "float": "f", "double": "d", "int32_t": "i", "uint8_t": "B", "bool": "?"}


def message(kind, payload):
    return struct.pack("<HB", len(payload), ord(kind)) + payload


def ulog(topics):
    """A ULog file of topics: {name: (fields, rows)}; fields as [(type, length or 0, name)]."""
    definitions, subscriptions, data = b"", b"", b""
    for number, (topic, (fields, rows)) in enumerate(topics.items()):
        name = topic.partition("#")[0]
        parts = [f"{kind}{f'[{size}]' if size else ''} {field};" for kind, size, field in fields]
        definitions += message("F", f"{name}:{''.join(parts)}".encode())
        instance = int(topic.partition("#")[2] or 0)
        subscriptions += message("A", struct.pack("<BH", instance, number) + name.encode())
        layout = "<" + "".join(CODES[kind] * (size or 1) for kind, size, _ in fields)
        for row in rows:
            data += message("D", struct.pack("<H", number) + struct.pack(layout, *row))
    # All instances of a topic share one format.
    return MAGIC + b"\x01" + struct.pack("<Q", 0) + definitions + subscriptions + data


STAMP = ("uint64_t", 0, "timestamp")
IMU = [STAMP, ("float", 3, "gyro_rad"), ("float", 3, "accelerometer_m_s2")]
GPS_REST = [
    ("float", 0, "eph"),
    ("float", 0, "epv"),
    ("float", 0, "s_variance_m_s"),
    ("float", 0, "hdop"),
    ("float", 0, "vel_n_m_s"),
    ("float", 0, "vel_e_m_s"),
    ("float", 0, "vel_d_m_s"),
    ("uint8_t", 0, "fix_type"),
    ("uint8_t", 0, "satellites_used"),
    ("bool", 0, "vel_ned_valid"),
]
GPS_NUMBERS = (1.5, 2.5, 0.3, 0.9, 10.0, 20.0, -1.0, 3, 14, True)
NEW_GPS = [("double", 0, key) for key in ("latitude_deg", "longitude_deg", "altitude_ellipsoid_m")]
OLD_GPS = [("int32_t", 0, key) for key in ("lat", "lon", "alt_ellipsoid")]


def flight(gps=(NEW_GPS, (47.5, 8.5, 500.0)), with_air=True):
    roll, pitch, heading = 0.3, -0.1, 4.0
    q = rotation.q_NB_from_euler(roll, pitch, heading)
    topics = {
        "sensor_combined": (
            IMU,
            [(t, 0.1, 0.2, 0.3, 1.0, 2.0, -9.80665) for t in range(10_000, 90_000, 5_000)],
        ),
        "vehicle_magnetometer": (
            [STAMP, ("float", 3, "magnetometer_ga")],
            [(t, 0.25, -0.5, 0.375) for t in (20_000, 40_000, 40_000, 60_000)],
        ),
        "vehicle_gps_position": (
            [STAMP, *gps[0], *GPS_REST],
            [(50_000, *gps[1], *GPS_NUMBERS)],
        ),
        "vehicle_attitude": ([STAMP, ("float", 4, "q")], [(30_000, *q), (70_000, *q)]),
        "vehicle_global_position": (
            [STAMP, ("double", 0, "lat"), ("double", 0, "lon"), ("float", 0, "alt_ellipsoid")],
            [(60_000, 47.25, 8.25, 512.0)],
        ),
        "vehicle_local_position": (
            [STAMP, ("float", 0, "vx"), ("float", 0, "vy"), ("float", 0, "vz")],
            [(25_000, 1.0, 2.0, 3.0), (65_000, 4.0, 5.0, 6.0)],
        ),
    }
    if with_air:
        topics |= {
            "airspeed_validated": (
                [STAMP, ("float", 0, "true_airspeed_m_s")],
                [(t, 15.0) for t in (30_000, 60_000)],
            ),
            "vehicle_air_data": (
                [STAMP, ("float", 0, "baro_alt_meter")],
                [(20_000, 400.0), (45_000, 425.0), (75_000, 450.0)],
            ),
        }
    return ulog(topics)


@pytest.fixture
def log(tmp_path):
    path = tmp_path / "flight.ulg"
    path.write_bytes(flight())
    return path


def test_topics_become_channels_in_our_units_and_signs(log):
    recording, report = import_recording(log, PX4)
    rates, load = recording["EFCS.RATES"], recording["EFCS.LOAD_FACTOR"]
    np.testing.assert_array_equal(rates["time_us"], np.arange(10_000, 90_000, 5_000))
    # The log holds single precision.
    np.testing.assert_allclose(rates["omega_B"][0], [0.1, 0.2, 0.3], rtol=1e-7)
    np.testing.assert_allclose(load["n_B"][0], [-1 / 9.80665, -2 / 9.80665, 1.0], rtol=1e-7)
    np.testing.assert_allclose(recording["SMDU"]["b_B"][0], [25e3, -50e3, 37.5e3], rtol=1e-12)
    gps = recording["GPS"]
    np.testing.assert_allclose([gps["lat"][0], gps["lon"][0]], np.deg2rad([47.5, 8.5]))
    np.testing.assert_allclose(gps["v_N"][0], [10, 20, -1])
    assert (gps["fix_type"][0], gps["satellites"][0], gps["has_velocity"][0]) == (3, 14, True)
    assert report.dropped["vehicle_magnetometer.timestamp"] == {"time not later than before": 1}


def test_values_of_other_topics_hold_until_their_next(log):
    recording, report = import_recording(log, PX4)
    np.testing.assert_array_equal(recording["ADC"]["time_us"], [30_000, 60_000])
    np.testing.assert_array_equal(recording["ADC"]["baro_altitude"], [400.0, 425.0])
    ins = recording["INS"]
    # No position was known at the first attitude.
    np.testing.assert_array_equal(ins["time_us"], [70_000])
    np.testing.assert_allclose(ins["v_N"], [[4, 5, 6]])
    np.testing.assert_allclose([ins["lat"][0], ins["h"][0]], [np.deg2rad(47.25), 512.0])
    euler = [ins[name][0] for name in ("roll", "pitch", "heading")]
    np.testing.assert_allclose(euler, [0.3, -0.1, 4.0], atol=1e-6)
    assert report.dropped["INS"] == {"lat missing or not finite": 1}


def test_the_integers_of_older_gps_topics_are_understood(tmp_path):
    path = tmp_path / "old.ulg"
    path.write_bytes(flight(gps=(OLD_GPS, (475_000_000, 85_000_000, 500_000))))
    recording, _ = import_recording(path, PX4)
    gps = recording["GPS"]
    np.testing.assert_allclose([gps["lat"][0], gps["lon"][0]], np.deg2rad([47.5, 8.5]), rtol=1e-12)
    np.testing.assert_allclose(gps["h"][0], 500.0, rtol=1e-12)


def test_a_log_without_airspeed_leaves_the_air_data_out_and_says_so(tmp_path):
    path = tmp_path / "copter.ulg"
    path.write_bytes(flight(with_air=False))
    recording, report = import_recording(path, PX4)
    assert "ADC" not in recording
    (said,) = [line for line in report.lines() if line.startswith("ADC left out")]
    assert "no column 'airspeed_validated.timestamp'" in said


def test_a_second_instance_of_a_topic_has_its_number(tmp_path):
    path = tmp_path / "two.ulg"
    fields = [STAMP, ("float", 0, "pressure")]
    path.write_bytes(ulog({"baro": (fields, [(1, 5.0)]), "baro#1": (fields, [(2, 6.0)])}))
    columns = read_topics(path)
    assert columns["baro.pressure"].tolist() == [5.0]
    assert columns["baro#1.pressure"].tolist() == [6.0]
    assert columns["baro#1.timestamp"].tolist() == [2.0]


@pytest.mark.parametrize("content", [b"", b"hello", MAGIC, MAGIC + b"\x01"])
def test_a_foreign_or_torn_log_is_named(tmp_path, content, capsys):
    path = tmp_path / "flight.ulg"
    path.write_bytes(content)
    with pytest.raises(InputError, match=re.escape(str(path))):
        import_recording(path, PX4)
    assert capsys.readouterr().out == ""
