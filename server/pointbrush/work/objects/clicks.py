"""Clicks of the object tool: rays into a frame, and the points that they may take."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.selection import Points, Stroke, first_hits
from pointbrush.selection.box import clipped
from pointbrush.selection.ray import Alive

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Clicks:
    """Rays that point at an object (``positives``) and at what is no part of it (``negatives``).

    Both are ``Stroke`` values of which the samples count, in source coordinates; ``reach`` is how
    far beside a ray a point may lie, metres.  ``label`` is the label to paint with: its own points
    are taken, those of other labels only with ``take_labelled``.  ``hidden`` are labels that only
    this viewer hides.  Outside the clip box that both carry nothing is taken.  ``previous`` is
    the id of the candidate taken so far, or "".
    """

    positives: Stroke
    negatives: Stroke
    label: int = 0
    take_labelled: bool = False
    hidden: frozenset[int] = frozenset()
    previous: str = ""

    @classmethod
    def parse(cls, fields: Mapping[str, Any], most: int) -> Clicks:
        """Build from the fields of a call or a message; at most ``most`` clicks of either kind.

        Raises BadInputError.
        """
        plain = {"shape": "ray", "tool": "erase"}
        kept = {name: fields[name] for name in ("radius", "clip") if fields.get(name) is not None}
        empty = Stroke.parse({**plain, **kept})
        return cls(
            positives=_clicks(empty, "positives", fields.get("positives") or (), most),
            negatives=_clicks(empty, "negatives", fields.get("negatives") or (), most),
            label=int(fields.get("label") or 0),
            take_labelled=bool(fields.get("take_labelled", False)),
            hidden=frozenset(fields.get("hidden") or ()),
            previous=str(fields.get("previous") or ""),
        )

    def words(self) -> tuple[object, ...]:
        """Return what tells these clicks from others, without ``previous``."""
        rays = (
            array.tobytes()
            for stroke in (self.positives, self.negatives)
            for array in (stroke.origins, stroke.directions)
        )
        radius = self.positives.radius
        clip = self.positives.clip
        box = () if clip is None else tuple(array.tobytes() for array in clip.values.values())
        return *rays, radius, self.label, self.take_labelled, sorted(self.hidden), box


def _clicks(empty: Stroke, name: str, samples: Sequence[Mapping[str, Any]], most: int) -> Stroke:
    if len(samples) > most:
        raise BadInputError(f"{name}: expected at most {most} clicks, got {len(samples)}")
    return empty.with_samples(samples)


def surface_hits(points: Points, rays: Stroke, shift: Floats, alive: Alive) -> Floats:
    """Return where rays in source coordinates meet the frame: (K, 3) local metres, hits only."""
    local = rays.to_local(shift)
    meets = clipped(local.clip, points, alive)
    hits = first_hits(points, local.origins, local.directions, local.radius, meets)
    return hits[np.isfinite(hits[:, 0])]
