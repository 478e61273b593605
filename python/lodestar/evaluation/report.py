# SPDX-License-Identifier: Apache-2.0
"""The report of a flight: one HTML file that needs nothing else."""

from __future__ import annotations

from html import escape
from pathlib import Path

from lodestar.evaluation import flight_facts, page, summary
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
        page.table("Summary", summary.error_table(score)),
        page.paragraphs(summary.notes(score)),
    ]
    losses = summary.loss_table(score)
    if losses is not None:
        parts.append(page.table(losses.title, losses))
    parts += [
        page.figure(name, TITLES[name], CAPTIONS[name], image) for name, image in images.items()
    ]
    parts.append(page.table("Channels", flight_facts.channel_table(recording)))
    parts.append(f"<footer>{escape(flight_facts.computer(recording))}</footer>")
    page.write(score.case, parts, path)


def _head(recording: Recording, score: Score, description: str) -> str:
    lines = [
        page.head(score.case, summary.headline(score), summary.verdict(score), passed=score.passed)
    ]
    if description:
        lines.append(f"<p>{escape(description)}</p>")
    lines.append(f"<p>{escape(flight_facts.description(recording, score))}</p>")
    return "\n".join(lines)
