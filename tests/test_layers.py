# SPDX-License-Identifier: Apache-2.0
"""Arrows go down only: no file includes or imports from its own layer's peers or from above."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]

CPP_LAYERS = [
    {"math", "samples"},
    {"earth", "filter"},
    {"strapdown"},
    {"sahrs", "fusion", "ahrs", "ins_gps_sar", "monitor"},
    {"navigator", "storage"},
    {"bus", "bindings"},
    {"app"},
]
PYTHON_LAYERS = [
    {"errors", "rotation", "messages", "_core", "__version__"},
    {"channels", "paths", "strict_toml"},
    {"recordings"},
    {"navigator", "simulation", "evaluation"},
    {"harness"},
    {"studies"},
    {"cli"},
]
MAY_INCLUDE_LCM = {"bus", "app"}


def level(layers: list[set[str]], folder: str) -> int:
    for number, names in enumerate(layers):
        if folder in names:
            return number
    raise AssertionError(f"{folder} belongs to no layer of the architecture")


def cpp_files() -> list[tuple[str, Path]]:
    core = [
        (path.relative_to(ROOT / "cpp/lodestar").parts[0], path)
        for path in (ROOT / "cpp/lodestar").rglob("*.[hc]*")
        if path.suffix in {".h", ".cpp"}
    ]
    return core + [("bindings", path) for path in (ROOT / "cpp/bindings").glob("*.[hc]*")]


def includes(path: Path) -> list[str]:
    return re.findall(r'^\s*#\s*include\s*[<"]([^">]+)[">]', path.read_text(), re.MULTILINE)


def python_files() -> list[tuple[str, Path]]:
    package = ROOT / "python/lodestar"
    files = []
    for path in package.rglob("*.py"):
        part = path.relative_to(package).parts[0]
        files.append((part.removesuffix(".py"), path))
    return [(part, path) for part, path in files if part != "__init__"]


def imported_parts(path: Path) -> set[str]:
    """Parts of the package that a file imports, wherever in the file it does so."""
    parts = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names = [node.module or ""]
            if node.module == "lodestar":
                names = [f"lodestar.{alias.name}" for alias in node.names]
        else:
            continue
        parts |= {name.split(".")[1] for name in names if name.startswith("lodestar.")}
    return parts


@pytest.mark.parametrize(("folder", "path"), cpp_files(), ids=lambda value: str(value)[-60:])
def test_a_cpp_file_includes_only_its_folder_and_lower_layers(folder: str, path: Path) -> None:
    own = level(CPP_LAYERS, folder)
    for include in includes(path):
        parts = include.split("/")
        if parts[0] != "lodestar" or len(parts) < 3:  # lodestar/x_t.hpp are the generated messages
            continue
        allowed = parts[1] == folder or level(CPP_LAYERS, parts[1]) < own
        assert allowed, f"{path.relative_to(ROOT)} includes {include}: that arrow goes up"


@pytest.mark.parametrize(("folder", "path"), cpp_files(), ids=lambda value: str(value)[-60:])
def test_lcm_and_pybind_stay_out_of_the_core(folder: str, path: Path) -> None:
    for include in includes(path):
        if include.startswith("lcm/") or include.endswith("_t.hpp"):
            assert folder in MAY_INCLUDE_LCM, f"{path.relative_to(ROOT)} includes {include}"
        if include.startswith("pybind11/"):
            assert folder == "bindings", f"{path.relative_to(ROOT)} includes {include}"


@pytest.mark.parametrize(("part", "path"), python_files(), ids=lambda value: str(value)[-60:])
def test_a_python_file_imports_only_its_part_and_lower_layers(part: str, path: Path) -> None:
    own = level(PYTHON_LAYERS, part)
    for imported in imported_parts(path):
        allowed = imported == part or level(PYTHON_LAYERS, imported) < own
        assert allowed, f"{path.relative_to(ROOT)} imports lodestar.{imported}: that arrow goes up"


def test_every_source_file_has_its_licence_line() -> None:
    folders = ["cpp", "python", "tests", "config", "lcm_types", "examples", ".ci"]
    suffixes = {".h", ".cpp", ".py", ".pyi", ".toml", ".lcm", ".cmake", ".txt", ".sh", ".profile"}
    files = [ROOT / name for name in ("CMakeLists.txt", "Makefile", "pyproject.toml")]
    for folder in folders:
        files += [path for path in (ROOT / folder).rglob("*") if path.suffix in suffixes]
    assert len(files) > 50
    missing = [
        str(path.relative_to(ROOT))
        for path in files
        if "SPDX-License-Identifier: Apache-2.0" not in path.read_text()[:300]
    ]
    assert not missing
