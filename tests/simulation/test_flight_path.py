# SPDX-License-Identifier: Apache-2.0
from math import acos, cos, pi, radians

import numpy as np
import pytest

from lodestar.simulation.calculus import derivative
from lodestar.simulation.earth import STANDARD_GRAVITY as G
from lodestar.simulation.flight_path import (
    ENERGY_TRADE,
    FlightError,
    FlightPath,
    PathBuilder,
    Start,
)

RATE = 120


def builder(airspeed=200.0):
    start = Start(radians(57.5), radians(16.0), 3000.0, radians(30.0), airspeed)
    return PathBuilder(start, RATE)


def forces(path: FlightPath):
    """Lift and side force per weight that the path takes: load factor in its own frame."""
    turn_up = derivative(path.path_angle, 1 / path.rate_hz)
    turn_right = derivative(path.track, 1 / path.rate_hz) * np.cos(path.path_angle)
    up = path.airspeed * turn_up / G + np.cos(path.path_angle)
    right = path.airspeed * turn_right / G
    lift = up * np.cos(path.bank) + right * np.sin(path.bank)
    side = right * np.cos(path.bank) - up * np.sin(path.bank)
    return lift, side


def settled(b: PathBuilder):
    assert b.state.bank == 0.0
    assert b.state.turn_up == (0.0, 0.0)


@pytest.mark.parametrize("angle_deg", [90.0, -200.0, 2.0, 720.0])
@pytest.mark.parametrize("how", [{"bank": radians(40)}, {"duration": 160.0}])
def test_horizontal_turn_ends_on_the_asked_track_level_and_coordinated(angle_deg, how):
    b = builder()
    b.horizontal_turn(radians(angle_deg), roll_rate=radians(25), **how)
    assert b.state.track == pytest.approx(radians(30 + angle_deg), abs=1e-9)
    assert b.state.altitude == pytest.approx(3000.0, abs=1e-9)
    settled(b)
    _, side = forces(b.path())
    assert np.max(np.abs(side)) < 1e-6


def test_horizontal_turn_keeps_to_bank_and_roll_rate():
    b = builder()
    b.horizontal_turn(pi, bank=radians(40), roll_rate=radians(25))
    path = b.path()
    # Whole ticks of time leave half a per cent of bank.
    assert np.rad2deg(path.bank.max()) == pytest.approx(40.0, rel=5e-3)
    rate = np.rad2deg(derivative(path.bank, 1 / RATE))
    assert 23.0 < rate.max() < 25.2
    lift, _ = forces(path)
    assert lift.max() == pytest.approx(1 / cos(path.bank.max()), rel=1e-6)


def test_small_turn_takes_less_bank_than_allowed():
    b = builder()
    b.horizontal_turn(radians(1), bank=radians(60), roll_rate=radians(25))
    assert b.path().bank.max() < radians(15)


def test_turn_can_change_speed_on_the_way():
    b = builder(102.9)
    b.horizontal_turn(radians(-90), duration=200.0, roll_rate=radians(10), airspeed=132.9)
    assert b.state.airspeed == pytest.approx(132.9)
    assert b.state.track == pytest.approx(radians(-60), abs=1e-9)
    _, side = forces(b.path())
    assert np.max(np.abs(side)) < 1e-6


@pytest.mark.parametrize(("to_deg", "load"), [(10.0, 1.5), (-8.0, 0.5), (1.0, 2.0), (60.0, 4.0)])
def test_vertical_turn_reaches_the_angle_with_about_the_load(to_deg, load):
    b = builder()
    b.vertical_turn(radians(to_deg), load=load)
    assert b.state.path_angle == radians(to_deg)
    settled(b)
    lift, side = forces(b.path())
    extreme = lift.max() if load > 1 else lift.min()
    # Weight across a sloping path is less than in level flight, by up to 0.01 at 8 degrees.
    assert 0 < (extreme - 1) / (load - 1) <= 1.02
    assert np.max(np.abs(side)) < 1e-9


def test_climb_reaches_the_altitude_within_a_metre_and_levels():
    for target in (3600.0, 2500.0):
        b = builder()
        b.climb(target, angle=radians(4), load=0.3)
        assert b.state.altitude == pytest.approx(target, abs=1.0)
        assert b.state.path_angle == 0.0
        settled(b)


def test_heading_oscillation_returns_to_its_track():
    b = builder()
    b.heading_oscillation(radians(15), 40.0, 3)
    path = b.path()
    swing = np.rad2deg(path.track - path.track[0])
    assert swing.max() == pytest.approx(15.0, rel=0.01)
    assert swing.min() == pytest.approx(-15.0, rel=0.01)
    assert b.state.track == pytest.approx(radians(30))
    _, side = forces(path)
    assert np.max(np.abs(side)) < 1e-5


def test_loop_closes_on_itself_and_trades_speed_for_height():
    b = builder(220.0)
    b.loop(5.0)
    path = b.path()
    assert path.path_angle[-1] == pytest.approx(2 * pi, abs=1e-9)
    assert b.state.path_angle == 0.0
    assert b.state.altitude == pytest.approx(3000.0, abs=0.01)
    assert b.state.airspeed == pytest.approx(220.0, abs=1e-3)
    lift, side = forces(path)
    assert lift.max() == pytest.approx(5.0, rel=0.02)
    assert lift.min() == pytest.approx(1.0, abs=1e-6)
    assert np.max(np.abs(side)) < 1e-9
    climbed = np.cumsum(path.airspeed * np.sin(path.path_angle)) / RATE
    top = np.argmax(climbed)
    lost = 0.5 * (220.0**2 - path.airspeed[top] ** 2) / G
    # The trade sets in and ends smoothly, so a few per cent are missing.
    assert lost == pytest.approx(ENERGY_TRADE * climbed[top], rel=0.03)


@pytest.mark.parametrize(("turns", "load"), [(1, 1.0), (-1, 1.0), (2, 0.5), (-3, 0.0), (1, 1.8)])
def test_aileron_roll_rolls_under_load_and_is_coordinated(turns, load):
    b = builder()
    b.aileron_roll(2 * pi * turns, rate=radians(120), load=load)
    path = b.path()
    rolled = np.abs(np.rad2deg(path.bank))
    assert rolled.max() == pytest.approx(360 * abs(turns), rel=1e-3)
    rate = np.abs(np.rad2deg(derivative(path.bank, 1 / RATE)))
    assert np.percentile(rate, 99) == pytest.approx(120.0, rel=0.03)
    settled(b)
    assert b.state.path_angle == 0.0
    lift, side = forces(path)
    inverted = np.abs(rolled % 360 - 180) < 60
    np.testing.assert_allclose(lift[inverted], load, atol=1e-4)
    assert np.max(np.abs(side)) < 1e-4


def test_split_s_ends_upright_and_lower_on_about_the_opposite_track():
    b = builder(150.0)
    b.split_s(rate=radians(120), load=5.5)
    path = b.path()
    turned = np.rad2deg(b.state.track - path.track[0])
    assert turned == pytest.approx(180.0, abs=6.0)  # the half roll drags the track along
    assert b.state.altitude < 3000.0 - 1000.0
    assert b.state.airspeed > 180.0
    settled(b)
    lift, side = forces(path)
    assert lift.max() == pytest.approx(5.5, rel=0.1)
    assert lift.min() > 0.5
    assert np.max(np.abs(side)) < 1e-4


def test_path_does_not_depend_on_the_rate_it_is_sampled_at():
    def fly(rate):
        b = PathBuilder(Start(1.0, 0.3, 3000.0, 0.5, 200.0), rate)
        b.straight(3.0)
        b.horizontal_turn(1.0, bank=0.8, roll_rate=0.5)
        b.aileron_roll(2 * pi, rate=2.0, load=1.0)
        b.loop(4.0)
        return b.path()

    coarse, fine = fly(60), fly(240)
    assert coarse.duration == fine.duration
    for name in ("airspeed", "path_angle", "track", "bank"):
        np.testing.assert_allclose(getattr(coarse, name), getattr(fine, name)[::4], atol=1e-7)


@pytest.mark.parametrize(
    ("manoeuvre", "message"),
    [
        (lambda b: b.horizontal_turn(pi, duration=5.0, roll_rate=1.0), "bank"),
        (lambda b: b.horizontal_turn(pi, roll_rate=1.0), "needs a bank or a duration"),
        (lambda b: b.vertical_turn(0.1, load=0.5), "above 1 g to turn up"),
        (lambda b: b.vertical_turn(0.0), "already"),
        (lambda b: b.vertical_turn(1.5, load=2.0), "75 deg"),
        (lambda b: b.climb(3005.0, angle=0.2, load=0.2), "too small"),
        (lambda b: b.heading_oscillation(1.5, 4.0, 2), "bank"),
        (lambda b: b.loop(1.6), "runs out of speed"),
        (lambda b: b.split_s(rate=2.0, load=2.2), "raise it"),
        (lambda b: b.straight(1.23), "tenths of a second"),
        (lambda b: b.aileron_roll(20 * pi, rate=0.5, load=0.0), "sag too far"),
    ],
)
def test_what_cannot_be_flown_is_refused_with_the_reason(manoeuvre, message):
    with pytest.raises(FlightError, match=message):
        manoeuvre(builder())


def test_loop_from_a_climb_is_refused():
    b = builder()
    b.vertical_turn(0.1)
    with pytest.raises(FlightError, match="level flight"):
        b.loop(5.0)


@pytest.mark.parametrize("rate", [20, 45])
def test_rate_must_hold_whole_tenths(rate):
    with pytest.raises(FlightError, match="multiple of 10"):
        PathBuilder(Start(0.0, 0.0, 0.0, 0.0, 100.0), rate)


def test_bank_of_a_load_is_that_of_a_level_turn():
    b = builder(220.0)
    b.horizontal_turn(2 * pi, bank=acos(1 / 5), roll_rate=radians(90))
    lift, _ = forces(b.path())
    assert lift.max() == pytest.approx(5.0, rel=0.03)
