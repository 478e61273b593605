# SPDX-License-Identifier: Apache-2.0
"""How good a flight's estimates were: figures, tables, plots and the report."""
