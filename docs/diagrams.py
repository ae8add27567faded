"""Draw the diagrams of the documentation anew: ``python docs/diagrams.py``.

Written are SVGs in ``docs/images``, which follow the browser's light or dark.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from html import escape
from pathlib import Path

IMAGES = Path(__file__).parent / "images"
WIDTH, HEIGHT = 150, 56
"""Of a box, pixels."""
STEP_X, STEP_Y = 216, 104
"""Between the middles of boxes."""
MARGIN = 12
LETTER = 3.6
"""Half the width of a letter of an arrow's words."""
STYLE = """<style>
svg{font:13px system-ui,sans-serif}
.card{fill:#fff}.box{fill:#eef2ff;stroke:#4051b5}.kept{fill:#fff4e0;stroke:#b26a00}
text{fill:#1c1e26;text-anchor:middle}.small{font-size:11px;fill:#4a4d57}
path{stroke:#5a5e6b;stroke-width:1.5;fill:none}.tip{fill:#5a5e6b;stroke:none}.halo{fill:#fff}
@media(prefers-color-scheme:dark){
.card,.halo{fill:#1e2129}.box{fill:#2a3152;stroke:#8c9eff}.kept{fill:#43341b;stroke:#ffb74d}
text{fill:#eceef4}.small{fill:#bfc3cf}path{stroke:#a7acba}.tip{fill:#a7acba}}
</style>
<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="8" markerHeight="8"
orient="auto-start-reverse"><path class="tip" d="M0 0 8 4 0 8z"/></marker></defs>"""


@dataclass(frozen=True)
class Box:
    """A box in a column and row; ``kept``: it is on a disk."""

    column: float
    row: float
    title: str
    about: str
    kept: bool = False

    @property
    def middle(self) -> tuple[float, float]:
        """Place of its middle, pixels."""
        return (
            MARGIN + WIDTH / 2 + self.column * STEP_X,
            MARGIN + HEIGHT / 2 + self.row * STEP_Y,
        )


@dataclass(frozen=True)
class Arrow:
    """An arrow between boxes by their keys, with words."""

    start: str
    end: str
    says: str = ""


@dataclass(frozen=True)
class Diagram:
    """Boxes by keys, and arrows."""

    about: str
    boxes: dict[str, Box]
    arrows: tuple[Arrow, ...]


DIAGRAMS = {
    "architecture": Diagram(
        "Data flows from files over sequences and streaming to the page, strokes come back",
        {
            "files": Box(0, 0, "files", "a recording's", kept=True),
            "formats": Box(1, 0, "formats", "a reader for each"),
            "sequences": Box(2, 0, "sequences", "frames, made ready", kept=True),
            "streaming": Box(3, 0, "streaming", "points in time"),
            "page": Box(4, 0, "page", "desk and headset"),
            "tracking": Box(2, 1, "tracking", "from frame to frame"),
            "selection": Box(4, 1, "selection", "stroke to points"),
            "labels": Box(3, 1, "labels", "a journal of edits", kept=True),
            "exports": Box(3, 2, "formats", "exports"),
        },
        (
            Arrow("files", "formats"), Arrow("formats", "sequences", "import"),
            Arrow("sequences", "streaming"), Arrow("streaming", "page"),
            Arrow("page", "selection", "strokes"), Arrow("selection", "labels"),
            Arrow("sequences", "tracking"), Arrow("tracking", "labels"),
            Arrow("labels", "streaming", "changes"), Arrow("labels", "exports"),
        ),
    ),
    "streaming": Diagram(
        "A plan says which points come next, four bounds how many; credits come back",
        {
            "files": Box(0, 1, "chunks", "encoded at import", kept=True),
            "plan": Box(1, 0, "plan", "which points next"),
            "rate": Box(2, 0, "rate", "link, pace, page, load"),
            "sender": Box(1, 1, "sender", "one for each viewer"),
            "socket": Box(2, 1, "WebSocket", "binary messages"),
            "page": Box(3, 1, "page", "decoder in a worker"),
            "edits": Box(1, 2, "edits", "each once, in order"),
            "journal": Box(0, 2, "labels", "the journal", kept=True),
        },
        (
            Arrow("files", "sender"), Arrow("plan", "sender"), Arrow("rate", "plan", "how many"),
            Arrow("sender", "socket"), Arrow("socket", "page", "frames"),
            Arrow("page", "rate", "credit"), Arrow("journal", "edits"), Arrow("edits", "sender"),
        ),
    ),
    "storage": Diagram(
        "An edit is appended to the journal and synced before it is answered",
        {
            "stroke": Box(0, 0, "stroke", "with an id of its own"),
            "select": Box(1, 0, "selection", "its points"),
            "journal": Box(2, 0, "journal", "append, fsync", kept=True),
            "answer": Box(3, 0, "answer", "now it is safe"),
            "snapshots": Box(2, 1, "snapshots", "every 64 edits a block", kept=True),
            "blocks": Box(1, 1, "blocks in memory", "65,536 points each"),
            "read": Box(0, 1, "page, export", "what is read"),
            "others": Box(3, 1, "other servers", "by LISTEN, in order"),
        },
        (
            Arrow("stroke", "select"), Arrow("select", "journal", "one edit"),
            Arrow("journal", "answer"), Arrow("journal", "snapshots"),
            Arrow("snapshots", "blocks"), Arrow("blocks", "read"), Arrow("journal", "others"),
        ),
    ),
}  # fmt: skip


def drawn(diagram: Diagram) -> str:
    """Return a diagram as SVG."""
    places = [box.middle for box in diagram.boxes.values()]
    width = max(x for x, _ in places) + WIDTH / 2 + MARGIN
    height = max(y for _, y in places) + HEIGHT / 2 + MARGIN
    about = escape(diagram.about)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" role="img">',
        f"<title>{about}</title>",
        STYLE,
        f'<rect class="card" width="{width:g}" height="{height:g}" rx="8"/>',
    ]
    for arrow in diagram.arrows:
        lines += _arrow(diagram.boxes[arrow.start], diagram.boxes[arrow.end], arrow.says)
    for box in diagram.boxes.values():
        x, y = box.middle
        lines += [
            f'<rect class="{"kept" if box.kept else "box"}" x="{x - WIDTH / 2:g}" '
            f'y="{y - HEIGHT / 2:g}" width="{WIDTH}" height="{HEIGHT}" rx="6"/>',
            f'<text x="{x:g}" y="{y - 4:g}" font-weight="600">{escape(box.title)}</text>',
            f'<text class="small" x="{x:g}" y="{y + 14:g}">{escape(box.about)}</text>',
        ]
    return "\n".join([*lines, "</svg>", ""])


def _arrow(start: Box, end: Box, says: str) -> Iterator[str]:
    """Draw from edge to edge: level, upright, or askew from the side."""
    (x, y), (u, v) = start.middle, end.middle
    if y == v or (x != u and abs(u - x) > abs(v - y)):
        side = WIDTH / 2 if u > x else -WIDTH / 2
        x, u = x + side, u - side
    else:
        side = HEIGHT / 2 if v > y else -HEIGHT / 2
        y, v = y + side, v - side
    yield f'<path d="M{x:g} {y:g}L{u:g} {v:g}" marker-end="url(#tip)"/>'
    if says:
        half, above = len(says) * LETTER, -7 if y == v else 4
        yield (
            f'<rect class="halo" x="{(x + u) / 2 - half:g}" y="{(y + v) / 2 + above - 11:g}" '
            f'width="{2 * half:g}" height="14"/>' if y != v else ""
        )  # fmt: skip
        yield (
            f'<text class="small" x="{(x + u) / 2:g}" y="{(y + v) / 2 + above:g}">'
            f"{escape(says)}</text>"
        )


def main() -> None:
    """Write all."""
    for name, diagram in DIAGRAMS.items():
        (IMAGES / f"{name}.svg").write_text(drawn(diagram), encoding="utf-8")


if __name__ == "__main__":
    main()
