# SPDX-License-Identifier: Apache-2.0
"""Recordings: LCM logs, npz files and importers of other people's formats."""
