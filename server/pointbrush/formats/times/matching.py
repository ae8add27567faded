"""Matching of files to the frames of a recording by name, time or number."""

from __future__ import annotations

import logging
import re
from collections import defaultdict
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import PurePath

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.formats.geometry.interpolation import NEAR
from pointbrush.formats.times.timing import seconds_in_names, time_in_name
from pointbrush.names import composed

log = logging.getLogger(__name__)
POINT_ENDINGS = frozenset(
    {".pcd", ".ply", ".bin", ".las", ".laz", ".copc", ".npy", ".npz", ".txt", ".csv", ".xyz"}
)
"""Endings of point files that other files keep before their own ending."""
LISTED = 8
"""Most files in the list of a message."""
_NUMBER = re.compile(r"\d+(\.\d+)?", re.ASCII)
_DECIMAL = re.compile(r"\d{1,10}\.\d+", re.ASCII)
"""A name of decimal seconds of a clock with any epoch."""
BY_ORDER = "or match them in their order (--by-order)"


@dataclass(frozen=True, slots=True)
class Origin:
    """The file of a frame, "" if it is unknown, and the frame's place among the frames of that
    file."""

    file: str = ""
    place: int = 0


@dataclass(frozen=True, slots=True)
class FrameName:
    """Properties for matching of a frame or a file: the file's name, and a time in seconds; "" and
    None if they are unknown."""

    file: str = ""
    time: float | None = None

    @property
    def stem(self) -> str:
        """The file's name without folders and endings."""
        return stem_of(self.file)

    @property
    def is_time(self) -> bool:
        """Return whether only a time identifies it."""
        if not self.file:
            return self.time is not None
        if _NUMBER.fullmatch(self.stem) is None:
            return False
        return _DECIMAL.fullmatch(self.stem) is not None or time_in_name(self.stem) is not None


def _seconds(names: Sequence[FrameName]) -> list[float | None]:
    """Return the known times, or else the times in the names."""
    found = [name.time for name in names]
    for place, time in enumerate(seconds_in_names([name.stem for name in names])):
        if found[place] is None:
            stem = names[place].stem
            decimal = time is None and _DECIMAL.fullmatch(stem)
            found[place] = float(stem) if decimal else time
    return found


Rule = Callable[[Sequence[FrameName], Sequence[FrameName]], list[int | None]]
"""Function that returns the frame of each file, None for files that it does not match."""


def stem_of(name: str) -> str:
    """Return a file's name without folders and endings; ``000001.pcd.json`` has two endings."""
    path = PurePath(composed(PurePath(name).name).lower())
    stem = PurePath(path.stem)
    return stem.stem if stem.suffix in POINT_ENDINGS else path.stem


def match(
    files: Sequence[str],
    frames: Sequence[FrameName],
    *,
    by_order: bool = False,
    times: Sequence[float] | None = None,
) -> list[int]:
    """Find the frame of each file, as ``matched`` does.

    ``times``: times of the files, seconds, used instead of their names.  ``by_order`` matches the
    files to the frames in the order of their times, or else in the given order; without it, only a
    single file of a single frame is matched by order.

    Raises BadInputError, which lists files without a frame, or several files of one frame.
    """
    if by_order or len(files) == len(frames) == 1:
        places = in_their_order(len(files), len(frames))
        if times is None:
            return places
        later = sorted(places, key=times.__getitem__)
        return [later.index(place) for place in places]
    names = [FrameName(file) for file in files]
    if times is not None:
        names = [FrameName("", time) for time in times]
    return _require_all(files, frames, matched(names, frames))


def in_their_order(files: int, frames: int) -> list[int]:
    """Match equally many files and frames by their places.  Raises BadInputError otherwise."""
    if files != frames:
        raise BadInputError(f"by order: expected {frames} files, one a frame, got {files}")
    return list(range(files))


def matched(
    files: Sequence[FrameName], frames: Sequence[FrameName], near: float = NEAR
) -> list[int | None]:
    """Find the frame of each file, None for a file without a frame.

    The first rule that fits any file is applied to all: equal names, names that contain a frame's
    name, times at most ``near`` seconds apart, numbers in the names.  Names that are times are
    compared as times first unless all are equal, and never as numbers.
    """
    by_time: Rule = partial(_by_time, near=near)
    rules: tuple[Rule, ...] = (_by_name, _by_part, by_time, _by_number)
    if all(file.is_time for file in files) or all(f.file and f.is_time for f in frames):
        if None not in (found := _by_name(files, frames)):
            return found
        rules = (by_time, _by_name)
    for rule in rules:
        found = rule(files, frames)
        if any(frame is not None for frame in found):
            return found
    return [None] * len(files)


def partners(
    frames: Sequence[FrameName],
    files: Sequence[FrameName],
    *,
    near: float = NEAR,
    by_order: bool = False,
) -> list[int | None]:
    """Find the file, a picture or a pose, of each frame, as ``matched`` does.

    A frame may have no file, and several frames the same one.  Raises BadInputError if no frame has
    a file, or if two files have one name.
    """
    if by_order:
        return list(in_their_order(len(files), len(frames)))
    held: dict[str, list[str]] = defaultdict(list)
    for file in files:
        held[file.stem].append(file.file)
    twice = next((names for stem, names in held.items() if stem and len(names) > 1), None)
    if twice:
        raise BadInputError(f"expected one file a moment, got {listed(twice)}")
    found = matched(frames, files, near)
    if frames and all(file is None for file in found):
        raise BadInputError(
            "expected files with the names, times or numbers of the frames "
            f"({_listed(frames)}), got {_listed(files)}; {BY_ORDER}"
        )
    return found


def _listed(names: Sequence[FrameName]) -> str:
    known = [name.file for name in names if name.file]
    return listed(known) or f"{len(names)} of {names[0].time:g} s on" if names else "none"


def _require_all(
    files: Sequence[str], frames: Sequence[FrameName], found: Sequence[int | None]
) -> list[int]:
    lost = [file for file, frame in zip(files, found, strict=True) if frame is None]
    if lost:
        known = [frame.file for frame in frames if frame.file]
        raise BadInputError(
            f"expected files with the names, times or numbers of frames"
            f"{f' ({listed(known)})' if known else ''}, got {len(lost)} of no frame: "
            f"{listed(lost)}; leave them out, {BY_ORDER}"
        )
    held: dict[int, list[str]] = defaultdict(list)
    for file, frame in zip(files, found, strict=True):
        if frame is not None:
            held[frame].append(file)
    twice = [name for names in held.values() if len(names) > 1 for name in names]
    if twice:
        raise BadInputError(
            f"expected one file a frame, got several of one: {listed(twice)}; leave some out, "
            f"{BY_ORDER}"
        )
    return [frame for frame in found if frame is not None]


def listed(names: Sequence[str]) -> str:
    """The first names of some files, for a message."""
    more = f" and {len(names) - LISTED} more" if len(names) > LISTED else ""
    return ", ".join(PurePath(name).name for name in names[:LISTED]) + more


def _only(frames: Sequence[FrameName]) -> Mapping[str, int]:
    """Return frames by the stem of their file, without frames that share a stem."""
    places: dict[str, list[int]] = defaultdict(list)
    for index, frame in enumerate(frames):
        if frame.file:
            places[frame.stem].append(index)
    return {stem: found[0] for stem, found in places.items() if len(found) == 1}


def _by_name(files: Sequence[FrameName], frames: Sequence[FrameName]) -> list[int | None]:
    """Match files to frames by name, or by the folder's name if all files have the same name."""
    known = _only(frames)
    stems = [file.stem for file in files]
    if len(set(stems)) == 1 < len(files):
        stems = [composed(PurePath(file.file).parent.name).lower() for file in files]
    return [known.get(stem) for stem in stems]


def _by_part(files: Sequence[FrameName], frames: Sequence[FrameName]) -> list[int | None]:
    """Match files with names that contain a frame's name as a whole word; the longest wins."""
    known = _only(frames)
    found: list[int | None] = []
    for file in files:
        words = re.split(r"([^0-9a-z]+)", file.stem)
        parts = {
            "".join(words[first:last])
            for first in range(0, len(words), 2)
            for last in range(first + 1, len(words) + 1, 2)
        }
        inside = sorted(parts & known.keys(), key=len)
        # A number alone is matched by ``_by_number``, not as a name.
        best = inside[-1] if inside and not inside[-1].isdecimal() else None
        found.append(None if best is None else known[best])
    return found


def _by_time(
    files: Sequence[FrameName], frames: Sequence[FrameName], near: float
) -> list[int | None]:
    """Match files to the frames nearest in time, at most ``near`` seconds away."""
    known = [(index, time) for index, time in enumerate(_seconds(frames)) if time is not None]
    timed = [(place, time) for place, time in enumerate(_seconds(files)) if time is not None]
    found: list[int | None] = [None] * len(files)
    if not known or not timed:
        return found
    at, wanted = (np.array([time for _, time in rows]) for rows in (known, timed))
    order = np.argsort(at, kind="stable")
    after = np.searchsorted(at[order], wanted)
    sides = order[np.stack([after - 1, after]).clip(0, len(at) - 1)]
    apart = np.abs(at[sides] - wanted)
    best = sides[apart.argmin(axis=0), np.arange(len(wanted))]
    for (place, _), frame, offset in zip(timed, best.tolist(), apart.min(axis=0), strict=True):
        found[place] = known[frame][0] if offset <= near else None
    return found


def _by_number(files: Sequence[FrameName], frames: Sequence[FrameName]) -> list[int | None]:
    """Match files to frames of the same number: the one in which the names differ."""
    numbers = _numbers([frame.stem for frame in frames])
    if None in numbers or len(set(numbers)) < len(frames):
        # Frames without numbers in their names are counted.
        numbers = list(range(len(frames)))
    known = {number: index for index, number in enumerate(numbers)}
    wanted = _numbers([file.stem for file in files])
    return [None if number is None else known.get(number) for number in wanted]


def frames_of_numbers(
    numbers: Collection[int], frames: Sequence[FrameName]
) -> Mapping[int, int | None]:
    """Find the frame of each number in a list that counts the frames of a drive.

    A number is in the name of a file if this fits all numbers, or if the files are a part of the
    drive; otherwise it is a position.  A warning states the choice if it makes a difference.
    """
    positions = dict(enumerate(range(len(frames))))
    named = {n: k for k, n in enumerate(_numbers([f.stem for f in frames])) if n is not None}
    places = positions
    if numbers and len(named) == len(frames) and named != positions:
        is_part = min(numbers) <= min(named) and max(named) <= max(numbers)
        places = named if is_part or set(numbers) <= named.keys() else positions
        log.warning(
            "the labels of frames %d to %d are matched %s: the files are numbered %d to %d",
            min(numbers), max(numbers),
            "by position" if places is positions else "by the numbers in the file names",
            min(named), max(named),
        )  # fmt: skip
    return {number: places.get(number) for number in numbers}


def _numbers(stems: Sequence[str]) -> list[int | None]:
    """Return the number of each name: the digits in which the names differ, or the only digits."""
    runs = [[int(digits) for digits in re.findall(r"\d{1,18}", stem)] for stem in stems]
    width = {len(found) for found in runs}
    if len(width) != 1 or not stems:
        return [found[0] if len(found) == 1 else None for found in runs]
    differing = [k for k in range(width.pop()) if len({found[k] for found in runs}) > 1]
    if len(differing) == 1:
        return [found[differing[0]] for found in runs]
    return [found[0] if len(found) == 1 else None for found in runs]
