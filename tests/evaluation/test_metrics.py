# SPDX-License-Identifier: Apache-2.0
import math

import numpy as np
import pymap3d
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lodestar.evaluation.metrics import coverage, gaps, maximum, north_east_m, rmse

NAN = np.nan


def test_samples_that_are_nan_do_not_count():
    error = np.array([3.0, NAN, -4.0])
    assert rmse(error) == pytest.approx(np.sqrt(12.5))
    assert maximum(error) == 4.0
    assert coverage(error, np.array([3.0, 1.0, 3.0]), 1) == 0.5
    assert coverage(error, np.array([NAN, NAN, 2.0]), 2) == 1.0


def test_nothing_to_count_is_nan():
    nothing = np.array([NAN])
    assert math.isnan(rmse(nothing))
    assert math.isnan(maximum(nothing))
    assert math.isnan(coverage(nothing, np.ones(1), 1))


def test_normal_errors_are_covered_as_they_should_be():
    error = np.random.default_rng(1).normal(0.0, 2.0, 100_000)
    sigma = np.full(100_000, 2.0)
    # Four standard deviations of a share of 100 000 samples.
    assert coverage(error, sigma, 1) == pytest.approx(0.6827, abs=0.006)
    assert coverage(error, sigma, 2) == pytest.approx(0.9545, abs=0.003)


@given(lat=st.floats(-80, 80), lon=st.floats(-180, 180), d=st.tuples(*[st.floats(-50, 50)] * 2))
def test_horizontal_offset_agrees_with_an_independent_package(lat, lon, d):
    there = pymap3d.enu2geodetic(d[1], d[0], 0.0, lat, lon, 2000.0)
    here = [np.array([np.deg2rad(x)]) for x in (there[0], there[1], lat, lon)]
    offset = north_east_m(*here, np.array([2000.0]))[0]
    # A tangent plane and the ellipsoid part by the square of 50 m over the radius, more so
    # near the poles.
    np.testing.assert_allclose(offset, d, atol=5e-3)


def test_offset_across_the_date_line_is_short():
    lat, h = np.array([0.5]), np.array([0.0])
    offset = north_east_m(lat, np.array([-np.pi + 1e-6]), lat, np.array([np.pi - 1e-6]), h)
    assert abs(offset[0, 1]) < 12.0


def test_a_gap_runs_from_the_first_message_that_did_not_come():
    time_us = np.array([0, 1, 2, 6, 7]) * 1_000_000
    found = gaps(time_us, 12_000_000, 3_000_000)
    assert [(gap.start_us, gap.end_us) for gap in found] == [
        (3_000_000, 6_000_000),
        (8_000_000, 12_000_000),
    ]
    assert found[0].duration_s == 3.0
    assert gaps(time_us[:3], 5_000_000, 3_000_000) == []
    assert gaps(time_us[:0], 5_000_000, 3_000_000) == []
