# SPDX-License-Identifier: Apache-2.0
"""The channels of the flight bus and the layout of their messages.

Names, types and shapes of the fields are read from the generated LCM classes, which are made from
``lcm_types/*.lcm``; nothing here repeats them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

import lodestar.messages as messages

MESSAGE_OF_INPUT: dict[str, type[Any]] = {
    "EFCS.RATES": messages.body_rates_t,
    "EFCS.LOAD_FACTOR": messages.load_factor_t,
    "SMDU": messages.magnetic_field_t,
    "ADC": messages.air_data_t,
    "IMU.ACCEL": messages.specific_force_t,
    "GPS": messages.gps_fix_t,
    "GPS.RAW": messages.gps_observables_t,
    "INS": messages.ins_solution_t,
    "SAR": messages.sar_measurement_t,
    "RALT": messages.radar_altitude_t,
}
MESSAGE_OF_OUTPUT: dict[str, type[Any]] = {
    "SAHRS": messages.attitude_t,
    "NAV": messages.navigation_t,
    "AHRS": messages.attitude_t,
    "INS.MONITOR": messages.ins_monitor_t,
    "TARGET": messages.target_t,
    "SMDU.CALIBRATION": messages.smdu_calibration_t,
    "HEALTH": messages.health_t,
}

CHANNELS: dict[str, type[Any]] = {
    **MESSAGE_OF_INPUT,
    **MESSAGE_OF_OUTPUT,
    "TRUTH": messages.truth_t,
}
"""Channel name to LCM class, in the order of the channel table."""

INPUTS: tuple[str, ...] = tuple(MESSAGE_OF_INPUT)
"""What the flight computer subscribes to, in the order of the counters in HEALTH."""

OUTPUTS: tuple[str, ...] = tuple(MESSAGE_OF_OUTPUT)
"""What the flight computer publishes."""

WARNINGS: dict[int, str] = {
    1: "outside the geomagnetic model's validity",
    2: "realtime scheduling refused",
}
"""Bit of HEALTH's ``warning`` to what it says."""

INS_STATES: tuple[str, ...] = ("none", "agrees", "suspect", "miscompare")
"""INS.MONITOR's ``state`` in words."""

MASTER = "EFCS.RATES"
"""The channel that triggers a frame."""

EVENT_ORDER: tuple[str, ...] = (
    *(name for name in INPUTS if name != MASTER),
    MASTER,
    *OUTPUTS,
    "TRUTH",
)
"""Order of messages that arrive together: the trigger of the frame is last of the inputs."""

_DTYPES = {
    "int8_t": ">i1",
    "int16_t": ">i2",
    "int32_t": ">i4",
    "int64_t": ">i8",
    "float": ">f4",
    "double": ">f8",
    "boolean": "?",
    "byte": ">u1",
}


@dataclass(frozen=True)
class Field:
    """One field of a message: name, dtype on the wire (big-endian), shape of one message."""

    name: str
    wire_dtype: np.dtype[Any]
    shape: tuple[int, ...]

    @property
    def dtype(self) -> np.dtype[Any]:
        """The dtype in memory (native byte order)."""
        return np.dtype(self.wire_dtype.type)


@cache
def fields(channel: str) -> tuple[Field, ...]:
    """The fields of a channel's message, in wire order.

    Raises KeyError for a channel that is not in CHANNELS.
    """
    message = CHANNELS[channel]
    return tuple(
        Field(name, np.dtype(_DTYPES[typename]), tuple(dimensions or ()))
        for name, typename, dimensions in zip(
            message.__slots__, message.__typenames__, message.__dimensions__, strict=True
        )
    )


def fingerprint(channel: str) -> int:
    """The LCM fingerprint (64 bit) that starts every message of the channel."""
    return int.from_bytes(CHANNELS[channel]._get_packed_fingerprint(), "big")
