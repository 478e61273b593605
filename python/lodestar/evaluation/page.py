# SPDX-License-Identifier: Apache-2.0
"""Pieces of a report: one HTML file that needs nothing else."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from html import escape
from pathlib import Path

from lodestar.errors import InputError
from lodestar.evaluation.summary import Table

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
.scroll { overflow-x: auto; width: fit-content; min-width: 100%;
  max-width: max(100%, 50vw + 32.5rem - 1.5rem); }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums;
  font-size: .92rem; }
th, td { padding: .4rem .55rem; text-align: right; border-bottom: 1px solid var(--line);
  white-space: nowrap; }
th { font-weight: 600; color: var(--soft); white-space: normal; vertical-align: bottom; }
th:first-child, td:first-child { text-align: left; padding-left: 0; position: sticky; left: 0;
  background: var(--page); }
@media print { .scroll { overflow: visible; } }
table.wide :is(th, td):last-child { white-space: normal; text-align: left; }
figure { margin: .75rem 0 0; padding: .9rem; background: #fff; border: 1px solid var(--line);
  border-radius: .5rem; }
img { display: block; width: 100%; height: auto; }
footer { margin-top: 3rem; color: var(--soft); font-size: .88rem; }
@media print { main { max-width: none; padding: 0; } figure { break-inside: avoid; } }
"""


def write(title: str, parts: Sequence[str], path: Path) -> None:
    """Write a page. Raises InputError when the file cannot be written."""
    text = (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)} – Lodestar</title>\n<style>{_STYLE}</style>\n</head>\n"
        "<body>\n<main>\n" + "\n".join(parts) + "\n</main>\n</body>\n</html>\n"
    )
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}") from None


def head(title: str, headline: str, verdict: str, *, passed: bool) -> str:
    """Title, what it is about in one line, and the verdict."""
    kind = "passed" if passed else "failed"
    return (
        f"<h1>{escape(title)}</h1>\n"
        f'<p class="soft">{escape(headline)}</p>\n'
        f'<p class="verdict {kind}">{escape(verdict)}</p>'
    )


def paragraphs(texts: Sequence[str]) -> str:
    """A quiet paragraph for each text."""
    return "\n".join(f'<p class="soft">{escape(text)}</p>' for text in texts)


def table(title: str, content: Table) -> str:
    """A table under its heading."""
    head = "".join(f"<th>{escape(name)}</th>" for name in content.header)
    body = "\n".join(
        "<tr>"
        + "".join(
            f'<td class="bad">{escape(cell)}</td>'
            if (row, column) in content.bad
            else f"<td>{escape(cell)}</td>"
            for column, cell in enumerate(cells)
        )
        + "</tr>"
        for row, cells in enumerate(content.rows)
    )
    kind = ' class="wide"' if content.wide else ""
    return (
        f'<h2>{escape(title)}</h2>\n<div class="scroll"><table{kind}>\n'
        f"<thead><tr>{head}</tr></thead>\n<tbody>\n{body}\n</tbody>\n</table></div>"
    )


def figure(name: str, title: str, caption: str, png: bytes) -> str:
    """A plot under its heading and caption; ``name`` is its anchor."""
    data = b64encode(png).decode("ascii")
    return (
        f'<h2 id="{name}">{escape(title)}</h2>\n<p class="soft">{escape(caption)}</p>\n'
        f'<figure><img alt="{escape(title)}" src="data:image/png;base64,{data}"></figure>'
    )
