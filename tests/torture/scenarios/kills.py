"""The whole server is killed while something is done: it is done whole, or not at all."""

from __future__ import annotations

from tests.faults.torture import torture
from tests.torture.framework import Arena, scenario
from tests.torture.operations import EDITS, RECORDINGS, Operation, Place

FEWEST = 2
SECONDS_OF_ONE = 2.5
"""Time that a kill takes with all that is compared after it."""


@scenario("SIGKILL while four authors edit and track", 2)
def killed_editing(arena: Arena) -> None:
    """The journal and every layer of every frame are compared after each."""
    workspace, tally = arena.folder / "workspace", arena.tally
    with tally.expect("lost"):
        kills = max(FEWEST, arena.fewest, int(arena.seconds / SECONDS_OF_ONE))
        summary = torture(workspace, kills, arena.seed)
        tally.times, tally.answered = summary.kills, summary.edits


def _killed(arena: Arena, operations: tuple[Operation, ...]) -> None:
    place = Place(arena)
    try:
        for number in arena.rounds():
            operations[number % len(operations)].round(place)
    finally:
        place.server.kill()


@scenario("SIGKILL during track, label import, merge, split, accept, boxes, class changes", 3)
def killed_in_edit(arena: Arena) -> None:
    """An edit is there whole, or not at all, and there when it was answered."""
    _killed(arena, EDITS)


@scenario("SIGKILL during import, export, delete, restore", 2)
def killed_in_recording(arena: Arena) -> None:
    """A recording is there whole, or not at all."""
    _killed(arena, RECORDINGS)
