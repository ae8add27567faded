"""Camera pictures of a recording's frames, stored unchanged.

Under ``cameras/``: ``NNNNNN.json`` lists the pictures of a frame with their projections, and
``NNNNNN.CC.jpg`` (``.png``, ``.webp``) is that of its camera CC.  A recording without that folder,
or a frame without a file there, has none.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pointbrush.errors import DamagedError, NotFoundError
from pointbrush.sequences.octree.arrays import digest
from pointbrush.sequences.storage.files import write_file
from pointbrush.values.frames import Camera

if TYPE_CHECKING:
    from pointbrush.formats.cameras.pictures import Picture

CAMERAS = "cameras"
MEDIA_TYPES = {".jpg": "image/jpeg", ".png": "image/png", ".webp": "image/webp"}


@dataclass(frozen=True, slots=True)
class Projection(Camera):
    """A picture of a frame and its camera; ``file``: name of the picture in ``cameras/``."""

    file: str


def write_pictures(folder: Path, frames: int, pictures: Iterable[Picture]) -> dict[str, str]:
    """Keep pictures of the first ``frames`` frames; returns checksums by path in ``folder``."""
    place = folder / CAMERAS
    place.mkdir()
    rows: dict[int, list[Projection]] = {}
    checksums = {}
    for each in pictures:
        if not 0 <= each.frame < frames:
            continue
        row = rows.setdefault(each.frame, [])
        camera = each.camera
        file = f"{each.frame:06d}.{len(row):02d}{each.ending}"
        write_file(place / file, each.content)
        checksums[f"{CAMERAS}/{file}"] = digest(each.content)
        row.append(
            Projection(
                camera.name,
                each.width,
                each.height,
                None if camera.K is None else camera.K.tolist(),
                camera.distortion,
                camera.model,
                None if camera.T_camera_frame is None else camera.T_camera_frame.tolist(),
                file,
            )
        )
    for index, row in rows.items():
        content = json.dumps([asdict(each) for each in row]).encode()
        write_file(place / f"{index:06d}.json", content)
        checksums[f"{CAMERAS}/{index:06d}.json"] = digest(content)
    return checksums


def read_projections(folder: Path, index: int) -> list[Projection]:
    """Return the pictures of a frame, [] where it has none; raises DamagedError."""
    path = folder / CAMERAS / f"{index:06d}.json"
    try:
        rows: list[dict[str, Any]] = json.loads(path.read_bytes())
        return [Projection(**row) for row in rows]
    except FileNotFoundError:
        return []
    except (OSError, ValueError, TypeError) as error:
        raise DamagedError(f"frame {index}: expected its cameras: {error}") from None


def find_picture(folder: Path, index: int, camera: str) -> Path:
    """Return the file of a camera's picture; raises NotFoundError naming the cameras there are."""
    projections = read_projections(folder, index)
    for each in projections:
        path = folder / CAMERAS / each.file
        if each.name == camera and path.parent == folder / CAMERAS and path.is_file():
            return path
    named = ", ".join(each.name for each in projections) or "none"
    raise NotFoundError(f"camera: expected one of frame {index} ({named}), got {camera[:60]!r}")
