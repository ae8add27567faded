"""The result file of "Check this headset": one definition for the page and the command.

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
"""Limit of a file, bytes; a report has a few thousand."""


class Part(BaseModel):
    """Base class: unknown fields are rejected, types are not coerced."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class HeadsetFeature(Part):
    """A requested feature; ``granted`` is null if the browser does not report it."""

    name: str
    granted: bool | None


class HeadsetSpace(Part):
    """A reference space, and whether the session provides it."""

    name: str
    given: bool


class HeadsetInput(Part):
    """An input source and its observed properties.

    ``kind`` and ``layout`` are the page's classification, empty if unknown; ``pressed`` and
    ``leaned`` are numbers of used buttons and axes; ``joints`` is null without a hand.
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

    ``told`` is the display rate reported by the browser, ``offered`` the available rates, ``found``
    the measured rate; a picture is ``late`` if it misses a refresh at the reported rate, or else
    the measured one.
    """

    told: Finite | None
    offered: list[Finite]
    found: Finite
    count: Count
    median_ms: Finite
    p95_ms: Finite
    late: Count


class HeadsetLayer(Part):
    """The layer to draw to; ``foveation`` is null if the browser has none."""

    kind: Literal["projection", "webgl"]
    width: Count
    height: Count
    views: Count
    foveation: Finite | None
    depth_near: Finite
    depth_far: Finite


class HeadsetSession(Part):
    """The initial state of a session; ``floor``: its space has the height of the floor."""

    mode: str
    blend: str
    floor: bool
    features: list[HeadsetFeature]
    spaces: list[HeadsetSpace]
    layer: HeadsetLayer


class HeadsetTask(Part):
    """A task; ``by_buttons``: it was done by a button or pad of a controller, not a panel."""

    name: Literal["play", "felt", "paint", "erase", "label", "undo", "step", "go"]
    verdict: Verdict
    by_buttons: bool


class HeadsetReport(Part):
    """The whole file; ``trouble``: why no session started; ``session``: null without a session."""

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
    """Read a report; raises BadInputError for any other file."""
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
