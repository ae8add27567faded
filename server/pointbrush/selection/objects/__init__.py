"""One click, one object: a frame prepared once, then at most six nested candidates a click.

    state = prepare(ObjectFrame(xyz, rgb, sensor="room", T_room_local=T))
    best, *others = candidates(state, positives=[[0.2, 0.1, 1.4]])

Underneath lies one structure a frame: cells → ground, graph → pieces → merge tree; ``sums`` of
pieces add up along the tree, two small ``forest``s of ``weights`` say what belongs together and
which ``unions`` of nodes are worth showing.
"""

from pointbrush.selection.objects.candidates import Candidate, candidates
from pointbrush.selection.objects.options import SENSOR_KINDS, ObjectOptions, SensorKind
from pointbrush.selection.objects.prepare import prepare
from pointbrush.selection.objects.state import ObjectFrame, ObjectState
from pointbrush.selection.objects.weights import Weights, load_weights, save_weights

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
