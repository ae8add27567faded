"""The kinds of recordings that are generated, by name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pointbrush.errors import BadInputError
from pointbrush.samples.camera import FPS
from pointbrush.samples.jugglers import JugglingOptions, JugglingScene
from pointbrush.samples.recording import Recording, Scene
from pointbrush.samples.sensor import Sensor
from pointbrush.samples.tabletop import TabletopOptions, TabletopScene
from pointbrush.samples.walkers import WalkingOptions, WalkingScene


def _juggling(seed: int, seconds: float, **options: Any) -> Scene:
    return JugglingScene(seed, seconds, JugglingOptions(**options))


def _tabletop(seed: int, seconds: float, **options: Any) -> Scene:
    return TabletopScene(seed, seconds, TabletopOptions(**options))


def _walking(seed: int, seconds: float, **options: Any) -> Scene:
    return WalkingScene(seed, seconds, WalkingOptions(**options))


KINDS: dict[str, Callable[..., Scene]] = {
    "juggling": _juggling,
    "tabletop": _tabletop,
    "walking": _walking,
}
"""Kind -> its scene; options are those of JugglingOptions, TabletopOptions, WalkingOptions."""


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
    if seed < 0:
        raise BadInputError(f"seed: expected 0 or more, got {seed}")
    if not 0 <= noise <= 10:
        raise BadInputError(f"noise: expected 0 to 10, got {noise}")
    try:
        scene = KINDS[kind](seed, frames / FPS, **options)
    except TypeError as error:
        raise BadInputError(f"options of {kind}: {error}") from None
    name = kind.capitalize() + (f" {seed}" if seed else "")
    return Recording(name, scene, frames, seed, sensor=Sensor(noise=noise))
