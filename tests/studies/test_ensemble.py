# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from lodestar.studies.campaign import Cell, Result
from lodestar.studies.ensemble import grouped, mean_interval, nees_bounds

ONE, OTHER = Cell("f", "f/one", "e"), Cell("f", "f/other", "e")


def result(cell, seed):
    return Result(cell, seed, {"x": float(seed)}, {"s": np.full(3, seed, np.float32)})


def test_results_are_grouped_by_cell_in_their_order():
    groups = grouped([result(OTHER, 1), result(OTHER, 2), result(ONE, 1)])
    assert [(group.cell, group.runs) for group in groups] == [(OTHER, 2), (ONE, 1)]
    np.testing.assert_array_equal(groups[0].figure("x"), [1.0, 2.0])
    np.testing.assert_array_equal(groups[0].series("s"), [[1, 1, 1], [2, 2, 2]])


def test_the_interval_holds_the_true_mean_as_often_as_it_says():
    rng = np.random.default_rng(1)
    held = [low <= 3 <= high for _, low, high in map(mean_interval, rng.normal(3, 2, (2000, 5)))]
    assert np.mean(held) == pytest.approx(0.95, abs=0.015)  # 3 sigma of 2000 draws


def test_one_flight_has_no_interval_and_a_missing_figure_no_mean():
    mean, low, high = mean_interval(np.array([2.0]))
    assert mean == 2.0
    assert np.isnan([low, high]).all()
    assert np.isnan(mean_interval(np.array([1.0, np.nan]))).all()


def test_the_bounds_hold_the_nees_of_a_consistent_filter_as_often_as_they_say():
    rng = np.random.default_rng(2)
    low, high = nees_bounds(10, 3)
    nees = np.mean(rng.normal(size=(4000, 10, 3)) ** 2, axis=(1, 2))
    assert np.mean((nees >= low) & (nees <= high)) == pytest.approx(0.95, abs=0.01)


def test_published_bounds_of_a_hundred_flights():
    # Chi-squared with 300 degrees of freedom: 253.9 to 349.9.
    assert nees_bounds(100, 3) == pytest.approx((253.912 / 300, 349.874 / 300), abs=1e-5)
