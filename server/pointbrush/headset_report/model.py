"""The file that "Check this headset" ends in: one definition for the page and the command.

``pointbrush.streaming.typescript`` writes the page's types from it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from pointbrush.errors import BadInputError

Verdict = Literal["works", "fails", "unknown"]
Finite = Annotated[float, Field(allow_inf_nan=False)]
Count = Annotated[int, Field(ge=0)]

LARGEST = 1 << 20
"""Bytes of a file; a report has a few thousand."""


class Part(BaseModel):
    """Base: unknown fields are refused, types are not coerced."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class HeadsetFeature(Part):
    """A feature that was asked for; ``granted`` is null where the browser does not tell."""

    name: str
    granted: bool | None


class HeadsetSpace(Part):
    """A reference space, and whether the session gives it."""

    name: str
    given: bool


class HeadsetInput(Part):
    """An input source, with what was seen of it.

    ``kind`` and ``layout`` are what the page took it for, empty where it knows none; ``pressed``
    and ``leaned`` are numbers of buttons and axes; ``joints`` is null without a hand.
    """

    side: Literal["left", "right", "none"]
    mode: str
    profiles: list[str]
    kind: str
    layout: str
    buttons: Count
    axes: Count
    pressed: list[Count]
    leaned: list[Count]
    joints: Count | None
    pulses: Literal["hapticActuators", "vibrationActuator", "none"]


class HeadsetPictures(Part):
    """Times between pictures while the recording played.

    ``told`` is the display's rate as the browser tells it, ``offered`` the rates that it can be
    asked for, ``found`` the rate that the times show; a picture is ``late`` when it misses a
    refresh, of the rate that is told if there is one.
    """

    told: Finite | None
    offered: list[Finite]
    found: Finite
    count: Count
    median_ms: Finite
    p95_ms: Finite
    late: Count


class HeadsetLayer(Part):
    """The layer that is drawn into; ``foveation`` is null where the browser has none."""

    kind: Literal["projection", "webgl"]
    width: Count
    height: Count
    views: Count
    foveation: Finite | None
    depth_near: Finite
    depth_far: Finite


class HeadsetSession(Part):
    """A session as it began; ``floor``: its space knows where the floor is."""

    mode: str
    blend: str
    floor: bool
    features: list[HeadsetFeature]
    spaces: list[HeadsetSpace]
    layer: HeadsetLayer


class HeadsetTask(Part):
    """A thing to do; ``by_buttons``: a button or pad of a controller did it, not a panel."""

    name: Literal["play", "felt", "paint", "erase", "label", "undo", "step", "go"]
    verdict: Verdict
    by_buttons: bool


class HeadsetReport(Part):
    """The whole file; ``trouble`` is why no session began, ``session`` null as long as none did."""

    format: Literal["pointbrush headset report"]
    version: Literal[1]
    made: str
    pointbrush: str
    browser: str
    trouble: str
    session: HeadsetSession | None
    inputs: list[HeadsetInput]
    pictures: HeadsetPictures | None
    tasks: list[HeadsetTask]


def read_report(path: Path) -> HeadsetReport:
    """Read a report; raises BadInputError for a file that is something else."""
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST + 1)
    except OSError as error:
        raise BadInputError(f"{path}: expected a readable file ({error.strerror})") from None
    if len(data) > LARGEST:
        raise BadInputError(f"{path}: expected a headset report, got more than {LARGEST:,} bytes")
    try:
        return HeadsetReport.model_validate_json(data)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(str(step) for step in first["loc"]) or "the file"
        raise BadInputError(
            f"{path}: expected a headset report of version 1, but {where}: {first['msg']}"
        ) from None
