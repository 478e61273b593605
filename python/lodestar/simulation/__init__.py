# SPDX-License-Identifier: Apache-2.0
"""Flights that are known exactly: profiles, wind, trajectories, and the sensors that see them."""
