"""Bags as recordings: their clouds, with the pictures of their cameras and poses of a file."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import islice
from pathlib import Path

import numpy as np

from pointbrush.formats.cameras.pictures import joined
from pointbrush.formats.geometry.interpolation import Pose
from pointbrush.formats.geometry.poses import named_file, read_poses
from pointbrush.formats.listing import FrameFile, Listing
from pointbrush.formats.options import ReadOptions
from pointbrush.formats.registry import Format
from pointbrush.formats.ros.bag import RECORDED, STAMPS, Bag, Clouds, find_clouds, read_clouds
from pointbrush.formats.ros.pictures import bag_pictures
from pointbrush.formats.times.timing import rate_of
from pointbrush.frame import PointFrame


def list_bags(entry: Format, bag: Bag, files: Sequence[Path], options: ReadOptions) -> Listing:
    """List bags one after the other, all with the topic of the first.

    Their poses are read from a file that the user names, at the stamps of the messages.
    """
    wanted, found = options.chosen.topic, []
    for path in files:
        found.append(find_clouds(bag, path, wanted))
        wanted = wanted or found[0].topic
    stamps = np.concatenate([clouds.stamps for clouds in found]).tolist()
    by_stamps, named = rate_of(stamps), named_file(options)
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
        None,
        fps,
        len(stamps),
        order="; ".join(dict.fromkeys(clouds.order_from for clouds in found)),
        rate_from=clock if fps else "",
        poses_from=poses.source if poses else "",
        topics=found[0].topics,
        topic=found[0].topic,
        pictures=joined(
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
