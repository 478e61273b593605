# SPDX-License-Identifier: Apache-2.0
"""Speed and size of this build on this machine: ``make bench`` writes out/bench.json.

The frames are those of a recorded flight of ``ordinary``, so every branch is taken as often as in
flight. Nothing here is asserted by a test.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from lodestar.harness.bus import Bus
from lodestar.harness.flight_computer import FlightComputer, find_executable
from lodestar.harness.fly import events, fly_over_bus
from lodestar.harness.isolation import isolated_bus
from lodestar.harness.scenario import load_scenario, simulate
from lodestar.recordings import Recording
from lodestar.recordings.log import write_log

Row = dict[str, Any]

PROGRAMS = Path("build/python/bench")
REPETITIONS = 9
ROUND_TRIPS = 3000
LIMITS = {
    "sahrs_step_median_us": 4.0,
    "sahrs_paper_step_median_us": 1.0,
    "geomagnetic_evaluation_median_us": 2.0,
    "integrated_step_median_us": 10.0,
    "navigator_cascade_frame_median_us": 4.0,
    "replay_3000s_s": 2.0,
    "fly_3000s_s": 60.0,
    "memory_mb": 64.0,
}
ESTIMATORS = {
    "sahrs_paper_step_median_us": "sahrs-paper",
    "sahrs_step_median_us": "sahrs",
    "cascade_step_median_us": "cascade",
    "navigator_cascade_frame_median_us": "cascade",
}
"""Whose figure it is; the others are of the whole, with the integrated filter."""


def main() -> None:
    """Measure everything, print a line each, write the JSON."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/bench.json"))
    out = parser.parse_args().out
    out.parent.mkdir(parents=True, exist_ok=True)
    flight = simulate(load_scenario("ordinary"), 1)
    log = out.with_name("bench.lcm")
    write_log(flight, log)
    rows: list[Row] = []
    for measure in (frame_rows, replay_rows, bus_rows):
        for row in measure(flight, log):
            rows.append(row)
            limit = f"  (limit {row['limit']:g})" if "limit" in row else ""
            print(f"{row['metric']:32s} {row['value']:10.3f}{limit}", flush=True)
    report = {"machine": machine(), "compiler": compiler(), "rows": rows}
    out.write_text(json.dumps(report, indent=2) + "\n")
    print(f"{out}")


def frame_rows(_: Recording, log: Path) -> Iterator[Row]:
    """Time of one 60 Hz frame, of the whole and of each estimator alone, and of a field evaluation.

    The median over repetitions of the mean over a flight's frames.
    """
    command = [
        str(PROGRAMS / "bench_frames"),
        "--benchmark_format=json",
        f"--benchmark_repetitions={REPETITIONS}",
        "--benchmark_report_aggregates_only=true",
    ]
    environment = {**os.environ, "LODESTAR_BENCH_LOG": str(log)}
    said = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    for result in json.loads(said.stdout)["benchmarks"]:
        if result["aggregate_name"] == "median":
            yield _row(f"{result['run_name']}_median_us", result["cpu_time"])


def replay_rows(_: Recording, log: Path) -> Iterator[Row]:
    """The fastest of three replays of the flight, and the most memory that the process held."""
    seconds = []
    memory_mb = 0.0
    answers = log.with_name("bench-answers.lcm")
    command = [str(find_executable()), "--replay", str(log), "--output", str(answers)]
    for _attempt in range(3):
        begin = time.perf_counter()
        process = subprocess.Popen(command, stderr=subprocess.DEVNULL)
        while process.poll() is None:
            memory_mb = max(memory_mb, _peak_memory_mb(process.pid))
            time.sleep(0.01)
        seconds.append(time.perf_counter() - begin)
        if process.returncode != 0:
            sys.exit(f"error: lodestar-fc --replay ended with status {process.returncode}")
    yield _row("replay_3000s_s", min(seconds))
    yield _row("memory_mb", memory_mb)


def _peak_memory_mb(pid: int) -> float:
    """Peak resident memory since its exec; what rusage gives includes the parent's before that."""
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmHWM:") and "lodestar-fc" in Path(f"/proc/{pid}/comm").read_text():
            return int(line.split()[1]) / 1024
    return 0.0


def bus_rows(flight: Recording, log: Path) -> Iterator[Row]:
    """A whole flight in lockstep over LCM, and the latency beside that of a bare echo."""
    with isolated_bus() as url:
        begin = time.perf_counter()
        fly_over_bus(flight, url, log.with_name("bench-flown.lcm"))
        yield _row("fly_3000s_s", time.perf_counter() - begin)
    rates = [event.payload for event in events(flight.subset(("EFCS.RATES",)))][:ROUND_TRIPS]
    with isolated_bus() as url, Bus(url) as bus, FlightComputer(bus):
        computer = _round_trip(bus, rates)
    with isolated_bus() as url, Bus(url) as bus, _echo(url):
        echo = _round_trip(bus, rates)
    yield _row("latency_median_us", computer * 1e6)
    yield _row("latency_ratio_to_echo", computer / echo)


def _round_trip(bus: Bus, payloads: list[bytes]) -> float:
    """Median seconds from sending EFCS.RATES to having SAHRS."""
    heard: list[str] = []
    bus.tap(lambda channel, _: heard.append(channel))
    deadline = time.monotonic() + 5.0
    while not heard and time.monotonic() < deadline:  # until the other side has joined
        bus.publish("EFCS.RATES", payloads[0])
        bus.receive(0.1)
    seconds = []
    for payload in payloads[1:]:
        heard.clear()
        begin = time.perf_counter()
        bus.publish("EFCS.RATES", payload)
        while "SAHRS" not in heard:
            if not bus.receive(1.0):
                raise TimeoutError("SAHRS: no answer within 1 s")
        seconds.append(time.perf_counter() - begin)
    return statistics.median(seconds)


@contextmanager
def _echo(url: str) -> Iterator[None]:
    process = subprocess.Popen([str(PROGRAMS / "bench_echo"), url])
    try:
        yield
    finally:
        process.terminate()
        process.wait()


def _row(metric: str, value: float) -> Row:
    estimator = ESTIMATORS.get(metric, "integrated")
    row: Row = {"case": "ordinary", "estimator": estimator, "metric": metric, "value": value}
    if metric in LIMITS:
        row["limit"] = LIMITS[metric]
    return row


def machine() -> str:
    """Processor and number of cores."""
    names = [
        line.split(":", 1)[1].strip()
        for line in Path("/proc/cpuinfo").read_text().splitlines()
        if line.startswith("model name")
    ]
    return f"{names[0] if names else platform.machine()}, {os.cpu_count()} cores"


def compiler() -> str:
    """First line of the C++ compiler's own version."""
    said = subprocess.run(["c++", "--version"], capture_output=True, text=True, check=True)
    return said.stdout.splitlines()[0]


if __name__ == "__main__":
    main()
