"""The files of one recording, in a folder or in a bucket."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from pointbrush.sequences.storage.recording_files import FolderFiles

if TYPE_CHECKING:
    from pointbrush.sequences.storage.bucket_files import BucketFiles

RecordingFiles: TypeAlias = "FolderFiles | BucketFiles"


def files_of(place: Path | RecordingFiles) -> RecordingFiles:
    """Return the files of a recording that is in a folder, or ``place`` itself."""
    return FolderFiles(place) if isinstance(place, Path) else place
