# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from lodestar.rotation import (
    C_NB_from_euler,
    C_NB_from_q_NB,
    euler_from_C_NB,
    exp_quaternion,
    exp_so3,
    log_so3,
    q_NB_from_C_NB,
    q_NB_from_euler,
    quaternion_conjugate,
    quaternion_product,
    wrap_2pi,
    wrap_pi,
)

angles = st.floats(-10.0, 10.0)
vectors = st.tuples(angles, angles, angles).map(np.array)


def test_C_NB_takes_body_vectors_to_north_east_down():
    nose = C_NB_from_euler(0.0, 0.0, np.pi / 2)[:, 0]
    np.testing.assert_allclose(nose, [0, 1, 0], atol=1e-15)  # heading east
    nose = C_NB_from_euler(0.0, np.pi / 6, 0.0)[:, 0]
    np.testing.assert_allclose(nose, [np.cos(np.pi / 6), 0, -0.5], atol=1e-15)  # nose up
    right_wing = C_NB_from_euler(np.pi / 2, 0.0, 0.0)[:, 1]
    np.testing.assert_allclose(right_wing, [0, 0, 1], atol=1e-15)  # rolled right: wing down


@given(angles, st.floats(-1.57, 1.57), angles)
def test_euler_angles_come_back(roll, pitch, heading):
    back = euler_from_C_NB(C_NB_from_euler(roll, pitch, heading))
    expected = (wrap_pi(roll), pitch, wrap_2pi(heading))
    for angle, wanted in zip(back, expected, strict=True):
        # Near the vertical roll and heading lose digits as 1 / cos(pitch): up to 1e3 here.
        assert abs(wrap_pi(angle - wanted)) < 1e-12


@given(angles, angles, angles)
def test_agrees_with_an_independent_package(roll, pitch, heading):
    theirs = Rotation.from_euler("ZYX", [heading, pitch, roll])
    C_NB = C_NB_from_euler(roll, pitch, heading)
    np.testing.assert_allclose(C_NB, theirs.as_matrix(), atol=1e-14)
    q_NB = q_NB_from_euler(roll, pitch, heading)
    np.testing.assert_allclose(C_NB_from_q_NB(q_NB), theirs.as_matrix(), atol=1e-14)


@given(vectors)
def test_quaternion_of_a_matrix_is_the_matrix_again(rotation_vector):
    C = exp_so3(rotation_vector)
    q = q_NB_from_C_NB(C)
    assert q[0] >= 0
    assert np.linalg.norm(q) == pytest.approx(1.0, abs=1e-15)
    np.testing.assert_allclose(C_NB_from_q_NB(q), C, atol=1e-14)


@pytest.mark.parametrize("axis", range(3))
def test_half_turns_have_a_well_conditioned_quaternion(axis):
    C = np.diag(np.where(np.arange(3) == axis, 1.0, -1.0))
    expected = np.zeros(4)
    expected[1 + axis] = 1.0
    np.testing.assert_allclose(np.abs(q_NB_from_C_NB(C)), expected, atol=1e-15)


@given(vectors, vectors)
def test_product_of_quaternions_is_product_of_matrices(a, b):
    product = quaternion_product(exp_quaternion(a), exp_quaternion(b))
    np.testing.assert_allclose(C_NB_from_q_NB(product), exp_so3(a) @ exp_so3(b), atol=1e-13)
    undone = quaternion_product(exp_quaternion(a), quaternion_conjugate(exp_quaternion(a)))
    np.testing.assert_allclose(undone, [1, 0, 0, 0], atol=1e-14)


@given(vectors, st.sampled_from([1.0, 1e-3, 1e-9, 0.0]))
def test_log_undoes_exp_up_to_half_a_turn(vector, scale):
    length = np.linalg.norm(vector)
    small = vector * scale * (3.1 / max(length, 3.1))
    np.testing.assert_allclose(log_so3(exp_so3(small)), small, rtol=1e-12, atol=1e-14)


def test_helpers_keep_any_leading_shape():
    angle = np.linspace(-3, 3, 24).reshape(2, 3, 4)
    C = C_NB_from_euler(angle, angle / 2, angle)
    assert C.shape == (2, 3, 4, 3, 3)
    assert q_NB_from_C_NB(C).shape == (2, 3, 4, 4)
    assert log_so3(C).shape == (2, 3, 4, 3)
    np.testing.assert_allclose(C[1, 2, 3], C_NB_from_euler(3.0, 1.5, 3.0), atol=1e-15)


@given(st.floats(-1e3, 1e3))
def test_wrapping_keeps_the_direction_and_stays_in_its_interval(angle):
    half, full = float(wrap_pi(angle)), float(wrap_2pi(angle))
    assert -np.pi < half <= np.pi
    assert 0 <= full < 2 * np.pi
    for wrapped in (half, full):
        assert np.cos(wrapped - angle) == pytest.approx(1.0, abs=1e-12)


def test_wrapping_at_the_ends_of_the_intervals():
    assert wrap_pi(np.pi) == np.pi
    assert wrap_pi(-np.pi) == np.pi
    assert wrap_2pi(-1e-20) == 0.0
    assert wrap_2pi(2 * np.pi) == 0.0
