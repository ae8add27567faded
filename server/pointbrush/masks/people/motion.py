"""Pixels that moved or rested between frames of a depth camera that stands still."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from pointbrush.masks.people.options import PeopleOptions
from pointbrush.masks.people.picture import DepthPicture

Mask = NDArray[np.bool_]


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """Pixels (h, w) that have the same depth in another frame, and pixels that moved.

    Behind a pixel that ``moved``, another frame shows the background.
    """

    rested: Mask
    moved: Mask


def find_motion(
    picture: DepthPicture, others: Iterable[DepthPicture], options: PeopleOptions
) -> Motion | None:
    """Return the motion between a picture and others; None if the camera moved in all of them."""
    gap = options.gap + options.gap_share * picture.depth
    rested, behind = np.zeros((2, *picture.seen.shape), np.bool_)
    known = False
    for other in others:
        if other.seen.shape != picture.seen.shape:
            continue
        both, step = picture.seen & other.seen, other.depth - picture.depth
        same = both & (np.abs(step) <= gap)
        if same.sum() >= options.steady_share * max(1, both.sum()):
            rested |= same
            behind |= both & (step > options.background_gap)
            known = True
    if not known:
        return None
    mostly = uniform_filter(rested.astype(np.float32), options.rest_window) > 0.5
    return Motion(mostly, behind & ~rested)
