# SPDX-License-Identifier: Apache-2.0
"""Mutated messages through the decoder, under the address and undefined-behaviour sanitizers."""

import subprocess
from pathlib import Path

import pytest

PROGRAM = Path(__file__).resolve().parents[2] / "build/asan/tests/fuzz_codec"
MESSAGES = 1_000_000


@pytest.mark.skipif(not PROGRAM.exists(), reason="needs `make build-asan`")
def test_no_message_breaks_the_decoder() -> None:
    done = subprocess.run(
        [PROGRAM, str(MESSAGES)], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr[-4000:]
    assert "runtime error" not in done.stderr  # the undefined-behaviour sanitizer only reports
    assert f"{MESSAGES} messages" in done.stdout
