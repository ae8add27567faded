"""A drawn stroke: samples of a controller or mouse, and its brush."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.selection.box import Clip
from pointbrush.selection.rigid import transformed, translation
from pointbrush.selection.shape import Shape, Values, rows, unit
from pointbrush.selection.shapes import SHAPES

TOOLS = ("paint", "erase", "delete", "restore")
MAX_SAMPLES = 65_536
MAX_FRAMES = 1_000
"""Maximum number of further frames that one stroke paints."""


@dataclass(frozen=True, eq=False)
class Stroke:
    """A validated stroke; coordinates are metres, in source or local coordinates.

    ``origins``, ``directions``  (S, 3) float64; directions are unit length.
    ``values`` holds the parameters of its shape by name.
    ``hidden``: labels hidden only by the viewer; 0: points without a label.
    ``hidden_sensors``: numbers of sensors hidden by the viewer.
    ``frames``: further frames to paint.
    ``clip``: box that limits shown, hit and selected points; None: no limit.
    ``met``  (S, 3): hits of the samples' rays on the surface, NaN without a hit; None: unknown.

    Raises BadInputError with expected and actual values.
    """

    shape: str
    tool: str = "paint"
    label: int = 0
    values: Values = field(default_factory=dict)
    origins: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))
    directions: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))
    only_unlabeled: bool = False
    hidden: frozenset[int] = frozenset()
    hidden_sensors: frozenset[int] = frozenset()
    frames: tuple[int, ...] = ()
    clip: Clip | None = None
    met: NDArray[np.float64] | None = None

    @classmethod
    def parse(cls, fields: Mapping[str, Any]) -> Stroke:
        """Return a stroke from fields of a call or a message, with ``samples`` as objects."""
        shape, tool = fields.get("shape", "sphere"), fields.get("tool", "paint")
        if shape not in SHAPES:
            raise BadInputError(f"shape: expected one of {', '.join(SHAPES)}, got {shape!r}")
        if tool not in TOOLS:
            raise BadInputError(f"tool: expected one of {', '.join(TOOLS)}, got {tool!r}")
        label = fields.get("label", 0)
        if tool == "paint" and label == 0:
            raise BadInputError(
                "label: expected 1 to 65534 to paint with, got 0 (use tool 'erase')"
            )
        stroke = cls(
            shape=shape,
            tool=tool,
            label=label,
            values=SHAPES[shape].read(fields),
            only_unlabeled=bool(fields.get("only_unlabeled", False)),
            hidden=frozenset(fields.get("hidden", ())),
            hidden_sensors=frozenset(fields.get("hidden_sensors", ())),
            frames=tuple(fields.get("frames", ())),
            clip=Clip.parse(fields.get("clip")),
        )
        return stroke.with_samples(fields.get("samples") or [])

    @property
    def kind(self) -> Shape:
        """The shape itself."""
        return SHAPES[self.shape]

    @property
    def radius(self) -> float:
        """Metres; of shapes that have one."""
        return float(self.values["radius"])

    def with_samples(self, samples: Sequence[Mapping[str, Any]]) -> Stroke:
        """Return this stroke with other samples (``origin``, ``direction``)."""
        if len(samples) > MAX_SAMPLES:
            raise BadInputError(
                f"samples: expected at most {MAX_SAMPLES:,} samples, got {len(samples):,}"
            )
        origins = [sample.get("origin") for sample in samples]
        directions = [sample.get("direction", (0.0, 0.0, -1.0)) for sample in samples]
        return replace(
            self,
            origins=rows("samples.origin", origins, 3),
            directions=unit(rows("samples.direction", directions, 3)),
        )

    def to_local(self, shift: NDArray[np.float64]) -> Stroke:
        """Return the stroke in local coordinates (source minus ``shift``)."""
        return self if not shift.any() else self.placed(translation(-shift))

    def placed(self, T_new_old: NDArray[np.float64]) -> Stroke:
        """Return the stroke in other coordinates, by a rigid transform (4, 4)."""
        placed = self.kind.placed
        return replace(
            self,
            origins=transformed(T_new_old, self.origins),
            directions=self.directions @ T_new_old[:3, :3].T,
            values=self.values if placed is None else placed(self.values, T_new_old),
            clip=None if self.clip is None else self.clip.placed(T_new_old),
            met=None if self.met is None else transformed(T_new_old, self.met),
        )

    def run(self, samples: slice) -> Stroke:
        """Return the stroke with some of its samples."""
        met = None if self.met is None else self.met[samples]
        return replace(
            self, origins=self.origins[samples], directions=self.directions[samples], met=met
        )
