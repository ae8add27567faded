"""Bags as recordings: their clouds, with the pictures of their cameras and poses of a file."""

from __future__ import annotations

import logging
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import islice
from pathlib import Path

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.formats.cameras.pictures import joined
from pointbrush.formats.geometry.interpolation import Pose
from pointbrush.formats.geometry.poses import named_file, read_poses
from pointbrush.formats.listing import FrameFile, Listing
from pointbrush.formats.options import ReadOptions
from pointbrush.formats.registry import Format
from pointbrush.formats.ros.bag import (
    RECORDED,
    SENSOR,
    STAMPS,
    Bag,
    Clouds,
    find_clouds,
    read_clouds,
)
from pointbrush.formats.ros.pictures import bag_pictures
from pointbrush.formats.ros.transforms import mounts
from pointbrush.formats.sensors.extrinsics import Extrinsics, read_extrinsics, with_offsets
from pointbrush.formats.sensors.streams import Stream, join_streams
from pointbrush.formats.times.timing import rate_of
from pointbrush.frame import PointFrame

log = logging.getLogger(__name__)
ALIKE = 2.0
"""Greatest ratio of the numbers of clouds of topics that count as sensors of one recording."""


def list_bags(entry: Format, bag: Bag, files: Sequence[Path], options: ReadOptions) -> Listing:
    """List bags one after the other, all with the topic of the first, or with several topics as
    sensors.

    Their poses are read from a file that the user names, at the stamps of the messages.
    """
    wanted = options.chosen.topics
    if options.chosen.sensors == "all" and len(wanted) < 2:
        wanted = _all_topics(bag, files[0], wanted)
    if len(wanted) > 1:
        return _list_sensors(entry, bag, files, options, wanted)
    return _list_topic(entry, bag, files, _clouds_of(bag, files, *wanted), options)


def _clouds_of(bag: Bag, files: Sequence[Path], wanted: str | None = None) -> list[Clouds]:
    """Find the clouds of each bag on the topic ``wanted``, else on the first bag's topic."""
    found: list[Clouds] = []
    for path in files:
        found.append(find_clouds(bag, path, wanted))
        wanted = wanted or found[0].topic
    return found


def _list_topic(
    entry: Format,
    bag: Bag,
    files: Sequence[Path],
    found: Sequence[Clouds],
    options: ReadOptions | None,
) -> Listing:
    """List the clouds of a topic; without ``options`` they have no poses and pictures."""
    stamps = np.concatenate([clouds.stamps for clouds in found]).tolist()
    by_stamps, named = rate_of(stamps), None if options is None else named_file(options)
    recorded = np.concatenate([clouds.recorded for clouds in found]).tolist()
    fps, clock = (by_stamps, STAMPS) if by_stamps else (rate_of(recorded), RECORDED)
    names = [f"message {number}" for number in range(len(stamps))]
    poses = None if named is None else read_poses(named, names, stamps)
    left = iter([None] * len(stamps) if poses is None else poses.matrices)
    return Listing(
        entry.name,
        [
            FrameFile(
                path.name,
                partial(_clouds, bag, clouds, path, list(islice(left, len(clouds.stamps)))),
            )
            for path, clouds in zip(files, found, strict=True)
        ],
        stamps,
        fps,
        len(stamps),
        order="; ".join(dict.fromkeys(clouds.order_from for clouds in found)),
        rate_from=clock if fps else "",
        poses_from=poses.source if poses else "",
        topics=found[0].topics,
        topic=found[0].topic,
        pictures=None
        if options is None
        else joined(
            [
                (bag_pictures(bag, clouds, path), len(clouds.stamps))
                for path, clouds in zip(files, found, strict=True)
            ]
        ),
    )


def _clouds(
    bag: Bag, found: Clouds, path: Path, poses: Sequence[Pose | None], options: ReadOptions
) -> Iterator[PointFrame]:
    """The clouds of a bag with the pose of each."""
    for frame, pose in zip(read_clouds(bag, found, path, options), poses, strict=True):
        yield replace(frame, pose=pose)


# ── several sensors ──────────────────────────────────────────────────────────────────────────


def _all_topics(bag: Bag, path: Path, first: Sequence[str]) -> list[str]:
    """Return the topics with about as many clouds as the first one, which is ``first`` or the one
    with most clouds."""
    topics = [each for each in bag.topics(path) if each.has_clouds and each.count]
    topics.sort(key=lambda each: (-each.count, each.name))
    if not topics:
        return list(first)
    name = first[0].partition(SENSOR)[0] if first else ""
    reference = next((each for each in topics if each.name == name), topics[0])
    near = [t for t in topics if 1 / ALIKE <= t.count / reference.count <= ALIKE]
    far = [f"{each.name} ({each.count})" for each in topics if each not in near]
    if far:
        log.warning(
            "%s: topics with another rate of clouds are left out (--topic, once for each sensor, "
            "reads them): %s", path.name, ", ".join(far),
        )  # fmt: skip
    others = [each.name for each in near if each is not reference]
    return [*(first or [reference.name]), *others]


def _list_sensors(
    entry: Format, bag: Bag, files: Sequence[Path], options: ReadOptions, wanted: Sequence[str]
) -> Listing:
    """Join topics, in the coordinates of the first one's sensor unless a file states mounts."""
    named = options.chosen.extrinsics
    stated = {} if named is None else read_extrinsics(Path(named), options.limits)
    found = dict(zip(_names(wanted), (_clouds_of(bag, files, t) for t in wanted), strict=True))
    known = stated if named is not None else _mounts(bag, files[0], found)
    known = with_offsets(known, list(found), options.chosen.clock_offset)
    streams = [
        Stream(name, _list_topic(entry, bag, files, clouds, None if k else options), known[name])
        for k, (name, clouds) in enumerate(found.items())
    ]
    return replace(join_streams(streams, options), topic=",".join(wanted))


def _names(topics: Sequence[str]) -> list[str]:
    """Name sensors by their topics, without the last part if it is the same in all."""
    parts = [topic.replace(SENSOR, "/").strip("/").split("/") for topic in topics]
    shared = len({each[-1] for each in parts}) == 1 and min(map(len, parts)) > 1
    return ["_".join(each[:-1] if shared else each) for each in parts]


def _mounts(bag: Bag, path: Path, found: Mapping[str, Sequence[Clouds]]) -> dict[str, Extrinsics]:
    """Return the mounts by the transforms of a bag; raise BadInputError for sensors without one."""
    ids = {name: clouds[0].sensor for name, clouds in found.items()}
    reference, *_ = ids.values()
    between = mounts(bag, path, next(iter(found.values()))[0].topics)
    known = {name: between(reference, frame_id) for name, frame_id in ids.items()}
    lost = [f"{name} ({ids[name]})" for name, mount in known.items() if mount is None]
    if lost:
        raise BadInputError(
            f"{path.name}: expected transforms that connect {', '.join(lost)} with {reference}, "
            "got none on /tf_static; name a file with the mounts (--extrinsics)"
        )
    return {name: Extrinsics(mount) for name, mount in known.items()}
