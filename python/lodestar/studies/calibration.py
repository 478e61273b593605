# SPDX-License-Identifier: Apache-2.0
"""Calibration of the magnetic detector from a flight with a reference attitude.

``b_cal = (I + D) b_raw + x_1..3`` (SAHRS paper §5): x_1..3 is a bias in nT, x_4..6 the diagonal of
D, x_7..12 its off-diagonal elements row by row. The reference is the INS's attitude and the model
of the Earth's field; the fit is one batch of least squares over the whole flight.
"""

from __future__ import annotations

import os
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from lodestar import _core, rotation
from lodestar.errors import InputError
from lodestar.recordings.recording import Recording

Array = NDArray[np.float64]
Model = Literal["igrf14", "wmm2025"]

DIAGONAL = ((0, 0), (1, 1), (2, 2))
OFF_DIAGONAL = ((0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1))
MINIMUM_OBSERVABILITY = 1e-3
"""A level circle has 0; squares with 45 deg banked corners to one side at 72 deg dip have 0.004."""

_FEWEST_SAMPLES = 1000
_BLOCK_S = 10.0  # residuals this far apart are taken for independent
_LONGEST_INS_GAP_US = 200_000


@dataclass(frozen=True)
class Calibration:
    """Twelve parameters of the magnetic detector and how well they are known."""

    x: Array
    """(12,) bias in nT, scale and misalignment without unit."""
    sigma: Array
    """(12,) standard deviations, with the correlation of the residuals in time accounted for."""
    residual_rms: Array
    """(3,) nT per body axis."""
    observability: float
    """Smallest eigenvalue of the mean information of (1, field direction in B)."""
    samples: int

    @property
    def bias_nT(self) -> Array:
        """(3,), added to the field after the matrix."""
        return self.x[:3]

    @property
    def matrix(self) -> Array:
        """(3, 3), I + D."""
        return matrix_of(self.x)

    def apply(self, b_B: Array) -> Array:
        """Calibrated field (n, 3) in nT of the raw field (n, 3)."""
        calibrated: Array = b_B @ self.matrix.T + self.bias_nT
        return calibrated


def matrix_of(x: Array) -> Array:
    """I + D (3, 3) of the parameter vector (12,)."""
    matrix = np.eye(3)
    for value, place in zip(x[3:], (*DIAGONAL, *OFF_DIAGONAL), strict=True):
        matrix[place] += value
    return matrix


def calibrate(
    recording: Recording,
    decimal_year: float,
    window_s: tuple[float, float] = (-np.inf, np.inf),
    model: Model = "igrf14",
) -> Calibration:
    """Calibrate SMDU of a recording against its INS, between two times of validity in seconds.

    Raises InputError when SMDU or INS is missing, when too few samples have a valid reference, or
    when too little of the sphere was seen to tell the parameters apart.
    """
    for name in ("SMDU", "INS"):
        if name not in recording:
            raise InputError(f"calibration: the recording has no {name}")
    time_us, b_B, reference_B = _paired_fields(recording, decimal_year, window_s, model)
    if len(time_us) < _FEWEST_SAMPLES:
        raise InputError(
            f"calibration: {len(time_us)} SMDU samples with a valid INS between {window_s[0]:g} "
            f"and {window_s[1]:g} s, must be at least {_FEWEST_SAMPLES}"
        )
    return fit(time_us, b_B, reference_B)


def fit(time_us: NDArray[np.int64], b_B: Array, reference_B: Array) -> Calibration:
    """Least-squares calibration that takes the raw field b_B to reference_B, both (n, 3) in nT.

    Raises InputError when too little of the sphere was seen to tell the parameters apart.
    """
    count = len(time_us)
    # Columns of like size condition the normal matrix.
    strength = float(np.sqrt(np.mean(np.sum(reference_B**2, axis=1))))
    direction = np.column_stack([np.ones(count), reference_B / strength])
    observability = float(np.linalg.eigvalsh(direction.T @ direction / count)[0])
    if observability < MINIMUM_OBSERVABILITY:
        raise InputError(
            f"calibration: too little of the sphere was seen (observability "
            f"{observability:.2g}, must be at least {MINIMUM_OBSERVABILITY:g}): "
            f"turn with bank to both sides"
        )
    A = np.column_stack([np.ones(count), b_B / strength])
    inverse = np.linalg.inv(A.T @ A)
    solution = inverse @ (A.T @ (reference_B - b_B))  # (4, 3), a column per axis
    residual = reference_B - b_B - A @ solution
    sigma = _sigma(time_us, A, residual, inverse)
    return Calibration(
        x=_vector(solution, strength),
        sigma=_vector(sigma, strength),
        residual_rms=np.sqrt(np.mean(residual**2, axis=0)),
        observability=observability,
        samples=count,
    )


def _vector(by_axis: Array, strength: float) -> Array:
    """The vector (12,) of regression coefficients (4, 3): constant and three field components."""
    D = by_axis[1:].T / strength
    return np.concatenate([by_axis[0], [D[place] for place in (*DIAGONAL, *OFF_DIAGONAL)]])


def _sigma(time_us: NDArray[np.int64], A: Array, residual: Array, inverse: Array) -> Array:
    """Standard deviations (4, 3) by the sandwich estimator over blocks of time.

    The reference attitude's error lasts for seconds, so neighbouring residuals are nearly the same;
    the plain formula would take each for news and be many times too small.
    """
    block = (time_us - time_us[0]) // round(_BLOCK_S * 1e6)
    start = np.flatnonzero(np.diff(block, prepend=-1))
    blocks = len(start)
    sigma = np.empty((4, 3))
    for axis in range(3):
        score = np.add.reduceat(A * residual[:, axis : axis + 1], start, axis=0)
        covariance = inverse @ (score.T @ score) @ inverse * blocks / max(blocks - 1, 1)
        sigma[:, axis] = np.sqrt(np.diag(covariance))
    return sigma


def _paired_fields(
    recording: Recording, decimal_year: float, window_s: tuple[float, float], model: Model
) -> tuple[NDArray[np.int64], Array, Array]:
    """Times, raw field and model field in B at the SMDU samples that have a valid reference."""
    ins, smdu = recording["INS"], recording["SMDU"]
    valid = ins["valid"]
    ins_time = ins["time_us"][valid]
    time_us = smdu["time_us"]
    if len(ins_time) == 0:
        return time_us[:0], smdu["b_B"][:0], smdu["b_B"][:0]
    b_N = _core.geomagnetic_field(
        ins["lat"][valid], ins["lon"][valid], ins["h"][valid], decimal_year, model
    )
    C_NB = rotation.C_NB_from_euler(*(ins[angle][valid] for angle in ("roll", "pitch", "heading")))
    field_B = np.einsum("nji,nj->ni", C_NB, b_N)
    before = np.searchsorted(ins_time, time_us, side="right") - 1
    after = np.searchsorted(ins_time, time_us, side="left")
    bracketed = (before >= 0) & (after < len(ins_time))
    gap = ins_time[np.minimum(after, len(ins_time) - 1)] - ins_time[np.maximum(before, 0)]
    keep = (
        smdu["valid"]
        & bracketed
        & (gap <= _LONGEST_INS_GAP_US)
        & (time_us >= window_s[0] * 1e6)
        & (time_us <= window_s[1] * 1e6)
    )
    # Interpolating the field in B, not the angles, has no wrap and no singularity.
    reference = np.column_stack([np.interp(time_us[keep], ins_time, axis) for axis in field_B.T])
    return time_us[keep], smdu["b_B"][keep], reference


def write_calibration(calibration: Calibration, path: Path) -> None:
    """Write the calibration as TOML that lodestar-fc's --calibration reads, in one step.

    Raises InputError when the file cannot be written.
    """
    rows = ",\n".join(f"  [{', '.join(repr(float(v)) for v in row)}]" for row in calibration.matrix)
    text = (
        f"# Magnetic detector, {calibration.samples} samples; residual rms "
        f"{', '.join(f'{v:.0f}' for v in calibration.residual_rms)} nT; observability "
        f"{calibration.observability:.3g}\n"
        f"# sigma of the bias: {', '.join(f'{v:.0f}' for v in calibration.sigma[:3])} nT; "
        f"of the matrix: at most {calibration.sigma[3:].max():.2g}\n"
        "[smdu_calibration]\n"
        f"bias_nT = [{', '.join(repr(float(v)) for v in calibration.bias_nT)}]\n"
        f"matrix = [\n{rows}\n]\n"
    )
    temporary = path.with_name(path.name + ".part")
    try:
        with temporary.open("w", encoding="utf-8") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None


def read_calibration(path: Path) -> tuple[Array, Array]:
    """Bias (3,) in nT and matrix (3, 3) of a file of write_calibration.

    Raises InputError for a file that is missing or does not hold a calibration.
    """
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: {error}") from None
    section = content.get("smdu_calibration")
    if not isinstance(section, dict):
        raise InputError(f"{path}: has no table [smdu_calibration]")
    return _numbers(path, section, "bias_nT", (3,)), _numbers(path, section, "matrix", (3, 3))


def _numbers(path: Path, section: dict[str, object], key: str, shape: tuple[int, ...]) -> Array:
    try:
        value = np.array(section.get(key), dtype=np.float64)
    except (TypeError, ValueError):
        value = np.empty(0)
    if value.shape != shape or not np.isfinite(value).all():
        raise InputError(f"{path}: smdu_calibration.{key} must be {shape} finite numbers")
    return value
