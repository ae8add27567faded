"""Seeded generators of Kinect 2 recordings with the exact label of every point.

recording = generate("juggling", seed=0, frames=90)
frame, truth = recording.frame(12), recording.truth[12]
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from pointbrush.lazy import lazily

if TYPE_CHECKING:
    from pointbrush.samples.generating import KINDS, generate, write
    from pointbrush.samples.recording import LabelInfo, Recording
    from pointbrush.samples.sensor import Sensor

__all__ = ["KINDS", "LabelInfo", "Recording", "Sensor", "generate", "write"]
_PLACES = {
    "KINDS": "pointbrush.samples.generating",
    "LabelInfo": "pointbrush.samples.recording",
    "Recording": "pointbrush.samples.recording",
    "Sensor": "pointbrush.samples.sensor",
    "generate": "pointbrush.samples.generating",
    "write": "pointbrush.samples.generating",
}
if not TYPE_CHECKING:
    __getattr__ = lazily(__name__, _PLACES)
