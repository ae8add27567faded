"""States of frames and labels, replayed from the log."""

from __future__ import annotations

import pytest

from pointbrush.teamwork.reviews import Review
from pointbrush.values.kinds import time_of
from pointbrush.values.team.review import ReviewOverview
from pointbrush.work.reviewing.states import replay, state_at

FRAMES = 10


def told(*log: Review, changes: dict[int, int] | None = None) -> ReviewOverview:
    return replay(log, FRAMES, {1, 2}, changes or {})


def test_frames_begin_open_and_are_counted_in_each_state() -> None:
    assert told().counts == {"open": 10, "review": 0, "accepted": 0, "rejected": 0}
    found = told(Review(0, 5, state="review"), Review(3, 6, state="accepted"))
    assert found.counts == {"open": 3, "review": 3, "accepted": 4, "rejected": 0}
    assert [(each.first, each.last, each.state) for each in found.frames] == [
        (0, 2, "review"),
        (3, 6, "accepted"),
    ]


def test_state_note_and_person_are_set_one_by_one() -> None:
    found = told(
        Review(0, 9, assignee="grace", author="ada", time=1.0),
        Review(2, 2, state="rejected", note="open door", place=(1, 2, 3), author="joan", time=2.0),
        Review(2, 2, state="review", author="grace", time=3.0),
    )
    frame = state_at(found, 2)
    assert (frame.state, frame.note, frame.place) == ("review", "open door", (1, 2, 3))
    assert (frame.assignee, frame.by, frame.at) == ("grace", "grace", time_of(3.0))
    assert (state_at(found, 3).state, state_at(found, 3).by) == ("open", "")


def test_labels_have_states_of_their_own_while_they_exist() -> None:
    found = told(
        Review(1, 1, label=2, state="rejected", note="half of it"),
        Review(None, None, label=1, state="accepted"),
        Review(1, 1, label=7, state="accepted"),
    )
    assert state_at(found, 1).state == "open"
    assert state_at(found, 1, 2).note == "half of it"
    assert [(each.label, each.state) for each in found.labels] == [(1, "accepted")]
    assert {each.label for each in found.frames} == {2}
    assert found.counts["open"] == FRAMES


@pytest.mark.parametrize(("change", "stale"), [(4, False), (5, False), (6, True)])
def test_what_changed_after_its_state_was_given_says_so(change: int, stale: bool) -> None:
    found = told(Review(0, 1, state="accepted", revision=5), changes={1: change})
    assert state_at(found, 0).changed is False
    assert state_at(found, 1).changed is stale
