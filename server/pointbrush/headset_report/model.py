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

    model_config = ConfigDict(
        extra="forbid", strict=True, frozen=True, use_attribute_docstrings=True
    )


class HeadsetFeature(Part):
    """A requested feature; ``granted`` is null if the browser does not report it."""

    name: str
    """Name of the WebXR feature."""
    granted: bool | None
    """The session has it; null: the browser does not report it."""


class HeadsetSpace(Part):
    """A reference space, and whether the session provides it."""

    name: str
    """Type of the WebXR reference space."""
    given: bool
    """The session provides it."""


class HeadsetInput(Part):
    """An input source and its observed properties.

    ``kind`` and ``layout`` are the page's classification, empty if unknown; ``pressed`` and
    ``leaned`` are numbers of used buttons and axes; ``joints`` is null without a hand.
    """

    side: Literal["left", "right", "none"]
    """Hand of the source: `left`, `right` or `none`."""
    mode: str
    """WebXR target ray mode."""
    profiles: list[str]
    """WebXR input profiles, the most specific first."""
    kind: str
    """Classification by the page; empty: unknown."""
    layout: str
    """Layout of its buttons by the page; empty: unknown."""
    buttons: Count
    """Number of its buttons."""
    axes: Count
    """Number of its axes."""
    pressed: list[Count]
    """Numbers of the buttons that were pressed."""
    leaned: list[Count]
    """Numbers of the axes that were moved."""
    joints: Count | None
    """Number of tracked joints; null: no hand."""
    pulses: Literal["hapticActuators", "vibrationActuator", "none"]
    """Interface for vibration: `hapticActuators`, `vibrationActuator` or `none`."""


class HeadsetPictures(Part):
    """Times between pictures while the recording played.

    ``told`` is the display rate reported by the browser, ``offered`` the available rates, ``found``
    the measured rate; a picture is ``late`` if it misses a refresh at the reported rate, or else
    the measured one.
    """

    told: Finite | None
    """Display rate that the browser reports, hertz; null: none."""
    offered: list[Finite]
    """Display rates that the browser offers, hertz."""
    found: Finite
    """Measured display rate, hertz."""
    count: Count
    """Number of pictures."""
    median_ms: Finite
    """Median time between pictures, milliseconds."""
    p95_ms: Finite
    """Time between pictures that 95 % stay below, milliseconds."""
    late: Count
    """Number of pictures that missed a refresh."""


class HeadsetLayer(Part):
    """The layer to draw to; ``foveation`` is null if the browser has none."""

    kind: Literal["projection", "webgl"]
    """Layer to draw to: `projection` or `webgl`."""
    width: Count
    """Width of its texture, pixels."""
    height: Count
    """Height of its texture, pixels."""
    views: Count
    """Number of views."""
    foveation: Finite | None
    """Fixed foveation, 0 to 1; null: the browser has none."""
    depth_near: Finite
    """Distance of the near plane, metres."""
    depth_far: Finite
    """Distance of the far plane, metres."""


class HeadsetSession(Part):
    """The initial state of a session; ``floor``: its space has the height of the floor."""

    mode: str
    """WebXR session mode."""
    blend: str
    """Environment blend mode."""
    floor: bool
    """The space has the height of the floor."""
    features: list[HeadsetFeature]
    """Requested features."""
    spaces: list[HeadsetSpace]
    """Reference spaces."""
    layer: HeadsetLayer
    """Layer to draw to."""


class HeadsetTask(Part):
    """A task; ``by_buttons``: it was done by a button or pad of a controller, not a panel."""

    name: Literal["play", "felt", "paint", "erase", "label", "undo", "step", "go"]
    """Tried action: `play`, `felt` a vibration, `paint`, `erase`, choose a `label`,
    `undo`, `step` a frame, or `go` somewhere."""
    verdict: Verdict
    """Outcome: `works`, `fails` or `unknown`."""
    by_buttons: bool
    """It was done by a button or pad of a controller, not a panel."""


class HeadsetReport(Part):
    """The whole file; ``trouble``: why no session started; ``session``: null without a session."""

    format: Literal["pointbrush headset report"]
    """Kind of the file: `pointbrush headset report`."""
    version: Literal[1]
    """Version of the format."""
    made: str
    """Time of the report, ISO 8601."""
    pointbrush: str
    """Version of pointbrush."""
    browser: str
    """User agent of the browser."""
    trouble: str
    """Reason why no session started; empty: one started."""
    session: HeadsetSession | None
    """Initial state of the session; null: none."""
    inputs: list[HeadsetInput]
    """Input sources."""
    pictures: HeadsetPictures | None
    """Times between pictures; null: not measured."""
    tasks: list[HeadsetTask]
    """Tasks and their outcomes."""


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
