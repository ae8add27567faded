"""Tables kept beside the journal so that nobody has to replay it.

Palette, tracks, counts, and the last change of each frame.
"""

from __future__ import annotations

from sqlalchemy import and_, bindparam, delete

from pointbrush.labels import schema
from pointbrush.labels.database import Database
from pointbrush.labels.draft import Draft
from pointbrush.labels.effect import Effect


def derive(database: Database, draft: Draft, effect: Effect) -> None:
    """Bring the palette, the tracks, the counts and the frames' last changes up to date."""
    connection, number = draft.connection, draft.state.number
    set_labels = [label for label in draft.labels.values() if label is not None]
    fields = ("id", "name", "category", "color", "locked", "visible", "instance", "position")
    database.upsert(
        connection,
        schema.labels,
        [{"sequence": number, **{f: getattr(label, f) for f in fields}} for label in set_labels],
    )
    for gone in (label_id for label_id, label in draft.labels.items() if label is None):
        here = and_(schema.labels.c.sequence == number, schema.labels.c.id == gone)
        connection.execute(delete(schema.labels).where(here))
    database.upsert(
        connection,
        schema.tracks,
        [
            {"sequence": number, "frame": frame, "label": label, "data": data}
            for (frame, label), data in draft.tracks.items()
            if data is not None
        ],
    )
    table = schema.tracks.c
    gone_tracks = [
        {"at_frame": frame, "of_label": label}
        for (frame, label), data in draft.tracks.items()
        if data is None
    ]
    if gone_tracks:
        here = and_(
            table.sequence == number,
            table.frame == bindparam("at_frame"),
            table.label == bindparam("of_label"),
        )
        connection.execute(delete(schema.tracks).where(here), gone_tracks)
    database.upsert(
        connection,
        schema.counts,
        [
            {"sequence": number, "frame": f, "label": n, "points": a, "painted": b, "held": c}
            for (f, n), (a, b, c) in effect.counts.items()
        ],
    )
    database.upsert(
        connection,
        schema.frame_changes,
        [
            {"sequence": number, "frame": frame, "revision": draft.revision}
            for frame in effect.frames
        ],
    )
