# SPDX-License-Identifier: Apache-2.0
"""The command line: what it prints, what it writes, how it ends."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import numpy as np
import pytest

from lodestar import channels as table
from lodestar import recordings
from lodestar.cli.main import app

SHORT = 'base = "ordinary"\nduration_s = 90\n'
PROGRAM = [sys.executable, "-c", "from lodestar.cli.main import main; main()"]


@pytest.fixture(scope="module")
def run_folder(tmp_path_factory):
    """A flight of 90 s by the program itself, with the object it printed."""
    folder = tmp_path_factory.mktemp("cli")
    (folder / "short.toml").write_text(SHORT)
    command = [*PROGRAM, "fly", "short.toml", "--seed", "5", "--out", "run", "--json"]
    ended = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120)
    assert ended.returncode == 0, ended.stderr
    return folder / "run", json.loads(ended.stdout)


def one_line_error(err: str) -> str:
    line = err.strip()
    assert line.startswith("error: ")
    assert "\n" not in line
    return line


def rows_of(summary: dict) -> dict[tuple[str, str], float]:
    return {(row["estimator"], row["metric"]): row["value"] for row in summary["rows"]}


def commands() -> list[str]:
    return [command.name for command in app.registered_commands]


# What a person finds out by asking


@pytest.mark.parametrize("command", commands())
def test_every_command_has_help_with_an_example(lodestar, command):
    status, out, _ = lodestar(command, "--help")
    assert status == 0
    assert f"lodestar {command}" in out
    assert "Example" in out


def test_help_names_every_command_and_the_exit_codes(lodestar):
    status, out, _ = lodestar("--help")
    assert status == 0
    assert all(command in out for command in commands())
    assert "2 bad input" in out


def test_version(lodestar):
    status, out, _ = lodestar("--version")
    assert status == 0
    assert out.startswith("lodestar 0.")


def test_help_loads_nothing_heavy():
    script = (
        "import sys, lodestar.cli.main\n"
        "print(sorted({'numpy', 'lcm', 'scipy', 'matplotlib'} & set(sys.modules)))"
    )
    said = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert said.stdout.strip() == "[]"


# fly


def test_fly_prints_one_object_of_the_score(run_folder):
    _, summary = run_folder
    assert (summary["scenario"], summary["seed"]) == ("short", 5)
    assert summary["duration_s"] == pytest.approx(90.0)
    assert summary["realtime_factor"] > 0
    rows = rows_of(summary)
    assert rows["sahrs", "roll_rmse_deg"] < 2.0
    assert ("integrated", "position_rmse_m") in rows


def test_fly_leaves_log_configuration_score_report_and_plots(run_folder):
    folder, summary = run_folder
    assert json.loads((folder / "score.json").read_text()) == summary
    assert "epoch_year" in (folder / "config.toml").read_text()
    assert "<svg" in (report := (folder / "report.html").read_text()) or "<img" in report
    assert list((folder / "plots").glob("*.png"))
    flight = recordings.load(folder / "flight.lcm")
    assert len(flight["SAHRS"]["time_us"]) == 90 * 60 + 1
    assert "TRUTH" in flight


def test_fly_ends_with_a_table_and_the_report(lodestar, tmp_path):
    (tmp_path / "short.toml").write_text(SHORT.replace("90", "65"))
    status, out, _ = lodestar("fly", "short.toml")
    assert status == 0
    assert "heading" in out
    assert "out/short/report.html" in out


def test_fly_with_a_configuration_that_spoils_the_flight_ends_with_1(lodestar, tmp_path):
    (tmp_path / "short.toml").write_text(SHORT)
    (tmp_path / "wrong.toml").write_text("[initial]\nroll_deg = 60\n")
    status, _, _ = lodestar("fly", "short.toml", "--config", "wrong.toml")
    assert status == 1
    assert "roll_deg = 60" in (tmp_path / "out/short/config.toml").read_text()


def test_fly_with_jsbsim_flies_the_f16(lodestar, tmp_path):
    pytest.importorskip("jsbsim", reason="the extra lodestar[jsbsim] is not installed")
    (tmp_path / "short.toml").write_text(SHORT.replace("90", "65"))
    status, out, _ = lodestar("fly", "short.toml", "--engine", "jsbsim", "--json")
    assert status == 0
    assert rows_of(json.loads(out))["sahrs", "roll_rmse_deg"] < 2.0
    # An aircraft that settles rolls a little even on a straight leg; the route itself does not.
    roll = np.degrees(recordings.load(tmp_path / "out/short/flight.lcm")["TRUTH"]["roll"])
    assert 0 < np.abs(roll[:60]).max() < 1


def test_fly_without_the_package_of_jsbsim_says_what_to_install(lodestar, monkeypatch):
    monkeypatch.setitem(sys.modules, "jsbsim", None)
    status, _, err = lodestar("fly", "ordinary", "--engine", "jsbsim")
    assert status == 2
    assert "pip install 'lodestar[jsbsim]'" in one_line_error(err)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["fly", "nowhere"], "scenario nowhere: unknown"),
        (["fly", "nothing.toml"], "nothing.toml"),
        (["fly", "bad.toml"], r"bad.toml:2"),
        (["fly", "short.toml", "--config", "bad.toml"], "bad.toml:1"),
        (["fly", "short.toml", "--config", "nothing.toml"], "nothing.toml"),
        (["fly", "short.toml", "--engine", "warp"], "engine warp: unknown"),
        (["fly", "short.toml", "--bus", "tcpq://host"], "udpm://GROUP:PORT"),
        (["fly", "short.toml", "--out", "short.toml"], "short.toml"),
        (["replay", "nothing.lcm"], "nothing.lcm"),
        (["replay", "bad.toml"], "bad.toml: neither an LCM log nor an npz file"),
        (["score", "nothing"], "nothing: no such folder"),
        (["score", "."], "flight.lcm"),
        (["convert", "nothing.lcm", "b.npz"], "nothing.lcm"),
        (["import", "nothing.csv", "--map", "umn_thor75.toml", "-o", "b.lcm"], "nothing.csv"),
        (["import", "bad.toml", "--map", "nothing.toml", "-o", "b.lcm"], "nothing.toml"),
        (["spy", "--bus", "udpm://1.2.3.4:5"], "no multicast group"),
        (["watch", "--bus", "nonsense"], "udpm://GROUP:PORT"),
    ],
)
def test_bad_input_is_one_line_that_names_it_and_ends_with_2(lodestar, tmp_path, arguments, said):
    (tmp_path / "short.toml").write_text(SHORT)
    (tmp_path / "bad.toml").write_text('base = "ordinary"\nno_such_key = 1\n')
    status, out, err = lodestar(*arguments)
    assert status == 2
    assert said in one_line_error(err)
    assert out == ""


@pytest.mark.parametrize("arguments", [["fly", "--no-such-option"], ["land"], ["convert", "a"]])
def test_wrong_usage_ends_with_2(lodestar, arguments):
    status, _, err = lodestar(*arguments)
    assert status == 2
    assert "Usage" in err


def test_without_the_flight_computer_one_line_says_so(lodestar, tmp_path, monkeypatch):
    (tmp_path / "short.toml").write_text(SHORT)
    monkeypatch.setenv("LODESTAR_FC", str(tmp_path / "gone"))
    status, _, err = lodestar("fly", "short.toml")
    assert status == 2
    assert "lodestar-fc: not found at" in one_line_error(err)


def test_ctrl_c_keeps_what_was_recorded_and_says_so(tmp_path):
    command = [*PROGRAM, "fly", "ordinary", "--realtime"]
    process = subprocess.Popen(
        command,
        cwd=tmp_path,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        # A shell's background job has SIGINT ignored, and its children inherit that.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    log = tmp_path / "out/ordinary/flight.lcm"
    while not log.exists() or log.stat().st_size < 100_000:
        assert process.poll() is None
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGINT)
    _, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert "out/ordinary/flight.lcm keeps what was recorded" in one_line_error(err)
    kept = recordings.load(log)
    assert len(kept["SAHRS"]["time_us"]) > 60


# replay and score


def test_a_replay_of_a_run_scores_as_the_run_did(run_folder, lodestar):
    folder, summary = run_folder
    status, out, _ = lodestar("replay", folder / "flight.lcm", "--out", "again", "--json")
    assert status == 0
    assert rows_of(json.loads(out)) == rows_of(summary)


def test_a_replay_can_be_scored_over_a_part(run_folder, lodestar):
    folder, summary = run_folder
    status, out, _ = lodestar(
        "replay", folder / "flight.lcm", "--from", "30", "--to", "50", "--out", "part", "--json"
    )
    assert status == 0
    part = json.loads(out)
    assert part["duration_s"] == pytest.approx(20.0, abs=0.1)
    assert rows_of(part)["sahrs", "roll_rmse_deg"] != rows_of(summary)["sahrs", "roll_rmse_deg"]


def test_a_part_outside_the_flight_is_refused(run_folder, lodestar):
    status, _, err = lodestar("replay", run_folder[0] / "flight.lcm", "--from", "5000")
    assert status == 2
    assert "from 0.0 to 90.0 s" in one_line_error(err)


def test_a_recording_without_reference_is_replayed_and_not_scored(run_folder, lodestar, tmp_path):
    flight = recordings.load(run_folder[0] / "flight.lcm")
    bare = flight.subset(("EFCS.RATES", "EFCS.LOAD_FACTOR", "SMDU", "ADC"))
    recordings.save(bare, tmp_path / "bare.npz")
    status, _, err = lodestar("replay", "bare.npz")
    assert status == 0
    assert "no score" in err
    answers = recordings.load(tmp_path / "out/bare-replay/flight.lcm")
    assert len(answers["SAHRS"]["time_us"]) == 90 * 60 + 1


def test_score_gives_the_run_the_same_score_again(run_folder, lodestar):
    folder, summary = run_folder
    status, out, _ = lodestar("score", folder, "--json")
    assert status == 0
    assert json.loads(out) == summary


# convert and import


def test_convert_goes_both_ways_without_losing_a_bit(run_folder, lodestar, tmp_path):
    log = run_folder[0] / "flight.lcm"
    assert lodestar("convert", log, "flight.npz")[0] == 0
    status, out, _ = lodestar("convert", "flight.npz", "back.lcm")
    assert status == 0
    assert "back.lcm" in out
    assert recordings.load(tmp_path / "back.lcm") == recordings.load(log)


def test_import_makes_a_recording_and_says_what_was_dropped(lodestar, tmp_path):
    (tmp_path / "data.csv").write_text("t,p,q,r\n0,1,2,3\n0.1,1,2,3\n0.05,1,2,3\n0.2,1,nan,3\n")
    (tmp_path / "map.toml").write_text(
        "[time]\n"
        'column = "t"\n'
        'unit = "s"\n'
        '[channels."EFCS.RATES"]\n'
        'omega_B = { columns = ["p", "q", "r"], unit = "deg/s", axes = "FRD" }\n'
        "valid = { constant = true }\n"
    )
    status, out, err = lodestar("import", "data.csv", "--map", "map.toml", "-o", "out.npz")
    assert status == 0, err
    assert "2 messages" in out
    assert "dropped" in out
    rates = recordings.load(tmp_path / "out.npz")["EFCS.RATES"]
    np.testing.assert_allclose(rates["omega_B"][0], np.radians([1.0, 2.0, 3.0]), rtol=1e-15)


# doctor and spy


def test_doctor_checks_this_machine(lodestar):
    status, out, _ = lodestar("doctor", "--json")
    findings = json.loads(out)
    assert {"lodestar-fc", "LCM", "isolated bus", "receive buffer", "Java"} <= findings.keys()
    needed = [one for one in findings.values() if one["needed"] and one["mend"]]
    assert status == (1 if needed else 0)


def test_doctor_says_how_to_mend_what_is_missing(lodestar, monkeypatch, tmp_path):
    monkeypatch.setenv("LODESTAR_FC", str(tmp_path / "gone"))
    status, out, _ = lodestar("doctor")
    assert status == 1
    assert "NO  lodestar-fc" in out
    assert "mend: " in out


def test_spy_without_a_display_says_so(lodestar, monkeypatch, tmp_path):
    monkeypatch.setattr("lodestar.cli.spy.types_jar", lambda: tmp_path / "types.jar")
    monkeypatch.setattr("lodestar.cli.spy.require_multicast", lambda url: None)
    monkeypatch.delenv("DISPLAY", raising=False)
    status, _, err = lodestar("spy")
    assert status == 2
    assert "no display" in one_line_error(err)


@pytest.mark.skipif(shutil.which("javac") is None, reason="no Java compiler here")
def test_spy_builds_its_jar_of_all_types_once(lodestar, monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    status, out, err = lodestar("spy", "--build-only")
    assert status == 0, err
    jar = Path(out.strip())
    classes = zipfile.ZipFile(jar).namelist()
    for message in table.CHANNELS.values():
        assert f"lodestar/{message.__name__}.class" in classes
    built = jar.stat().st_mtime_ns
    assert lodestar("spy", "--build-only")[1] == out
    assert jar.stat().st_mtime_ns == built


def test_spy_without_java_says_what_to_install(lodestar, monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("PATH", str(tmp_path))
    status, _, err = lodestar("spy", "--build-only")
    assert status == 2
    assert "apt install default-jdk" in one_line_error(err)


def test_calibrate_tells_what_it_found_and_stores_only_what_is_good(lodestar, run_folder, tmp_path):
    log = run_folder[0] / "flight.lcm"
    status, out, err = lodestar("calibrate", log, "-o", "smdu.cal")
    assert status == 1
    assert one_line_error(err).endswith("flight.lcm: too short; nothing is stored")
    assert "verdict: too short" in out
    assert "bias x" in out
    assert not (tmp_path / "smdu.cal").exists()
    (tmp_path / "lenient.toml").write_text(
        "[earth]\nepoch_year = 2026.5\n"
        "[smdu_calibration_filter]\nmin_duration_s = 60\nmin_observability = 0\n"
    )
    status, out, err = lodestar(
        "calibrate", log, "--config", "lenient.toml", "-o", "smdu.cal", "--from", "10"
    )
    assert (status, err) == (0, "")
    assert "verdict: good" in out
    assert (tmp_path / "smdu.cal").stat().st_size == 788
    status, _, err = lodestar("calibrate", log, "--ground", "--config", "lenient.toml")
    assert status == 1
    assert "too few headings" in one_line_error(err)
