# SPDX-License-Identifier: Apache-2.0
"""What kind of flight a recording holds, told from its data."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from lodestar.channels import INPUTS, WARNINGS
from lodestar.evaluation.health_plots import REASONS
from lodestar.evaluation.score import Score
from lodestar.evaluation.summary import Table
from lodestar.recordings.recording import Channel, Recording


def description(recording: Recording, score: Score) -> str:
    """Place, height, speed, bank and wind of the flight, in a few sentences."""
    reference = recording[score.comparison.reference]
    rows = reference["valid"] if "valid" in reference else np.ones(len(reference["lat"]), bool)
    lat, lon = (np.rad2deg(reference[name][rows][0]) for name in ("lat", "lon"))
    speed = np.hypot(*reference["v_N"][rows][:, :2].T)
    bank = np.rad2deg(np.abs(reference["roll"][rows]).max())
    told = (
        f"{score.duration_s:.0f} s from {abs(lat):.2f}° {'N' if lat >= 0 else 'S'} "
        f"{abs(lon):.2f}° {'E' if lon >= 0 else 'W'}, at "
        f"{_span(reference['h'][rows])} m and {_span(speed)} m/s over the ground, "
        f"with up to {bank:.0f}° of bank."
    )
    if "wind_N" in reference:
        wind = reference["wind_N"][:, :2]
        north, east = wind.mean(axis=0)
        told += f" Mean wind {north:.1f} m/s towards north and {east:.1f} m/s towards east"
        spread = wind.std(axis=0)
        told += (
            f" (varying by {spread[0]:.1f} and {spread[1]:.1f})." if spread.max() > 0.05 else "."
        )
    losses = score.comparison.gps_losses
    if losses:
        total = sum(gap.duration_s for gap in losses)
        times = "once" if len(losses) == 1 else f"{len(losses)} times"
        told += f" GPS is lost {times}, for {total:.0f} s in all."
    return told


def _span(values: NDArray[np.float64]) -> str:
    low, high = float(values.min()), float(values.max())
    return f"{low:.0f}" if round(low) == round(high) else f"{low:.0f} to {high:.0f}"


def channel_table(recording: Recording) -> Table:
    """Messages and rate of every channel; from HEALTH, what became of the inputs."""
    health = recording.channels.get("HEALTH")
    rows: list[tuple[str, ...]] = [
        (name, *_counts(channel), *_fate(name, health))
        for name, channel in recording.channels.items()
    ]
    header = ("channel", "messages", "rate, Hz", "used", "refused")
    return Table("Channels", header, rows, wide=True)


def _counts(channel: Channel) -> tuple[str, str]:
    time_us = channel["time_us"]
    span = float(time_us[-1] - time_us[0]) * 1e-6 if len(time_us) > 1 else 0.0
    rate = f"{(len(time_us) - 1) / span:.1f}" if span > 0 else "–"
    return str(len(time_us)), rate


def _fate(name: str, health: Channel | None) -> tuple[str, str]:
    if health is None or name not in INPUTS or not len(health["time_us"]):
        return "–", "–"
    row = INPUTS.index(name)
    counts = health["rejected"][-1, row]
    reasons = [f"{int(n)} {why}" for why, n in zip(REASONS, counts, strict=True) if n]
    return str(int(health["used"][-1, row])), ", ".join(reasons) or "0"


def computer(recording: Recording) -> str:
    """Build, configuration and calibration of the flight computer, and its warnings."""
    if "HEALTH" not in recording or not len(recording["HEALTH"]["time_us"]):
        return ""
    last = {name: column[-1] for name, column in recording["HEALTH"].items()}
    version = bytes(last["build_version"]).rstrip(b"\0").decode("ascii", "replace")
    told = [f"lodestar-fc {version}".rstrip()]
    config = int(last["config_hash"])
    told.append(f"configuration {config:08x}" if config else "built-in configuration")
    calibration = int(last["calibration_id"])
    told.append(f"calibration {calibration:08x}" if calibration else "no SMDU calibration")
    if last["cycle_max"] > 0:
        told.append(
            f"frames mean {last['cycle_mean'] * 1e6:.1f} µs, 99 % {last['cycle_p99'] * 1e6:.1f} µs"
        )
    told += [text for bit, text in WARNINGS.items() if int(last["warning"]) & bit]
    return " · ".join(told)
