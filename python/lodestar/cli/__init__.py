# SPDX-License-Identifier: Apache-2.0
"""The command lodestar: one file per subcommand.

Importing a command imports nothing heavy: ``lodestar fly`` must be able to move into namespaces of
its own before NumPy starts threads, and ``--help`` should be there at once.
"""
