"""Checks of where the points of labels are."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from pointbrush.labels import Label
from pointbrush.work.reviewing.checks.finding import Finding
from pointbrush.work.reviewing.checks.options import CheckOptions
from pointbrush.work.reviewing.checks.sketch import Sketch

Sketches = Mapping[int, Mapping[int, Sketch]]
"""Frame → label → how it looks there."""


def stray_points(palette: Sequence[Label], sketches: Sketches) -> Iterator[Finding]:
    """Yield labels of which some points lie far from the rest."""
    names = {label.id: label.name for label in palette}
    for frame, labels in sketches.items():
        for label, found in labels.items():
            if found.stray is None or label not in names:
                continue
            points = max(1, round(found.stray.share * found.points))
            text = (
                f"{points:,} {'point' if points == 1 else 'points'} of “{names[label]}” "
                f"{found.stray.distance:.1f} m from the rest"
            )
            yield Finding("stray", text, (label,), frame, frame, found.stray.place)


def jumps(palette: Sequence[Label], sketches: Sketches, options: CheckOptions) -> Iterator[Finding]:
    """Yield labels whose middle goes farther between two frames than in those around."""
    for label in palette:
        mine = {n: labels[label.id] for n, labels in sketches.items() if label.id in labels}
        steps = {
            frame: float(np.linalg.norm(np.subtract(each.world, mine[frame - 1].world)))
            for frame, each in mine.items()
            if frame - 1 in mine
        }
        for frame, step in steps.items():
            near = range(frame - options.window, frame + options.window + 1)
            others = [steps[n] for n in near if n != frame and n in steps]
            usual = float(np.median(others)) if others else 0.0
            if step > max(options.jump, options.jump_factor * usual):
                text = f"“{label.name}” jumps {step:.1f} m from the frame before"
                yield Finding("jump", text, (label.id,), frame, frame, mine[frame].center)
