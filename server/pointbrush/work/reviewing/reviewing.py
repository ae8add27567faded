"""The service for the review of recordings by id."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from pointbrush.accounts.accounts import require_name
from pointbrush.errors import BadInputError, ForbiddenError, NotFoundError
from pointbrush.sequences import Sequence as Recording
from pointbrush.teamwork.reviews import Review
from pointbrush.teamwork.store import WorkspaceStore
from pointbrush.values.team.review import (
    Agreement,
    BoxAgreement,
    Checked,
    Finding,
    ReviewOverview,
    Standing,
)
from pointbrush.work.exporting import parse_frames
from pointbrush.work.reviewing import comparing, states
from pointbrush.work.reviewing.box_comparing import compare_boxes
from pointbrush.work.reviewing.checking import Checker
from pointbrush.work.reviewing.comparing import By
from pointbrush.work.reviewing.report.gather import Report, gather
from pointbrush.work.reviewing.states import STATES, accepted_all

SETTLED = ("open", "accepted")
"""States in which an earlier note is resolved."""
LONGEST_NOTE = 2_000
"""Longest note, characters."""


class Reviewing:
    """States, notes and assignees of all recordings; thread-safe."""

    def __init__(self, store: WorkspaceStore, recording: Callable[[str], Recording]) -> None:
        self._store, self._recording = store, recording
        self._checker = Checker(store)

    def overview(self, sequence: str) -> ReviewOverview:
        """Return the review state of each frame and label; raises NotFoundError."""
        recording = self._recording(sequence)
        log = self._store.reviews.entries(sequence)
        palette = {label.id for label in self._store.palette(sequence)}
        changes = self._store.frame_changes(sequence)
        found = states.replay(log, len(recording), palette, changes)
        people = {entry.author for entry in log} | self._store.authors(sequence)
        names = {self._name(account) for account in people}
        names |= {entry.assignee for entry in log if entry.assignee}
        return replace(
            found,
            frames=tuple(map(self._named, found.frames)),
            labels=tuple(map(self._named, found.labels)),
            people=tuple(sorted(names, key=str.lower)),
        )

    def frame(self, sequence: str, frame: int, label: int = 0) -> Standing:
        """Return the review state of one frame, or of a label in it; raises NotFoundError."""
        _ = self._recording(sequence)[frame]
        return states.state_at(self.overview(sequence), frame, label)

    def history(self, sequence: str) -> list[Review]:
        """Return the review decisions, newest first, with names of authors."""
        self._recording(sequence)
        log = self._store.reviews.entries(sequence)
        return [replace(entry, author=self._name(entry.author)) for entry in reversed(log)]

    def put(self, sequence: str, author: str, review: Review, *, decides: bool = True) -> None:
        """Set the state, note or person of frames, or of a label; None keeps a value.

        Accepting or reopening removes the note, unless a new one is given.  ``decides``: the caller
        may revoke acceptance.  Raises NotFoundError (frame, label), BadInputError for invalid
        values, ForbiddenError.
        """
        recording = self._recording(sequence)
        _check_frames(review, len(recording))
        _check_words(review)
        palette = {one.id for one in self._store.palette(sequence)}
        if review.label and review.label not in palette:
            raise NotFoundError(f"label: expected the id of a label, got {review.label}")
        if review.state in SETTLED and review.note is None:
            review = replace(review, note="")

        def require_undecided(log: Sequence[Review]) -> None:
            _require_undecided(states.replay(log, len(recording), palette, {}), review)

        self._store.reviews.add(
            sequence, recording.identity, author, review, None if decides else require_undecided
        )

    def checks(self, sequence: str, frames: str | None = None) -> Checked:
        """Return the findings of checks in frames ``I:J``, by default all, in their order.

        Raises NotFoundError, BadInputError for an invalid range.
        """
        recording = self._recording(sequence)
        found = self._checker.check(recording, parse_frames(frames, len(recording)))
        overview = self.overview(sequence)
        settled = (replace(one, settled=_is_settled(one, overview)) for one in found.findings)
        return replace(found, findings=tuple(settled))

    def agreement(
        self, sequence: str, other: str, by: By = "name", frames: str | None = None
    ) -> Agreement:
        """Compare the labels with the labels of another recording of the same points.

        Raises NotFoundError, BadInputError for a recording of other points.
        """
        first, second = self._recording(sequence), self._recording(other)
        return comparing.compare(self._store, first, second, by, parse_frames(frames, len(first)))

    def box_agreement(self, sequence: str, other: str, frames: str | None = None) -> BoxAgreement:
        """Compare the boxes with the boxes of another recording of the same points, by class.

        Raises the errors of ``agreement``.
        """
        first, second = self._recording(sequence), self._recording(other)
        return compare_boxes(self._store, first, second, parse_frames(frames, len(first)))

    def difference(self, sequence: str, other: str, frame: int, by: By = "name") -> bytes:
        """Return a PNG of label differences in a frame, from above; raises like ``agreement``."""
        first, second = self._recording(sequence), self._recording(other)
        _ = first[frame]
        return comparing.picture(self._store, first, second, by, frame)

    def report(self, sequence: str) -> Report:
        """Return progress, points, confidence and effort of a recording."""
        recording = self._recording(sequence)
        return gather(self._store, recording, self.overview(sequence), self._name)

    def _name(self, account: str) -> str:
        return self._store.accounts.name(account)

    def _named(self, standing: Standing) -> Standing:
        return replace(standing, by=self._name(standing.by)) if standing.by else standing


def _is_settled(finding: Finding, overview: ReviewOverview) -> bool:
    """Return whether a reviewer has accepted its frames, or each of its labels, unchanged since."""
    if finding.first is None or finding.last is None:
        accepted = {each.label for each in overview.labels if each.state == "accepted"}
        return bool(finding.labels) and accepted.issuperset(finding.labels)
    return any(
        all(accepted_all(overview, finding.first, finding.last, label) for label in layer)
        for layer in ((0,), finding.labels)
        if layer
    )


def _require_undecided(overview: ReviewOverview, review: Review) -> None:
    if review.first is None or review.last is None:
        there = [each for each in overview.labels if each.label == review.label]
    else:
        there = list(states.overlapping(overview, review.first, review.last, review.label))
    if any(each.state == "accepted" for each in there):
        raise ForbiddenError("expected a reviewer to reopen accepted frames or labels")


def _check_frames(review: Review, frames: int) -> None:
    if (review.first is None) != (review.last is None):
        raise BadInputError("frames: expected first and last, or neither")
    if review.first is None or review.last is None:
        if not review.label:
            raise BadInputError("frames: expected first and last, or a label, got neither")
        if review.assignee is not None:
            raise BadInputError("assignee: expected frames to give to a person, got a label")
        return
    if not 0 <= review.first <= review.last < frames:
        raise NotFoundError(
            f"frames: expected first <= last within 0 to {frames - 1}, "
            f"got {review.first} to {review.last}"
        )
    if review.label and review.assignee is not None:
        raise BadInputError("assignee: expected frames to give to a person, got a label")


def _check_words(review: Review) -> None:
    if review.state is None and review.note is None and review.assignee is None:
        raise BadInputError("expected a state, a note or an assignee, got none of them")
    if review.state is not None and review.state not in STATES:
        raise BadInputError(f"state: expected one of {', '.join(STATES)}, got {review.state!r}")
    if review.note is not None and len(review.note) > LONGEST_NOTE:
        raise BadInputError(
            f"note: expected at most {LONGEST_NOTE} characters, got {len(review.note)}"
        )
    if review.note is not None and "\0" in review.note:
        raise BadInputError("note: expected no NUL character")
    if review.place is not None and not review.note:
        raise BadInputError("place: expected a note to pin there, got none")
    if review.assignee:
        require_name(review.assignee)
