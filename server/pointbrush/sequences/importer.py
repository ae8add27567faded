"""Importing: frames → a folder on disk, all of it or nothing."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.frame import PointFrame
from pointbrush.sequences.arrays import digest, write_arrays
from pointbrush.sequences.check import CHECKSUMS, encode_checksums
from pointbrush.sequences.columns import POINT_FIELDS, Encoded, Grid, encode_frame
from pointbrush.sequences.files import new_folder, write_file
from pointbrush.sequences.manifest import FILE, Manifest, encode_manifest
from pointbrush.sequences.quantise import base_step
from pointbrush.sequences.room import RoomFinder
from pointbrush.sequences.store import FRAMES

Progress = Callable[[float, str], None]

FAR = 1024.0
"""Coordinates beyond this (metres) are shifted: float32 has less than 0.1 mm left there."""

_WORKERS = 2


def _silent(fraction: float, message: str) -> None:
    """Progress nobody asked for."""


@dataclass(frozen=True, slots=True, eq=False)
class _Record:
    """What the manifest needs of one stored frame."""

    count: int
    fields: tuple[str, ...]
    lo: NDArray[np.float64]
    hi: NDArray[np.float64]
    error: float
    prefix: NDArray[np.float32]
    pose: list[float] | None
    viewpoint: list[float] | None
    timestamp: float | None
    dropped: int
    checksums: dict[str, str]


def import_frames(
    frames: Iterable[PointFrame],
    target: Path,
    *,
    sequence_id: str,
    name: str,
    fps: float,
    total: int | None = None,
    progress: Progress = _silent,
    source: str = "",
) -> Manifest:
    """Import ``frames`` into the new folder ``target``; they are consumed one by one.

    ``progress`` gets a fraction 0..1 and a message after each frame; what it raises cancels.
    Nothing is left on any error.  Raises ConflictError when ``target`` exists, BadInputError
    when there is no frame, UnavailableError when the disk is full, and what ``frames`` raises.
    """
    if not (np.isfinite(fps) and fps > 0):
        raise BadInputError(f"fps: expected a positive number, got {fps}")
    with new_folder(target) as folder:
        (folder / FRAMES).mkdir()
        grid_of = _GridChooser()
        records = []
        for record in _store_all(frames, folder, grid_of):
            records.append(record)
            done = len(records)
            count = f"{done} of {total}" if total else f"{done}"
            progress(min(done / total, 1.0) if total else 0.0, f"imported {count} frames")
        if not records:
            raise BadInputError("expected at least one frame, got none")
        manifest = _manifest(records, grid_of.grid, sequence_id, name, fps, source)
        write_file(folder / FILE, encode_manifest(manifest))
        checksums = {key: value for record in records for key, value in record.checksums.items()}
        write_file(folder / CHECKSUMS, encode_checksums(checksums))
    return manifest


class _GridChooser:
    """Fixes shift, grid and intensity range by the first frame that can tell."""

    def __init__(self) -> None:
        self.grid = Grid(np.zeros(3), base_step(0.0), None)
        self._placed = False

    def __call__(self, frame: PointFrame) -> Grid:
        if not self._placed and len(frame):
            self._placed = True
            lo = frame.xyz.min(axis=0).astype(np.float64)
            hi = frame.xyz.max(axis=0).astype(np.float64)
            step = base_step(float((hi - lo).max()))
            self.grid = Grid(choose_shift(lo, hi), step, self.grid.intensity_range)
        if self.grid.intensity_range is None and frame.intensity is not None and len(frame):
            span = intensity_range(frame.intensity)
            self.grid = Grid(self.grid.shift, self.grid.step, span)
        return self.grid


def choose_shift(lo: NDArray[np.float64], hi: NDArray[np.float64]) -> NDArray[np.float64]:
    """A round shift (3,) near the middle of the bounds when they are far out, else zeros."""
    if max(float(np.abs(lo).max()), float(np.abs(hi).max())) <= FAR:
        return np.zeros(3)
    middle = lo / 2 + hi / 2
    shift: NDArray[np.float64] = np.where(np.abs(middle) > FAR / 4, np.rint(middle / 100) * 100, 0)
    return shift + 0.0  # no negative zeros


def intensity_range(intensity: NDArray[np.float32]) -> tuple[float, float]:
    """Source values that stream as 0 and 255: the unit's whole range where it is plain."""
    finite = intensity[np.isfinite(intensity)].astype(np.float64)
    if len(finite) == 0:
        return 0.0, 1.0
    low, high = float(finite.min()), float(finite.max())
    if low >= 0 and high <= 1:
        return 0.0, 1.0
    if low >= 0 and high <= 255:
        return 0.0, 255.0
    # A few retro-reflectors must not turn all else black.
    low, high = float(np.quantile(finite, 0.001)), float(np.quantile(finite, 0.995))
    return (low, high) if high > low else (low, low + 1.0)


def _store_all(
    frames: Iterable[PointFrame], folder: Path, grid_of: _GridChooser
) -> Iterator[_Record]:
    """Store frames in order; reading the next ones overlaps with encoding.

    Threads do, since numpy and scipy let go of the interpreter's lock in their long loops.
    """
    pending: deque[Future[_Record]] = deque()
    with ThreadPoolExecutor(_WORKERS, "import") as pool:
        try:
            for index, frame in enumerate(frames):
                grid = grid_of(frame)
                pending.append(pool.submit(_store_frame, frame, index, grid, folder))
                if len(pending) > _WORKERS:
                    yield pending.popleft().result()
            while pending:
                yield pending.popleft().result()
        finally:
            for future in pending:
                future.cancel()


def _store_frame(frame: PointFrame, index: int, grid: Grid, folder: Path) -> _Record:
    encoded = encode_frame(frame, grid)
    meta: dict[str, Any] = {"dtype": frame.xyz.dtype.name}
    if frame.camera is not None:
        camera = frame.camera
        names = ("width", "height", "fx", "fy", "cx", "cy")
        meta["camera"] = {key: getattr(camera, key) for key in names}
    stem = folder / FRAMES / f"{index:06d}"
    checksums = write_arrays(stem.with_suffix(".points"), encoded.arrays, meta)
    wire = stem.with_suffix(".wire")
    write_file(wire, encoded.wire)
    checksums[wire.name] = digest(encoded.wire)
    return _record(frame, encoded, {f"{FRAMES}/{key}": v for key, v in checksums.items()})


def _record(frame: PointFrame, encoded: Encoded, checksums: dict[str, str]) -> _Record:
    xyz, chunks = encoded.arrays["xyz"], encoded.arrays["chunks"]
    none = np.full(3, np.nan)
    return _Record(
        count=len(xyz),
        fields=("xyz", *(key for key in POINT_FIELDS if getattr(frame, key) is not None)),
        lo=chunks["lo"].min(axis=0).astype(np.float64) if len(xyz) else none,
        hi=chunks["hi"].max(axis=0).astype(np.float64) if len(xyz) else none,
        error=encoded.error,
        prefix=xyz[:4096].copy(),
        pose=None if frame.pose is None else frame.pose.ravel().tolist(),
        viewpoint=None if frame.viewpoint is None else frame.viewpoint.tolist(),
        timestamp=None if frame.timestamp is None else float(frame.timestamp),
        dropped=frame.dropped,
        checksums=checksums,
    )


def _manifest(
    records: list[_Record], grid: Grid, sequence_id: str, name: str, fps: float, source: str
) -> Manifest:
    filled = [record for record in records if record.count]
    lo = np.min([record.lo for record in filled], axis=0) if filled else np.zeros(3)
    hi = np.max([record.hi for record in filled], axis=0) if filled else np.zeros(3)
    present = {field for record in records for field in record.fields}
    finder = RoomFinder(grid.shift)
    for record in records:
        viewpoint = None if record.viewpoint is None else np.array(record.viewpoint)
        finder.add(record.prefix, viewpoint)
    return Manifest(
        id=sequence_id,
        name=name,
        frames=len(records),
        fps=float(fps),
        points=[record.count for record in records],
        fields=[field for field in ("xyz", *POINT_FIELDS) if field in present],
        shift=grid.shift.tolist(),
        lo=lo.tolist(),
        hi=hi.tolist(),
        room=finder.room(camera="pixel" in present).ravel().tolist(),
        position_error=max((record.error for record in records), default=0.0),
        intensity_range=None if grid.intensity_range is None else list(grid.intensity_range),
        dropped=[record.dropped for record in records],
        poses=[record.pose for record in records],
        timestamps=[record.timestamp for record in records],
        viewpoints=[record.viewpoint for record in records],
        source=source,
        large=False,
        created=datetime.now(UTC).isoformat(timespec="seconds"),
    )
