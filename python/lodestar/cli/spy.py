# SPDX-License-Identifier: Apache-2.0
"""Command ``lodestar spy``."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import Annotated

import typer

import lodestar
from lodestar.cli.common import BusOption, bus_url
from lodestar.errors import InputError
from lodestar.harness.isolation import require_multicast

EXAMPLE = "Example: lodestar spy, and lodestar fly --realtime --bus default in another terminal"


def command(
    bus: BusOption = "default",
    build_only: Annotated[
        bool, typer.Option("--build-only", help="Build the jar of message types, say its path.")
    ] = False,
) -> None:
    """Start lcm-spy with the message types of Lodestar (the jar is built on the first run)."""
    jar = types_jar()
    if build_only:
        typer.echo(jar)
        return
    url = bus_url(bus)
    require_multicast(url)
    if not os.environ.get("DISPLAY"):
        raise InputError("spy: no display ($DISPLAY is not set); lodestar watch needs none")
    environment = {**os.environ, "CLASSPATH": str(jar)}
    raise typer.Exit(subprocess.call([_lcm_tool("lcm-spy"), f"--lcm-url={url}"], env=environment))


def types_jar() -> Path:
    """The jar with the Java classes of all message types, built if these types have none yet.

    Raises InputError where there is no Java.
    """
    types = _lcm_types()
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in types)).hexdigest()[:16]
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "lodestar"
    jar = cache / f"messages-{digest}.jar"
    if not jar.exists():
        cache.mkdir(parents=True, exist_ok=True)
        _build(types, jar)
    return jar


def _build(types: list[Path], jar: Path) -> None:
    if not (shutil.which("java") and shutil.which("javac") and shutil.which("jar")):
        raise InputError("spy: no Java compiler; mend with: sudo apt install default-jdk")
    with tempfile.TemporaryDirectory(dir=jar.parent) as folder:
        source, classes, built = Path(folder, "src"), Path(folder, "classes"), Path(folder, "jar")
        _run([_lcm_tool("lcm-gen"), "--java", "--jpath", str(source), *map(str, types)])
        files = [str(path) for path in sorted(source.rglob("*.java"))]
        _run(["javac", "-cp", str(_lcm_jar()), "-d", str(classes), *files])
        _run(["jar", "cf", str(built), "-C", str(classes), "."])
        built.replace(jar)


def _run(command: list[str]) -> None:
    ended = subprocess.run(command, capture_output=True, text=True)
    if ended.returncode != 0:
        words = (ended.stderr.strip() or "it said nothing").splitlines()[0]
        raise InputError(f"spy: {Path(command[0]).name} failed: {words}")


def _lcm_types() -> list[Path]:
    """The .lcm files of the installed package, or of the checkout it runs from."""
    package = Path(lodestar.__file__).resolve().parent
    for folder in (package / "lcm_types", package.parents[1] / "lcm_types"):
        if found := sorted(folder.glob("*.lcm")):
            return found
    raise InputError(f"spy: the .lcm files are missing from {package}")


def _lcm_home() -> Path:
    import lcm

    return Path(lcm.__file__).resolve().parents[1]


def _lcm_tool(name: str) -> str:
    return str(_lcm_home() / "bin" / name)


def _lcm_jar() -> Path:
    return _lcm_home() / "share" / "java" / "lcm.jar"
