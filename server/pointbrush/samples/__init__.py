"""Seeded generators of Kinect 2 recordings with the exact label of every point.

recording = generate("juggling", seed=0, frames=90)
frame, truth = recording.frame(12), recording.truth[12]
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from pointbrush.lazy import lazily

if TYPE_CHECKING:
    from pointbrush.samples.generating import KINDS, generate, write
    from pointbrush.samples.recording import Recording
if not TYPE_CHECKING:
    __getattr__ = lazily(__name__)
