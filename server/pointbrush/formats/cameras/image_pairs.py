"""Depth images of a folder and their colour pictures, found by names and image types."""

from __future__ import annotations

import logging
import re
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pointbrush.errors import BadInputError
from pointbrush.formats.cameras.depth_camera import COLOR_FILES, find_color_intrinsics
from pointbrush.formats.cameras.depth_image import DEPTH_MODES, is_same_shape
from pointbrush.formats.cameras.images import opened
from pointbrush.formats.inside import is_inside
from pointbrush.formats.options import ReadOptions
from pointbrush.formats.times.matching import FrameName, listed, partners
from pointbrush.formats.times.time_order import TimeOrder
from pointbrush.formats.times.timing import natural_key, order_of, times_of

log = logging.getLogger(__name__)
IMAGES = (".png", ".tif", ".tiff", ".pgm", ".jpg", ".jpeg", ".bmp", ".ppm")
DEPTH_IMAGES = (".png", ".tif", ".tiff", ".pgm")
DEPTH_FOLDERS = ("depth", "depth_raw", "depths")
COLOR_FOLDERS = ("rgb", "color", "colour", "colors", "registered", "image", "images")
COLOR_MODES = ("RGB", "RGBA")
MOST_STREAMS = 64
"""Most streams in a folder; with more, its names differ in more than numbers."""
_KINDS = re.compile(r"depth|rgb|colou?rs?|registered|images?|img|pose|raw")
"""Words of a file name that describe the content of its image, not its moment."""
_OTHERS = re.compile(
    r"(?<![a-z])(labels?|seg|segm[a-z]*|masks?|inst[a-z]*|sem[a-z]*|class|classes|normals?|thermal"
    r"|infra[a-z]*|ir)(?![a-z])"
)
"""Words in names of images that show neither depth nor colour."""


@dataclass(frozen=True, slots=True)
class Pair:
    """The images of one moment."""

    depth: Path
    color: Path | None
    time: float | None = None


@dataclass(frozen=True, slots=True)
class FoundPairs:
    """Pairs in their order; names of the source of ``color`` and of the pictures left unused."""

    pairs: Sequence[Pair]
    order: TimeOrder
    color: str = ""
    unused: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Stream:
    """Images of a folder with names that differ in numbers only.

    ``name``, ``mode`` and ``size`` are of the first image.  The name begins with a folder if the
    images are not in the recording's own folder.
    """

    files: tuple[Path, ...]
    name: str
    mode: str = ""
    size: tuple[int, int] = (1, 1)

    def __str__(self) -> str:
        return f"{self.name} ({len(self.files)})"

    @property
    def folder(self) -> Path:
        """The folder of the images."""
        return self.files[0].parent

    @property
    def is_depth(self) -> bool:
        """Whether the first image has one channel of 16 bits or floats, and is no label."""
        return self.mode in DEPTH_MODES and not _OTHERS.search(self.name.lower())

    @property
    def is_color(self) -> bool:
        """Whether the first image has three channels of 8 bits, and is no label."""
        return self.mode in COLOR_MODES and not _OTHERS.search(self.name.lower())


def find_pairs(folder: Path, options: ReadOptions) -> FoundPairs | None:
    """Find depth images in a folder or in one of its folders, and the colour picture of each.

    Depth images are in a folder or in files named ``depth``, or else the only stream of images of
    depth type.  Colour images are named so, or else the stream of colour pictures that pairs with
    most depth images.  None if there are no depth images.  Raises BadInputError as ``partners``.
    """
    (own, beside), by_order = streams_in(folder), options.chosen.by_order
    depths = find_depths(folder, own, beside)
    if not depths:
        return None
    place = depths[0].parent
    if place == folder and "depth" in folder.name.lower():
        beside += _sisters(folder, options)
    streams = [stream for stream in (*own, *beside) if not set(stream.files) & set(depths)]
    taken: Sequence[Path] = _declared(folder, place, streams)
    taken = taken or _best(depths, [each for each in streams if each.is_color], by_order)
    colors = _paired(depths, taken, by_order) if taken else [None] * len(depths)
    unused = [each for each in streams if not set(each.files) & set(taken)]
    if lost := [str(each) for each in unused if each.is_color or each.is_depth]:
        log.warning(
            "%s: pictures are left unused: %s; a folder of depth images is imported by its path",
            folder.name, ", ".join(lost),
        )  # fmt: skip
    times = times_of(depths, place)
    order = order_of(depths, place, times)
    pairs = [Pair(depths[i], colors[i], times[i] if times else None) for i in order.places]
    return FoundPairs(pairs, order, taken[0].parent.name if taken else "", tuple(map(str, unused)))


def streams_in(folder: Path) -> tuple[list[Stream], list[Stream]]:
    """Return the streams of images in a folder, and the streams in its subfolders."""
    beside = (stream for place in folders_in(folder) for stream in _streams(place, inside=True))
    return _streams(folder), list(beside)


def find_depths(folder: Path, own: Sequence[Stream], beside: Sequence[Stream]) -> list[Path]:
    """Return the depth images, in natural order, or none if they are ambiguous."""
    inner = {each.folder.name.lower(): each.folder for each in beside}
    named = next((inner[name] for name in DEPTH_FOLDERS if name in inner), None)
    if named is not None:
        streams = [each for each in beside if each.folder == named]
    else:
        streams = [each for each in own if "depth" in each.name.lower()]
    if streams:
        # Colour images among depth images are pictures, or renderings of the depth.
        streams = [each for each in streams if not each.is_color] or streams
        files = [path for each in streams for path in each.files]
        return sorted((p for p in files if p.suffix.lower() in DEPTH_IMAGES), key=natural_key)
    by_folder = "depth" in folder.name.lower() or any(s.is_color for s in (*own, *beside))
    streams = [each for each in own if each.is_depth and by_folder]
    streams += [s for s in beside if s.is_depth and "depth" in s.folder.name.lower()]
    return list(streams[0].files) if len(streams) == 1 else []


def folders_in(folder: Path) -> list[Path]:
    """Return the folders in a folder, in natural order, without hidden ones."""
    found = (p for p in folder.iterdir() if p.is_dir() and not p.name.startswith("."))
    return sorted(found, key=natural_key)


def _streams(folder: Path, *, inside: bool = False) -> list[Stream]:
    """Return the images of a folder by stream, in natural order."""
    images = [path for path in folder.iterdir() if path.suffix.lower() in IMAGES]
    groups: dict[str, list[Path]] = defaultdict(list)
    for path in sorted((p for p in images if not p.name.startswith(".")), key=natural_key):
        groups[re.sub(r"\d+", "", path.name.lower())].append(path)
    if len(groups) > MOST_STREAMS:
        groups = {"": sorted(path for files in groups.values() for path in files)}
    found = []
    for first, *others in groups.values():
        name = f"{folder.name}/{first.name}" if inside else first.name
        mode, size = _look(first)
        found.append(Stream((first, *others), name, mode, size))
    return found


def _look(path: Path) -> tuple[str, tuple[int, int]]:
    """Return mode and size of an image, "" and 1x1 for one that cannot be read."""
    try:
        with opened(path.name, path, "an image") as image:
            return image.mode, image.size
    except BadInputError:
        return "", (1, 1)


def _sisters(folder: Path, options: ReadOptions) -> list[Stream]:
    """Return the streams of the folders beside a folder of depth with similar names."""
    roots, name = options.limits.roots, _moment(folder.name)
    places = [
        place
        for place in folders_in(folder.absolute().parent)
        if place.name != folder.name and _moment(place.name) == name
    ]
    allowed = [place for place in places if not roots or is_inside(place, roots)]
    return [stream for place in allowed for stream in _streams(place, inside=True)]


def _declared(folder: Path, place: Path, streams: Sequence[Stream]) -> list[Path]:
    """Return the images with a name, or a folder's name, of colour images."""
    folders = {each.folder.name.lower(): each.folder for each in streams if each.folder != place}
    named = next((folders[name] for name in COLOR_FOLDERS if name in folders), None)
    if place != folder and named is not None:
        return [path for each in streams if each.folder == named for path in each.files]
    mixed = (path for each in streams if each.folder == place for path in each.files)
    return [path for path in mixed if re.search(r"rgb|colou?r", path.stem.lower())]


def _best(depths: Sequence[Path], streams: Sequence[Stream], by_order: bool) -> tuple[Path, ...]:
    """Find the stream of colour pictures that pairs with most depth images.

    A warning explains why another stream does not.
    """
    best: tuple[Path, ...] = ()
    most = 0
    _, size = _look(depths[0])
    for each in streams:
        if len(depths) > 1 and not re.search(r"\d", each.files[0].stem):
            continue  # a thumbnail belongs to no frame
        if not is_same_shape(each.size, size) and find_color_intrinsics(depths[0]) is None:
            log.warning(
                "%s: the pictures of %dx%d have not the shape of the depth images, %dx%d, and the "
                "colour camera's matrix is not in %s", each, *each.size, *size, COLOR_FILES[0],
            )  # fmt: skip
            continue
        try:
            places = _partners(depths, each.files, by_order)
        except BadInputError as error:
            log.warning("%s: %s", each, error)
            continue
        paired = sum(place is not None for place in places)
        if paired > most:
            best, most = each.files, paired
    return best


def moment_of(path: Path) -> FrameName:
    """Return the name of an image without its kind: the same for all files of a moment."""
    return FrameName(f"{_moment(path.stem) or path.stem}{path.suffix}")


def _moment(name: str) -> str:
    return _KINDS.sub("", name.lower()).strip("._- ")


def _partners(depths: Sequence[Path], colors: Sequence[Path], by_order: bool) -> list[int | None]:
    moments = ([moment_of(path) for path in paths] for paths in (depths, colors))
    return partners(*moments, by_order=by_order)


def _paired(
    depths: Sequence[Path], colors: Sequence[Path], by_order: bool
) -> Sequence[Path | None]:
    """Find the colour image of each depth image; a warning counts images without a partner.

    Raises BadInputError as ``partners``.
    """
    found = _partners(depths, colors, by_order)
    alone = [path.name for path, place in zip(depths, found, strict=True) if place is None]
    if alone:
        log.warning(
            "%d of %d depth images have no colour: %s", len(alone), len(depths), listed(alone)
        )
    unused = [path.name for place, path in enumerate(colors) if place not in found]
    if unused:
        log.warning(
            "%d of %d colour images have no depth image and are left out: %s",
            len(unused), len(colors), listed(unused),
        )  # fmt: skip
    return [None if place is None else colors[place] for place in found]
