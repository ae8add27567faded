"""The commands on the list of recordings, and on one of them as a whole."""

from __future__ import annotations

import argparse
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from pointbrush.commands.answers import Answer, confirmed, table
from pointbrush.commands.arguments import (
    FRAMES,
    ONE_OR_ALL,
    SEQUENCE,
    argument,
    switch,
    verb,
)
from pointbrush.commands.places import Place, finished

if TYPE_CHECKING:
    from pointbrush.client import Client, Manifest


@verb(ONE_OR_ALL)
def info(given: argparse.Namespace, place: Place) -> Answer:
    """List the recordings, or describe one."""
    if given.sequence is None:
        return _listed(place.manifests())
    recording = place[given.sequence]
    known, palette = recording.manifest, recording.labels()
    facts = _facts(known) | {"sensors": [sensor.name for sensor in known.sensors]}
    shown = _facts(known) | {
        "points": f"{min(known.points):,} to {max(known.points):,} a frame",
        "fields": ", ".join(known.fields),
        "revision": known.revision,
    }
    if known.sensors:
        shown["sensors"] = ", ".join(f"{each.name} ({each.type})" for each in known.sensors)
    lines = [f"{name:10} {value}" for name, value in shown.items()]
    lines += [f"label {label.id:<4} {label.color} {label.name}" for label in palette]
    return Answer(facts | {"revision": known.revision, "labels": palette}, lines)


@verb(
    SEQUENCE,
    FRAMES,
    switch("--undo", "restore the mounts of before the last alignment"),
)
def align_sensors(given: argparse.Namespace, place: Place) -> Answer:
    """Correct the mounts of several sensors by surfaces that they share."""
    from pointbrush.work.exporting import parse_frames  # slow to import

    recording = place[given.sequence]
    frames = parse_frames(given.frames, len(recording.frames)) if given.frames else None
    result = finished(place, recording.start_align_sensors(frames, undo=given.undo))
    lines = [
        f"{each['name']}\tmoved by {1000 * each['shift']:.1f} mm and {each['turn']:.2f}°\t"
        f"{1000 * each['before']:.1f} → {1000 * each['after']:.1f} mm from shared surfaces"
        for each in result["sensors"]
    ]
    return Answer(result, [*lines, result["message"]])


def _listed(listed: Iterable[Manifest]) -> Answer:
    value = [
        (_facts(known) if known.frames else {"id": known.id})
        | {"damaged": known.damaged, "labels_missing": known.labels_missing}
        for known in listed
    ]
    return Answer(
        value, list(map(_row, listed)), head="ID\tFRAMES\tRATE\tPOINTS\tNAME" if value else ""
    )


def _facts(known: Manifest) -> dict[str, Any]:
    return {
        "id": known.id,
        "name": known.name,
        "source": known.source,
        "frames": known.frames,
        "fps": known.fps,
        "points": list(known.points),
        "fields": list(known.fields),
    }


def _row(known: Manifest) -> str:
    """Return the columns of a recording in the list, separated by tabs."""
    parts = [known.id]
    if known.frames:
        points = f"{sum(known.points):,} points"
        parts += [f"{known.frames} frames", f"{known.fps:g} fps", points, known.name]
    if known.damaged is not None:
        parts.append(f"damaged: {known.damaged}")
    if known.labels_missing is not None:
        parts.append(f"labels did not come in: {known.labels_missing}")
    return "\t".join(parts)


@verb(SEQUENCE)
def labels(given: argparse.Namespace, place: Place) -> Answer:
    """List the labels of a recording with their numbers of points."""
    palette = place[given.sequence].labels()
    rows = [(each.id, each.color, each.name, each.category, each.points) for each in palette]
    return table(palette, ("ID", "COLOUR", "NAME", "CATEGORY", "POINTS"), rows)


@verb(SEQUENCE)
def delete(given: argparse.Namespace, place: Place) -> Answer:
    """Delete a recording; `undelete` restores it within 30 days."""
    recording = place[given.sequence]
    recording.delete()
    return confirmed(
        f"deleted {recording.id}; `pointbrush undelete {recording.id}` restores it within 30 days",
        sequence=recording.id,
    )


@verb(argument("sequence", "id of the deleted recording", metavar="SEQ"))
def undelete(given: argparse.Namespace, place: Place) -> Answer:
    """Restore a deleted recording."""
    restored = place.restore(given.sequence).id
    return confirmed(f"restored {restored}", sequence=restored)


@verb(SEQUENCE, argument("name", "the new name", metavar="NAME"))
def rename(given: argparse.Namespace, place: Place) -> Answer:
    """Rename a recording; its id stays the same."""
    known = place[given.sequence].update(name=given.name)
    return confirmed(f"renamed {known.id} to {known.name!r}", sequence=known.id, name=known.name)


@verb(SEQUENCE)
def undo(given: argparse.Namespace, client: Client) -> Answer:
    """Undo your last edit of a recording on a server."""
    recording = client[given.sequence]
    edit = recording.undo()
    line = f"undid your last edit of {recording.id}: {edit.changed:,} points changed"
    return confirmed(line, sequence=recording.id, edit=edit.edit, changed=edit.changed)
