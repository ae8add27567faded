"""Manifests of recordings as REST has them."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from typing import Any

from pointbrush import sequences
from pointbrush.labels import Progress
from pointbrush.sequences.storage.sensors import StoredSensor
from pointbrush.values.kinds import time_of
from pointbrush.values.recordings import Bounds, Manifest, Sensor
from pointbrush.work.deletion import Deleted

NOTHING = Progress()


def listed(
    sequence: str,
    revision: int,
    stored: sequences.Manifest | None,
    damaged: str | None = None,
    progress: Progress = NOTHING,
    **more: str | None,
) -> Manifest:
    """Return the manifest of a recording with the fields ``more``.

    ``stored`` is None if it cannot be read, ``damaged`` a sentence or None.
    """
    if stored is None:
        return _unreadable(sequence, revision, damaged=damaged, **more)
    return _manifest(
        stored, revision, progress.changed, damaged=damaged, labelled=progress.frames,
        labels=progress.labels, labels_used=progress.used, **more,
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
        "bounds": Bounds(*(_moved(corner, shift) for corner in stored.bounds)),
        "sensors": tuple(map(_sensor, stored.sensors)),
        "revision": revision, "shift": shift, "created": created,
        "changed": time_of(changed) or created, "labelled": 0, "labels": 0, "labels_used": 0,
        "damaged": None, "labels_missing": None, "project": "default", "copy_of": None,
        "deleted": None, "until": None,
    }  # fmt: skip
    return Manifest.of(stored, **fields | more)


def _sensor(stored: StoredSensor) -> Sensor:
    mounts = tuple(tuple(stored.mount(k).ravel().tolist()) for k in range(len(stored.mounts)))
    return Sensor.of(stored, mounts=mounts, correction=tuple(stored.correction))


def _moved(corner: Sequence[float], shift: Sequence[float]) -> tuple[float, float, float]:
    x, y, z = (float(a) + b for a, b in zip(corner, shift, strict=True))
    return x, y, z
