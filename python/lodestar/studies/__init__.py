# SPDX-License-Identifier: Apache-2.0
"""Studies on recorded and simulated flights: calibration, identification, Monte Carlo."""
