"""Seeded generators of Kinect 2 recordings with the exact label of every point.

recording = generate("juggling", seed=0, frames=90)
frame, truth = recording.frame(12), recording.truth[12]
"""

from __future__ import annotations

from typing import Any

from pointbrush.errors import BadInputError
from pointbrush.samples.camera import FPS
from pointbrush.samples.recording import LabelInfo, Recording
from pointbrush.samples.scenes import JugglingOptions, JugglingScene
from pointbrush.samples.sensor import Sensor

__all__ = ["KINDS", "LabelInfo", "Recording", "Sensor", "generate"]

KINDS = ("juggling",)


def generate(
    kind: str = "juggling", seed: int = 0, frames: int = 90, *, noise: float = 1.0, **options: Any
) -> Recording:
    """Prepare a recording; its frames are made when they are asked for.

    ``noise`` multiplies the sensor's errors (0: none).  ``options`` are those of the kind.
    Raises BadInputError for an unknown kind or option and for values out of range.
    """
    if kind not in KINDS:
        raise BadInputError(f"kind: expected one of {', '.join(KINDS)}, got {kind!r}")
    if frames < 1:
        raise BadInputError(f"frames: expected 1 or more, got {frames}")
    try:
        chosen = JugglingOptions(**options)
    except TypeError as error:
        raise BadInputError(f"options of {kind}: {error}") from None
    scene = JugglingScene(seed, frames / FPS, chosen)
    return Recording(f"{kind} {seed}", scene, frames, seed, sensor=Sensor(noise=noise))
