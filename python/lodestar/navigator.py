# SPDX-License-Identifier: Apache-2.0
"""The flight computer's core in this process: a recording in, its answers out.

The code that runs is the one of ``lodestar-fc``; for the same messages in the same order the
answers are the same bits.
"""

from __future__ import annotations

from lodestar import _core
from lodestar.channels import INPUTS
from lodestar.errors import InputError
from lodestar.recordings.recording import Recording

_ESTIMATED = ("EFCS.RATES", "EFCS.LOAD_FACTOR", "SMDU", "ADC", "GPS", "INS")


def run(recording: Recording, config: str = "", calibration: str | bytes = "") -> Recording:
    """Run ``recording`` through a fresh navigator; return its inputs and the answers.

    ``config`` and ``calibration`` are what ``lodestar-fc`` reads from files: TOML texts, and for
    the calibration also the bytes of a stored one.
    Raises InputError for a bad configuration or a recording without body rates.
    """
    inputs = recording.subset(INPUTS)
    names = [name for name in (*_ESTIMATED[1:], _ESTIMATED[0]) if name in inputs]
    if "EFCS.RATES" not in names:
        raise InputError("recording: has no EFCS.RATES, the channel that triggers the frames")
    _, channel, row = inputs.event_arrays(names)
    try:
        outputs = _core.run(config, calibration, inputs.channels, names, channel, row)
    except _core.ConfigError as error:
        raise InputError(str(error)) from error
    result = Recording(dict(recording.channels))
    for name, values in outputs.items():
        result.put(name, values)
    return result
