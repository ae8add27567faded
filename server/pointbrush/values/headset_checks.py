"""Checks of headsets, and their reports."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from typing import Annotated, Literal

from pointbrush.values.base import Body, Rule, Value

Verdict = Literal["works", "fails", "unknown"]
Number = Annotated[float, Rule(allow_inf_nan=False)]
Count = Annotated[int, Rule(ge=0)]


@dataclass(frozen=True, slots=True)
class HeadsetCheck(Value):
    """A check that can begin."""

    sequence: str
    """Id of the recording to try the controls in, which no list contains."""


@dataclass(frozen=True, slots=True)
class NewHeadsetReport(Value):
    """A report that was stored."""

    id: str
    """Id of the report."""


@dataclass(frozen=True, slots=True)
class HeadsetFeature(Body):
    """A requested feature; ``granted`` is null if the browser does not report it."""

    name: str
    """Name of the WebXR feature."""
    granted: bool | None
    """The session has it; null: the browser does not report it."""


@dataclass(frozen=True, slots=True)
class HeadsetSpace(Body):
    """A reference space, and whether the session provides it."""

    name: str
    """Type of the WebXR reference space."""
    given: bool
    """The session provides it."""


@dataclass(frozen=True, slots=True)
class HeadsetInput(Body):
    """An input source and its observed properties.

    ``kind`` and ``layout`` are the page's classification, empty if unknown; ``pressed`` and
    ``leaned`` are numbers of used buttons and axes; ``joints`` is null without a hand.
    """

    side: Literal["left", "right", "none"]
    """Hand of the source: `left`, `right` or `none`."""
    mode: str
    """WebXR target ray mode."""
    profiles: tuple[str, ...]
    """WebXR input profiles, the most specific first."""
    kind: str
    """Classification by the page; empty: unknown."""
    layout: str
    """Layout of its buttons by the page; empty: unknown."""
    buttons: Count
    """Number of its buttons."""
    axes: Count
    """Number of its axes."""
    pressed: tuple[Count, ...]
    """Numbers of the buttons that were pressed."""
    leaned: tuple[Count, ...]
    """Numbers of the axes that were moved."""
    joints: Count | None
    """Number of tracked joints; null: no hand."""
    pulses: Literal["hapticActuators", "vibrationActuator", "none"]
    """Interface for vibration: `hapticActuators`, `vibrationActuator` or `none`."""


@dataclass(frozen=True, slots=True)
class HeadsetPictures(Body):
    """Times between pictures while the recording played.

    ``told`` is the display rate reported by the browser, ``offered`` the available rates, ``found``
    the measured rate; a picture is ``late`` if it misses a refresh at the reported rate, or else
    the measured one.
    """

    told: Number | None
    """Display rate that the browser reports, hertz; null: none."""
    offered: tuple[Number, ...]
    """Display rates that the browser offers, hertz."""
    found: Number
    """Measured display rate, hertz."""
    count: Count
    """Number of pictures."""
    median_ms: Number
    """Median time between pictures, milliseconds."""
    p95_ms: Number
    """Time between pictures that 95 % stay below, milliseconds."""
    late: Count
    """Number of pictures that missed a refresh."""


@dataclass(frozen=True, slots=True)
class HeadsetLayer(Body):
    """The layer to draw to; ``foveation`` is null if the browser has none."""

    kind: Literal["projection", "webgl"]
    """Layer to draw to: `projection` or `webgl`."""
    width: Count
    """Width of its texture, pixels."""
    height: Count
    """Height of its texture, pixels."""
    views: Count
    """Number of views."""
    foveation: Number | None
    """Fixed foveation, 0 to 1; null: the browser has none."""
    depth_near: Number
    """Distance of the near plane, metres."""
    depth_far: Number
    """Distance of the far plane, metres."""


@dataclass(frozen=True, slots=True)
class HeadsetSession(Body):
    """The initial state of a session; ``floor``: its space has the height of the floor."""

    mode: str
    """WebXR session mode."""
    blend: str
    """Environment blend mode."""
    floor: bool
    """The space has the height of the floor."""
    features: tuple[HeadsetFeature, ...]
    """Requested features."""
    spaces: tuple[HeadsetSpace, ...]
    """Reference spaces."""
    layer: HeadsetLayer
    """Layer to draw to."""


@dataclass(frozen=True, slots=True)
class HeadsetTask(Body):
    """A task; ``by_buttons``: it was done by a button or pad of a controller, not a panel."""

    name: Literal["play", "felt", "paint", "erase", "label", "undo", "step", "go"]
    """Tried action: `play`, `felt` a vibration, `paint`, `erase`, choose a `label`,
    `undo`, `step` a frame, or `go` somewhere."""
    verdict: Verdict
    """Outcome: `works`, `fails` or `unknown`."""
    by_buttons: bool
    """It was done by a button or pad of a controller, not a panel."""


@dataclass(frozen=True, slots=True)
class HeadsetReportFile(Body):
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
    inputs: tuple[HeadsetInput, ...]
    """Input sources."""
    pictures: HeadsetPictures | None
    """Times between pictures; null: not measured."""
    tasks: tuple[HeadsetTask, ...]
    """Tasks and their outcomes."""


@dataclass(frozen=True, slots=True)
class HeadsetReport(Value):
    """A report, the account that sent it, and the time at which it arrived."""

    id: str
    """Id of the report."""
    account: str
    """Account that sent it."""
    received: datetime
    """Time at which it arrived."""
    report: HeadsetReportFile
    """The report, as the page made it."""
