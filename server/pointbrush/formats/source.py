"""A recording at a user's path: a file, several files, a folder, a glob or an archive."""

from __future__ import annotations

import glob
import logging
import os
import re
import shutil
import weakref
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path

from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.formats.archive import ENDINGS, is_archive, unpack
from pointbrush.formats.cameras.pictures import PictureSource, joined
from pointbrush.formats.folder import frames_among, list_files
from pointbrush.formats.inside import require_inside
from pointbrush.formats.listing import INNER, FrameFile, Listing
from pointbrush.formats.options import ColorRange, Limits, ReadOptions, UndecidedColorsError
from pointbrush.formats.registry import format_named
from pointbrush.formats.sensors.sources import list_named, list_recording
from pointbrush.formats.tables.class_maps import ClassNumbers
from pointbrush.formats.tables.corrections import Corrections
from pointbrush.formats.times.matching import Origin
from pointbrush.formats.times.timing import ASSUMED, in_order, rate_of
from pointbrush.frame import PointFrame
from pointbrush.names import spelled_out

MOST_WARNINGS = 100
"""Most warnings of one recording."""


@dataclass
class Source:
    """A recording about to be read.

    ``frames`` yields the frames in order, once, and raises the errors of readers.  ``count`` is
    their number and ``fps`` their rate, if the files state them; ``listings``: the listing of each
    path; ``scale``: metres for a unit of the files; ``classes``: names of labels 1, 2, … if the
    files have words for labels; ``origins``: the file of each frame read so far.  ``close`` removes
    temporary files; exhausting or dropping ``frames`` does so as well.
    """

    frames: Iterator[PointFrame]
    count: int | None
    fps: float | None
    name: str
    listings: Sequence[Listing] = ()
    scale: float = 1.0
    classes: Sequence[str] = ()
    origins: Sequence[Origin] = ()
    _temporary: list[Path] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._finalizer = weakref.finalize(self, _remove, list(self._temporary))

    @property
    def pictures(self) -> PictureSource | None:
        """Pictures of cameras beside the frames, or None; read them before ``close``."""
        counts = [listing.count for listing in self.listings]
        if None in counts:
            return None
        found = [(each.pictures, each.count or 0) for each in self.listings]
        return joined(found, self.scale)

    def rate(self, given: float | None) -> tuple[float, str]:
        """Return the frames per second and their source: ``given``, the files, or assumed."""
        if given:
            return given, "given"
        if self.fps:
            return self.fps, self.listings[0].rate_from
        return self.listings[0].assumed_fps, ASSUMED

    def __enter__(self) -> Source:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Remove the temporary files of archives."""
        self._finalizer()


def _remove(folders: list[Path]) -> None:
    for folder in folders:
        shutil.rmtree(folder, ignore_errors=True)


def read(
    path: Path | str, format: str | None = None, *, drop_invalid: bool = False
) -> Iterator[PointFrame]:
    """The frames of a file, folder, glob or archive, in natural or timestamp order.

    Raises NotFoundError, BadInputError, TooLargeError as ``open_source`` does, at the first
    frame that is asked for.
    """
    chosen = Corrections(format=format, drop_invalid=drop_invalid)
    with open_source([Path(path)], chosen=chosen) as source:
        yield from source.frames


def open_source(
    paths: Sequence[Path],
    format: str | None = None,
    limits: Limits | None = None,
    *,
    chosen: Corrections | None = None,
    columns_found: Callable[[Mapping[str, str]], None] | None = None,
) -> Source:
    """Find the frames that ``paths`` name, without reading points yet.

    ``format`` is a name of the registry, as is ``chosen.format``; see ``ReadOptions``.

    Raises NotFoundError for a path or glob that matches nothing, BadInputError for an unknown
    format, a folder without points or with several formats, a damaged archive; TooLargeError;
    ForbiddenError for paths outside ``limits.roots``.
    """
    if not paths:
        raise BadInputError("path: expected one or more files or folders, got none")
    chosen = chosen or Corrections()
    format = format or chosen.format
    classes = ClassNumbers()
    options = ReadOptions(
        limits=limits or Limits(),
        chosen=chosen,
        columns_found=columns_found,
        class_number=classes.number,
    )
    if format is not None:
        format_named(format)
    found = _expand(paths)
    if options.limits.roots:
        require_inside(found, options.limits.roots)
    temporary: list[Path] = []
    try:
        listings = _listings(found, format, options, temporary)
    except BaseException:
        _remove(temporary)
        raise
    times = [time for listing in listings for time in listing.times or []]
    counts = [listing.count for listing in listings]
    count = sum(c for c in counts if c is not None) if None not in counts else None
    fps = listings[0].fps if len(listings) == 1 else None
    fps = fps or (rate_of(times) if count == len(times) else None)
    origins: list[Origin] = []
    frames = _frames(listings, options, origins)
    if not any(listing.sensors for listing in listings):
        frames = map(chosen.applied, frames)
    name, scale = source_name(paths), chosen.scale
    return Source(frames, count, fps, name, listings, scale, classes.names, origins, temporary)


def _frames(
    listings: list[Listing], options: ReadOptions, origins: list[Origin]
) -> Iterator[PointFrame]:
    files = [file for listing in listings for file in listing.frames]
    several = len(files) > 1 or sum(listing.count or 0 for listing in listings) != 1
    colors = ColorRange() if several else None
    for number, file in enumerate(files):
        done = 0
        while True:
            chosen = replace(options, known=file.known, colors=colors)
            try:
                for frame in islice(file.read(chosen), done, None):
                    origins.append(Origin(file.name, done))
                    yield frame
                    done += 1
                break
            except UndecidedColorsError as undecided:
                assert colors is not None  # noqa: S101 – nothing else leaves them undecided
                colors = _decided(colors, undecided, files[number + 1 :], options)


def _decided(
    colors: ColorRange,
    undecided: UndecidedColorsError,
    later: list[FrameFile],
    options: ReadOptions,
) -> ColorRange:
    """Return the range for all files: the small one, unless a later file exceeds it.

    In a later file with several frames, the first frame with colours decides.
    """
    small, large = (255, 65535) if undecided.kind == "whole" else (1, 255)
    high = undecided.high
    for file in later:
        if high > small:
            break
        with suppress(BadInputError):  # raised again when the file is read in order
            try:
                next(file.read(replace(options, known=file.known, colors=colors)), None)
            except UndecidedColorsError as other:
                high = max(high, other.high if other.kind == undecided.kind else 0)
    return replace(colors, **{undecided.kind: large if high > small else small})


def _expand(paths: Sequence[Path]) -> list[Path]:
    """Replace globs by their matches, in natural order; other paths must exist."""
    found: list[Path] = []
    for path in paths:
        if path.exists():
            found.append(path)
            continue
        pattern = str(path)
        # Path.glob takes no absolute patterns.
        matches = glob.glob(pattern, recursive=True) if glob.has_magic(pattern) else []  # noqa: PTH207
        if not matches:
            kind = "files that match" if glob.has_magic(str(path)) else "a file or folder"
            raise NotFoundError(f"path: expected {kind}, there is no {path}")
        found += in_order([Path(match) for match in matches])
    return found


def _listings(
    paths: list[Path], format: str | None, options: ReadOptions, temporary: list[Path]
) -> list[Listing]:
    named = list_named(format, options)
    if named is not None:
        return [named]
    plain = [path for path in paths if path.is_file() and not is_archive(path)]
    if len(plain) == len(paths):
        plain = frames_among(plain, options) or plain
        return [list_files(in_order(plain), format, plain[0].parent, options)]
    listings: list[Listing] = []
    for path in paths:
        if is_archive(path):
            folder = unpack(path, options.limits)
            temporary.append(folder.parent)
            listings.append(list_recording(folder, format, options))
        elif path.is_dir():
            listings.append(list_recording(path, format, options))
        else:
            listings.append(list_files([path], format, path.parent, options))
    formats = sorted({listing.format for listing in listings})
    if len(formats) > 1:
        raise BadInputError(f"path: expected files of one format, got {' and '.join(formats)}")
    return listings


def source_name(paths: Sequence[Path]) -> str:
    """Return a name for the recording at ``paths``: its file, folder or archive, without endings.

    Several files are named after their folder, or, if it has a random name (uploads), after the
    common prefix of their names.  Characters that names must not contain are written out.
    """
    return spelled_out(_bare_name(paths))


def _bare_name(paths: Sequence[Path]) -> str:
    path = Path(paths[0])
    if len(paths) > 1 or glob.has_magic(str(path)):
        folder = path.absolute().parent
        stems = [Path(each).stem for each in paths]
        # Despite its name, commonprefix compares characters, as needed here.
        common = os.path.commonprefix(stems).rstrip("0123456789_-. ")  # noqa: RUF071
        random_name = re.fullmatch("[0-9a-f]{32}", folder.name) is not None
        return (common or "upload") if random_name else folder.name
    path = path.resolve()
    if path.is_dir():
        while path.name.lower() in INNER and path.parent.name:
            path = path.parent
        return path.name
    for ending in (*ENDINGS, ".copc.laz"):
        if path.name.lower().endswith(ending) and len(path.name) > len(ending):
            return path.name[: -len(ending)]
    return path.stem


class _Collector(logging.Handler):
    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self.found: dict[str, None] = {}

    def emit(self, record: logging.LogRecord) -> None:
        if len(self.found) < MOST_WARNINGS:
            self.found.setdefault(record.getMessage())


@contextmanager
def reported() -> Iterator[dict[str, None]]:
    """Collect the warnings of readers in the context, each once, in order; they are logged as well.

    Readers of this process, in all its threads: one recording at a time.
    """
    collector = _Collector()
    logger = logging.getLogger("pointbrush.formats")
    logger.addHandler(collector)
    try:
        yield collector.found
    finally:
        logger.removeHandler(collector)
