"""Files that come beside the frames of a recording, matched to them by name, time or number."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePath

from pointbrush.errors import BadInputError
from pointbrush.formats.interpolation import NEAR
from pointbrush.formats.timing import nearest, time_in_name

POINT_ENDINGS = frozenset(
    {".pcd", ".ply", ".bin", ".las", ".laz", ".copc", ".npy", ".npz", ".txt", ".csv", ".xyz"}
)
"""Endings of points that other files' names keep before their own."""
LISTED = 8
"""Files that a message names."""
BY_ORDER = "or match them in their order (--by-order)"


@dataclass(frozen=True, slots=True)
class Origin:
    """The file that a frame came from, "" where that is not known, and its place among the frames
    of that file."""

    file: str = ""
    place: int = 0


@dataclass(frozen=True, slots=True)
class FrameName:
    """Marks of a frame for matching: the file that it came from, and its time in seconds; "" and
    None where they are not known."""

    file: str = ""
    time: float | None = None

    @property
    def stem(self) -> str:
        """The file's name without folders and endings."""
        return stem_of(self.file)


def stem_of(name: str) -> str:
    """The name of a file without folders and endings, of which ``000001.pcd.json`` has two."""
    path = PurePath(PurePath(name).name.lower())
    stem = PurePath(path.stem)
    return stem.stem if stem.suffix in POINT_ENDINGS else path.stem


def match(
    files: Sequence[str],
    frames: Sequence[FrameName],
    *,
    by_order: bool = False,
    times: Sequence[float] | None = None,
) -> list[int]:
    """Find the frame that each file is of.

    The first rule that fits any file is the rule for all: equal names, names that contain those of
    frames, times (``times`` of the files, seconds, or those in their names), numbers in the names.
    ``by_order`` takes the files one a frame, in their order, and nothing else does but one file for
    the only frame.

    Raises BadInputError, which lists the files that are of no frame, or several of one frame.
    """
    alone = len(files) == len(frames) == 1
    if by_order or alone:
        if len(files) != len(frames):
            raise BadInputError(
                f"by order: expected {len(frames)} files, one a frame, got {len(files)}"
            )
        return list(range(len(files)))
    rules: tuple[Callable[[], list[int | None]], ...] = (
        lambda: _by_name(files, frames),
        lambda: _by_part(files, frames),
        lambda: _by_time(files, frames, times),
        lambda: _by_number(files, frames),
    )
    found: list[int | None] = [None] * len(files)
    for rule in rules[2:3] if times is not None else rules:
        found = rule()
        if any(frame is not None for frame in found):
            break
    return _require_all(files, frames, found)


def _require_all(
    files: Sequence[str], frames: Sequence[FrameName], found: Sequence[int | None]
) -> list[int]:
    lost = [file for file, frame in zip(files, found, strict=True) if frame is None]
    if lost:
        known = [frame.file for frame in frames if frame.file]
        raise BadInputError(
            f"expected files with the names, times or numbers of frames"
            f"{f' ({_listed(known)})' if known else ''}, got {len(lost)} of no frame: "
            f"{_listed(lost)}; leave them out, {BY_ORDER}"
        )
    held: dict[int, list[str]] = defaultdict(list)
    for file, frame in zip(files, found, strict=True):
        if frame is not None:
            held[frame].append(file)
    twice = [name for names in held.values() if len(names) > 1 for name in names]
    if twice:
        raise BadInputError(
            f"expected one file a frame, got several of one: {_listed(twice)}; leave some out, "
            f"{BY_ORDER}"
        )
    return [frame for frame in found if frame is not None]


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - LISTED} more" if len(names) > LISTED else ""
    return ", ".join(PurePath(name).name for name in names[:LISTED]) + more


def _only(frames: Sequence[FrameName]) -> Mapping[str, int]:
    """Frames by the stem of their file; those that share one are told by no name."""
    places: dict[str, list[int]] = defaultdict(list)
    for index, frame in enumerate(frames):
        if frame.file:
            places[frame.stem].append(index)
    return {stem: found[0] for stem, found in places.items() if len(found) == 1}


def _by_name(files: Sequence[str], frames: Sequence[FrameName]) -> list[int | None]:
    """Match files to frames of the same name, or of the folder that they are the only one in."""
    known = _only(frames)
    stems = [stem_of(file) for file in files]
    folders = [PurePath(file).parent.name.lower() for file in files]
    if len(set(stems)) == 1 < len(files):
        stems = folders
    return [known.get(stem) for stem in stems]


def _by_part(files: Sequence[str], frames: Sequence[FrameName]) -> list[int | None]:
    """Match files whose names contain that of a frame as a whole word; the longest counts."""
    known = _only(frames)
    found: list[int | None] = []
    for file in files:
        words = re.split(r"([^0-9a-z]+)", stem_of(file))
        parts = {
            "".join(words[first:last])
            for first in range(0, len(words), 2)
            for last in range(first + 1, len(words) + 1, 2)
        }
        inside = sorted(parts & known.keys(), key=len)
        # A lone number is the number of a name, not a name.
        best = inside[-1] if inside and not inside[-1].isdecimal() else None
        found.append(None if best is None else known[best])
    return found


def _by_time(
    files: Sequence[str], frames: Sequence[FrameName], times: Sequence[float] | None
) -> list[int | None]:
    """Match files to the frames nearest in time, within NEAR seconds."""
    wanted = [time_in_name(stem_of(file)) for file in files] if times is None else list(times)
    timed = [(index, frame.time) for index, frame in enumerate(frames) if frame.time is not None]
    asked = [(place, time) for place, time in enumerate(wanted) if time is not None]
    found: list[int | None] = [None] * len(files)
    near = nearest([time for _, time in asked], [time for _, time in timed], NEAR)
    for (place, _), frame in zip(asked, near, strict=True):
        found[place] = None if frame is None else timed[frame][0]
    return found


def _by_number(files: Sequence[str], frames: Sequence[FrameName]) -> list[int | None]:
    """Match files to frames of the same number: the one in which the names differ."""
    numbers = _numbers([frame.stem for frame in frames])
    if None in numbers or len(set(numbers)) < len(frames):
        # Frames without numbers of their own are counted.
        numbers = list(range(len(frames)))
    known = {number: index for index, number in enumerate(numbers)}
    stems = [stem_of(file) for file in files]
    wanted = _numbers(stems)
    return [None if number is None else known.get(number) for number in wanted]


def _numbers(stems: Sequence[str]) -> list[int | None]:
    """The number of each name: the digits in which the names differ, or the only ones."""
    runs = [[int(digits) for digits in re.findall(r"\d{1,18}", stem)] for stem in stems]
    width = {len(found) for found in runs}
    if len(width) != 1 or not stems:
        return [found[0] if len(found) == 1 else None for found in runs]
    differing = [k for k in range(width.pop()) if len({found[k] for found in runs}) > 1]
    if len(differing) == 1:
        return [found[differing[0]] for found in runs]
    return [found[0] if len(found) == 1 else None for found in runs]
