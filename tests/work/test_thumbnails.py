"""Small pictures show what is in a frame."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
from PIL import Image

from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, Sequence, StoredFrame, import_frames
from pointbrush.work.thumbnails import HEIGHT, WIDTH, draw, thumbnail


def stored(folder: Path, xyz: np.ndarray, rgb: np.ndarray | None = None) -> StoredFrame:
    frames = [PointFrame(xyz=xyz.astype(np.float32), rgb=rgb)]
    import_frames(frames, folder, RecordingInfo("s", "s", 1.0))
    return Sequence(folder)[0]


def wall(colour: tuple[int, int, int], z: float) -> tuple[np.ndarray, np.ndarray]:
    """A grid of points before a sensor in the origin, 2 m wide."""
    x, y = np.meshgrid(np.linspace(-1, 1, 120), np.linspace(-1, 1, 120))
    xyz = np.stack([x.ravel(), y.ravel(), np.full(x.size, z)], axis=1)
    return xyz, np.tile(np.array(colour, np.uint8), (len(xyz), 1))


def test_what_is_near_hides_what_is_far(tmp_path: Path) -> None:
    near, red = wall((250, 10, 10), -2)
    far, green = wall((10, 250, 10), -4)
    frame = stored(tmp_path / "s", np.vstack([near, far]), np.vstack([red, green]))
    picture = draw(frame, np.eye(4))
    middle = picture[HEIGHT // 2, WIDTH // 2]
    assert middle[0] > 200 > middle[1]


def test_it_is_a_small_jpeg_also_without_colour(tmp_path: Path) -> None:
    xyz = np.random.default_rng(1).normal(size=(5000, 3)) * [10, 1, 10]
    data = thumbnail(stored(tmp_path / "s", xyz), np.eye(4))
    picture = Image.open(io.BytesIO(data))
    assert (picture.format, picture.size) == ("JPEG", (WIDTH, HEIGHT))
    assert np.asarray(picture).max() > 150
    assert len(data) < 30_000
