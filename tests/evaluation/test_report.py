# SPDX-License-Identifier: Apache-2.0
import io
import re
from html.parser import HTMLParser

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from rich.console import Console

from lodestar.errors import InputError
from lodestar.evaluation import drawing
from lodestar.evaluation.plots import TITLES, figures, render, write_plots
from lodestar.evaluation.report import write_report
from lodestar.evaluation.score import score
from lodestar.evaluation.tables import print_table
from lodestar.recordings import Recording

DEG = np.pi / 180


@pytest.fixture(scope="module")
def flight(synthetic):
    time_us = np.arange(0, 300_000_001, 50_000)
    t = time_us * 1e-6
    truth = synthetic.truth(time_us, (6.0, 7.0, 0.0))
    wave = np.sin(2 * np.pi * t / 30)
    return synthetic.recording(
        {
            "TRUTH": truth,
            "ADC": synthetic.air_data(truth),
            "GPS": synthetic.gps(truth, 20, [(59.5, 100.0)]),
            "SAHRS": synthetic.sahrs(truth, 1.0 * DEG, -0.5 * DEG, 3.0 * DEG * wave, 2.0 * DEG),
            "NAV": synthetic.nav(
                truth,
                3.0 * wave,
                -4.0 * wave,
                (0.25 * DEG, 0.5 * DEG, 1.0 * DEG * wave),
                (0.5, -1.5, 0.0),
                (3.5, 0.6 * DEG, 1.0),
            ),
            "HEALTH": synthetic.health(truth, 20),
        }
    )


@pytest.fixture(scope="module")
def flown(flight):
    return score(flight, case="ordinary", seed=1, realtime_factor=50.0)


@pytest.fixture(scope="module")
def images(flight, flown):
    return render(flight, flown)


class Page(HTMLParser):
    """Collects cells, references to other resources, and whether the tags match."""

    VOID = frozenset({"meta", "img", "br", "link"})

    def __init__(self, text):
        super().__init__()
        self.open, self.cells, self.bad, self.sources, self.tags = [], [], [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.sources += [value for name, value in attrs if name in ("src", "href")]
        if tag == "td" and ("class", "bad") in attrs:
            self.bad.append(len(self.cells))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] == "td":
            self.cells.append(data)


def test_there_is_a_plot_of_everything_and_each_is_a_picture(images):
    assert list(images) == list(TITLES)
    for data in images.values():
        picture = Image.open(io.BytesIO(data))
        assert picture.format == "PNG"
        assert picture.width == 1440
        # Something is drawn on it.
        assert len(np.unique(np.asarray(picture.convert("L")))) > 10


def test_the_same_flight_gives_the_same_pictures(flight, images):
    again = score(flight, case="ordinary", seed=1, realtime_factor=50.0)
    assert render(flight, again) == images


def test_the_report_is_one_file_that_needs_no_other(tmp_path, flight, flown, images):
    path = tmp_path / "report.html"
    write_report(flight, flown, path, description="Where <tags> & quotes are text.", images=images)
    text = path.read_text(encoding="utf-8")
    page = Page(text)
    assert page.open == []
    assert len(page.sources) == len(TITLES)
    assert all(source.startswith("data:image/png;base64,") for source in page.sources)
    assert not {"link", "script", "iframe"} & set(page.tags)
    assert not re.search(r"https?:|url\(|@import", text)
    assert "Where &lt;tags&gt; &amp; quotes are text." in text
    assert "passed: every limit was kept" in text
    assert path.stat().st_size < 5e6


def test_the_summary_holds_the_figures(tmp_path, flight, flown, images):
    path = tmp_path / "report.html"
    write_report(flight, flown, path, images=images)
    cells = Page(path.read_text(encoding="utf-8")).cells
    roll = cells.index("roll, °")
    assert cells[roll : roll + 6] == ["roll, °", "1.00", "0.25", "1.00", "0.25", "2/10"]
    wind = cells.index("wind N, m/s")
    assert cells[wind + 1 : wind + 3] == ["6.00", "0.50"]
    loss = cells.index("at 60 s")
    assert cells[loss + 1] == "40"
    gps = cells.index("GPS")
    assert cells[gps + 1] == str(len(flight["GPS"]["time_us"]))
    assert cells[gps + 4] == "1 gate"


def test_a_failed_flight_shows_what_failed(tmp_path, synthetic):
    time_us = np.arange(0, 90_000_001, 100_000)
    truth = synthetic.truth(time_us)
    recording = synthetic.recording(
        {"TRUTH": truth, "SAHRS": synthetic.sahrs(truth, 3.0 * DEG, 0.0, 0.0, DEG)}
    )
    flown = score(recording, case="ordinary")
    path = tmp_path / "report.html"
    write_report(recording, flown, path, images={})
    page = Page(path.read_text(encoding="utf-8"))
    assert [page.cells[index] for index in page.bad] == ["3.00"]
    console = Console(record=True, width=100, file=io.StringIO())
    print_table(flown, console)
    assert "failed: sahrs roll_rmse_deg is 3, limit 2" in console.export_text()


def without(recording, *names):
    return Recording({k: v for k, v in recording.channels.items() if k not in names})


@pytest.mark.parametrize(
    ("missing", "plots"),
    [
        (("NAV",), {"track", "attitude", "sahrs", "innovations", "modes"}),
        (("SAHRS",), set(TITLES) - {"sahrs"}),
        (("HEALTH",), set(TITLES) - {"innovations"}),
        (("GPS",), set(TITLES) - {"losses"}),
        (("SAHRS", "NAV", "HEALTH"), {"track"}),
    ],
)
def test_what_is_missing_is_left_out_and_the_rest_is_shown(tmp_path, flight, missing, plots):
    recording = without(flight, *missing)
    flown = score(recording, case="ordinary")
    assert set(figures(recording, flown)) == plots
    write_report(recording, flown, tmp_path / "report.html", images={})
    assert Page((tmp_path / "report.html").read_text(encoding="utf-8")).open == []
    print_table(flown, Console(file=io.StringIO()))


def test_the_ins_takes_the_place_of_truth(tmp_path, flight):
    recording = without(flight, "TRUTH")
    truth = flight["TRUTH"]
    fields = ("time_us", "roll", "pitch", "heading", "lat", "lon", "h", "v_N")
    valid = (truth["time_us"] > 50e6) & (truth["time_us"] < 250e6)
    recording.put("INS", {**{name: truth[name] for name in fields}, "valid": valid})
    flown = score(recording, case="flight")
    assert set(figures(recording, flown)) == set(TITLES)
    path = tmp_path / "report.html"
    write_report(recording, flown, path, images={})
    text = path.read_text(encoding="utf-8")
    assert "The reference is the INS, itself an estimate" in text
    # Neither limits nor published figures exist for it.
    assert "limit rmse/max" not in text
    assert "thesis" not in text


def test_output_that_is_never_valid_is_no_error(tmp_path, flight):
    recording = without(flight, "NAV", "SAHRS")
    for name in ("NAV", "SAHRS"):
        columns = dict(flight[name])
        recording.channels[name] = columns | {"valid": np.zeros(len(columns["valid"]), bool)}
    flown = score(recording, case="ordinary")
    assert not flown.passed
    images = render(recording, flown)
    assert set(images) == {"track", "innovations", "modes"}
    write_report(recording, flown, tmp_path / "report.html", images=images)


def test_the_terminal_table_fits_eighty_columns(flown):
    console = Console(record=True, width=80, file=io.StringIO())
    print_table(flown, console)
    text = console.export_text()
    assert "…" not in text
    assert "ordinary · seed 1 · 300 s · compared with TRUTH · 50 × real time" in text
    heading = next(line for line in text.splitlines() if line.startswith("heading"))
    assert heading.split()[2:7] == ["2.12", "0.71", "3.00", "1.00", "5/10"]
    assert "3.46 → 0.72" in heading
    assert "at 60 s" in text


def test_many_losses_of_one_length_are_summed_up(synthetic):
    time_us = np.arange(0, 400_000_001, 100_000)
    truth = synthetic.truth(time_us)
    lost = [(t + 0.5, t + 11.0) for t in range(40, 400, 80)]
    nav = synthetic.nav(truth, 3.0, 4.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    recording = synthetic.recording(
        {"TRUTH": truth, "GPS": synthetic.gps(truth, 10, lost), "NAV": nav}
    )
    console = Console(record=True, width=80, file=io.StringIO())
    print_table(score(recording, case="x"), console)
    row = next(line for line in console.export_text().splitlines() if line.startswith("5 times"))
    assert "5.00 (worst 5.00)" in row


def test_plots_are_written_as_files(tmp_path, flight, flown, images):
    paths = write_plots(flight, flown, tmp_path / "plots", images)
    assert [path.name for path in paths] == [f"{name}.png" for name in TITLES]
    assert all(path.read_bytes() == images[path.stem] for path in paths)


def test_a_folder_that_cannot_be_written_is_named(tmp_path, flight, flown, images):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="file/plots"):
        write_plots(flight, flown, tmp_path / "file" / "plots", images)
    with pytest.raises(InputError, match=re.escape("nowhere/report.html")):
        write_report(flight, flown, tmp_path / "nowhere" / "report.html", images=images)


@given(st.integers(1, 20_000), st.integers(0, 2**32 - 1))
def test_an_envelope_keeps_extremes_and_order_in_few_points(count, seed):
    values = np.random.default_rng(seed).normal(size=count)
    t = np.arange(count, dtype=float)
    at, drawn = drawing.envelope(t, values)
    assert len(at) == len(drawn) <= 3002
    assert drawn.max() == values.max()
    assert drawn.min() == values.min()
    assert np.all(np.diff(at) >= 0)
    np.testing.assert_array_equal(drawn, values[at.astype(int)])


def test_an_envelope_keeps_gaps():
    t = np.arange(30_000, dtype=float)
    values = np.where((t > 10_000) & (t < 20_000), np.nan, 1.0)
    at, drawn = drawing.envelope(t, values)
    assert np.isnan(drawn[(at > 10_050) & (at < 19_950)]).all()
    assert np.all(drawn[(at < 9_950) | (at > 20_050)] == 1.0)
