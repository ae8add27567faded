"""The kind of the files of a stored frame."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from pointbrush.sequences.storage.frame_files import CopiedFiles, MappedFiles, PackedFiles
from pointbrush.sequences.storage.manifest import Manifest
from pointbrush.sequences.storage.sensor_files import SensorFiles


def open_frame_files(
    folder: Path,
    index: int,
    manifest: Manifest,
    checksums: Mapping[str, str],
    held: object = None,
) -> CopiedFiles | MappedFiles:
    """Open the files of frame ``index`` in ``folder``; raises DamagedError."""
    place = folder / f"{index:06d}"
    if manifest.sensors:
        return SensorFiles(folder, index, manifest, checksums, held)
    if not place.is_dir():
        return CopiedFiles(folder, index, manifest, checksums, held)
    kind = MappedFiles if (place / "xyz.npy").exists() else PackedFiles
    return kind(folder, index, manifest, checksums, held)
