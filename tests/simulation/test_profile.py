# SPDX-License-Identifier: Apache-2.0
from math import radians

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lodestar.errors import InputError
from lodestar.paths import config_path, shipped
from lodestar.simulation.profile import (
    MANOEUVRES,
    flight_path,
    parse_profile,
    read_profile,
    turned,
)

START = "start lat 57 deg lon 16 deg altitude 3000 m heading 30 deg speed 200 m/s\n"


def values(line):
    return parse_profile(START + line).lines[1].values


def test_a_line_reads_as_a_person_writes_it():
    profile = parse_profile(
        "# a comment\n\n" + START + "horizontal_turn  right 90 deg  bank 40 deg  # more\n"
    )
    start, turn = profile.lines
    assert (start.name, start.number) == ("start", 3)
    assert start.values["lat"] == pytest.approx(radians(57))
    assert (turn.name, turn.number) == ("horizontal_turn", 4)
    assert turn.values == pytest.approx(
        {"right": radians(90), "bank": radians(40), "roll_rate": radians(25)}
    )


def test_the_first_key_may_be_left_out():
    assert values("straight 120 s") == values("straight for 120 s") == values("straight 2 min")
    assert values("loop 5 g") == values("loop load 5 g")


@pytest.mark.parametrize(
    ("line", "key", "si"),
    [
        ("speed_change to 360 km/h in 10 s", "to", 100.0),
        ("speed_change to 200 kt in 10 s", "to", 200 * 1852 / 3600),
        ("climb to 10000 ft", "to", 3048.0),
        ("climb to 3.1 km", "to", 3100.0),
        ("vertical_turn to 0.1 rad", "to", 0.1),
        ("climb to 3100 m", "angle", radians(4)),
        ("heading_oscillation amplitude 10 deg period 30 s cycles 3", "cycles", 3),
    ],
)
def test_units_and_defaults(line, key, si):
    assert values(line)[key] == pytest.approx(si)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", r"^p: empty; the first manoeuvre must be start"),
        ("straight 10 s", r"p:1: straight: the first manoeuvre"),
        (START + START, r"p:2: start: the first manoeuvre, and only the first"),
        (START + "\nbarrel 3 g", r"p:3: barrel: no such manoeuvre; allowed are start, straight"),
        (START + "straight 10", r"p:2: straight: for: unit nothing; allowed are s, min"),
        (START + "straight 10 h", r"p:2: straight: for: unit h; allowed are s, min"),
        (START + "straight for ten s", r"p:2: straight: for: a number must follow, not ten"),
        (START + "straight 10 s long 3 s", r"unknown key long; allowed are for"),
        (START + "straight 10 s for 10 s", r"for is given twice"),
        (START + "straight", r"for missing"),
        (START + "straight -5 s", r"straight: for -5: allowed is 0.1 to 36000 s"),
        (START + "straight nan s", r"straight: for nan: allowed is"),
        (START + "loop 12 g", r"loop: load 12: allowed is 1.5 to 9 g"),
        (START + "loop 12 g 3", r"allowed is 1.5 to 9 g"),
        (START + "horizontal_turn right 90 deg", r"exactly one of bank, load, in"),
        (START + "horizontal_turn right 9 deg left 9 deg in 9 s", r"exactly one of left, right"),
        (START + "vertical_turn to 5 deg load 2 g in 5 s", r"only one of load, in"),
        (START + "aileron_roll right 1.5", r"must be a whole number"),
        ("start lat 95 deg", r"p:1: start: lat 95: allowed is -85 to 85 deg"),
        ("start lat 5 deg", r"lon, altitude, heading, speed missing"),
    ],
)
def test_errors_name_file_line_key_and_what_is_allowed(text, message):
    with pytest.raises(InputError, match=message):
        parse_profile(text, "p")


def test_what_cannot_be_flown_names_file_and_line():
    profile = parse_profile(START + "straight 5 s\nhorizontal_turn right 180 deg in 5 s", "p")
    with pytest.raises(InputError, match=r"^p:3: horizontal_turn: needs more than 85 deg of bank"):
        flight_path(profile, 60)


def refusal(text):
    try:
        parse_profile(text, "p")
    except InputError as error:
        return str(error)
    return None


@settings(deadline=None)
@given(st.text(max_size=60))
def test_any_text_is_read_or_refused_in_one_line(text):
    message = refusal(START + text)
    assert message is None or (message.startswith("p:") and "\n" not in message)


def test_unreadable_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"none\.profile: cannot be read"):
        read_profile(tmp_path / "none.profile")
    (tmp_path / "binary.profile").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match=r"binary\.profile: cannot be read"):
        read_profile(tmp_path / "binary.profile")


def test_every_manoeuvre_of_the_language_can_be_flown():
    text = (
        START
        + """
        straight 5 s
        speed_change to 190 m/s in 10 s
        horizontal_turn left 90 deg load 2 g roll_rate 40 deg/s
        horizontal_turn right 90 deg in 100 s speed 200 m/s
        vertical_turn to 5 deg
        vertical_turn to 0 deg in 5 s speed 190 m/s
        climb to 3600 m angle 6 deg load 0.5 g
        heading_oscillation amplitude 10 deg period 40 s cycles 2
        loop load 5 g
        aileron_roll left 1
        split_s load 6 g
    """
    )
    profile = parse_profile(text)
    assert {line.name for line in profile.lines} == set(MANOEUVRES)
    path = flight_path(profile, 60)
    assert path.duration > 300
    assert np.isfinite(path.airspeed).all()


@pytest.mark.parametrize("name", shipped("routes", ".profile"))
def test_shipped_routes_can_be_flown(name):
    path = flight_path(read_profile(config_path(f"routes/{name}.profile")), 30)
    assert path.duration >= 900


def test_a_turned_profile_flies_the_same_manoeuvres_on_another_course():
    profile = parse_profile(START + "horizontal_turn right 90 deg bank 40 deg\nstraight 10 s\n")
    path, other = flight_path(profile, 30), flight_path(turned(profile, radians(50)), 30)
    np.testing.assert_allclose(other.track - path.track, radians(50), atol=1e-9)
    np.testing.assert_array_equal(other.bank, path.bank)
