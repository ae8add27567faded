"""Manifests of recordings as REST has them."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from typing import Any

from pointbrush import sequences
from pointbrush.values.kinds import time_of
from pointbrush.values.recordings import Bounds, Manifest
from pointbrush.work.deletion import Deleted
from pointbrush.work.listing import Listed


def listed(entry: Listed) -> Manifest:
    """Return the manifest of a listed recording; a damaged one may have only its id."""
    if entry.manifest is None:
        return _unreadable(entry.id, entry.revision, damaged=entry.damaged)
    return _manifest(
        entry.manifest, entry.revision, entry.progress.changed,
        damaged=entry.damaged, labelled=entry.progress.frames, labels=entry.progress.labels,
        labels_used=entry.progress.used, labels_missing=entry.labels_missing,
        project=entry.project, copy_of=entry.copy_of,
    )  # fmt: skip


def removed(entry: Deleted) -> Manifest:
    """Return the manifest of a deleted recording."""
    known = entry.known
    more = {
        "id": known.id, "identity": known.identity,
        "deleted": time_of(known.deleted), "until": time_of(known.until),
    }  # fmt: skip
    if entry.manifest is None:
        damaged = "its files are damaged or missing"
        return _unreadable(known.id, known.revision, damaged=damaged, **more)
    return _manifest(entry.manifest, known.revision, None, **more)


def _unreadable(sequence: str, revision: int, **more: Any) -> Manifest:
    zero = (0.0, 0.0, 0.0)
    fields: dict[str, Any] = {
        "id": sequence, "name": sequence, "frames": 0, "fps": 1.0, "points": (), "fields": (),
        "bounds": Bounds(zero, zero), "revision": revision, "shift": zero,
        "room": tuple(float(i % 5 == 0) for i in range(16)), "position_error": 0.0, "dropped": (),
        "large": False, "source": "",
    }  # fmt: skip
    return Manifest(**fields | more)


def _manifest(
    stored: sequences.Manifest, revision: int, changed: float | None, **more: Any
) -> Manifest:
    """Return the manifest of a stored recording, which has local bounds."""
    shift = [float(x) for x in stored.shift]
    created = datetime.fromisoformat(stored.created)
    fields = {
        "bounds": Bounds(_moved(stored.lo, shift), _moved(stored.hi, shift)),
        "revision": revision, "shift": shift, "created": created,
        "changed": time_of(changed) or created, "labelled": 0, "labels": 0, "labels_used": 0,
        "damaged": None, "labels_missing": None, "project": "default", "copy_of": None,
        "deleted": None, "until": None,
    }  # fmt: skip
    return Manifest.of(stored, **fields | more)


def _moved(corner: Sequence[float], shift: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = (float(a) + b for a, b in zip(corner, shift, strict=True))
    return x, y, z
