"""The review of a recording: states and notes, suspicious labels, agreement, reports."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx

from pointbrush.client.steps import L, Part, Request, Steps, send, steps
from pointbrush.client.uploads import AnyPath
from pointbrush.client.values import Vector, read


@dataclass(frozen=True, slots=True)
class Standing:
    """Review state of frames ``first`` to ``last``, or of ``label`` as a whole (frames None).

    ``label`` None: state of the frames themselves.  ``place``: position of the note, source
    coordinates, metres.  ``at``: ISO 8601.  ``changed``: labels have changed since the review.
    """

    first: int | None
    last: int | None
    label: int | None
    state: str
    note: str
    place: Vector | None
    assignee: str
    by: str
    at: str | None
    changed: bool


@dataclass(frozen=True, slots=True)
class Finding:
    """A suspicious label; ``place`` in frame ``first``, source coordinates, metres."""

    id: str
    kind: str
    text: str
    labels: tuple[int, ...]
    first: int | None
    last: int | None
    place: Vector | None
    settled: bool


@dataclass(frozen=True, slots=True)
class Checked:
    """Findings in the order of review, and a sentence for each skipped check."""

    findings: tuple[Finding, ...]
    unchecked: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class LabelAgreement:
    """Agreement on a label: its points in the first recording, the second and both."""

    name: str
    iou: float
    first: int
    second: int
    both: int


@dataclass(frozen=True, slots=True)
class FrameAgreement:
    """Points of a frame labelled in either recording, and the differing ones among them."""

    frame: int
    labelled: int
    differ: int


@dataclass(frozen=True, slots=True)
class BoxScore:
    """Score of the second recording's boxes against the first's, with minimum 3D IoU ``iou``."""

    iou: float
    ap: float
    precision: float
    recall: float


@dataclass(frozen=True, slots=True)
class ClassAgreement:
    """Boxes of a class, counted in each frame; ``mean_iou`` of overlapping boxes."""

    name: str
    first: int
    second: int
    mean_iou: float | None
    scores: tuple[BoxScore, ...]


@dataclass(frozen=True, slots=True)
class BoxAgreement:
    """Agreement of boxes by class; ``hota`` None if the server has no trackeval."""

    classes: tuple[ClassAgreement, ...]
    hota: float | None


@dataclass(frozen=True, slots=True)
class Agreement:
    """Agreement of two annotations; values are None if neither has labels."""

    miou: float | None
    same: float | None
    labels: tuple[LabelAgreement, ...]
    frames: tuple[FrameAgreement, ...]
    boxes: BoxAgreement | None = None


class Review(Part[L]):
    """The review of one recording."""

    def __init__(self, link: L, sequence: str) -> None:
        super().__init__(link)
        self._sequence = sequence

    def _get(self, path: str, **query: Any) -> Steps[httpx.Response]:
        given = {name: value for name, value in query.items() if value is not None}
        place = f"/sequences/{self._sequence}{path}"
        return send(Request("GET", place, {"params": given}, again=True))

    @steps
    def counts(self) -> Steps[dict[str, int]]:
        """Return the numbers of open, review, accepted and rejected frames."""
        found: dict[str, int] = (yield from self._get("/review")).json()["counts"]
        return found

    @steps
    def standings(self) -> Steps[list[Standing]]:
        """Return the states of reviewed runs of frames, then of labels as a whole."""
        found = (yield from self._get("/review")).json()
        return [read(Standing, entry) for entry in (*found["frames"], *found["labels"])]

    @steps
    def frame(self, frame: int, label: int | None = None) -> Steps[Standing]:
        """Return the review state of a frame, or of a label in it."""
        answer = yield from self._get(f"/frames/{frame}/review", label=label)
        return read(Standing, answer.json())

    @steps
    def put(
        self,
        first: int | None = None,
        last: int | None = None,
        *,
        label: int | None = None,
        state: str | None = None,
        note: str | None = None,
        place: Sequence[float] | None = None,
        assignee: str | None = None,
    ) -> Steps[None]:
        """Change the review of frames ``first`` to ``last`` (default: ``first``) or of a label.

        Raises ForbiddenError for an insufficient role, NotFoundError, BadInputError.
        """
        given = {
            "first": first,
            "last": first if last is None else last,
            "label": label,
            "state": state,
            "note": note,
            "place": None if place is None else [float(value) for value in place],
            "assignee": assignee,
        }
        body = {name: value for name, value in given.items() if value is not None}
        path = f"/sequences/{self._sequence}/review"
        yield from send(Request("PUT", path, {"json": body}, again=True))

    @steps
    def history(self, limit: int = 100) -> Steps[list[dict[str, Any]]]:
        """Return the review decisions with their authors, newest first."""
        answer = yield from self._get("/review/history", limit=limit)
        found: list[dict[str, Any]] = answer.json()
        return found

    @steps
    def check(self, frames: str | None = None) -> Steps[Checked]:
        """Return the findings in frames ``I:J``, and the skipped checks."""
        return read(Checked, (yield from self._get("/checks", frames=frames)).json())

    @steps
    def checks(self, frames: str | None = None) -> Steps[list[Finding]]:
        """Return the findings in frames ``I:J`` (None: all)."""
        answer = yield from self._get("/checks", frames=frames)
        return list(read(Checked, answer.json()).findings)

    @steps
    def agreement(
        self, other: str, by: str = "name", frames: str | None = None, *, boxes: bool = False
    ) -> Steps[Agreement]:
        """Return the agreement with another recording: IoU by label, differing points by frame.

        ``by``: match labels by "name" or "category".  ``frames``: I:J.  ``boxes``: compare boxes
        as well.
        """
        query = {"with": other, "by": by, "frames": frames, "boxes": "true" if boxes else None}
        return read(Agreement, (yield from self._get("/agreement", **query)).json())

    @steps
    def difference(self, other: str, frame: int, by: str = "name") -> Steps[bytes]:
        """Return a PNG of a frame from above with the differing points."""
        query = {"with": other, "by": by}
        return (yield from self._get(f"/frames/{frame}/agreement", **query)).content

    @steps
    def report(self, out: AnyPath, table: str = "frames") -> Steps[Path]:
        """Write the report to a .html or .csv file, and return its path.

        ``table`` of a .csv: "frames", "labels" or "people".
        """
        target = Path(out)
        csv = target.suffix.lower() == ".csv"
        query = {"format": "csv", "table": table} if csv else {"format": "html"}
        target.write_bytes((yield from self._get("/report", **query)).content)
        return target
