# SPDX-License-Identifier: Apache-2.0
"""The one error a person is meant to read."""


class InputError(ValueError):
    """Bad input from a person: a file, a key, an option.

    The message is one line that names the thing, what was wrong, and what is allowed. Commands
    print it without a traceback and exit with 2.
    """
