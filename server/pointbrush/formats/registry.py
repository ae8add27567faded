"""Registry of the formats that are read, with the formats of plug-ins.

A plug-in package adds a format with an entry point in the group ``pointbrush.formats`` that names
a ``Format``.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path

from pointbrush.errors import BadInputError
from pointbrush.formats.cameras.depth_image import read_depth
from pointbrush.formats.options import ReadOptions
from pointbrush.formats.readers.e57 import read_e57
from pointbrush.formats.readers.feather import read_feather
from pointbrush.formats.readers.kitti import read_bin, read_kitti, read_nuscenes, read_xyzrgb
from pointbrush.formats.readers.las import read_las
from pointbrush.formats.readers.npy import read_npy, read_npz
from pointbrush.formats.readers.pcd import read_pcd
from pointbrush.formats.readers.ply import read_ply
from pointbrush.formats.readers.ptx import read_ptx
from pointbrush.formats.readers.s3dis import read_room
from pointbrush.formats.ros import mcap, rosbag1, rosbag2
from pointbrush.formats.ros.bag import Bag
from pointbrush.frame import PointFrame

log = logging.getLogger(__name__)
Reader = Callable[[Path, ReadOptions], Iterator[PointFrame]]


@dataclass(frozen=True, slots=True)
class Format:
    """A file format: its name on the command line, file name endings, and reader.

    ``magic``: first bytes of the format's files, for ambiguous names.  ``read`` yields the frames
    of one file and raises BadInputError for a damaged file.  ``weak`` endings have other uses too
    (.txt): in a folder, files with other endings take precedence.
    ``bag``: files hold topics, and messages that are frames.
    ``headless``: files have only points, so that a file of 0 bytes has none.
    """

    name: str
    extensions: tuple[str, ...]
    read: Reader
    title: str
    magic: tuple[bytes, ...] = ()
    weak: tuple[str, ...] = ()
    bag: Bag | None = None
    headless: bool = False


BUILT_IN = (
    Format("ply", (".ply",), read_ply, "PLY", (b"ply\n", b"ply\r")),
    Format("pcd", (".pcd",), read_pcd, "PCD", (b"# .PCD", b"VERSION ")),
    Format("las", (".las", ".laz"), read_las, "LAS, LAZ and COPC", (b"LASF",)),
    Format("e57", (".e57",), read_e57, "E57", (b"ASTM-E57",)),
    Format("rosbag1", (".bag",), rosbag1.read_rosbag1, "ROS 1 bag", (b"#ROSBAG",), bag=rosbag1.BAG),
    Format("rosbag2", (".db3",), rosbag2.read_rosbag2, "ROS 2 bag", bag=rosbag2.BAG),
    Format("mcap", (".mcap",), mcap.read_mcap, "MCAP", (b"\x89MCAP0",), bag=mcap.BAG),
    Format("ptx", (".ptx",), read_ptx, "PTX"),
    Format("feather", (".feather",), read_feather, "feather tables (Argoverse 2)", (b"ARROW1",)),
    Format("npy", (".npy",), read_npy, "NumPy array", (b"\x93NUMPY",)),
    Format("npz", (".npz",), read_npz, "NumPy arrays"),
    Format("xyzrgb", (".xyzrgb",), read_xyzrgb, "XYZRGB float records", headless=True),
    Format("nuscenes", (".pcd.bin",), read_nuscenes, "nuScenes sweeps", headless=True),
    Format("bin", (".bin",), read_bin, "float records (KITTI, nuScenes, XYZRGB)", headless=True),
    Format("kitti", (), read_kitti, "KITTI and SemanticKITTI", headless=True),
    Format("rgbd", (), read_depth, "depth and colour images (TUM RGB-D, Kinect v2)"),
    Format(
        "text",
        (".xyz", ".txt", ".pts", ".csv", ".asc"),
        read_room,
        "XYZ, TXT, PTS, CSV",
        weak=(".txt", ".csv"),
        headless=True,
    ),
)
ALIASES = {
    **{"bag": "rosbag1", "db3": "rosbag2"},
    **dict.fromkeys(("tum", "kinect", "kinect2", "depth"), "rgbd"),
    **dict.fromkeys(("laz", "copc"), "las"),
    **dict.fromkeys(("xyz", "txt", "pts", "csv", "asc"), "text"),
    **dict.fromkeys(("semantickitti", "velodyne"), "kitti"),
}


FORMATS: dict[str, Format] = {entry.name: entry for entry in BUILT_IN}
"""Formats by name; formats of plug-ins are added on first use."""


@cache
def load_plugins() -> None:
    """Add the formats of plug-ins to FORMATS, once.

    Not at import: a plug-in imports this package, perhaps before it is complete.
    """
    for point in entry_points(group="pointbrush.formats"):
        # A plug-in that does not load must not disable the built-in formats.
        try:
            plugin = point.load()
        except Exception:
            log.exception("format plug-in %s could not be loaded", point.name)
            continue
        if isinstance(plugin, Format):
            FORMATS[plugin.name] = plugin
        else:
            log.error("format plug-in %s: expected a Format, got %r", point.name, plugin)


ADVICE = {
    (".pkl", ".pkl.gz", ".pickle"): (
        "pickles, as of PandaSet, run code when they are opened and are not read; write their "
        "tables as feather, pandas.read_pickle(file).to_feather(name)"
    ),
    (".pcap", ".pcapng"): "packets of a scanner are not read; write PCD or LAS by its maker's tool",
}
"""Ways to convert unsupported files, by the endings of their names."""


def advice(paths: Iterable[Path]) -> str:
    """Return the way to convert the first unsupported file, after ": ", or "" without one."""
    for path in paths:
        for endings, text in ADVICE.items():
            if path.name.lower().endswith(endings):
                return f": {text}"
    return ""


def format_names() -> list[str]:
    """Return every name that ``format_named`` accepts, including plug-ins."""
    load_plugins()
    return sorted({*FORMATS, *ALIASES})


def format_named(name: str) -> Format:
    """Return the format called ``name``; raise BadInputError with the list of formats."""
    load_plugins()
    key = name.lower().lstrip(".")
    key = ALIASES.get(key, key)
    if key not in FORMATS:
        raise BadInputError(f"format: expected one of {', '.join(FORMATS)}, got {name!r}")
    return FORMATS[key]


def format_by_name(path: Path) -> Format | None:
    """Return the format of a file's ending; the longest ending wins (``.copc.laz``)."""
    load_plugins()
    lower = path.name.lower()
    matches = [
        (len(extension), entry)
        for entry in FORMATS.values()
        for extension in entry.extensions
        if lower.endswith(extension)
    ]
    return max(matches, key=lambda match: match[0])[1] if matches else None


def format_of(path: Path) -> Format:
    """The format of a single file, by its ending, else by its first bytes.

    Raises BadInputError if neither identifies a format.
    """
    found = format_by_name(path)
    if found is None:
        with path.open("rb") as file:
            start = file.read(16)
        found = next((f for f in FORMATS.values() if f.magic and start.startswith(f.magic)), None)
    if found is None:
        endings = ", ".join(e for entry in FORMATS.values() for e in entry.extensions)
        raise BadInputError(
            f"{path.name}: expected a file ending in {endings}, got another{advice([path])}"
        )
    return found
