"""Import of exports of pointbrush: matching of files to frames by ``export.json``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.options import ReadOptions
from pointbrush.formats.readers.npy import read_array
from pointbrush.formats.tables.parsing import parse_json
from pointbrush.formats.writers import EXPORTS
from pointbrush.formats.writers.about import DELETED, NAME, PLACEMENT, TIMES
from pointbrush.names import stored_as

MAX_BYTES = 64 << 20
LEVELS = 4
"""Folders above a file that are searched for its ``export.json``."""


@dataclass(frozen=True, slots=True, eq=False)
class OwnExport:
    """An export of pointbrush in files.

    ``root``: its folder; ``frames``: numbers of the frames by the paths of their files;
    ``deleted``: masks of frames with deleted points; ``T_export_source`` (4, 4): the transform of
    its points.
    """

    root: Path
    format: str
    frames: Mapping[Path, int]
    deleted: Mapping[int, Path]
    T_export_source: NDArray[np.float64] = field(default_factory=lambda: np.eye(4))
    times: Mapping[int, float] = field(default_factory=dict)
    """Seconds of frames, for tables with times in their rows."""

    def label_files(self, place: Path) -> tuple[str, list[Path]]:
        """Find the format of labels, and the files at ``place`` with labels, by frame.

        Raises BadInputError for an export that is not known.
        """
        if self.format not in EXPORTS:
            raise BadInputError(
                f"{NAME}: expected one of {', '.join(EXPORTS)}, got {self.format[:40]!r}"
            )
        name, pattern = EXPORTS[self.format].read_as
        above = place.absolute()
        chosen = [p for p in self.frames if p.is_relative_to(above) and p.match(pattern)]
        if not chosen:  # all frames are in one file
            chosen = [p for p in sorted(self.root.rglob(pattern)) if p.is_relative_to(above)]
        return name, [path for path in chosen if path.is_file()]

    def spread(self, frame: int, values: NDArray[Any]) -> NDArray[Any]:
        """Spread values of the points kept over all points of their frame; 0 for deleted ones.

        Raises BadInputError for a mask of another number of points.
        """
        if frame not in self.deleted:
            return values
        path = self.deleted[frame]
        gone = read_array(path, ReadOptions())
        if gone.dtype != np.bool_ or gone.ndim != 1 or int((~gone).sum()) != len(values):
            raise BadInputError(
                f"{path.parent.name}/{path.name}: expected a mask that leaves {len(values):,} "
                f"points, got {gone.dtype} {gone.shape}"
            )
        spread = np.zeros(len(gone), values.dtype)
        spread[~gone] = values
        return spread


def own_export(place: Path) -> OwnExport | None:
    """Find the export of pointbrush that a file or folder belongs to, or None.

    Raises BadInputError for a damaged ``export.json``.
    """
    absolute = place.absolute()
    beside = absolute.with_name(f"{absolute.stem}.{NAME}")
    above = [*([absolute] if absolute.is_dir() else []), *list(absolute.parents)[:LEVELS]]
    for manifest in (beside, *(folder / NAME for folder in above)):
        if manifest.is_file():
            return _parse(manifest, alone=absolute if manifest == beside else None)
    return None


def _parse(manifest: Path, alone: Path | None) -> OwnExport:
    """Read ``export.json``; ``alone``: the only file of points, with the only frame."""
    try:
        if manifest.stat().st_size > MAX_BYTES:
            raise ValueError(f"more than {MAX_BYTES} bytes")
        document = parse_json(manifest.read_text("utf-8"))
        frames: dict[Path, int] = {}
        deleted: dict[int, Path] = {}
        for entry in document["frames"]:
            number = int(entry["frame"])
            frames |= {_place(manifest, name, alone): number for name in entry["files"]}
            if DELETED in entry:
                deleted[number] = _place(manifest, entry[DELETED], alone)
        return OwnExport(
            manifest.parent,
            str(document["format"]),
            MappingProxyType(frames),
            MappingProxyType(deleted),
            _rigid(document.get(PLACEMENT)),
            {int(frame): float(time) for frame, time in document.get(TIMES, {}).items()},
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise BadInputError(
            f"{manifest.name}: expected frames and files of an export, got another file: {error}"
        ) from None


def _rigid(value: Any) -> NDArray[np.float64]:
    """Read a rigid transform (4, 4), the identity if there is none; raise ValueError."""
    if value is None:
        return np.eye(4)
    T = np.asarray(value, np.float64)
    if T.shape != (4, 4) or not np.isfinite(T).all() or (T[3] != [0, 0, 0, 1]).any():
        raise ValueError(f"{PLACEMENT}: expected 4 finite rows of 4, the last 0 0 0 1")
    if not np.allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-6):
        raise ValueError(f"{PLACEMENT}: expected a rotation and a shift")
    return T


def _place(manifest: Path, name: str, alone: Path | None) -> Path:
    """Return the path of a file of an export, in its folder or beside its single file."""
    if alone is not None:
        beside = alone.with_name(f"{alone.stem}.{name.replace('/', '.')}")
        return alone if name.endswith(alone.suffix) else beside
    path = stored_as(manifest.parent / name)
    if not path.resolve().is_relative_to(manifest.parent.resolve()):
        raise ValueError(f"a file outside the export: {name[:80]}")
    return path
