# SPDX-License-Identifier: Apache-2.0
import importlib.util
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "cpp/lodestar/earth/make_coefficients.py"


def generated_headers() -> dict[str, str]:
    spec = importlib.util.spec_from_file_location("make_coefficients", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    return script.headers()


@pytest.mark.parametrize("name", ["igrf14_coefficients.h", "wmm2025_coefficients.h"])
def test_table_is_what_the_script_makes_of_the_published_coefficients(name: str) -> None:
    assert SCRIPT.with_name(name).read_text() == generated_headers()[name]
