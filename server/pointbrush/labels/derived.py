"""Tables kept beside the journal so that nobody has to replay it.

Palette, tracks, counts, and the last change of each frame.
"""

from __future__ import annotations

from typing import Any

from sqlalchemy import bindparam, delete

from pointbrush.labels import schema
from pointbrush.labels.draft import Draft
from pointbrush.labels.effect import Effect
from pointbrush.labels.statements import Driver, Statement, upsert

_PUT_LABEL, _PUT_TRACK = upsert(schema.labels), upsert(schema.tracks)
_PUT_COUNT, _PUT_CHANGE = upsert(schema.counts), upsert(schema.frame_changes)
_DROP_LABEL = Statement(
    delete(schema.labels).where(
        schema.labels.c.sequence == bindparam("sequence"), schema.labels.c.id == bindparam("id")
    )
)
_DROP_TRACK = Statement(
    delete(schema.tracks).where(
        schema.tracks.c.sequence == bindparam("sequence"),
        schema.tracks.c.frame == bindparam("frame"),
        schema.tracks.c.label == bindparam("label"),
    )
)
_FIELDS = ("id", "name", "category", "color", "locked", "visible", "instance", "position")


def derive(driver: Driver, draft: Draft, effect: Effect) -> None:
    """Bring the palette, the tracks, the counts and the frames' last changes up to date."""
    here = {"sequence": draft.state.number}

    def row(**columns: Any) -> dict[str, Any]:
        return {**here, **columns}

    given = [label for label in draft.labels.values() if label is not None]
    _PUT_LABEL.run_each(driver, [row(**{f: getattr(one, f) for f in _FIELDS}) for one in given])
    gone = [row(id=number) for number, label in draft.labels.items() if label is None]
    _DROP_LABEL.run_each(driver, gone)
    tracks = [row(frame=f, label=n, data=data) for (f, n), data in draft.tracks.items()]
    _PUT_TRACK.run_each(driver, [one for one in tracks if one["data"] is not None])
    _DROP_TRACK.run_each(driver, [one for one in tracks if one["data"] is None])
    counts = effect.counts.items()
    _PUT_COUNT.run_each(
        driver,
        [row(frame=f, label=n, points=a, painted=b, held=c) for (f, n), (a, b, c) in counts],
    )
    _PUT_CHANGE.run_each(
        driver, [row(frame=frame, revision=draft.revision) for frame in effect.frames]
    )
