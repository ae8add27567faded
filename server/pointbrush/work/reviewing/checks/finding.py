"""Finding of a check."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Literal, get_args

Kind = Literal["name", "few", "stray", "jump", "unlike"]
KINDS: tuple[Kind, ...] = get_args(Kind)
"""Two labels of one name; a label of few points; points far from their object; a track that jumps;
a frame unlike its neighbours."""


@dataclass(frozen=True, slots=True)
class Finding:
    """A suspicious thing.

    ``labels``         the labels that it is about; () where it is about frames.
    ``first``, ``last``  its frames, both included; None where it is about the palette.
    ``place``          where to look in frame ``first``, source coordinates in metres, or None.
    ``settled``        a reviewer has accepted it: the frames, or the label, unchanged since.
    """

    kind: Kind
    text: str
    labels: tuple[int, ...] = ()
    first: int | None = None
    last: int | None = None
    place: tuple[float, float, float] | None = None
    settled: bool = False

    @property
    def id(self) -> str:
        """Tells this finding from the others of its recording, however often one looks."""
        return "-".join(map(str, (self.kind, *self.labels, self.first, self.last)))


def grouped(found: Iterable[Finding]) -> list[Finding]:
    """Join findings of one kind and label in consecutive frames; the first one's words stay."""
    runs: list[Finding] = []
    for each in sorted(found, key=lambda one: (one.kind, one.labels, one.first or 0)):
        before = runs[-1] if runs else None
        if (
            before is not None
            and (before.kind, before.labels) == (each.kind, each.labels)
            and before.last is not None
            and each.first == before.last + 1
        ):
            runs[-1] = replace(before, last=each.last)
        else:
            runs.append(each)
    return runs
