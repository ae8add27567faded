"""A thing hardly thicker than the depth noise, put down elsewhere on the table."""

from __future__ import annotations

import numpy as np
from guards.recordings import pushed_aside

from pointbrush.tracking import METHODS, Seed, TrackOptions


def test_a_thin_thing_has_what_hardly_stands_out_against_the_table() -> None:
    frames = pushed_aside()
    seeds = [Seed(1, np.flatnonzero(frames[0].truth == 1))]
    order, options = range(len(frames)), TrackOptions(continue_lost=True)
    *_, result = METHODS["auto"]().track(frames.__getitem__, order, seeds, lambda _: None, options)
    found, last = np.zeros(len(frames[-1].truth), bool), frames[-1].truth == 1
    found[result.assignments[1]] = True
    assert (found & last).sum() / (found | last).sum() > 0.9
