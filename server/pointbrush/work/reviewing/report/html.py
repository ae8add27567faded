"""A report as a single HTML file without external resources and scripts."""

from __future__ import annotations

import base64
import hashlib
from collections import Counter
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from html import escape

import numpy as np

from pointbrush.work.reviewing.report import plots
from pointbrush.work.reviewing.report.gather import Report
from pointbrush.work.reviewing.report.plots import Series
from pointbrush.work.reviewing.states import STATES, State

STATE_COLORS: dict[State, str] = {
    "open": "#8b93a3",
    "review": "#e0a100",
    "accepted": "#2e9e6b",
    "rejected": "#d9534f",
}
STATE_WORDS: dict[State, str] = {
    "open": "open",
    "review": "in review",
    "accepted": "accepted",
    "rejected": "rejected",
}
BLUE, PALE = "#3b82f6", "#93b8f5"
STYLE = """
:root { color-scheme: light dark; --ink: #1b1f27; --soft: #667085; --paper: #fff; --line: #e2e6ee;
  --card: #f6f8fb; }
@media (prefers-color-scheme: dark) { :root { --ink: #e8ebf1; --soft: #98a2b3; --paper: #14161b;
  --line: #2b303a; --card: #1c1f26; } }
body { margin: 0 auto; max-width: 960px; padding: 32px 20px 64px; background: var(--paper);
  color: var(--ink); font: 15px/1.5 system-ui, sans-serif; }
h1 { margin: 0; font-size: 26px; } h2 { margin: 40px 0 8px; font-size: 18px; }
p { margin: 4px 0 12px; } .soft { color: var(--soft); }
.cards { display: grid; grid-template-columns: repeat(auto-fit, minmax(150px, 1fr)); gap: 12px;
  margin-top: 24px; }
.card { background: var(--card); border-radius: 10px; padding: 12px 16px; }
.card strong { display: block; font-size: 24px; font-variant-numeric: tabular-nums; }
svg { display: block; width: 100%; overflow: visible; margin: 6px 0; }
svg text { font: 12px system-ui, sans-serif; fill: var(--ink); }
svg text.soft { fill: var(--soft); } .grid { stroke: var(--line); }
.key { display: inline-block; margin-right: 18px; } .key svg { display: inline-block; width: 12px;
  margin: 0 6px 0 0; vertical-align: -1px; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { padding: 6px 10px; border-bottom: 1px solid var(--line); text-align: right; }
th:first-child, td:first-child { text-align: left; padding-left: 0; }
th { color: var(--soft); font-weight: 500; }
"""
STYLE_HASH = base64.b64encode(hashlib.sha256(STYLE.encode()).digest()).decode()
POLICY = f"default-src 'none'; style-src 'sha256-{STYLE_HASH}'; frame-ancestors 'none'"
"""Content-Security-Policy of the report."""
MOST_LINES = 40
"""Limit of labels with a separate line; more names would not be legible."""


def to_html(report: Report) -> str:
    """Return the report as a page."""
    made = datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    parts = (_cards, _progress, _labels, _confidence, _effort)
    return page(report.name, f"Labels as of {made}", "".join(part(report) for part in parts))


def page(title: str, about: str, body: str) -> str:
    """Return a page; ``title`` and ``about`` are plain text, ``body`` is HTML."""
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8">'
        f'<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escape(title)}</title><style>{STYLE}</style></head><body>"
        f'<header><h1>{escape(title)}</h1><p class="soft">{escape(about)}</p></header>'
        f"{body}</body></html>\n"
    )


def duration(seconds: float) -> str:
    """Return a time in words: "45 s", "12 min", "3 h 05 min"."""
    minutes = round(seconds / 60)
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60:02d} min"


def _cards(report: Report) -> str:
    frames = len(report.points)
    states = Counter(report.states)
    total = sum(each.seconds for each in report.people().values())
    strokes = sum(each.strokes for each in report.people().values())
    facts = [
        (f"{int((report.labelled > 0).sum()):,} of {frames:,}", "frames with labels"),
        (f"{_share(report.labelled.sum(), report.points.sum())}", "of all points labelled"),
        (f"{states['accepted']:,} of {frames:,}", "frames accepted"),
        (f"{states['rejected']:,}", "frames rejected"),
        (duration(total), "of work"),
        (f"{strokes:,}", "strokes"),
    ]
    cards = "".join(
        f'<div class="card"><strong>{value}</strong><span class="soft">{what}</span></div>'
        for value, what in facts
    )
    return f'<div class="cards">{cards}</div>'


def _progress(report: Report) -> str:
    frames = len(report.points)
    points = np.maximum(report.points, 1)
    series = [
        Series("labelled", PALE, 100.0 * report.labelled / points),
        Series("painted", BLUE, 100.0 * report.painted / points),
    ]
    colors = [STATE_COLORS[state] for state in report.states]
    titles = [
        f"frame {n}: {STATE_WORDS[state]}{f', {who}' if who else ''}"
        for n, (state, who) in enumerate(zip(report.states, report.assignees, strict=True))
    ]
    keys = [("labelled", PALE), ("of these painted by hand", BLUE)]
    keys += [(STATE_WORDS[state], STATE_COLORS[state]) for state in STATES]
    return (
        "<h2>Progress</h2><p class='soft'>Share of each frame's points, and its state below</p>"
        + plots.over_frames(series, frames, top=None, unit=" %")
        + plots.strip(colors, titles)
        + legend(keys)
    )


def _labels(report: Report) -> str:
    rows = []
    for label in report.palette:
        mine = report.by_label[label.id]
        counts = f"{int(mine.sum()):,} in {int((mine > 0).sum()):,} frames"
        rows.append((label.name, label.color, float(mine.sum()), counts))
    rows.sort(key=lambda row: -row[2])
    empty = "<p class='soft'>There are no labels yet.</p>"
    return "<h2>Points per label</h2>" + (plots.named_bars(rows) if rows else empty)


def _confidence(report: Report) -> str:
    head = "<h2>Confidence over time</h2>"
    if not report.confidence:
        return head + "<p class='soft'>Nothing was tracked.</p>"
    tracked = [label for label in report.palette if label.id in report.confidence][:MOST_LINES]
    series = [Series(each.name, each.color, report.confidence[each.id]) for each in tracked]
    keys = [(each.name, each.color) for each in tracked]
    return head + plots.lines(series, len(report.points), top=1.0, unit="") + legend(keys)


def _effort(report: Report) -> str:
    per_frame = report.per_frame()
    frames = len(per_frame)
    seconds = Series("seconds", BLUE, np.array([each.seconds for each in per_frame]))
    strokes = Series("strokes", PALE, np.array([each.strokes for each in per_frame], float))
    rows = [
        (name, duration(each.seconds), f"{each.strokes:,}", f"{each.edits:,}",
         f"{_frames_of(report, name):,}")
        for name, each in report.people().items()
    ]  # fmt: skip
    return (
        "<h2>Seconds per frame</h2>"
        + plots.over_frames([seconds], frames, top=None, unit=" s")
        + "<h2>Strokes per frame</h2>"
        + plots.over_frames([strokes], frames, top=None, unit="")
        + "<h2>People</h2>"
        + table(("person", "time", "strokes", "edits", "frames"), rows)
    )


def _frames_of(report: Report, person: str) -> int:
    return sum(1 for frame, who in report.effort if who == person and frame is not None)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table; its cells are plain text."""
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    body = "".join(
        f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows
    )
    return f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"


def legend(keys: Iterable[tuple[str, str]]) -> str:
    """Return the names of colours."""
    return "<p>" + "".join(
        f'<span class="key"><svg viewBox="0 0 12 12" aria-hidden="true"><rect width="12" '
        f'height="12" rx="3" fill="{color}"/></svg>{escape(name)}</span>'
        for name, color in keys
    ) + "</p>"  # fmt: skip


def _share(part: float, whole: float) -> str:
    return f"{100 * part / max(whole, 1):.1f} %"
