"""The manifest: the properties of a sequence in one JSON file; other files never change."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from datetime import UTC, datetime
from functools import cache
from hashlib import blake2b
from math import isfinite
from pathlib import Path
from types import UnionType
from typing import Any, Literal, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.names import composed, require_visible
from pointbrush.sequences.depth.lattice import DEPTH_FORMAT, Lattice, lattice_of
from pointbrush.sequences.storage.files import replace_file
from pointbrush.sequences.storage.sensors import Matrix, StoredSensor, require_rigid, sensor_of

FILE = "manifest.json"
VERSION = 8
"""1 keeps all arrays of frames plain, 2 packs them, 3 may have a lattice, 4 packs the source's
further fields like arrays, and the coordinates of octrees, 5 has the format of depth images, 6 the
names of classes of labels that are words, and the files of frames, 7 the meaning of numbers of
labels, and the scale, 8 several sensors; all are read."""
_ONE_SENSOR = 7
"""Version of the manifest of a recording of one sensor, which older servers read."""


@dataclass(frozen=True, slots=True)
class Manifest:
    """Manifest of a sequence.

    ``points``          points per frame; ``dropped`` invalid points left out per frame.
    ``fields``          of ``xyz``, ``rgb``, ``intensity``, ``label``, ``instance``, ``pixel``:
                        the fields of at least one frame.
    ``shift``           local = source − shift, metres.
    ``lo``, ``hi``      bounds over all frames, local.
    ``room``            ``T_room_local``, row-major 4x4: places it on the floor, y up.
    ``found_room``      ``room`` as the import found it.
    ``position_error``  greatest difference per axis between a streamed coordinate and the stored
                        one, metres; for a large frame that of its coarsest chunk.
    ``color_error``     greatest root mean square difference of a frame's streamed colours and the
                        stored ones, of 255; only pictures of depth cameras differ.
    ``lattice``         pixels that the frames' points lie on, or None; ``unit`` and ``eye`` local.
    ``depth_format``    version of the bytes of the frames' depth images, where they have some.
    ``intensity_range`` source values that stream as 0 and 255, or None.
    ``poses``           ``T_world_frame`` per frame, row-major 4x4 or None.
    ``timestamps``      seconds per frame, or None; ``viewpoints`` sensor positions, source.
    ``large``           a frame is an octree of chunks.
    ``classes``         names of the labels 1, 2, … if the files have words for labels.
    ``dataset``         dataset that defines the numbers of labels, "" if it is unknown.
    ``palette``         palette of the labels' ids if the files are an export of pointbrush:
                        fields of ``formats.palette.SourceLabel``.
    ``scale``           metres for a unit of the source's coordinates.
    ``project``         id of the project of the import, "" where it named none; the database tells
                        the present one, and takes this for a recording that it does not know yet.
    ``files``           name of the file that each frame came from, ``places`` its place among the
                        frames of that file; both empty where an older import did not keep them.
    ``sensors``         sensors of a recording of several, in the order of their numbers, else [].
    ``created``         date of the import, or of the copy.
    ``imported_as``     ``id`` at the import: a restored recording may have got another one.
    """

    id: str
    name: str
    frames: int
    fps: float
    points: list[int]
    fields: list[str]
    shift: list[float]
    lo: list[float]
    hi: list[float]
    room: Matrix
    found_room: Matrix
    position_error: float
    color_error: float
    lattice: Lattice | None
    depth_format: int
    intensity_range: list[float] | None
    dropped: list[int]
    poses: list[Matrix | None]
    timestamps: list[float | None]
    viewpoints: list[list[float] | None]
    source: str
    large: bool
    created: str
    imported_as: str
    classes: list[str]
    files: list[str]
    places: list[int]
    dataset: str
    palette: list[dict[str, Any]]
    scale: float
    project: str
    sensors: list[StoredSensor] = field(default_factory=list)

    @property
    def identity(self) -> str:
        """16 hex digits that differ for every import, also for another import of the same id."""
        facts = [self.imported_as, self.created, self.source, self.lo, self.hi]
        return blake2b(json.dumps(facts).encode(), digest_size=8).hexdigest()

    @property
    def placement(self) -> str:
        """Name of the import and of its corrected mounts: a key of values made from positions."""
        corrections = [sensor.correction for sensor in self.sensors]
        if not any(sensor.corrected for sensor in self.sensors):
            return self.identity
        digest = blake2b(json.dumps(corrections).encode(), digest_size=8).hexdigest()
        return f"{self.identity}-{digest}"

    @property
    def bounds(self) -> tuple[list[float], list[float]]:
        """Bounds over all frames, local, which hold all points also by corrected mounts."""
        shifts = [sensor.greatest_shift() for sensor in self.sensors if sensor.corrected]
        most = np.max(shifts, axis=0) if shifts else np.zeros(3)
        return np.subtract(self.lo, most).tolist(), np.add(self.hi, most).tolist()

    @property
    def depth_lattice(self) -> Lattice | None:
        """The lattice of depth images that can be sent, or None."""
        return self.lattice if self.sends_depth else None

    @property
    def sends_depth(self) -> bool:
        """Return whether the frames' depth images, if they have some, can be sent."""
        return self.depth_format == DEPTH_FORMAT

    @property
    def T_room_local(self) -> NDArray[np.float64]:  # noqa: N802 - named for its direction
        """``room`` as a (4, 4) array."""
        return np.array(self.room).reshape(4, 4)

    @property
    def T_found_room_local(self) -> NDArray[np.float64]:  # noqa: N802 - named for its direction
        """``found_room`` as a (4, 4) array."""
        return np.array(self.found_room).reshape(4, 4)


def checksum(content: dict[str, Any]) -> str:
    """Return the checksum that a manifest contains of its other content."""
    text = json.dumps(content, sort_keys=True, separators=(",", ":"))
    return blake2b(text.encode(), digest_size=16).hexdigest()


def now() -> str:
    """Return the current date to the microsecond, from which an import's identity is derived."""
    return datetime.now(UTC).isoformat(timespec="microseconds")


def encode_manifest(manifest: Manifest) -> bytes:
    """The manifest's file, which carries a checksum of itself."""
    content = {"version": VERSION, **asdict(manifest)}
    if not manifest.sensors:
        content["version"] = _ONE_SENSOR
        del content["sensors"]
    return json.dumps(content | {"checksum": checksum(content)}, indent=1).encode()


def read_manifest(path: Path) -> Manifest:
    """The manifest of the sequence in folder ``path``.

    Raises NotFoundError when there is none, BadInputError when it is damaged.
    """
    try:
        data = (path / FILE).read_bytes()
    except FileNotFoundError as error:
        raise NotFoundError(f"expected a sequence in {path.name}, got no {FILE}") from error
    return parse_manifest(data, path.name)


def parse_manifest(data: bytes, name: str) -> Manifest:
    """Return the manifest in the bytes of its file in folder ``name``; raises BadInputError."""
    name = f"{name}/{FILE}"
    try:
        content = json.loads(data)
    except ValueError as error:
        raise BadInputError(f"{name}: expected a manifest in JSON, got {error}") from error
    found = content.get("version") if isinstance(content, dict) else None
    if found not in range(1, VERSION + 1):
        raise BadInputError(
            f"{name}: expected a manifest of version 1 to {VERSION}, got {found}"
            + (", of a newer pointbrush" if isinstance(found, int) and found > VERSION else "")
        )
    given = content.pop("checksum", None)
    if given != checksum(content):
        raise BadInputError(f"{name}: expected manifest checksum {given}, got another")
    try:
        manifest = _of_any_version(content)
    except (KeyError, TypeError, AttributeError) as error:
        raise BadInputError(f"{name}: expected all fields of a manifest, got {error!r}") from None
    _require_sound(manifest, name)
    return manifest


def _of_any_version(content: dict[str, Any]) -> Manifest:
    # Manifests written before rooms could be corrected have no room as found; manifests written
    # before recordings could be restored under another id have no first id.
    content.setdefault("found_room", content["room"])
    content.setdefault("imported_as", content["id"])
    content.setdefault("color_error", 0.0)
    content.setdefault("depth_format", 1)
    # Older imports left out labels in words.
    content.setdefault("classes", [])
    content.setdefault("files", _files_of(content))
    content.setdefault("places", [0] * len(content["files"]))
    content.setdefault("dataset", "")
    content.setdefault("palette", [])
    content.setdefault("scale", 1.0)
    content.setdefault("project", "")
    content["lattice"] = lattice_of(content.get("lattice"))
    content["sensors"] = [sensor_of(each) for each in content.get("sensors", [])]
    return Manifest(**{each.name: content[each.name] for each in fields(Manifest)})


def _require_sound(manifest: Manifest, name: str) -> None:
    """Raise BadInputError unless each field has a value of its type, and each frame its points."""
    for checked, types in (
        (manifest, _types(Manifest)),
        *((s, _types(StoredSensor)) for s in manifest.sensors),
    ):
        for key, kind in types.items():
            if not _fits(getattr(checked, key), kind):
                raise BadInputError(f"{name}: expected {key} of type {kind}")
    if manifest.frames != len(manifest.points) or min(manifest.points, default=0) < 0:
        raise BadInputError(f"{name}: expected the points of {manifest.frames} frames")
    if (len(manifest.room), len(manifest.found_room)) != (16, 16):
        raise BadInputError(f"{name}: expected 16 numbers of room")


@cache
def _types(checked: type) -> dict[str, Any]:
    return get_type_hints(checked)


def _fits(value: Any, kind: Any) -> bool:
    """Return whether a value from JSON is of an annotated type."""
    if isinstance(kind, UnionType):
        return any(_fits(value, each) for each in get_args(kind))
    if get_origin(kind) is list:
        (item,) = get_args(kind)
        return isinstance(value, list) and all(_fits(each, item) for each in value)
    if get_origin(kind) is Literal:
        return value in get_args(kind)
    if kind is float and isinstance(value, int | float):
        return not isinstance(value, bool) and isfinite(value)
    return kind is Any or isinstance(value, get_origin(kind) or kind)


def _files_of(content: dict[str, Any]) -> list[str]:
    """Derive the names of files from the source of an older import, where it lists one a frame."""
    names = [Path(source).name for source in content["source"].split(", ")]
    return names if len(names) == content["frames"] and all(names) else []


def rename_sequence(path: Path, sequence: str) -> Manifest:
    """Give the copy of a recording in folder ``path`` a new id and a new identity.

    It counts as imported now: caches, unsent edits and labels are keyed by the identity.
    """
    manifest = replace(read_manifest(path), id=sequence, created=now())
    replace_file(path / FILE, encode_manifest(manifest))
    return manifest


def note_import(path: Path, **noted: Any) -> None:
    """Add facts of the import to the manifest of the recording in folder ``path``.

    ``noted``: its fields ``dataset``, ``palette``, ``scale`` and ``project``.
    """
    manifest = replace(read_manifest(path), **noted)
    replace_file(path / FILE, encode_manifest(manifest))


def update_manifest(path: Path, **fields: Any) -> Manifest:
    """Change the mutable fields of an imported sequence in one step; see ``changed_manifest``."""
    manifest = changed_manifest(read_manifest(path), **fields)
    replace_file(path / FILE, encode_manifest(manifest))
    return manifest


def changed_manifest(
    manifest: Manifest,
    *,
    id: str | None = None,
    name: str | None = None,
    fps: float | None = None,
    room: NDArray[np.float64] | None = None,
    corrections: Sequence[NDArray[np.float64]] | None = None,
) -> Manifest:
    """Return a manifest with the given fields changed.

    ``room`` is ``T_room_local`` (4, 4), affine and invertible.  ``corrections``: that of each
    sensor's mount, (4, 4), rigid.  Raises BadInputError for an empty name, a rate that is not
    positive and finite, or another matrix.
    """
    if id is not None:
        manifest = replace(manifest, id=id)
    if name is not None:
        if not name.strip():
            raise BadInputError("name: expected some text, got none")
        require_visible("name", name)
        manifest = replace(manifest, name=composed(name))
    if fps is not None:
        if not (np.isfinite(fps) and fps > 0):
            raise BadInputError(f"fps: expected a positive number, got {fps}")
        manifest = replace(manifest, fps=float(fps))
    if room is not None:
        manifest = replace(manifest, room=_check_room(room))
    if corrections is not None:
        manifest = replace(manifest, sensors=_corrected(manifest.sensors, corrections))
    return manifest


def _corrected(
    sensors: Sequence[StoredSensor], corrections: Sequence[NDArray[np.float64]]
) -> list[StoredSensor]:
    if len(corrections) != len(sensors):
        raise BadInputError(
            f"corrections: expected one for each of {len(sensors)} sensors, got {len(corrections)}"
        )
    return [
        replace(
            sensor,
            correction=require_rigid(f"correction of {sensor.name}", correction),
            previous=sensor.correction,
        )
        for sensor, correction in zip(sensors, corrections, strict=True)
    ]


def _check_room(room: NDArray[np.float64]) -> Matrix:
    matrix = np.asarray(room, np.float64)
    if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
        raise BadInputError(f"room: expected a finite 4x4 matrix, got shape {matrix.shape}")
    if (matrix[3] != (0, 0, 0, 1)).any() or abs(np.linalg.det(matrix[:3, :3])) < 1e-12:
        raise BadInputError("room: expected an affine, invertible matrix, got another")
    return [float(value) for value in matrix.ravel()]
