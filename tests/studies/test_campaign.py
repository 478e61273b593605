# SPDX-License-Identifier: Apache-2.0
"""Campaigns go on where they were stopped, and end with the same bits however they were flown."""

import contextlib
import os
import signal
import subprocess
import sys
import time
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from lodestar.errors import InputError
from lodestar.studies.campaign import Cell, Result, origin, run
from lodestar.studies.pool import LocalPool
from lodestar.studies.sahrs import sahrs_study
from lodestar.studies.store import ParquetStore

SHORT = 'base = "ordinary"\nduration_s = 20\n'
CELLS = tuple(Cell(flight, f"{flight}/{v}", "e") for flight in ("a", "b") for v in "xyz")


@dataclass
class Counting:
    """A study whose results are drawn from cell and seed; remembers what was flown."""

    cells: tuple[Cell, ...] = CELLS
    name: str = "counting"
    text: str = "scenario"
    flown: list[tuple[str, int]] = field(default_factory=list)

    def fly(self, cells, seed):
        self.flown.append((cells[0].flight, seed))
        return [self.result(cell, seed) for cell in cells]

    def result(self, cell, seed):
        rng = np.random.default_rng([seed, *cell.case.encode()])
        figures = {"one": float(rng.normal()), "two": float("nan")}
        return Result(cell, seed, figures, {"s": rng.normal(size=7).astype(np.float32)})

    def inputs(self, flight):
        return self.text + flight


class InThisProcess:
    def work(self, function, tasks):
        return map(function, tasks)


class StopsAfter:
    def __init__(self, flights):
        self.flights = flights

    def work(self, function, tasks):
        for number, task in enumerate(tasks):
            if number == self.flights:
                raise KeyboardInterrupt
            yield function(task)


def same(one, other):
    assert [(r.cell, r.seed) for r in one] == [(r.cell, r.seed) for r in other]
    for a, b in zip(one, other, strict=True):
        assert (
            np.array(list(a.figures.values())).tobytes()
            == np.array(list(b.figures.values())).tobytes()
        )
        assert a.figures.keys() == b.figures.keys()
        assert a.series.keys() == b.series.keys()
        for name in a.series:
            assert a.series[name].dtype == np.float32
            assert a.series[name].tobytes() == b.series[name].tobytes()


# What is flown


def test_the_store_gives_back_what_was_flown_bit_for_bit(tmp_path):
    study = Counting()
    run(study, range(3, 6), ParquetStore(tmp_path), InThisProcess())
    kept = ParquetStore(tmp_path).results(study.cells, range(3, 6))
    same(kept, [study.result(cell, seed) for cell in study.cells for seed in range(3, 6)])


def test_one_flight_serves_all_its_cells_and_comes_before_the_next(tmp_path):
    study = Counting()
    run(study, range(2), ParquetStore(tmp_path), InThisProcess())
    assert study.flown == [("a", 0), ("a", 1), ("b", 0), ("b", 1)]


def test_a_stopped_campaign_flies_only_what_is_missing(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        run(Counting(), range(3), ParquetStore(tmp_path), StopsAfter(4))
    study = Counting()
    told = []
    run(study, range(3), ParquetStore(tmp_path), InThisProcess(), lambda *done: told.append(done))
    assert study.flown == [("b", 1), ("b", 2)]
    assert told == [(4, 6), (5, 6), (6, 6)]
    again = Counting()
    run(again, range(3), ParquetStore(tmp_path), InThisProcess())
    assert again.flown == []


def test_more_runs_and_more_cells_add_to_what_there_is(tmp_path):
    run(Counting(CELLS[:2]), range(2), ParquetStore(tmp_path), InThisProcess())
    study = Counting(CELLS[:3])
    run(study, range(3), ParquetStore(tmp_path), InThisProcess())
    assert study.flown == [("a", 0), ("a", 1), ("a", 2)]
    kept = ParquetStore(tmp_path).results(CELLS[:3], range(3))
    same(kept, [study.result(cell, seed) for cell in CELLS[:3] for seed in range(3)])


def test_a_cell_that_wants_few_flights_gets_the_first_of_them(tmp_path):
    few = replace(CELLS[1], most_runs=2)
    study = Counting((CELLS[0], few))
    run(study, range(5, 9), ParquetStore(tmp_path), InThisProcess())
    kept = ParquetStore(tmp_path).results(study.cells, range(5, 9))
    assert [r.seed for r in kept if r.cell == few] == [5, 6]
    assert [r.seed for r in kept if r.cell == CELLS[0]] == [5, 6, 7, 8]
    again = Counting((CELLS[0], few))
    told = []
    run(
        again, range(5, 9), ParquetStore(tmp_path), InThisProcess(), lambda *done: told.append(done)
    )
    assert (again.flown, told) == ([], [(4, 4)])


def test_results_of_another_scenario_are_not_mixed_in(tmp_path):
    run(Counting(), range(1), ParquetStore(tmp_path), InThisProcess())
    with pytest.raises(InputError, match="a/x was flown with another build or scenario"):
        run(Counting(text="other"), range(1), ParquetStore(tmp_path), InThisProcess())


def test_the_origin_tells_scenarios_routes_and_engines_apart():
    pytest.importorskip("jsbsim", reason="the extra lodestar[jsbsim] is not installed")
    study = sahrs_study(["ordinary"], [], [], set())
    assert origin(study, "ordinary/profile") != origin(study, "ordinary/jsbsim")
    longer = replace(study.scenarios[0], duration_s=2000)
    changed = replace(study, scenarios=(longer,))
    assert origin(changed, "ordinary/profile") != origin(study, "ordinary/profile")
    fewer = sahrs_study(["ordinary"], ["profile"], ["paper"], {True})
    assert origin(fewer, "ordinary/profile") == origin(study, "ordinary/profile")


# What a crash leaves


def test_a_file_that_was_being_written_is_no_result(tmp_path, monkeypatch):
    def stopped(*_):
        raise KeyboardInterrupt

    study, store = Counting(), ParquetStore(tmp_path)
    flown = study.fly(CELLS[:3], 1)
    monkeypatch.setattr("pathlib.Path.replace", stopped)
    with pytest.raises(KeyboardInterrupt):
        store.add(flown, "origin")
    monkeypatch.undo()
    assert len(list(store.folder.glob(".*.part"))) == 1
    assert ParquetStore(tmp_path).results(CELLS, range(5)) == []
    with ParquetStore(tmp_path).writing():
        assert list(store.folder.glob(".*.part")) == []


def test_a_damaged_file_is_named_with_the_remedy(tmp_path):
    run(Counting(), range(1), ParquetStore(tmp_path), InThisProcess())
    path = sorted((tmp_path / "flights").glob("*.parquet"))[0]
    path.write_bytes(path.read_bytes()[:-20])
    with pytest.raises(InputError, match=rf"{path.name}: .*; delete it to fly it again"):
        ParquetStore(tmp_path).results(CELLS, range(1))


def test_two_campaigns_do_not_write_into_one_folder(tmp_path):
    with (
        ParquetStore(tmp_path).writing(),
        pytest.raises(InputError, match="another campaign"),
        ParquetStore(tmp_path).writing(),
    ):
        pass


def test_any_reader_of_parquet_reads_the_folder(tmp_path):
    import pyarrow.parquet as pq

    store = ParquetStore(tmp_path)
    with store.writing():
        run(Counting(), range(2), store, InThisProcess())
    table = pq.read_table(store.folder)
    assert table.num_rows == 2 * len(CELLS)
    assert {"case", "estimator", "seed", "one"} <= set(table.column_names)


# The pool of processes


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    path = tmp_path_factory.mktemp("study") / "short.toml"
    path.write_text(SHORT)
    return sahrs_study([str(path)], ["profile"], [], {False})


@pytest.fixture(scope="module")
def alone(study, tmp_path_factory):
    """Four flights in one process."""
    folder = tmp_path_factory.mktemp("alone")
    run(study, range(1, 5), ParquetStore(folder), LocalPool(1))
    return ParquetStore(folder).results(study.cells, range(1, 5))


def test_results_do_not_depend_on_the_number_of_processes(study, alone, tmp_path):
    run(study, range(1, 5), ParquetStore(tmp_path), LocalPool(2))
    same(ParquetStore(tmp_path).results(study.cells, range(1, 5)), alone)


def test_results_do_not_depend_on_what_flew_before(study, alone, tmp_path):
    one = study.fly(study.cells[1:], 4)
    same(one, [r for r in alone if r.seed == 4 and r.cell == study.cells[1]])


def test_an_error_in_a_process_is_raised_here_and_leaves_none_behind(tmp_path):
    (tmp_path / "long.toml").write_text(SHORT.replace("20", "30000"))
    impossible = sahrs_study([str(tmp_path / "long.toml")], ["profile"], [], set())
    before = children_of(os.getpid())
    with pytest.raises(InputError, match=r"long/profile, seed \d: .*asks for 30000 s"):
        run(impossible, range(4), ParquetStore(tmp_path), LocalPool(2))
    assert children_of(os.getpid()) == before


def test_a_campaign_that_is_killed_goes_on_and_ends_with_the_same_bits(study, alone, tmp_path):
    (tmp_path / "short.toml").write_text(SHORT)
    arguments = ["--runs", "4", "--engine", "profile", "--uncalibrated", "--workers", "2"]
    for enough in (1, 2):
        process = start(tmp_path, *arguments, "--out", ".", stderr=subprocess.DEVNULL)
        workers = workers_when_flown(process, tmp_path, enough)
        process.kill()
        process.wait()
        wait_until_gone(workers)  # each ends when it sees that its parent has
        ParquetStore(tmp_path).results(study.cells, range(1, 5))  # whatever there is can be read
    run(study, range(1, 5), ParquetStore(tmp_path), LocalPool(1))
    same(ParquetStore(tmp_path).results(study.cells, range(1, 5)), alone)


def test_ctrl_c_says_what_is_kept_and_leaves_no_process(tmp_path):
    (tmp_path / "short.toml").write_text(SHORT)
    arguments = ["--engine", "profile", "--workers", "1", "--out", "out"]
    process = start(tmp_path, *arguments, stderr=subprocess.PIPE)
    workers = workers_when_flown(process, tmp_path / "out", 1)
    os.killpg(process.pid, signal.SIGINT)
    _, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert "out/flights keeps what was flown" in err
    assert "Traceback" not in err
    wait_until_gone(workers)


def start(folder, *arguments, stderr):
    """The program, on the scenario in the folder, in a process group of its own."""
    return subprocess.Popen(
        [
            *(sys.executable, "-c", "from lodestar.cli.main import main; main()"),
            *("monte-carlo", "sahrs", "--scenario", "short.toml", *arguments),
        ],
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=stderr,
        text=True,
        start_new_session=True,
        # A shell's background job has SIGINT ignored, and its children inherit that.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )


def workers_when_flown(process, folder, enough):
    """The children of a campaign once it has flown so many flights, or has ended."""
    flown = folder / "flights"
    wait_until(lambda: process.poll() is not None or len(list(flown.glob("*.parquet"))) >= enough)
    return children_of(process.pid)


def wait_until_gone(processes):
    wait_until(lambda: not any(map(is_alive, processes)))


def wait_until(condition, limit_s=60.0):
    deadline = time.monotonic() + limit_s
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def children_of(pid):
    said = subprocess.run(["ps", "-o", "pid=,comm=", "--ppid", str(pid)], capture_output=True)
    rows = [line.split(None, 1) for line in said.stdout.decode().splitlines()]
    return {int(number) for number, name in rows if name != "ps"}


def is_alive(pid):
    with contextlib.suppress(OSError):
        os.kill(pid, 0)
        return True
    return False
