"""One click, one object: a frame prepared once, then at most six nested candidates a click.

    state = prepare(ObjectFrame(xyz, rgb, sensor="room", T_room_local=T))
    best, *others = candidates(state, positives=[[0.2, 0.1, 1.4]])

Underneath lies one structure a frame: cells → ground, graph → pieces → merge tree; ``sums`` of
pieces add up along the tree, two small ``forest``s of ``weights`` say what belongs together and
which ``unions`` of nodes are worth showing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from pointbrush.lazy import lazily

if TYPE_CHECKING:
    from pointbrush.selection.objects.choosing import Candidate, candidates
    from pointbrush.selection.objects.options import ObjectOptions
    from pointbrush.selection.objects.preparing import prepare
    from pointbrush.selection.objects.state import ObjectFrame, ObjectState
    from pointbrush.selection.objects.weights import Weights, load_weights, save_weights
    from pointbrush.sensor_kind import SENSOR_KINDS, SensorKind

__all__ = [
    "SENSOR_KINDS",
    "Candidate",
    "ObjectFrame",
    "ObjectOptions",
    "ObjectState",
    "SensorKind",
    "Weights",
    "candidates",
    "load_weights",
    "prepare",
    "save_weights",
]
_PLACES = {
    "Candidate": "pointbrush.selection.objects.choosing",
    "candidates": "pointbrush.selection.objects.choosing",
    "SENSOR_KINDS": "pointbrush.sensor_kind",
    "ObjectOptions": "pointbrush.selection.objects.options",
    "SensorKind": "pointbrush.sensor_kind",
    "prepare": "pointbrush.selection.objects.preparing",
    "ObjectFrame": "pointbrush.selection.objects.state",
    "ObjectState": "pointbrush.selection.objects.state",
    "Weights": "pointbrush.selection.objects.weights",
    "load_weights": "pointbrush.selection.objects.weights",
    "save_weights": "pointbrush.selection.objects.weights",
}
if not TYPE_CHECKING:
    __getattr__ = lazily(__name__, _PLACES)
