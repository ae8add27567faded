"""The review of a recording: states and notes, suspicious labels, agreement, reports."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from pointbrush.client.answers import vector
from pointbrush.client.steps import L, Part, Steps, steps
from pointbrush.client.uploads import AnyPath
from pointbrush.values.team.review import (
    Agreement,
    Checked,
    Decision,
    Finding,
    ReviewOverview,
    ReviewPatch,
    ReviewState,
    Standing,
)


class Review(Part[L]):
    """The review of one recording."""

    @steps
    def counts(self) -> Steps[dict[ReviewState, int]]:
        """Return the numbers of open, review, accepted and rejected frames."""
        return dict((yield from self._get(ReviewOverview, "/review")).counts)

    @steps
    def standings(self) -> Steps[list[Standing]]:
        """Return the states of reviewed runs of frames, then of labels as a whole."""
        found = yield from self._get(ReviewOverview, "/review")
        return [*found.frames, *found.labels]

    @steps
    def frame(self, frame: int, label: int | None = None) -> Steps[Standing]:
        """Return the review state of a frame, or of a label in it."""
        return self._get(Standing, f"/frames/{frame}/review", label=label)

    @steps
    def put(
        self,
        first: int | None = None,
        last: int | None = None,
        *,
        label: int | None = None,
        state: ReviewState | None = None,
        note: str | None = None,
        place: Sequence[float] | None = None,
        assignee: str | None = None,
    ) -> Steps[None]:
        """Change the review of frames ``first`` to ``last`` (default: ``first``) or of a label.

        Raises ForbiddenError for an insufficient role, NotFoundError, BadInputError.
        """
        end = first if last is None else last
        body = ReviewPatch(note, vector(place), assignee, state, label, first, end).to_json()
        yield from self._call("PUT", "/review", json=body, idempotent=True)

    @steps
    def history(self, limit: int = 100) -> Steps[list[Decision]]:
        """Return the review decisions with their authors, newest first."""
        return self._get(list[Decision], "/review/history", limit=limit)

    @steps
    def check(self, frames: str | None = None) -> Steps[Checked]:
        """Return the findings in frames ``I:J``, and the skipped checks."""
        return self._get(Checked, "/checks", frames=frames)

    @steps
    def checks(self, frames: str | None = None) -> Steps[list[Finding]]:
        """Return the findings in frames ``I:J`` (None: all)."""
        return list((yield from self._get(Checked, "/checks", frames=frames)).findings)

    @steps
    def agreement(
        self, other: str, by: str = "name", frames: str | None = None, *, boxes: bool = False
    ) -> Steps[Agreement]:
        """Return the agreement with another recording: IoU by label, differing points by frame.

        ``by``: match labels by "name" or "category".  ``frames``: I:J.  ``boxes``: compare boxes
        as well.
        """
        query = {"with": other, "by": by, "frames": frames, "boxes": "true" if boxes else None}
        return self._get(Agreement, "/agreement", **query)

    @steps
    def difference(self, other: str, frame: int, by: str = "name") -> Steps[bytes]:
        """Return a PNG of a frame from above with the differing points."""
        query = {"with": other, "by": by}
        place = f"/frames/{frame}/agreement"
        return (yield from self._call("GET", place, params=query)).content

    @steps
    def report(self, out: AnyPath, table: str = "frames") -> Steps[Path]:
        """Write the report to a .html or .csv file, and return its path.

        ``table`` of a .csv: "frames", "labels" or "people".
        """
        target = Path(out)
        csv = target.suffix.lower() == ".csv"
        query = {"format": "csv", "table": table} if csv else {"format": "html"}
        target.write_bytes((yield from self._call("GET", "/report", params=query)).content)
        return target
