"""The JSON schemas of REST; clients rely on their names."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from pointbrush.accounts.roles import Role
from pointbrush.labels import Commit
from pointbrush.labels.boxes.maps import LONGEST_SIDE
from pointbrush.names import HIDDEN
from pointbrush.sequences import Manifest
from pointbrush.streaming.messages import (
    Brush,
    Color,
    FrameIndex,
    Matrix4,
    Sample,
    Uuid,
    Vec3,
)
from pointbrush.work.annotate.splitting import Split
from pointbrush.work.deletion import Deleted
from pointbrush.work.listing import Listed

VISIBLE = f"[^{HIDDEN}]"
"""Pattern of a character that names may hold."""
Name = Annotated[str, Field(min_length=1, max_length=200, pattern=f"^{VISIBLE}+$")]
PaintId = Annotated[int, Field(ge=1, le=65534)]
Side = Annotated[float, Field(gt=0, le=LONGEST_SIDE, allow_inf_nan=False)]
Sides = Annotated[list[Side], Field(min_length=3, max_length=3)]
"""Length, width and height of a box, metres."""


def integral(body: Any) -> Any:
    """Return a body with 3.0 as 3: both are the same integer in JSON."""
    if isinstance(body, dict):
        return {name: integral(value) for name, value in body.items()}
    if isinstance(body, list):
        return [integral(item) for item in body]
    return int(body) if isinstance(body, float) and body.is_integer() else body


class Body(BaseModel):
    """Base of request bodies: unknown fields are refused, types are not coerced."""

    model_config = ConfigDict(extra="forbid", strict=True)
    _integral = model_validator(mode="before")(integral)


class Out(BaseModel):
    """Base of answers that are made from a workspace's objects with equal field names."""

    model_config = ConfigDict(from_attributes=True)

    @classmethod
    def of(cls, found: object) -> Self:
        """Return the answer for an object with attributes of these names."""
        return cls.model_validate(found)


class Bounds(BaseModel):
    """Axis-aligned bounds over all frames, source coordinates, metres."""

    lo: Vec3
    hi: Vec3


class SequenceOut(BaseModel):
    """A sequence's manifest."""

    id: str
    name: str
    frames: int
    fps: float
    points: list[int]
    bounds: Bounds
    fields: list[str]
    revision: int
    shift: Vec3
    room: Matrix4
    position_error: float
    dropped: list[int]
    large: bool
    source: str
    created: Annotated[datetime | None, Field(description="when it was imported")] = None
    changed: Annotated[
        datetime | None, Field(description="time of its last edit, or else of its import")
    ] = None
    labelled: Annotated[int, Field(description="number of frames with labelled points")] = 0
    labels: Annotated[int, Field(description="labels")] = 0
    labels_used: Annotated[int, Field(description="labels that have points in some frame")] = 0
    damaged: Annotated[str | None, Field(description="reason why it cannot be opened")] = None
    labels_missing: Annotated[
        str | None, Field(description="reason why the labels in its files were not imported")
    ] = None
    project: Annotated[str, Field(description="id of its project")] = "default"
    copy_of: Annotated[
        str | None, Field(description="the recording of which this is one person's copy")
    ] = None
    identity: Annotated[str | None, Field(description="id of this import")] = None
    deleted: Annotated[datetime | None, Field(description="when it was deleted")] = None
    until: Annotated[
        datetime | None, Field(description="end of the time in which it can be restored")
    ] = None

    @classmethod
    def listed(cls, entry: Listed) -> SequenceOut:
        """Return the answer for a listed recording; a damaged one may have only its id."""
        if entry.manifest is None:
            return cls.unreadable(entry.id, entry.revision, entry.damaged)
        changed = entry.progress.changed
        more = {
            "changed": None if changed is None else datetime.fromtimestamp(changed, UTC),
            "damaged": entry.damaged,
            "labelled": entry.progress.frames,
            "labels": entry.progress.labels,
            "labels_used": entry.progress.used,
            "labels_missing": entry.labels_missing,
            "project": entry.project,
            "copy_of": entry.copy_of,
        }
        return cls.of(entry.manifest, entry.revision, **more)

    @classmethod
    def removed(cls, entry: Deleted) -> SequenceOut:
        """Return the answer for a deleted recording."""
        known, manifest = entry.known, entry.manifest
        if manifest is None:
            out = cls.unreadable(known.id, known.revision, "its files are damaged or missing")
        else:
            out = cls.of(manifest, known.revision)
        times = {
            name: None if seconds is None else datetime.fromtimestamp(seconds, UTC)
            for name, seconds in (("deleted", known.deleted), ("until", known.until))
        }
        return out.model_copy(update={"id": known.id, "identity": known.identity, **times})

    @classmethod
    def unreadable(cls, sequence: str, revision: int, damaged: str | None) -> SequenceOut:
        """Return the answer for a recording with an unreadable manifest, without frames."""
        nowhere = [0.0, 0.0, 0.0]
        return cls(
            id=sequence, name=sequence, frames=0, fps=1.0, points=[], fields=[],
            bounds=Bounds(lo=nowhere, hi=nowhere), revision=revision, shift=nowhere,
            room=[float(i % 5 == 0) for i in range(16)], position_error=0.0, dropped=[],
            large=False, source="", damaged=damaged,
        )  # fmt: skip

    @classmethod
    def of(cls, manifest: Manifest, revision: int, **more: Any) -> SequenceOut:
        """Return the answer for a stored manifest, which has local bounds, and ``more`` fields."""
        shift = [float(x) for x in manifest.shift]
        lo, hi = (
            [float(x) + s for x, s in zip(corner, shift, strict=True)]
            for corner in (manifest.lo, manifest.hi)
        )
        created = datetime.fromisoformat(manifest.created)
        more["changed"] = more.get("changed") or created
        return cls(
            bounds=Bounds(lo=lo, hi=hi), revision=revision, shift=shift, room=manifest.room,
            id=manifest.id, name=manifest.name, frames=manifest.frames, fps=manifest.fps,
            points=list(manifest.points), fields=list(manifest.fields),
            position_error=manifest.position_error, dropped=list(manifest.dropped),
            large=manifest.large, source=manifest.source, identity=manifest.identity,
            created=created, **more,
        )  # fmt: skip


class SequencePatch(Body):
    """Changes of a recording."""

    name: Name | None = None
    fps: Annotated[float, Field(gt=0, le=1000, allow_inf_nan=False)] | None = None
    room: Matrix4 | None = None


class FloorBody(Body):
    """Rays to the floor in a frame, source coordinates, as a stroke's samples."""

    frame: FrameIndex
    samples: Annotated[list[Sample], Field(min_length=1, max_length=64)]


class LabelOut(Out):
    """An entry of the palette."""

    id: int
    name: str
    category: str
    color: Color
    locked: bool
    visible: bool


class CountedLabelOut(LabelOut):
    """An entry of the palette with the number of its points in all frames."""

    points: int


class LabelBody(Body):
    """A new label; the server chooses a missing ``id`` and ``color``.

    ``distinct``: replace a name or colour that is in use by a free one, for example "pin 2".
    """

    name: Name
    category: Annotated[str, Field(max_length=200, pattern=f"^{VISIBLE}*$")] = ""
    color: Color | None = None
    id: PaintId | None = None
    locked: bool = False
    visible: bool = True
    distinct: bool = False


class LabelPatch(Body):
    """Changes of a label; missing fields do not change."""

    name: Name | None = None
    category: Annotated[str, Field(max_length=200, pattern=f"^{VISIBLE}*$")] | None = None
    color: Color | None = None
    locked: bool | None = None
    visible: bool | None = None


class StrokeBody(Brush):
    """A whole stroke; the server applies an ``id`` once."""

    _integral = model_validator(mode="before")(integral)
    id: Uuid | None = None
    samples: Annotated[list[Sample], Field(max_length=65536, default_factory=list)]


class EditOut(BaseModel):
    """Result of an edit, which is durable."""

    edit: str
    changed: int
    revision: int

    @classmethod
    def of(cls, commit: Commit) -> EditOut:
        """Return the answer for a commit of the store."""
        return cls(edit=commit.edit_id, changed=commit.changed, revision=commit.revision)


class MergeBody(Body):
    """Labels to merge into another label."""

    labels: Annotated[list[PaintId], Field(min_length=1, max_length=1000)]


class SplitBody(Body):
    """Rule that divides a label's points in a frame into parts."""

    frame: FrameIndex
    gap: Annotated[float, Field(gt=0, le=100, allow_inf_nan=False)] | None = Field(
        None, description="metres between parts; null: more than the spacing of the points"
    )
    least: int = Field(
        10, ge=1, le=10**9, description="least points of a part; smaller parts stay with the label"
    )


class SplitOut(EditOut):
    """Result of a split: the new labels, and the gap between parts, metres."""

    labels: list[int]
    gap: float

    @classmethod
    def done(cls, split: Split) -> SplitOut:
        """Return the answer for the workspace's result."""
        edit = EditOut.of(split.commit).model_dump()
        return cls(**edit, labels=[label.id for label in split.labels], gap=split.gap)


class UndoBody(Body):
    """``id``: the UUID of the undo, which is applied once; ``edit``: the edit, null: the last."""

    id: Uuid | None = None
    edit: Uuid | None = None


class EditInfoOut(Out):
    """One line of the history."""

    id: str
    revision: int
    author: str
    time: datetime
    kind: str
    summary: str
    points: int
    frames: list[int]
    undone: bool


class ChunkOut(Out):
    """One row of a frame's chunk table; ``offset`` is into the frame's wire bytes.

    Position = ``origin + q * scale``, local metres; ``parent`` is the chunk above in an octree,
    -1 elsewhere.
    """

    index: int
    level: int
    first: int
    count: int
    offset: int
    nbytes: int
    origin: Vec3
    scale: Vec3
    lo: Vec3
    hi: Vec3
    parent: int


class ChunkTable(BaseModel):
    """All chunks of a frame."""

    frame: int
    points: int
    identity: Annotated[str, Field(description="of the import: makes a chunk's URL its own")]
    chunks: list[ChunkOut]


class SessionBody(Body):
    """Sign in with a token."""

    token: Annotated[str, Field(min_length=1, max_length=512)]


class SessionOut(BaseModel):
    """The signed-in person."""

    author: str
    role: Role


class MeOut(SessionOut):
    """The caller, and the messages that the server speaks."""

    model_config = ConfigDict(populate_by_name=True)

    schema_: Annotated[str, Field(alias="schema", description="hash of the socket's messages")]
    version: str


Command = Annotated[str, Field(min_length=1, max_length=128)]
CommandKey = Annotated[str, Field(min_length=1, max_length=32)]


class OwnKeysBody(Body):
    """Keyboard shortcuts of the caller, by the text of the command."""

    keys: Annotated[dict[Command, CommandKey], Field(max_length=256)]


class OwnKeysOut(BaseModel):
    """The keyboard shortcuts of the caller."""

    keys: Annotated[
        dict[str, str] | None, Field(description="null: the caller has never chosen any")
    ]


class Health(BaseModel):
    """The server is up."""

    status: Literal["ok"] = "ok"
    version: str


class Ready(BaseModel):
    """Whether the server can work, and the fault of each part, or "ok"."""

    status: Literal["ready", "not ready"]
    parts: dict[str, str]
