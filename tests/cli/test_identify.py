# SPDX-License-Identifier: Apache-2.0
"""lodestar identify: what it prints and writes, and how it ends."""

import json
from dataclasses import replace

import pytest

from lodestar import recordings
from lodestar.harness.scenario import estimator_config, load_scenario, simulate
from lodestar.navigator import run


@pytest.fixture(scope="module")
def flights(tmp_path_factory):
    """Two flights of 150 s with the answers of SAHRS, and one of 50 s."""
    folder = tmp_path_factory.mktemp("flights")
    for seed, duration_s in ((1, 150.0), (2, 150.0), (3, 50.0)):
        scenario = replace(load_scenario("ordinary"), duration_s=duration_s)
        flown = simulate(scenario, seed)
        answered = run(flown, estimator_config(scenario, flown))
        recordings.save(answered, folder / f"{seed}.npz")
    return folder


def test_it_prints_one_object_and_writes_it_with_its_plots(lodestar, flights, tmp_path):
    status, out, _ = lodestar(
        "identify", flights / "1.npz", "--validate", flights / "2.npz", "--json"
    )
    assert status == 0
    told = json.loads(out)
    assert (told["reference"], told["interval_s"]) == ("INS", 1.0)
    assert [angle["samples"] for angle in told["angles"]] == [151] * 3
    assert all(0 < angle["A"] < 1 and angle["validation"] for angle in told["angles"])
    folder = tmp_path / "out/1-identify"
    assert json.loads((folder / "identification.json").read_text()) == told
    assert (folder / "plots/autocorrelation.png").stat().st_size > 0


def test_it_ends_with_tables_and_where_the_plots_are(lodestar, flights):
    status, out, _ = lodestar(
        "identify", flights / "1.npz", "--reference", "truth", "--ts", "0.5", "--out", "here"
    )
    assert status == 0
    assert "TRUTH − SAHRS" in out
    assert "every 0.5 s" in out
    assert "plots: here/plots" in out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["{}/3.npz"], "3.npz: heading error: 51 samples at 1 s; a fit needs 100"),
        (["{}/1.npz", "--ts", "0.001"], "SAHRS answers every 0.0167 s"),
        (["{}/1.npz", "--reference", "map"], "reference map: unknown; allowed are ins, truth"),
        (["{}/nothing.npz"], "nothing.npz: No such file"),
        (["{}/1.npz", "--validate", "{}/nothing.npz"], "nothing.npz: No such file"),
    ],
)
def test_bad_input_is_one_line(lodestar, flights, arguments, said):
    status, _, err = lodestar("identify", *(text.format(flights) for text in arguments))
    assert status == 2
    assert err.startswith("error: ")
    assert err.count("\n") == 1
    assert said in err
