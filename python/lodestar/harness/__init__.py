# SPDX-License-Identifier: Apache-2.0
"""Flights of the real flight computer process: bus, process, scenarios, clocks, pytest plugin."""

LOG = "flight.lcm"
"""What went over the bus, in the folder of a run."""
CONFIG = "config.toml"
"""The flight computer's configuration, beside it."""
