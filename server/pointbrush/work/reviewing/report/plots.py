"""Plots as SVG: values over the frames, and bars with names.  No styles, no scripts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

F64 = NDArray[np.float64]
WIDTH, HEIGHT = 920, 150
LEFT, BOTTOM, TOP = 56, 22, 10
"""Space for the axes, pixels."""
MOST = 460
"""Limit of columns of a plot; more frames are averaged."""
ROW = 26
NAMED = 190
"""Pixels for the names of bars."""


@dataclass(frozen=True, slots=True, eq=False)
class Series:
    """Values (F,) with a colour; NaN: no value; ``name`` is shown on hover."""

    name: str
    color: str
    values: F64


def columns(values: F64) -> F64:
    """Return means over frames for at most MOST columns, without NaN."""
    if len(values) <= MOST:
        return values
    edges = np.linspace(0, len(values), MOST + 1).astype(int)
    parts = [values[a:b][np.isfinite(values[a:b])] for a, b in pairwise(edges)]
    return np.array([part.mean() if len(part) else np.nan for part in parts])


def over_frames(series: Sequence[Series], frames: int, *, top: float | None, unit: str) -> str:
    """Return bars over the frame numbers, later series in front of earlier ones.

    ``top`` is the upper end of the axis, by default the greatest value.
    """
    drawn = [(each, columns(each.values)) for each in series]
    high = top or max([float(np.nanmax(v)) for _, v in drawn if np.isfinite(v).any()] or [0.0])
    high = high or 1.0
    parts = _axes(high, frames, unit)
    for each, values in drawn:
        step = (WIDTH - LEFT) / max(1, len(values))
        bars = "".join(
            f"M{LEFT + n * step:.1f} {HEIGHT - BOTTOM}v{-_tall(value, high):.1f}"
            f"h{max(step - (step > 3), 0.6):.1f}v{_tall(value, high):.1f}z"
            for n, value in enumerate(values)
            if np.isfinite(value) and value > 0
        )
        parts += f'<path d="{bars}" fill="{each.color}"><title>{escape(each.name)}</title></path>'
    return _svg(HEIGHT, parts)


def lines(series: Sequence[Series], frames: int, *, top: float, unit: str) -> str:
    """Return a line for each series over the frame numbers, interrupted at missing values."""
    parts = _axes(top, frames, unit)
    for each in series:
        values = columns(each.values)
        step = (WIDTH - LEFT) / max(1, len(values))
        path, pen = "", "M"
        for n, value in enumerate(values):
            if not np.isfinite(value):
                pen = "M"
                continue
            x, y = LEFT + (n + 0.5) * step, HEIGHT - BOTTOM - _tall(value, top)
            path += f"{pen}{x:.1f} {y:.1f}"
            if pen == "M":
                path += "h0.1"  # a single point is visible too
            pen = "L"
        parts += (
            f'<path d="{path}" fill="none" stroke="{each.color}" stroke-width="2" '
            f'stroke-linecap="round"><title>{escape(each.name)}</title></path>'
        )
    return _svg(HEIGHT, parts)


def named_bars(rows: Sequence[tuple[str, str, float, str]]) -> str:
    """Return a bar for each (name, colour, value, text), scaled to the longest."""
    most = max([value for _, _, value, _ in rows] or [0.0]) or 1.0
    parts = ""
    for n, (name, color, value, text) in enumerate(rows):
        y, wide = n * ROW, (WIDTH - NAMED - 150) * value / most
        parts += (
            f'<text x="{NAMED - 10}" y="{y + 17}" text-anchor="end">{escape(_short(name))}</text>'
            f'<rect x="{NAMED}" y="{y + 5}" width="{max(wide, 1):.1f}" height="16" rx="3" '
            f'fill="{color}"/>'
            f'<text x="{NAMED + wide + 8:.1f}" y="{y + 17}" class="soft">{escape(text)}</text>'
        )
    return _svg(max(ROW, ROW * len(rows)), parts)


def strip(colors: Sequence[str], titles: Sequence[str]) -> str:
    """Return a strip of a colour per frame, equal ones joined; ``titles`` are shown on hover."""
    step = (WIDTH - LEFT) / max(1, len(colors))
    starts = [n for n, color in enumerate(colors) if n == 0 or color != colors[n - 1]]
    parts = "".join(
        f'<rect x="{LEFT + a * step:.1f}" y="0" width="{max((b - a) * step, 0.8):.1f}" '
        f'height="14" fill="{colors[a]}"><title>{escape(titles[a])}</title></rect>'
        for a, b in zip(starts, [*starts[1:], len(colors)], strict=True)
    )
    return _svg(14, parts)


def _tall(value: float, high: float) -> float:
    return (HEIGHT - BOTTOM - TOP) * min(float(value) / high, 1.0)


def _axes(high: float, frames: int, unit: str) -> str:
    parts = ""
    for share in (0.0, 0.5, 1.0):
        y = HEIGHT - BOTTOM - (HEIGHT - BOTTOM - TOP) * share
        parts += (
            f'<line x1="{LEFT}" x2="{WIDTH}" y1="{y}" y2="{y}" class="grid"/>'
            f'<text x="{LEFT - 8}" y="{y + 4}" text-anchor="end" class="soft">'
            f"{high * share:.3g}{unit}</text>"
        )
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        anchor = "start" if share == 0 else "end" if share == 1 else "middle"
        parts += (
            f'<text x="{LEFT + (WIDTH - LEFT) * share}" y="{HEIGHT - 5}" text-anchor="{anchor}" '
            f'class="soft">{round((frames - 1) * share)}</text>'
        )
    return parts


def _svg(height: int, parts: str) -> str:
    return f'<svg viewBox="0 0 {WIDTH} {height}" role="img" aria-hidden="true">{parts}</svg>'


def _short(name: str) -> str:
    return name if len(name) <= 26 else f"{name[:25]}…"
