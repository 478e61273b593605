# SPDX-License-Identifier: Apache-2.0
"""Lodestar: an open flight computer for synthetic attitude, heading and navigation."""

__version__ = "0.1.0"
