# SPDX-License-Identifier: Apache-2.0
"""Flights of the real flight computer process: bus, process, scenarios, clocks, pytest plugin."""
