"""Faults of a sequence's files, found by their checksums or by their own contents."""

from __future__ import annotations

from pathlib import Path

from pointbrush.errors import DamagedError, PointbrushError, UnavailableError
from pointbrush.sequences.octree.arrays import read_array, read_layout
from pointbrush.sequences.storage.checksums import CHECKSUMS, encode_checksums
from pointbrush.sequences.storage.frame_files import FRAMES
from pointbrush.sequences.storage.source_fields import FIELDS
from pointbrush.sequences.storage.stored_files import RecordingFiles, files_of

NO_CHECKSUMS = (
    f"{CHECKSUMS}: expected checksums in JSON, it is missing or damaged: changed bytes of the "
    "frames cannot be noticed"
)


def verify(place: Path | RecordingFiles) -> list[str]:
    """Return the problems of the sequence at ``place``, one sentence each; none if it is whole."""
    files, problems = files_of(place), []
    try:
        files.manifest()
    except UnavailableError:
        raise
    except PointbrushError as error:
        problems.append(str(error))
    expected = files.checksums()
    if expected is None:
        return [*problems, NO_CHECKSUMS, *_unreadable(files)]
    there = files.names()
    for name, checksum in expected.items():
        if name not in there:
            problems.append(f"{name}: expected a file, it is missing")
        elif files.digest(name) != checksum:
            problems.append(f"{name}: expected checksum {checksum}, its bytes have changed")
    # Imports before manifest version 4 have no checksums of a source's further fields.
    extra = sorted(name for name in there - set(expected) if not name.startswith(f"{FIELDS}/"))
    problems += [f"{name}: expected no such file" for name in extra]
    return problems


def note_checksums(place: Path | RecordingFiles) -> bool:
    """Write checksums of all files, if there are none yet and all files can be read.

    Returns whether they were written.  Raises OSError, UnavailableError.
    """
    files = files_of(place)
    try:
        files.manifest()
    except UnavailableError:
        raise
    except PointbrushError:
        return False
    if files.checksums() is not None or _unreadable(files):
        return False
    checksums = {name: files.digest(name) for name in files.names()}
    files.write(CHECKSUMS, encode_checksums(checksums))
    return True


def _unreadable(files: RecordingFiles) -> list[str]:
    """List faults of frames' files without checksums, from their headers and lengths."""
    problems = []
    for name in sorted(files.names()):
        if not (name.startswith(f"{FRAMES}/") and name.endswith(".points")):
            continue
        try:
            with files.hold(int(Path(name).stem), FRAMES):
                problems += _faults(files.path / name)
        except DamagedError as error:
            problems.append(str(error))
    return problems


def _faults(file: Path) -> list[str]:
    """List faults of a frame's two files, of which ``file`` has its arrays."""
    layout = read_layout(file)
    chunks = read_array(file, layout, "chunks")
    wire = file.with_suffix(".wire")
    nbytes = int((chunks["offset"] + chunks["nbytes"]).max(initial=0))
    if "depth_ends" in layout.entries:
        nbytes = int(read_array(file, layout, "depth_ends")[-1])
    if not wire.is_file() or wire.stat().st_size != nbytes:
        return [f"{FRAMES}/{wire.name}: expected {nbytes:,} bytes"]
    return []
