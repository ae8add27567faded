"""Selection of objects by clicks: frames are prepared once; a click has at most six candidates.

    state = prepare(ObjectFrame(xyz, rgb, sensor="room", T_room_local=T))
    best, *others = candidates(state, positives=[[0.2, 0.1, 1.4]])

A frame has one structure: cells → ground, graph → pieces → merge tree.  ``sums`` of pieces are
additive along the tree.  Two small ``forest``s of ``weights`` score merges of pieces and ``unions``
of nodes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from pointbrush.lazy import lazily

if TYPE_CHECKING:
    from pointbrush.selection.objects.choosing import Candidate, candidates
    from pointbrush.selection.objects.options import ObjectOptions
    from pointbrush.selection.objects.preparing import prepare
    from pointbrush.selection.objects.state import ObjectFrame, ObjectState
    from pointbrush.selection.objects.weights import load_weights
if not TYPE_CHECKING:
    __getattr__ = lazily(__name__)
