# SPDX-License-Identifier: Apache-2.0
"""The report of a flight: one HTML file that needs nothing else."""

from __future__ import annotations

from base64 import b64encode
from html import escape
from pathlib import Path

from lodestar.errors import InputError
from lodestar.evaluation import flight_facts, summary
from lodestar.evaluation.plots import TITLES, render
from lodestar.evaluation.score import Score
from lodestar.recordings.recording import Recording

CAPTIONS = {
    "track": "Reference and NAV over a grid of latitude and longitude, undistorted.",
    "attitude": "Estimate minus reference. SAHRS is the attitude before correction, NAV after it; "
    "the bands are NAV's own σ.",
    "sahrs": "Small rotation from the reference to SAHRS about the aircraft's axes, with the σ "
    "that SAHRS states for it.",
    "position": "NAV minus reference, and the GPS fixes minus reference. The scale is that of the "
    "time with GPS.",
    "losses": "From the moment GPS is lost to its return.",
    "wind": "Velocity of the air over the ground.",
    "innovations": "Measured minus predicted, once a second, with the σ the filter expects. The "
    "filters refuse by χ² gates, whose refusals are counted in the next plot.",
    "modes": "Modes of the estimators, and messages that reached no state, by channel and reason.",
}

_STYLE = """
:root { color-scheme: light dark; --ink: #1d2433; --soft: #5b6475; --line: #e2e5ea; --page: #fbfbfc;
  --card: #fff; --good: #00795a; --bad: #b3261e; }
@media (prefers-color-scheme: dark) { :root { --ink: #e6e8ec; --soft: #a3abb9; --line: #353b47;
  --page: #14171d; --card: #1c2028; --good: #4fc79c; --bad: #ff8a80; } }
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--ink); line-height: 1.5;
  font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, "Helvetica Neue", sans-serif; }
main { max-width: 68rem; margin: 0 auto; padding: 2.5rem 1.5rem 4rem; }
h1 { font-size: 2rem; line-height: 1.2; margin: 0 0 .25rem; letter-spacing: -.01em; }
h2 { font-size: 1.2rem; margin: 2.75rem 0 .5rem; }
p { margin: .4rem 0; max-width: 46rem; }
.soft { color: var(--soft); }
.verdict { display: inline-block; margin: .9rem 0 .4rem; padding: .3rem .8rem; border-radius: .4rem;
  font-weight: 600; border: 1.5px solid currentColor; }
.passed { color: var(--good); } .failed, td.bad { color: var(--bad); }
td.bad { font-weight: 700; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums;
  font-size: .92rem; }
th, td { padding: .4rem .7rem; text-align: right; border-bottom: 1px solid var(--line);
  white-space: nowrap; }
th { font-weight: 600; color: var(--soft); }
th:first-child, td:first-child { text-align: left; padding-left: 0; }
table.wide td:last-child { white-space: normal; }
figure { margin: .75rem 0 0; padding: .9rem; background: #fff; border: 1px solid var(--line);
  border-radius: .5rem; }
img { display: block; width: 100%; height: auto; }
footer { margin-top: 3rem; color: var(--soft); font-size: .88rem; }
@media print { main { max-width: none; padding: 0; } figure { break-inside: avoid; } }
"""


def write_report(
    recording: Recording,
    score: Score,
    path: Path,
    *,
    description: str = "",
    images: dict[str, bytes] | None = None,
) -> None:
    """Write the report. ``description`` says what the scenario is about, in a sentence or two.

    ``images`` are those of plots.render() where it was called already. Raises InputError when the
    file cannot be written.
    """
    images = render(recording, score) if images is None else images
    parts = [
        _head(recording, score, description),
        _table("Summary", summary.error_table(score)),
        _paragraphs(summary.notes(score)),
    ]
    losses = summary.loss_table(score)
    if losses is not None:
        parts.append(_table(losses.title, losses))
    parts += [_figure(name, image) for name, image in images.items()]
    parts.append(_table("Channels", flight_facts.channel_table(recording), wide=True))
    parts.append(f"<footer>{escape(flight_facts.computer(recording))}</footer>")
    page = (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(score.case)} – Lodestar</title>\n<style>{_STYLE}</style>\n</head>\n"
        "<body>\n<main>\n" + "\n".join(parts) + "\n</main>\n</body>\n</html>\n"
    )
    try:
        path.write_text(page, encoding="utf-8")
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None


def _head(recording: Recording, score: Score, description: str) -> str:
    kind = "passed" if score.passed else "failed"
    lines = [
        f"<h1>{escape(score.case)}</h1>",
        f'<p class="soft">{escape(summary.headline(score))}</p>',
        f'<p class="verdict {kind}">{escape(summary.verdict(score))}</p>',
    ]
    if description:
        lines.append(f"<p>{escape(description)}</p>")
    lines.append(f"<p>{escape(flight_facts.description(recording, score))}</p>")
    return "\n".join(lines)


def _paragraphs(texts: list[str]) -> str:
    return "\n".join(f'<p class="soft">{escape(text)}</p>' for text in texts)


def _table(title: str, table: summary.Table, *, wide: bool = False) -> str:
    head = "".join(f"<th>{escape(name)}</th>" for name in table.header)
    body = "\n".join(
        "<tr>"
        + "".join(
            f'<td class="bad">{escape(cell)}</td>'
            if (row, column) in table.bad
            else f"<td>{escape(cell)}</td>"
            for column, cell in enumerate(cells)
        )
        + "</tr>"
        for row, cells in enumerate(table.rows)
    )
    kind = ' class="wide"' if wide else ""
    return (
        f'<h2>{escape(title)}</h2>\n<div class="scroll"><table{kind}>\n'
        f"<thead><tr>{head}</tr></thead>\n<tbody>\n{body}\n</tbody>\n</table></div>"
    )


def _figure(name: str, image: bytes) -> str:
    data = b64encode(image).decode("ascii")
    title = escape(TITLES[name])
    return (
        f'<h2 id="{name}">{title}</h2>\n<p class="soft">{escape(CAPTIONS[name])}</p>\n'
        f'<figure><img alt="{title}" src="data:image/png;base64,{data}"></figure>'
    )
