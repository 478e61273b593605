# SPDX-License-Identifier: Apache-2.0
"""A flight whose outputs are its truth plus errors that are known."""

import numpy as np
import pytest
from scipy.integrate import cumulative_trapezoid

from lodestar import channels, rotation
from lodestar.recordings import Recording
from lodestar.simulation import earth

START = (np.deg2rad(57.5), np.deg2rad(16.0), 2500.0)
SPEED = 200.0


def true_flight(time_us, wind_N=(0.0, 0.0, 0.0)):
    """Level flight with turns to both sides in a constant wind: columns of TRUTH."""
    t = time_us * 1e-6
    heading = np.deg2rad(30) + 1.2 * np.sin(2 * np.pi * t / 90)
    roll = np.arctan(SPEED / 9.81 * 1.2 * 2 * np.pi / 90 * np.cos(2 * np.pi * t / 90))
    pitch = np.deg2rad(3) * np.ones_like(t)
    v_air = SPEED * np.column_stack([np.cos(heading), np.sin(heading), np.zeros_like(t)])
    v_N = v_air + np.asarray(wind_N)
    lat, lon, h = START
    for _ in range(3):
        rate = v_N[:, 0] / (earth.meridian_radius(lat) + h)
        lat = START[0] + cumulative_trapezoid(rate, t, initial=0)
    east_rate = v_N[:, 1] / ((earth.transverse_radius(lat) + h) * np.cos(lat))
    return {
        "time_us": time_us,
        "lat": lat,
        "lon": lon + cumulative_trapezoid(east_rate, t, initial=0),
        "h": np.full_like(t, h),
        "v_N": v_N,
        "roll": roll,
        "pitch": pitch,
        "heading": rotation.wrap_2pi(heading),
        "wind_N": np.broadcast_to(np.asarray(wind_N, float), (len(t), 3)),
        "omega_B": np.zeros((len(t), 3)),
        "f_B": np.zeros((len(t), 3)),
        "b_N": np.zeros((len(t), 3)),
    }


def attitude_message(truth, d_roll, d_pitch, d_heading, sigma):
    """Columns of SAHRS: truth plus errors (rad), with one sigma for every axis."""
    count = len(truth["time_us"])
    roll, pitch = truth["roll"] + d_roll, truth["pitch"] + d_pitch
    heading = rotation.wrap_2pi(truth["heading"] + d_heading)
    return {
        "time_us": truth["time_us"],
        "roll": roll,
        "pitch": pitch,
        "heading": heading,
        "q_NB": rotation.q_NB_from_euler(roll, pitch, heading),
        "sigma_B": np.full((count, 3), sigma),
        "gyro_bias_B": np.zeros((count, 3)),
        "field_bias_B": np.zeros((count, 3)),
        "used": np.zeros(count, np.int32),
        "rejected": np.zeros(count, np.int32),
        "reset_count": np.zeros(count, np.int16),
        "reset_delta_B": np.zeros((count, 3)),
        "mode": np.full(count, 2, np.int8),
        "valid": np.ones(count, bool),
    }


def navigation_message(truth, north_m, east_m, d_euler, d_wind, sigmas):
    """Columns of NAV: truth plus errors (m, rad, m/s), and sigmas of position, attitude, wind."""
    count = len(truth["time_us"])
    radius = earth.transverse_radius(truth["lat"]) + truth["h"]
    euler = [truth[name] + d for name, d in zip(("roll", "pitch"), d_euler, strict=False)]
    return {
        "time_us": truth["time_us"],
        "lat": truth["lat"] + north_m / (earth.meridian_radius(truth["lat"]) + truth["h"]),
        "lon": truth["lon"] + east_m / (radius * np.cos(truth["lat"])),
        "h": truth["h"],
        "v_N": truth["v_N"],
        "roll": euler[0],
        "pitch": euler[1],
        "heading": rotation.wrap_2pi(truth["heading"] + d_euler[2]),
        "wind_N": truth["wind_N"] + np.asarray(d_wind),
        "sigma_position": np.full((count, 3), sigmas[0]),
        "sigma_velocity": np.full((count, 3), 0.5),
        "sigma_attitude": np.full((count, 3), sigmas[1]),
        "sigma_wind": np.full((count, 2), sigmas[2]),
        "gps_error": np.zeros((count, 2)),
        "gps_age": np.zeros(count),
        "horizontal_protection_level": np.full(count, -1.0),
        "reset_count": np.zeros(count, np.int16),
        "reset_delta": np.zeros((count, 2)),
        "mode": np.ones(count, np.int8),
        "valid": np.ones(count, bool),
    }


def air_data_message(truth, speed=SPEED):
    """Columns of ADC that fit the level flight exactly."""
    count = len(truth["time_us"])
    return {
        "time_us": truth["time_us"],
        # Level flight: the air velocity in B follows from pitch and roll.
        **_vanes(truth, speed),
        "baro_altitude": truth["h"],
        "static_temperature": np.full(count, 280.0),
        "valid": np.ones(count, bool),
    }


def _vanes(truth, speed):
    C_NB = rotation.C_NB_from_euler(truth["roll"], truth["pitch"], truth["heading"])
    v_air_N = truth["v_N"] - truth["wind_N"]
    u, v, w = np.einsum("nji,nj->in", C_NB, v_air_N)
    return {
        "true_airspeed": np.full(len(u), speed),
        "alpha": np.arctan2(w, u),
        "beta": np.arcsin(v / speed),
    }


def gps_message(truth, every, lost_s=()):
    """Columns of GPS at every n-th truth row, silent in the windows ``lost_s`` (start, end)."""
    rows = np.arange(0, len(truth["time_us"]), every)
    t = truth["time_us"][rows] * 1e-6
    for start, end in lost_s:
        rows = rows[(t <= start) | (t >= end)]
        t = truth["time_us"][rows] * 1e-6
    count = len(rows)
    return {
        "time_us": truth["time_us"][rows],
        **{name: truth[name][rows] for name in ("lat", "lon", "h", "v_N")},
        "has_velocity": np.zeros(count, bool),
        "sigma_horizontal": np.full(count, 5.0),
        "sigma_vertical": np.full(count, 8.0),
        "sigma_velocity": np.full(count, 0.1),
        "fix_type": np.full(count, 3, np.int8),
        "satellites": np.full(count, 9, np.int8),
        "hdop": np.ones(count),
    }


def health_message(truth, every):
    """Columns of HEALTH at every n-th truth row: innovations of one sigma, one fix refused."""
    time_us = truth["time_us"][::every]
    count = len(time_us)
    columns = {
        field.name: np.zeros((count, *field.shape), field.dtype)
        for field in channels.fields("HEALTH")
    }
    columns["time_us"] = time_us
    columns["innovation_sigma"][:, :9] = 1.0
    columns["innovation"][:, :9] = np.random.default_rng(3).normal(size=(count, 9))
    columns["received"] += np.arange(count)[:, None]
    columns["used"] = columns["received"].copy()
    columns["rejected"][count // 2 :, channels.INPUTS.index("GPS"), 11] = 1
    columns["build_version"][:, :5] = np.frombuffer(b"0.1.0", np.uint8)
    return columns


def put_all(columns_by_channel):
    recording = Recording()
    for name, columns in columns_by_channel.items():
        recording.put(name, columns)
    return recording


@pytest.fixture(scope="session")
def synthetic():
    """The functions above, for tests that build a flight of their own."""

    class Synthetic:
        speed = SPEED
        truth = staticmethod(true_flight)
        sahrs = staticmethod(attitude_message)
        nav = staticmethod(navigation_message)
        air_data = staticmethod(air_data_message)
        gps = staticmethod(gps_message)
        health = staticmethod(health_message)
        recording = staticmethod(put_all)

    return Synthetic
