# SPDX-License-Identifier: Apache-2.0
"""The truth must agree with itself: what is integrated must give back what was differentiated."""

from dataclasses import replace
from math import radians

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from lodestar.paths import config_path
from lodestar.rotation import (
    C_NB_from_q_NB,
    exp_quaternion,
    quaternion_conjugate,
    quaternion_product,
    wrap_pi,
)
from lodestar.simulation import earth
from lodestar.simulation.flight_path import PathBuilder, Start
from lodestar.simulation.profile import flight_path, read_profile
from lodestar.simulation.trajectory import Aircraft, Trajectory, fly_path
from lodestar.simulation.wind import Turbulence, Wind

YEAR = 2026.5


def shipped_flight(route: str, wind: Wind, gust_sigma: float, rate_hz: int = 60) -> Trajectory:
    path = flight_path(read_profile(config_path(f"routes/{route}.profile")), rate_hz)
    t = np.arange(len(path.airspeed)) / rate_hz
    rng = np.random.default_rng(1)
    gust_B = Turbulence(gust_sigma).gust_B(len(t), 1 / rate_hz, 200.0, rng)
    return fly_path(path, wind.velocity_N(t, rng), gust_B, Aircraft(), YEAR)


@pytest.fixture(scope="module")
def calm() -> Trajectory:
    return shipped_flight("ordinary", Wind((3, 3), (12, 12), 300.0, 1.0, 120.0), 0.7)


@pytest.fixture(scope="module")
def hard() -> Trajectory:
    return shipped_flight("hard", Wind((6, 7)), 0.0)


@pytest.fixture(params=["calm", "hard"])
def flight(request) -> Trajectory:
    return request.getfixturevalue(request.param)


def gauss_points(values: np.ndarray, interval: float) -> list[np.ndarray]:
    """Values at the three Gauss-Legendre points of each interval."""
    n = len(values)
    t = np.arange(n) * interval
    spline = make_interp_spline(t, values, k=5)
    c = np.sqrt(15) / 10
    return [spline(t[:-1] + interval * x) for x in (0.5 - c, 0.5, 0.5 + c)]


def integrated_attitude(trajectory: Trajectory) -> np.ndarray:
    """q_NB from the emitted rates alone: sixth-order Magnus expansion, Blanes et al. 2000."""
    dt = 1 / trajectory.rate_hz
    frame_rate = earth.earth_rate_N(trajectory.lat) + earth.transport_rate_N(
        trajectory.lat, trajectory.h, trajectory.v_N
    )
    omega = trajectory.omega_B - np.einsum("nji,nj->ni", trajectory.C_NB, frame_rate)
    w1, w2, w3 = gauss_points(omega, dt)
    # The expansion is for Y' = A Y; with Y = C_NB^T the generator is -omega.
    a1 = -dt * w2
    a2 = -np.sqrt(15) / 3 * dt * (w3 - w1)
    a3 = -10 / 3 * dt * (w3 - 2 * w2 + w1)
    c1 = np.cross(a1, a2)
    c2 = np.cross(a1, 2 * a3 + c1) / -60
    turn = -(a1 + a3 / 12 + np.cross(-20 * a1 - a3 + c1, a2 + c2) / 240)
    q_NB = np.empty_like(trajectory.q_NB)
    q_NB[0] = trajectory.q_NB[0]
    a, b, c, d = q_NB[0].tolist()
    for k, (e, f, g, h) in enumerate(exp_quaternion(turn).tolist(), start=1):
        a, b, c, d = (
            a * e - b * f - c * g - d * h,
            a * f + b * e + c * h - d * g,
            a * g - b * h + c * e + d * f,
            a * h + b * g - c * f + d * e,
        )
        q_NB[k] = a, b, c, d
    return q_NB


def angle_between(q: np.ndarray, p: np.ndarray) -> np.ndarray:
    return 2 * np.linalg.norm(quaternion_product(quaternion_conjugate(q), p)[:, 1:], axis=-1)


def test_rates_integrate_to_the_attitude(flight):
    error = angle_between(flight.q_NB, integrated_attitude(flight))
    assert len(error) > 2400 * 60
    assert error.max() < 1e-7


def test_specific_force_integrates_to_velocity_and_position(flight):
    dt = 1 / flight.rate_hz
    part = slice(500 * 60, 1400 * 60)  # rolls, loops and turns are in it
    C_NB = C_NB_from_q_NB(integrated_attitude(flight)[part])
    f_N = np.einsum("nij,nj->ni", C_NB, flight.f_B[part])
    true_v_N, true_lat, true_lon, true_h = (
        getattr(flight, name)[part] for name in ("v_N", "lat", "lon", "h")
    )
    v_N = np.tile(true_v_N[0], (len(f_N), 1))
    lat, h = np.full(len(f_N), true_lat[0]), np.full(len(f_N), true_h[0])
    for _ in range(8):  # Picard's iteration, from no motion at all
        acceleration = f_N - np.cross(
            2 * earth.earth_rate_N(lat) + earth.transport_rate_N(lat, h, v_N), v_N
        )
        acceleration[:, 2] += earth.gravity(lat, h)
        v_N = true_v_N[0] + integral(acceleration, dt)
        lat = true_lat[0] + integral(v_N[:, 0] / (earth.meridian_radius(lat) + h), dt)
        h = true_h[0] - integral(v_N[:, 2], dt)
    eastward = v_N[:, 1] / ((earth.transverse_radius(lat) + h) * np.cos(lat))
    lon = true_lon[0] + integral(eastward, dt)
    # Free inertial navigation: 1e-8 rad of attitude is 1e-7 m/s^2, 0.04 m after 900 s.
    assert np.abs(v_N - true_v_N).max() < 1e-4
    assert np.abs(lat - true_lat).max() * 6.4e6 < 0.05
    assert np.abs(lon - true_lon).max() * 3.4e6 < 0.05
    assert np.abs(h - true_h).max() < 0.05


def integral(values: np.ndarray, interval: float) -> np.ndarray:
    x1, x2, x3 = gauss_points(values, interval)
    steps = interval * (5 * x1 + 8 * x2 + 5 * x3) / 18
    return np.concatenate([np.zeros_like(values[:1]), np.cumsum(steps, axis=0)])


def test_wind_triangle_closes_with_the_whole_wind(flight):
    ca, sa, cb, sb = (f(x) for x in (flight.alpha, flight.beta) for f in (np.cos, np.sin))
    v_air_B = flight.true_airspeed[:, None] * np.stack([ca * cb, sb, sa * cb], axis=-1)
    v_N = np.einsum("nij,nj->ni", flight.C_NB, v_air_B) + flight.wind_N
    np.testing.assert_allclose(v_N, flight.v_N, atol=1e-10)


def test_euler_angles_quaternion_and_matrix_are_one_attitude(flight):
    np.testing.assert_allclose(C_NB_from_q_NB(flight.q_NB), flight.C_NB, atol=1e-14)
    steps = np.linalg.norm(np.diff(flight.q_NB, axis=0), axis=1)
    assert steps.max() < 0.05  # no jump between q and -q
    np.testing.assert_allclose(np.sin(flight.pitch), -flight.C_NB[:, 2, 0], atol=1e-14)


def test_calm_flight_is_that_of_a_fighter(calm):
    roll_deg, alpha_deg = np.degrees(calm.roll), np.degrees(calm.alpha)
    assert 40 < np.abs(roll_deg).max() < 55
    assert 1 < alpha_deg.min() < alpha_deg.max() < 6
    assert 1950 < calm.h.min() < calm.h.max() < 3550
    assert 165 < calm.true_airspeed.min() < calm.true_airspeed.max() < 225
    assert np.degrees(np.abs(calm.omega_B)).max() < 30


def test_hard_flight_is_hard(hard):
    load = -hard.f_B / earth.STANDARD_GRAVITY
    assert 5.5 < load[:, 2].max() < 6.5
    assert load[:, 2].min() < -0.4
    assert np.abs(load[:, 1]).max() < 0.02  # coordinated throughout
    assert 120 < np.degrees(hard.omega_B[:, 0]).max() < 160
    assert np.degrees(hard.pitch).max() > 89
    assert 14 < np.degrees(hard.alpha).max() < 20


def level_turn(wind_N: tuple[float, float, float], bank: float) -> Trajectory:
    builder = PathBuilder(Start(radians(57.5), radians(16.0), 3000.0, 0.0, 200.0), 60)
    builder.straight(5.0)
    builder.horizontal_turn(radians(180), bank=bank, roll_rate=radians(30))
    path = builder.path()
    n = len(path.airspeed)
    return fly_path(path, np.tile(wind_N, (n, 1)), np.zeros((n, 3)), Aircraft(), YEAR)


def test_level_turn_has_the_load_factor_and_rates_of_the_textbook():
    turn = level_turn((0, 0, 0), radians(45))
    middle = len(turn.lat) // 2
    track = np.unwrap(np.arctan2(turn.v_N[:, 1], turn.v_N[:, 0]))
    rate = (track[middle + 1] - track[middle - 1]) * 30
    sideways = rate * turn.true_airspeed[middle] / earth.STANDARD_GRAVITY
    # The bank gives way by half a per cent to end the turn on a whole tenth of a second.
    assert sideways == pytest.approx(np.tan(radians(45)), rel=0.02)
    # Coriolis and the local gravity make 0.4 %.
    load = np.linalg.norm(turn.f_B[middle]) / earth.STANDARD_GRAVITY
    assert load == pytest.approx(np.hypot(1, sideways), rel=4e-3)
    assert abs(turn.f_B[middle, 1]) < 0.05
    roll_rate, pitch_rate, yaw_rate = turn.omega_B[middle]
    roll, pitch = turn.roll[middle], turn.pitch[middle]
    # The Earth turns by 7e-5 rad/s, N over it by 3e-5, and Coriolis changes alpha.
    assert pitch_rate == pytest.approx(rate * np.sin(roll) * np.cos(pitch), abs=2e-4)
    assert yaw_rate == pytest.approx(rate * np.cos(roll) * np.cos(pitch), abs=2e-4)
    assert roll_rate == pytest.approx(-rate * np.sin(pitch), abs=2e-4)


def test_steady_wind_moves_the_ground_track_and_nothing_else_that_is_felt():
    still, windy = level_turn((0, 0, 0), radians(30)), level_turn((6, 7, 0), radians(30))
    np.testing.assert_allclose(windy.v_N - still.v_N, np.tile([6, 7, 0], (len(still.h), 1)))
    # Coriolis acts on the ground velocity: 1e-3 m/s^2.
    np.testing.assert_allclose(windy.f_B, still.f_B, atol=3e-3)
    np.testing.assert_allclose(windy.true_airspeed, still.true_airspeed, rtol=1e-12)


def test_change_of_wind_is_felt_as_a_force(calm):
    """In the ramp the aircraft is carried along: ground velocity changes, so a force must act."""
    t = calm.time_us * 1e-6
    ramp = (t > 304) & (t < 306)
    ground_acceleration = np.gradient(calm.v_N[ramp], 1 / 60, axis=0)[1:-1]
    f_N = np.einsum("nij,nj->ni", calm.C_NB[ramp], calm.f_B[ramp])[1:-1]
    # 12 m/s in 10 s on both axes, on top of a turn; Coriolis stays below 0.04 m/s^2.
    np.testing.assert_allclose(f_N[:, :2], ground_acceleration[:, :2], atol=0.05)
    assert np.degrees(np.abs(calm.beta[ramp])).max() > 0.5


def test_gusts_move_the_air_and_not_the_aircraft():
    path = flight_path(read_profile(config_path("routes/ordinary.profile")), 60)
    n = 60 * 100
    columns = ("airspeed", "path_angle", "track", "bank")
    path = replace(path, **{name: getattr(path, name)[:n] for name in columns})
    still = fly_path(path, np.zeros((n, 3)), np.zeros((n, 3)), Aircraft(), YEAR)
    gust_B = Turbulence(2.0).gust_B(n, 1 / 60, 180.0, np.random.default_rng(3))
    gusty = fly_path(path, np.zeros((n, 3)), gust_B, Aircraft(), YEAR)
    for name in ("lat", "v_N", "omega_B", "f_B", "q_NB"):
        np.testing.assert_array_equal(getattr(gusty, name), getattr(still, name))
    assert np.std(gusty.true_airspeed) > 1.0
    np.testing.assert_allclose(
        gusty.wind_N, np.einsum("nij,nj->ni", gusty.C_NB, gust_B), atol=1e-12
    )


def test_magnetic_truth_is_wmm2025(calm):
    pygeomag = pytest.importorskip("pygeomag")
    model = pygeomag.GeoMag(coefficients_file="wmm/WMM_2025.COF")
    for k in (0, 90_000):
        theirs = model.calculate(
            glat=np.degrees(calm.lat[k]),
            glon=np.degrees(calm.lon[k]),
            alt=calm.h[k] / 1000,
            time=YEAR,
        )
        # The other package rounds its height and angles.
        np.testing.assert_allclose(calm.b_N[k], [theirs.x, theirs.y, theirs.z], atol=0.1)


def test_heading_is_the_track_through_the_air_when_nothing_pushes_sideways(hard):
    level = (np.abs(np.degrees(hard.roll)) < 0.01) & (np.abs(np.degrees(hard.pitch)) < 60)
    v_air_N = hard.v_N - hard.wind_N
    track = np.arctan2(v_air_N[:, 1], v_air_N[:, 0])
    assert np.degrees(np.abs(wrap_pi(hard.heading - track)[level])).max() < 0.1
