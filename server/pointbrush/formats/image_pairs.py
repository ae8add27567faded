"""Depth and colour images that were taken at one moment, by the names of their files."""

from __future__ import annotations

import logging
import re
from collections.abc import Sequence
from pathlib import Path

from pointbrush.errors import BadInputError
from pointbrush.formats.interpolation import NEAR
from pointbrush.formats.timing import nearest, time_in_name

log = logging.getLogger(__name__)
_KINDS = re.compile(r"depth|rgb|colou?rs?|registered|images?|img|pose|raw")
"""Words of a file name that tell what its image is of, and not when."""
TOLD = 3
"""Files that a message names."""


def moment_of(path: Path) -> str:
    """The name of an image without its kind: the same for all files of a moment."""
    return _KINDS.sub("", path.stem.lower()).strip("._- ")


def colors_of(depths: Sequence[Path], colors: Sequence[Path]) -> list[Path | None]:
    """Find the colour image of each depth image: by name, else by time, else by number.

    Raises BadInputError where the names tell no pair, or two colour images have one moment.
    """
    if not colors:
        return [None] * len(depths)
    named = {moment_of(path): path for path in colors}
    if len(named) < len(colors):
        twice = [path for path in colors if named[moment_of(path)] != path]
        raise BadInputError(
            f"{colors[0].parent.name}: expected one colour image a moment, got {twice[0].name} and "
            f"{named[moment_of(twice[0])].name}"
        )
    found = [named.get(moment_of(path)) for path in depths]
    taken = set(found)
    timed = _by_time(depths, [path for path in colors if path not in taken])
    found = [color or timed.get(depth) for depth, color in zip(depths, found, strict=True)]
    if not any(found):
        numbered = {number: path for path in colors if (number := _number(path)) >= 0}
        numbers = [_number(path) for path in depths]
        if len(set(numbers)) == len(numbers):
            found = [numbered.get(number) for number in numbers]
    if not any(found):
        raise BadInputError(
            f"{depths[0].parent.name}: expected colour images with the names, times or numbers of "
            f"the depth images, got {listed(depths)} and {listed(colors)}"
        )
    _tell_lone(depths, colors, found)
    return found


def _by_time(depths: Sequence[Path], colors: Sequence[Path]) -> dict[Path, Path]:
    """Colour images that are nearest to depth images in time by their names, within NEAR."""
    of_depth, of_color = (
        [(path, time) for path in paths if (time := _seconds(path)) is not None]
        for paths in (depths, colors)
    )
    places = nearest([time for _, time in of_depth], [time for _, time in of_color], NEAR)
    return {
        depth: of_color[place][0]
        for (depth, _), place in zip(of_depth, places, strict=True)
        if place is not None
    }


def _seconds(path: Path) -> float | None:
    """The time in a name: since 1970, or a decimal number of seconds of any clock."""
    decimal = re.fullmatch(r"\d{1,10}\.\d+", moment_of(path), re.ASCII)
    return time_in_name(path.stem) or (float(decimal[0]) if decimal else None)


def _number(path: Path) -> int:
    """The number of a name that has one alone, else -1."""
    digits = re.findall(r"\d+", moment_of(path), re.ASCII)
    return int(digits[0][:18]) if len(digits) == 1 else -1


def _tell_lone(
    depths: Sequence[Path], colors: Sequence[Path], found: Sequence[Path | None]
) -> None:
    """Warn of images without a partner."""
    without = [depth for depth, color in zip(depths, found, strict=True) if color is None]
    used = set(found)
    unused = [path for path in colors if path not in used]
    if without:
        log.warning(
            "%d of %d depth images have no colour: %s", len(without), len(depths), listed(without)
        )
    if unused:
        log.warning(
            "%d of %d colour images have no depth image and are left out: %s",
            len(unused), len(colors), listed(unused),
        )  # fmt: skip


def listed(paths: Sequence[Path]) -> str:
    """The first names of some files, for a message."""
    return ", ".join(path.name for path in paths[:TOLD]) + ", …" * (len(paths) > TOLD)
