# SPDX-License-Identifier: Apache-2.0
"""Error series of flights, and the identification of all three angles."""

import json
from math import radians

import numpy as np
import pytest

from lodestar import channels, rotation
from lodestar.errors import InputError
from lodestar.recordings import Recording
from lodestar.studies.identification import (
    ANGLES,
    error_series,
    identify,
    tables,
    to_json,
)
from lodestar.studies.identification_plots import write_plots

RATE_HZ = 10
TAU_S = 10.0


def empty(channel, time_us):
    columns = {
        field.name: np.zeros((len(time_us), *field.shape), field.dtype)
        for field in channels.fields(channel)
    }
    return columns | {"time_us": time_us, "valid": np.ones(len(time_us), bool)}


def flight(errors, heading=0.0):
    """INS on a circle through north, SAHRS off by the given errors (reference minus SAHRS, rad)."""
    count = len(errors["heading"])
    time_us = (np.arange(count) * 1_000_000 // RATE_HZ).astype(np.int64)
    true = {
        "roll": np.full(count, radians(20.0)),
        "pitch": np.full(count, radians(2.0)),
        "heading": rotation.wrap_2pi(heading + 0.02 * np.sin(np.arange(count) / 50.0)),
    }
    told = {angle: true[angle] - errors[angle] for angle in true}
    told["heading"] = rotation.wrap_2pi(told["heading"])
    order = ("roll", "pitch", "heading")
    recording = Recording()
    recording.put("INS", empty("INS", time_us) | true)
    q_NB = rotation.q_NB_from_euler(*(told[angle] for angle in order))
    recording.put("SAHRS", empty("SAHRS", time_us) | told | {"q_NB": q_NB})
    return recording


def wandering(count, seed):
    """Errors of 0.02 rad with a time constant of TAU_S."""
    rng = np.random.default_rng(seed)
    A = np.exp(-1.0 / (RATE_HZ * TAU_S))
    errors = {}
    for angle in ANGLES:
        x = 0.02 * rng.standard_normal()
        series = []
        for w in 0.02 * np.sqrt(1 - A * A) * rng.standard_normal(count):
            series.append(x)
            x = A * x + w
        errors[angle] = np.array(series)
    return errors


def test_errors_are_reference_minus_sahrs_also_through_north():
    errors = wandering(600, 1)
    series = error_series(flight(errors), "it", interval_s=1.0)
    assert series.interval_s == 1.0
    for angle in ANGLES:
        # Through two rotations and back.
        np.testing.assert_allclose(series.errors[angle], errors[angle][::RATE_HZ], atol=1e-12)


def test_where_sahrs_or_the_reference_is_not_valid_or_silent_there_is_no_error():
    recording = flight(wandering(600, 2))
    recording["SAHRS"]["valid"][100:151] = False
    recording["INS"]["valid"][300:341] = False
    silent = {name: np.delete(v, np.s_[400:450], 0) for name, v in recording["SAHRS"].items()}
    silent.pop("arrival_us")
    recording.put("SAHRS", silent)
    series = error_series(recording, "it", interval_s=1.0)
    missing = np.flatnonzero(np.isnan(series.errors["pitch"]))
    # 30 and 34 s lie at the edges of the INS's silence, whose neighbours are 4.2 s apart.
    assert missing.tolist() == [*range(10, 16), *range(30, 35), *range(40, 45)]


def test_answers_that_come_a_little_early_or_late_are_all_used():
    errors = wandering(3000, 8)
    recording = flight(errors)
    jitter = np.random.default_rng(8).integers(-20, 21, 3000)
    jitter[0] = 0
    for channel in ("SAHRS", "INS"):
        recording[channel]["time_us"] += jitter
    series = error_series(recording, "it", interval_s=1.0)
    np.testing.assert_allclose(series.errors["roll"], errors["roll"][::RATE_HZ], atol=1e-12)


def test_a_flight_gives_a_model_of_each_angle_and_another_tests_it(tmp_path):
    one = error_series(flight(wandering(6000, 3)), "one.npz", interval_s=0.5)
    other = error_series(flight(wandering(4000, 4)), "other.npz", interval_s=0.5)
    found = identify(one, other, "ins")
    told = json.loads(json.dumps(to_json(found)))
    assert (told["reference"], told["validated_on"]) == ("INS", "other.npz")
    assert [angle["angle"] for angle in told["angles"]] == list(ANGLES)
    for angle in told["angles"]:
        assert angle["samples"] == 1200
        assert angle["tau_low_s"] < angle["tau_s"] < angle["tau_high_s"]
        assert abs(np.log(angle["tau_s"] / TAU_S)) < 4 * angle["tau_sigma_s"] / angle["tau_s"]
        assert angle["validation"]["white"]
        assert angle["validation"]["fit_percent"] > 50
        assert len(angle["validation"]["autocorrelation"]) == 25
    models, own, validation = tables(found)
    assert len(models.rows) == len(own.rows) == len(validation.rows) == 3
    assert "other.npz" in validation.title
    assert {path.name for path in write_plots(found, tmp_path)} == {
        "errors.png",
        "residuals.png",
        "autocorrelation.png",
        "validation-residuals.png",
    }


def test_without_another_flight_there_is_no_validation(tmp_path):
    series = error_series(flight(wandering(2000, 5)), "one.npz", interval_s=1.0)
    found = identify(series, None, "ins")
    assert all(angle["validation"] is None for angle in to_json(found)["angles"])
    assert len(tables(found)) == 2
    assert len(write_plots(found, tmp_path)) == 3


def without(recording, channel):
    return recording.subset(tuple(name for name in recording.channels if name != channel))


def test_what_cannot_be_compared_is_refused_by_name():
    recording = flight(wandering(300, 6))
    with pytest.raises(InputError, match=r"^it: has no SAHRS; lodestar replay"):
        error_series(without(recording, "SAHRS"), "it")
    with pytest.raises(InputError, match=r"^it: has no valid INS to compare with$"):
        error_series(without(recording, "INS"), "it")
    with pytest.raises(InputError, match=r"^it: has no valid TRUTH"):
        error_series(recording, "it", reference="truth")
    with pytest.raises(InputError, match=r"answers every 0\.1 s; a sampling time of 0\.05 s"):
        error_series(recording, "it", interval_s=0.05)
    recording["INS"]["valid"][:] = False
    with pytest.raises(InputError, match="no valid INS"):
        error_series(recording, "it")


def test_a_flight_too_short_names_itself_and_the_angle():
    long, short = (error_series(flight(wandering(n, 7)), f"{n}.npz") for n in (1500, 300))
    with pytest.raises(InputError, match=r"^300.npz: heading error: 30 samples at 1 s"):
        identify(short, None, "ins")
    with pytest.raises(InputError, match=r"^300.npz: heading error: 30 samples; a validation"):
        identify(long, short, "ins")
