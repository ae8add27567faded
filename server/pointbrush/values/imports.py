"""Imports of recordings and labels, and their previews."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal

from pointbrush.values.base import Body, Meanings, Repeated, Rule, Value, integral
from pointbrush.values.kinds import MOST_SENSORS, Name, SensorType, SequenceName, Uuid
from pointbrush.values.recordings import Rate

MOST_COLUMNS = 1024
LARGEST_SCALE = 1e6
LISTS = ("columns", "sensor", "clock_offset")
"""Options that may also be one text with commas."""
ColumnName = Annotated[str, Rule(min_length=1, max_length=200)]
ImportedBoxes = Annotated[
    Literal["both", "keep", "points"],
    Meanings(
        {
            "both": "keep boxes, and label the points inside",
            "keep": "keep boxes",
            "points": "label the points inside boxes",
        }
    ),
]
Text = Annotated[str, Rule(min_length=1, max_length=4096, pattern=r"^[^\x00]+$")]


Sensors = Annotated[
    Literal["one", "all"],
    Meanings({"one": "the main sensor", "all": "all sensors, as one recording"}),
]


@dataclass(frozen=True, slots=True)
class ImportOptions(Body):
    """Corrections by a person to an import's files; null: as found in the files."""

    name: Name | None = None
    """Name of the recording; null: of the file or folder."""
    fps: Rate | None = None
    """Frames per second of playback, at most 1000."""
    format: str | None = None
    """Format of the files, such as ``ply``; null: detected."""
    columns: Annotated[tuple[ColumnName, ...], Rule(max_length=MOST_COLUMNS)] | None = None
    """Meanings of the columns in their order: x,y,z,intensity,red,green,blue,label,instance, or
    ``-`` for a column to leave out; or pairs: ``scalar_Foo=label``; also one text with commas."""
    delimiter: str | None = None
    """Separator of the columns of text files: one character, or comma, semicolon, tab, space or
    pipe."""
    decimal_comma: bool | None = None
    """Numbers in text files have a decimal comma: 1,5 is one and a half."""
    scale: Annotated[float, Rule(gt=0, le=LARGEST_SCALE, allow_inf_nan=False)] | None = None
    """Metres per unit of the files and their poses: 0.001 for millimetres; null: 1."""
    up: Annotated[str, Rule(pattern=r"^\+?(x|y|z|-x|-y|-z)$")] | None = None
    """Axis of the coordinates that points up, such as ``z`` or ``-y`` (``--up=-y``)."""
    topic: Annotated[str, Rule(min_length=1, max_length=1000), Repeated] | None = None
    """Topic of a bag to read; ``topic#frame_id`` if sensors share a topic; several, also as one
    text with commas: the topics of the sensors of one recording, the reference first."""
    sensors: Sensors = "one"
    """Sensors of a bag or a dataset to read."""
    sensor: Annotated[tuple[Text, ...], Rule(max_length=MOST_SENSORS), Repeated] | None = None
    """Sensors of one recording, each ``NAME=PATH``, the reference first; paths are within the
    imported path, if there is one."""
    extrinsics: Text | None = None
    """File in JSON with the mount ``T_frame_sensor`` of each sensor by name, 16 numbers by rows."""
    clock_offset: Annotated[tuple[Text, ...], Rule(max_length=MOST_SENSORS), Repeated] | None = None
    """Seconds to add to the times of a sensor: ``NAME=SECONDS``, or ``NAME=auto`` to estimate them
    from motion that it and the reference see."""
    poses: Text | None = None
    """``auto``, ``viewpoint`` of PCD files, ``none``, or a file of poses, one line per frame."""
    by_order: bool = False
    """Match poses with times, and colour images, to frames by their order."""
    drop_invalid: bool = False
    """Leave out points without finite coordinates instead of refusing the files."""
    project: SequenceName = "default"
    """Id of the project that the recording joins."""
    id: Uuid | None = None
    """UUID of the job: a repeated call does not begin another job."""

    @classmethod
    def prepared(cls, value: Any) -> Any:
        """Also accept lists as one text with commas, and several topics as a list."""
        if isinstance(value, dict):
            texts = {name: text for name in LISTS if isinstance(text := value.get(name), str)}
            value = value | {n: [part.strip() for part in t.split(",")] for n, t in texts.items()}
            if isinstance(topics := value.get("topic"), list):
                value["topic"] = ",".join(map(str, topics))
        return integral(value)


@dataclass(frozen=True, slots=True)
class ImportRequest(ImportOptions):
    """Files to import that the server can already read."""

    path: Text | None = None
    """Path on the server, below one of its allowed folders; or ``upload``, or only ``sensor``."""
    upload: Annotated[str, Rule(pattern="^[0-9a-f]{32}$")] | None = None
    """Id of files that were uploaded for a preview; or ``path``."""


@dataclass(frozen=True)
class LabelOptions(Value):
    """Choices on how label files are read."""

    format: str | None = None
    """Format of the label files; null: detected."""
    no_ground: bool = False
    """Leave the ground inside boxes without the box's label."""
    by_order: bool = False
    """Match files to frames by their order instead of their names."""
    allow_empty: bool = False
    """Accept files that label nothing, which are an error otherwise."""
    field: Annotated[str, Rule(min_length=1, max_length=200)] | None = None
    """Field of the points that holds the labels; null: detected."""
    boxes: ImportedBoxes = "both"
    """Result of imported boxes."""


@dataclass(frozen=True, kw_only=True)
class LabelImportOptions(LabelOptions, Body):
    """Label files to import as one edit."""

    map: Annotated[str, Rule(max_length=1 << 20)] | None = None
    """Names of classes as JSON, YAML, XML of point_labeler, or lines ``number name``."""
    id: Uuid | None = None
    """UUID of the job: a repeated call does not begin another job."""


@dataclass(frozen=True, kw_only=True)
class LabelImportRequest(LabelImportOptions):
    """Label files that the server can already read."""

    path: Text
    """Path on the server, below one of its allowed folders."""


@dataclass(frozen=True, slots=True)
class FolderRequest(Body):
    """A folder on the server."""

    path: Text
    """Path of the folder, below one of the allowed folders."""


@dataclass(frozen=True, slots=True)
class FolderImport(FolderRequest):
    """A folder on the server; each file or folder in it is a recording."""

    fps: Rate | None = None
    """Frames per second of playback; null: as found in the files."""


@dataclass(frozen=True, slots=True)
class Entry(Value):
    """A file or folder in a folder on the server."""

    name: str
    """Name of the entry."""
    path: str
    """Path on the server."""
    bytes: int
    """Size of the file, or of all files in the folder."""


@dataclass(frozen=True, slots=True)
class FileFrame(Value):
    """A file, and the frame that it is or belongs to."""

    file: str
    """Path of the file."""
    frame: int
    """Number of the frame."""


@dataclass(frozen=True, slots=True)
class PreviewedFrame(Value):
    """Points of a frame that a preview has read."""

    points: int
    """Number of points."""
    left_out: int
    """Number of points without a position, which are left out."""


@dataclass(frozen=True, slots=True)
class PreviewedColumn(Value):
    """A column of the points."""

    name: str
    """Name in the file."""
    meaning: str
    """Meaning, such as ``x``; empty: left out."""


@dataclass(frozen=True, slots=True)
class PreviewedTopic(Value):
    """A topic of a bag."""

    name: str
    """Name of the topic."""
    type: str
    """Type of its messages."""
    messages: int
    """Number of its messages."""
    clouds: bool
    """Its messages are point clouds."""
    read: bool
    """The import reads it."""


@dataclass(frozen=True, slots=True)
class PreviewedSensor(Value):
    """One of several sensors of a recording, and the joining of its frames by time."""

    name: str
    """Name of the sensor."""
    type: SensorType
    """Type of the sensor."""
    joined: int
    """Number of its frames that are joined with frames of the reference."""
    left_out: int
    """Number of its other frames."""
    apart: float | None
    """Median seconds between frames that are joined; null: they are joined in their order."""


@dataclass(frozen=True, slots=True)
class PreviewedPoses(Value):
    """Poses of the frames."""

    source: str
    """Place where they were found."""
    agree: bool | None
    """Frames agree better with them than without; null: not measured."""


@dataclass(frozen=True, slots=True)
class UnitGuess(Value):
    """Estimated unit of the files."""

    name: str
    """Name of the unit."""
    scale: float
    """Metres per unit."""
    extent: tuple[float, float, float]
    """Width of the middle 96 % of the first frame's points along each axis, in units."""


@dataclass(frozen=True, slots=True)
class Preview(Value):
    """Preview of an import of files: the frames, fields and labels that it would store."""

    name: str
    """Name that the recording would get."""
    format: str
    """Format of the files."""
    title: str
    """Format that people see."""
    frames: int | None
    """Number of frames; null: unknown before the whole is read."""
    fps: float
    """Frames per second of playback."""
    fps_from: str
    """Source of ``fps``."""
    order: str
    """Rule that orders the frames."""
    files: tuple[FileFrame, ...]
    """Frame of each file, the first hundred."""
    points: tuple[PreviewedFrame, ...]
    """Points of the first frames."""
    columns: tuple[PreviewedColumn, ...]
    """Columns of the points."""
    topics: tuple[PreviewedTopic, ...]
    """Topics of a bag."""
    cameras: tuple[dict[str, Any], ...]
    """``name`` of each camera with pictures."""
    sensors: tuple[PreviewedSensor, ...]
    """Sensors of a recording of several, the reference first."""
    poses: PreviewedPoses | None
    """Poses of the frames; null: none."""
    units: UnitGuess
    """Unit of the coordinates."""
    up: str
    """Axis that points up."""
    up_from: str
    """Source of ``up``."""
    labels: bool
    """The files contain labels."""
    corrections: dict[str, Any]
    """Corrections of the request that take effect."""
    warnings: tuple[str, ...]
    """Sentences about doubtful content."""


@dataclass(frozen=True, slots=True)
class ImportPreview(Preview):
    """Preview of an import with its uploaded files."""

    upload: str | None = None
    """Id of the uploaded files, which are kept for an hour; null: files of the server."""


@dataclass(frozen=True, slots=True)
class ImportedSensor(Value):
    """One of several sensors of an imported recording."""

    name: str
    """Name of the sensor."""
    type: SensorType
    """Type of the sensor."""
    frames: int
    """Number of frames with points of it."""


@dataclass(frozen=True, slots=True)
class ImportedRecording(Value):
    """Result of an import of a recording."""

    up: str
    """Axis that points up."""
    up_from: str
    """Source of ``up``."""
    sequence: str
    """Id of the recording."""
    frames: int
    """Number of frames."""
    fps: float
    """Frames per second of playback."""
    points: int
    """Number of points of all frames."""
    dropped: int
    """Number of points without a position, which were left out."""
    warnings: tuple[str, ...]
    """Sentences about doubtful content."""
    sensors: tuple[ImportedSensor, ...] = ()
    """Sensors of a recording of several."""


@dataclass(frozen=True, slots=True)
class LabelledFrame(FileFrame):
    """A frame with labels from a file."""

    points: int
    """Number of labelled points."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ImportedLabels(Value):
    """Result of an import of labels, or of its trial; lists have the first hundred entries."""

    labelled: int = 0
    """Number of labelled points in the files."""
    doubtful: int = 0
    """Number of points at the borders of masks, which stay as they are."""
    frames: tuple[LabelledFrame, ...] = ()
    """Frames with labels, each with its file."""
    files: tuple[FileFrame, ...] = ()
    """All files that match a frame."""
    matched: int = 0
    """Number of frames with labels."""
    unknown: int = 0
    """Number of classes without a name."""
    unknown_classes: tuple[int, ...] = ()
    """Numbers of classes without a name."""
    unmatched: int = 0
    """Number of frames without labels and of files without a frame."""
    unmatched_frames: tuple[int, ...] = ()
    """Numbers of frames without labels."""
    unmatched_files: tuple[str, ...] = ()
    """Files without a frame."""
    labels: Mapping[str, int] = field(default_factory=dict)
    """Number of labelled points, by id of the label."""
    new_labels: tuple[str, ...] = ()
    """Names of the new labels."""
    boxes: int = 0
    """Number of new boxes."""
    box_poses: int = 0
    """Number of poses of new boxes."""
    box_poses_known: int = 0
    """Number of poses that a label already has."""
    boxes_resized: tuple[str, ...] = ()
    """Objects whose sizes differ between frames: their box has the median size."""
    boxes_empty: int = 0
    """Number of boxes with a side of 0, which are left out."""
    warnings: tuple[str, ...] = ()
    """Sentences about doubtful content."""
    locked: tuple[str, ...] = ()
    """Names of locked labels that keep points which the files label otherwise."""
    edit: str | None = None
    """UUID of the edit; null: none was made."""
    changed: int = 0
    """Number of points with a new label."""
    refused: str = ""
    """Reason why the files label nothing; empty: they label something."""
