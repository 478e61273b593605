# SPDX-License-Identifier: Apache-2.0
"""Where the shipped configuration lies: in a checkout, or inside the installed package."""

from __future__ import annotations

from pathlib import Path

from lodestar.errors import InputError

_PACKAGE = Path(__file__).resolve().parent
_FOLDERS = ("", "scenarios", "routes", "maps")


def config_root() -> Path:
    """The folder ``config`` of the installed package, or of the checkout the package runs from.

    Raises InputError where neither is there.
    """
    for root in (_PACKAGE / "config", _PACKAGE.parents[1] / "config"):
        if root.is_dir():
            return root
    raise InputError(f"the shipped configuration is missing: no folder config in {_PACKAGE}")


def config_path(name: str) -> Path:
    """The shipped file ``name``, from config/ or its folders scenarios, routes and maps.

    ``name`` is a file name ("gripen.toml") or starts with the folder ("scenarios/hard.toml").
    Raises InputError when there is none.
    """
    root = config_root()
    for folder in _FOLDERS:
        path = root / folder / name
        if path.is_file():
            return path
    raise InputError(f"{name}: no such file in {root} or its folders {', '.join(_FOLDERS[1:])}")


def shipped(folder: str, suffix: str) -> list[str]:
    """Names, without ``suffix``, of the shipped files of one folder, sorted."""
    return sorted(path.stem for path in (config_root() / folder).glob(f"*{suffix}"))
