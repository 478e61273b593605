# SPDX-License-Identifier: Apache-2.0
"""Rotations over arrays: direction cosine matrices, quaternions, Euler angles, rotation vectors.

``C_NB`` takes a vector from B to N; ``q_NB`` is the same rotation as a Hamilton quaternion, scalar
first. Euler angles are heading, pitch, roll, applied in that order (3-2-1). Everything is in
radians and works on any leading shape: angles (...,), vectors (..., 3), quaternions (..., 4),
matrices (..., 3, 3).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def wrap_pi(angle: ArrayLike) -> Array:
    """The same angle in (-pi, pi]."""
    turned = np.asarray(angle, float)
    return turned - 2 * np.pi * np.ceil((turned - np.pi) / (2 * np.pi))


def wrap_2pi(angle: ArrayLike) -> Array:
    """The same angle in [0, 2 pi)."""
    wrapped = np.mod(np.asarray(angle, float), 2 * np.pi)
    # The remainder of a tiny negative angle rounds up to the full turn.
    return np.where(wrapped >= 2 * np.pi, 0.0, wrapped)


def rotation_x(angle: ArrayLike) -> Array:
    """C of a frame that is turned by ``angle`` about x: shape (..., 3, 3)."""
    return _about(np.asarray(angle, float), 1, 2)


def rotation_y(angle: ArrayLike) -> Array:
    """C of a frame that is turned by ``angle`` about y: shape (..., 3, 3)."""
    return _about(np.asarray(angle, float), 2, 0)


def rotation_z(angle: ArrayLike) -> Array:
    """C of a frame that is turned by ``angle`` about z: shape (..., 3, 3)."""
    return _about(np.asarray(angle, float), 0, 1)


def _about(angle: Array, i: int, j: int) -> Array:
    C = np.zeros((*angle.shape, 3, 3))
    C[...] = np.eye(3)
    C[..., i, i] = C[..., j, j] = np.cos(angle)
    C[..., j, i] = np.sin(angle)
    C[..., i, j] = -C[..., j, i]
    return C


def C_NB_from_euler(roll: ArrayLike, pitch: ArrayLike, heading: ArrayLike) -> Array:
    """C_NB (..., 3, 3) of the Euler angles."""
    C: Array = rotation_z(heading) @ rotation_y(pitch) @ rotation_x(roll)
    return C


def euler_from_C_NB(C_NB: Array) -> tuple[Array, Array, Array]:
    """Roll in (-pi, pi], pitch in [-pi/2, pi/2], heading in [0, 2 pi)."""
    roll = np.arctan2(C_NB[..., 2, 1], C_NB[..., 2, 2])
    # Well conditioned up to the vertical, where an arc sine is not.
    pitch = np.arctan2(-C_NB[..., 2, 0], np.hypot(C_NB[..., 2, 1], C_NB[..., 2, 2]))
    heading = np.arctan2(C_NB[..., 1, 0], C_NB[..., 0, 0])
    return wrap_pi(roll), pitch, wrap_2pi(heading)


def quaternion_product(a: Array, b: Array) -> Array:
    """Hamilton product a b (..., 4)."""
    a0, a1, a2, a3 = np.moveaxis(a, -1, 0)
    b0, b1, b2, b3 = np.moveaxis(b, -1, 0)
    return np.stack(
        [
            a0 * b0 - a1 * b1 - a2 * b2 - a3 * b3,
            a0 * b1 + a1 * b0 + a2 * b3 - a3 * b2,
            a0 * b2 - a1 * b3 + a2 * b0 + a3 * b1,
            a0 * b3 + a1 * b2 - a2 * b1 + a3 * b0,
        ],
        axis=-1,
    )


def quaternion_conjugate(q: Array) -> Array:
    """The quaternion of the opposite rotation (..., 4)."""
    return np.asarray(q * np.array([1.0, -1.0, -1.0, -1.0]))


def q_NB_from_euler(roll: ArrayLike, pitch: ArrayLike, heading: ArrayLike) -> Array:
    """q_NB (..., 4) of the Euler angles."""
    halves = (0.5 * np.asarray(angle, float) for angle in (heading, pitch, roll))
    turns = []
    for axis, half in zip((3, 2, 1), halves, strict=True):
        q = np.zeros((*half.shape, 4))
        q[..., 0] = np.cos(half)
        q[..., axis] = np.sin(half)
        turns.append(q)
    return quaternion_product(quaternion_product(turns[0], turns[1]), turns[2])


def C_NB_from_q_NB(q_NB: Array) -> Array:
    """C_NB (..., 3, 3) of a unit quaternion (..., 4)."""
    q0, q1, q2, q3 = np.moveaxis(q_NB, -1, 0)
    rows = [
        [1 - 2 * (q2 * q2 + q3 * q3), 2 * (q1 * q2 - q0 * q3), 2 * (q1 * q3 + q0 * q2)],
        [2 * (q1 * q2 + q0 * q3), 1 - 2 * (q1 * q1 + q3 * q3), 2 * (q2 * q3 - q0 * q1)],
        [2 * (q1 * q3 - q0 * q2), 2 * (q2 * q3 + q0 * q1), 1 - 2 * (q1 * q1 + q2 * q2)],
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def q_NB_from_C_NB(C_NB: Array) -> Array:
    """q_NB (..., 4) with a scalar part that is not negative.

    All four products with the largest component are formed, and the best conditioned used
    (Shepperd's method).
    """
    m00, m11, m22 = C_NB[..., 0, 0], C_NB[..., 1, 1], C_NB[..., 2, 2]
    d21 = C_NB[..., 2, 1] - C_NB[..., 1, 2]
    d02 = C_NB[..., 0, 2] - C_NB[..., 2, 0]
    d10 = C_NB[..., 1, 0] - C_NB[..., 0, 1]
    s01 = C_NB[..., 0, 1] + C_NB[..., 1, 0]
    s02 = C_NB[..., 0, 2] + C_NB[..., 2, 0]
    s12 = C_NB[..., 1, 2] + C_NB[..., 2, 1]
    # Row k is 4 q_k (q0, q1, q2, q3).
    products = np.stack(
        [
            np.stack([1 + m00 + m11 + m22, d21, d02, d10], axis=-1),
            np.stack([d21, 1 + m00 - m11 - m22, s01, s02], axis=-1),
            np.stack([d02, s01, 1 - m00 + m11 - m22, s12], axis=-1),
            np.stack([d10, s02, s12, 1 - m00 - m11 + m22], axis=-1),
        ],
        axis=-2,
    )
    best = np.argmax(np.diagonal(products, axis1=-2, axis2=-1), axis=-1)
    q = np.take_along_axis(products, best[..., None, None], axis=-2)[..., 0, :]
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    return np.asarray(q * np.where(q[..., :1] < 0, -1.0, 1.0))


def exp_so3(rotation_vector: Array) -> Array:
    """C (..., 3, 3) of a rotation vector (..., 3), exact for every length."""
    return C_NB_from_q_NB(exp_quaternion(rotation_vector))


def exp_quaternion(rotation_vector: Array) -> Array:
    """Unit quaternion (..., 4) of a rotation vector (..., 3)."""
    half = 0.5 * np.asarray(rotation_vector, float)
    length = np.linalg.norm(half, axis=-1, keepdims=True)
    return np.concatenate([np.cos(length), np.sinc(length / np.pi) * half], axis=-1)


def log_so3(C: Array) -> Array:
    """Rotation vector (..., 3), of length up to pi, of C (..., 3, 3)."""
    q = q_NB_from_C_NB(C)
    length = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    half = np.arctan2(length, q[..., :1])
    return np.asarray(2.0 * q[..., 1:] / np.sinc(half / np.pi))
