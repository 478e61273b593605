# SPDX-License-Identifier: Apache-2.0
"""Write igrf14_coefficients.h and wmm2025_coefficients.h beside this script.

The numbers come from the packages ppigrf 2.1.0 (IGRF14.shc) and pygeomag 1.1.0 (WMM_2025.COF).
Both models become the same table: one row per epoch, linear in time between two of them. A model
given as main field and secular variation gets its last epoch five years on.
"""

import importlib.util
import textwrap
from decimal import Decimal
from pathlib import Path

HERE = Path(__file__).resolve().parent

HEADER = """\
// SPDX-License-Identifier: Apache-2.0
// Made by make_coefficients.py from {source}: numbers only. Not to be edited.
#pragma once

namespace lodestar::earth::{model} {{

// clang-format off
inline constexpr int kDegree = {degree};
inline constexpr double kYears[] = {{
{years}
}};
// Schmidt semi-normalised Gauss coefficients (nT), a row per year, each in the order
// g10 g11 h11 g20 g21 h21 g22 h22 ...; what a row leaves out is zero.
inline constexpr double kCoefficients[][kDegree * (kDegree + 2)] = {{
{rows}
}};
// clang-format on

}}  // namespace lodestar::earth::{model}
"""


def package_file(package: str, name: str) -> Path:
    """Path of a data file of an installed package, which is not imported."""
    spec = importlib.util.find_spec(package)
    if spec is None or spec.origin is None:
        raise SystemExit(f"error: package {package} is not installed")
    return Path(spec.origin).parent / name


def read_igrf(path: Path) -> tuple[list[str], list[list[str]]]:
    """Years and, per year, the coefficients of an SHC file (which has them in our order)."""
    lines = [line.split() for line in path.read_text().splitlines() if not line.startswith("#")]
    years, rows = lines[1], lines[2:]
    return years, [[row[2 + epoch] for row in rows] for epoch in range(len(years))]


def read_wmm(path: Path) -> tuple[list[str], list[list[str]]]:
    """Years and coefficients of a WMM file: at its epoch, and five years on by its variation."""
    first, *lines = (line.split() for line in path.read_text().splitlines())
    main: list[Decimal] = []
    variation: list[Decimal] = []
    for _, m, g, h, g_rate, h_rate in (line for line in lines if len(line) == 6):
        main += [Decimal(g)] if m == "0" else [Decimal(g), Decimal(h)]
        variation += [Decimal(g_rate)] if m == "0" else [Decimal(g_rate), Decimal(h_rate)]
    later = [value + 5 * rate for value, rate in zip(main, variation, strict=True)]
    year = Decimal(first[0])
    return [str(year), str(year + 5)], [list(map(str, main)), list(map(str, later))]


def short(number: str) -> str:
    """The same number without padding zeros."""
    value = Decimal(number).normalize()
    return "0" if value == 0 else f"{value:f}"


def wrapped(numbers: list[str]) -> str:
    """Numbers as lines of an initialiser list, without the zeros that end it."""
    texts = [short(number) for number in numbers]
    while texts[-1] == "0":
        texts.pop()
    return textwrap.fill(
        ", ".join(texts),
        98,
        initial_indent="  ",
        subsequent_indent="  ",
        break_on_hyphens=False,
    )


def header(model: str, source: str, years: list[str], rows: list[list[str]]) -> str:
    """Text of the C++ header of one model."""
    degree = round((len(rows[0]) + 1) ** 0.5) - 1
    return HEADER.format(
        model=model,
        source=source,
        degree=degree,
        years=wrapped(years),
        rows="\n".join(
            f"{{  // {short(y)}\n{wrapped(r)}}}," for y, r in zip(years, rows, strict=True)
        ),
    )


def headers() -> dict[str, str]:
    """File name and text of both headers."""
    igrf = read_igrf(package_file("ppigrf", "IGRF14.shc"))
    wmm = read_wmm(package_file("pygeomag", "wmm/WMM_2025.COF"))
    return {
        "igrf14_coefficients.h": header("igrf14", "IGRF14.shc of ppigrf 2.1.0", *igrf),
        "wmm2025_coefficients.h": header("wmm2025", "WMM_2025.COF of pygeomag 1.1.0", *wmm),
    }


if __name__ == "__main__":
    for name, text in headers().items():
        (HERE / name).write_text(text)
