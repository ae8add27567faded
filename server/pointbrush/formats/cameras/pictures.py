"""Camera pictures of a recording: cameras, their projections, and ``cameras.json``."""

from __future__ import annotations

import io
import logging
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError, TooLargeError
from pointbrush.formats.cameras.images import opened
from pointbrush.formats.inside import is_inside
from pointbrush.formats.options import Limits
from pointbrush.formats.tables.parsing import parse_json
from pointbrush.formats.times.matching import FrameName, match
from pointbrush.names import stored_as

log = logging.getLogger(__name__)
Matrix = NDArray[np.float64]
FILE = "cameras.json"
ENDINGS = {"JPEG": ".jpg", "PNG": ".png", "WEBP": ".webp"}
"""Kinds of pictures that every browser shows, by Pillow's name; others are refused."""
MAX_BYTES = 64 * 2**20
"""Most bytes of one picture."""
MAX_CAMERAS = 64


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """Intrinsics, distortion and place of a camera.

    ``K`` (3, 3) pixels, ``distortion`` the coefficients of ``model`` (OpenCV's order for
    ``plumb_bob``), ``T_camera_frame`` (4, 4) from the frame's points to the camera, z ahead and y
    down.  Unknown values are None: such pictures are shown, but no points project into them.
    """

    name: str
    K: Matrix | None = None
    T_camera_frame: Matrix | None = None
    distortion: tuple[float, ...] = ()
    model: str = "plumb_bob"


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """An unchanged picture of a frame; ``ending`` is of its kind, sizes are in pixels."""

    frame: int
    camera: Camera
    content: bytes
    ending: str
    width: int
    height: int


@dataclass(frozen=True, slots=True)
class PictureSource:
    """The pictures of a recording: its cameras, and all pictures, in any order."""

    cameras: tuple[Camera, ...]
    pictures: Callable[[], Iterator[Picture]]


def picture(frame: int, camera: Camera, content: bytes, name: str) -> Picture:
    """Return the picture in ``content``; raise BadInputError, naming ``name``, if it is none."""
    with opened(name, io.BytesIO(content), "a picture") as image:
        (width, height), kind = image.size, image.format or ""
    if kind not in ENDINGS:
        raise BadInputError(f"{name}: expected a JPEG, PNG or WebP picture, got {kind}")
    return Picture(frame, camera, content, ENDINGS[kind], width, height)


def projecting(name: str, P: Matrix, T_camera_frame: Matrix | None) -> Camera:
    """Return the camera of a projection P (3, 4); the last column of P moves the camera."""
    K, moved = P[:, :3], np.eye(4)
    moved[:3, 3] = np.linalg.solve(K, P[:, 3])
    return Camera(name, K, None if T_camera_frame is None else moved @ T_camera_frame)


def of_files(
    base: Path, rows: Sequence[Mapping[Camera, Path]], cameras: Sequence[Camera], limits: Limits
) -> PictureSource | None:
    """Return pictures in files, for each frame by camera, or None without any.

    Files must be, with links followed, in ``base`` (and in ``limits.roots``).
    """
    if not any(rows):
        return None
    roots = (base.resolve(),)

    def read_one(index: int, camera: Camera, path: Path) -> Picture:
        if not all(is_inside(path.absolute(), each) for each in (roots, limits.roots) if each):
            raise BadInputError(f"{path.name}: expected a picture within {base.name}")
        return picture(index, camera, _content(path), path.name)

    return PictureSource(
        tuple(cameras),
        lambda: readable(
            partial(read_one, index, camera, path)
            for index, row in enumerate(rows)
            for camera, path in row.items()
        ),
    )


def readable(pictures: Iterable[Callable[[], Picture]]) -> Iterator[Picture]:
    """Yield the readable pictures; a warning counts the others."""
    failed, first = 0, ""
    for read in pictures:
        try:
            yield read()
        except (BadInputError, TooLargeError) as error:
            failed, first = failed + 1, first or str(error)
    if failed:
        log.warning("%d picture(s) of cameras are left out; the first: %s", failed, first)


def _content(path: Path) -> bytes:
    try:
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise TooLargeError(
                f"{path.name}: expected a picture of at most {MAX_BYTES:,} bytes, got {size:,}"
            )
        return path.read_bytes()
    except OSError as error:
        raise BadInputError(f"{path.name}: expected a picture, {error.strerror}") from None


def joined(
    sources: Sequence[tuple[PictureSource | None, int]], scale: float = 1.0
) -> PictureSource | None:
    """Return the pictures of consecutive recordings, each of a number of frames.

    ``scale``: scale of the points, which applies to the places of cameras as well.
    """
    found = [source for source, _ in sources if source is not None]
    if not found:
        return None

    def read() -> Iterator[Picture]:
        first = 0
        for source, count in sources:
            for each in source.pictures() if source is not None else ():
                camera = each.camera if scale == 1.0 else _scaled(each.camera, scale)
                yield replace(each, frame=each.frame + first, camera=camera)
            first += count

    return PictureSource(found[0].cameras, read)


def moved(source: PictureSource | None, T_frame_new: Matrix) -> PictureSource | None:
    """Return the pictures for frames whose points are moved to new coordinates."""
    if source is None or np.array_equal(T_frame_new, np.eye(4)):
        return source
    cameras = {
        each.name: each
        if each.T_camera_frame is None
        else replace(each, T_camera_frame=each.T_camera_frame @ T_frame_new)
        for each in source.cameras
    }
    return PictureSource(
        tuple(cameras.values()),
        lambda: (replace(p, camera=cameras[p.camera.name]) for p in source.pictures()),
    )


def _scaled(camera: Camera, scale: float) -> Camera:
    if camera.T_camera_frame is None:
        return camera
    moved = camera.T_camera_frame.copy()
    moved[:3, 3] *= scale
    return replace(camera, T_camera_frame=moved)


# ── cameras.json ─────────────────────────────────────────────────────────────────────────────


def read_cameras_file(path: Path, names: Sequence[str], limits: Limits) -> PictureSource | None:
    """Read a ``cameras.json`` beside frames in files called ``names``.

    ``{"cameras": [{"name", "K", "distortion", "T_camera_frame", "files"}]}``: ``files`` lists a
    picture (or null) for each frame, or maps names of frames to pictures; paths are relative to
    the file.  Raises BadInputError naming an invalid entry.
    """
    try:
        content = parse_json(path.read_bytes())
    except ValueError as error:
        raise BadInputError(f"{FILE}: expected JSON, {error}") from None
    entries = content.get("cameras") if isinstance(content, dict) else content
    if isinstance(entries, dict):
        entries = [{"name": name, **entry} for name, entry in entries.items()]
    if not isinstance(entries, list) or not all(isinstance(each, dict) for each in entries):
        raise BadInputError(f"{FILE}: expected a list of cameras")
    if len(entries) > MAX_CAMERAS:
        raise TooLargeError(f"{FILE}: expected at most {MAX_CAMERAS} cameras, got {len(entries)}")
    cameras: list[Camera] = []
    rows: list[dict[Camera, Path]] = [{} for _ in names]
    for number, entry in enumerate(entries):
        where = f"{FILE}: camera {number}"
        camera = _camera(where, entry)
        if camera.name in [each.name for each in cameras]:
            raise BadInputError(f"{where}: expected a name of its own, got {camera.name!r} again")
        cameras.append(camera)
        for index, file in _files_of(where, entry.get("files"), names):
            rows[index][camera] = stored_as(path.parent / file)
    return of_files(path.parent, rows, cameras, limits)


def _camera(where: str, entry: Mapping[str, Any]) -> Camera:
    name = entry.get("name")
    if not isinstance(name, str) or not 0 < len(name) <= 200 or "/" in name:
        raise BadInputError(f"{where}: expected a name without '/', got {name!r}")
    distortion = _numbers(where, "distortion", entry.get("distortion") or [])
    K = entry.get("K", entry.get("intrinsics"))
    if isinstance(K, dict):
        K = _of_focal_lengths(where, K)
    return Camera(
        name,
        None if K is None else _shaped(where, "K", K, 3),
        None
        if entry.get("T_camera_frame") is None
        else _shaped(where, "T_camera_frame", entry["T_camera_frame"], 4),
        tuple(distortion.tolist()),
        str(entry.get("model", "plumb_bob"))[:60],
    )


def _of_focal_lengths(where: str, given: Mapping[str, Any]) -> list[Any]:
    missing = [key for key in ("fx", "fy", "cx", "cy") if key not in given]
    if missing:
        raise BadInputError(f"{where}: expected intrinsics fx, fy, cx, cy, got no {missing[0]}")
    return [given["fx"], 0, given["cx"], 0, given["fy"], given["cy"], 0, 0, 1]


def _numbers(where: str, key: str, value: object) -> Matrix:
    try:
        numbers = np.array(value, np.float64).ravel()
    except (TypeError, ValueError):
        numbers = np.array([np.nan])
    if numbers.size > 64 or not np.isfinite(numbers).all():
        raise BadInputError(f"{where}: expected {key} in numbers, got something else")
    return numbers


def _shaped(where: str, key: str, value: object, side: int) -> Matrix:
    numbers = _numbers(where, key, value)
    if numbers.size != side * side:
        raise BadInputError(f"{where}: expected {key} as {side}x{side} numbers, got {numbers.size}")
    return numbers.reshape(side, side)


def _files_of(where: str, given: object, names: Sequence[str]) -> Iterator[tuple[int, str]]:
    """Frame and file of the pictures that an entry lists."""
    if isinstance(given, dict):
        try:
            frames = match(list(given), [FrameName(name) for name in names])
        except BadInputError as error:
            raise BadInputError(f"{where}: {str(error).partition(';')[0]}") from None
        pairs = list(zip(frames, given.values(), strict=True))
    elif isinstance(given, list):
        if len(given) != len(names):
            raise BadInputError(
                f"{where}: expected a file for each of {len(names)} frames, got {len(given)}"
            )
        pairs = list(enumerate(given))
    else:
        raise BadInputError(f"{where}: expected files, a list with one for each frame")
    for index, file in pairs:
        if file is None:
            continue
        if not isinstance(file, str) or Path(file).is_absolute() or ".." in Path(file).parts:
            raise BadInputError(f"{where}: expected files below the folder of {FILE}, got {file!r}")
        yield index, file
