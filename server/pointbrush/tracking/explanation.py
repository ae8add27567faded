"""Record of the steps by which `auto` finds a label in a frame, for inspection."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from pointbrush.tracking.compute.rigid import inverse, transform, transform_each
from pointbrush.tracking.interface import F64, I64, Mask, TrackState
from pointbrush.tracking.model.registration import Registration
from pointbrush.tracking.model.track import Track
from pointbrush.tracking.scene.depth import Background
from pointbrush.tracking.sensors.view import View


@dataclass(frozen=True, slots=True, eq=False)
class Explanation:
    """The steps of one label in one frame; coordinates are the frame's own, metres.

    ``predicted`` (K, 3): centres of the predicted poses; ``hypotheses`` (H, 3): centres of the
    registered poses, with ``costs`` (H,), of which the minimum was chosen; ``surface`` (M, 3): the
    registered model; ``residual`` (M,): metres from each of its points to the nearest labelled
    point.  Indices of the frame's points: ``around`` (P,) the predictions, with the mask ``static``
    (P,) of background and ``owner`` (P,), the assigned label, 0 for none.  ``features``: inputs of
    the confidence.  Arrays are empty for steps that were not reached: no points to register, or a
    person, as people are tracked jointly.
    """

    frame: int
    label: int
    track: TrackState
    predicted: F64
    hypotheses: F64
    costs: F64
    surface: F64
    residual: F64
    around: I64
    static: Mask
    owner: NDArray[np.uint16]
    features: Mapping[str, float]


Watch = Callable[[Explanation], None]


def explain(
    view: View, background: Background, track: Track, fit: Registration | None, state: TrackState
) -> Explanation:
    """Return the steps of a label after its frame is decided and before the models are updated."""
    T = view.T_world_frame
    back = np.eye(4) if T is None else inverse(T)
    nowhere = np.empty((0, 3))
    if fit is None:
        none = np.empty(0, np.int64)
        return Explanation(
            view.number, track.label, state, nowhere, nowhere, np.empty(0), nowhere, np.empty(0),
            none, none.astype(bool), none.astype(np.uint16), MappingProxyType({}),
        )  # fmt: skip
    owner = np.zeros(len(view.xyz), np.uint16)
    for label, points in view.labels.items():
        owner[points] = label
    far, still = background.static(view, fit.around)
    own = view.xyz[view.labels.get(track.label, fit.around[:0])]
    residual = np.empty(0)
    if len(own):
        residual = np.asarray(cKDTree(own).query(fit.world)[0], np.float64)
    evidence = track.last.evidence
    features = {} if evidence is None else {k: float(v) for k, v in asdict(evidence).items()}
    centre = track.motion.centre[None]
    return Explanation(
        view.number,
        track.label,
        state,
        transform(back, transform_each(fit.predicted, centre)[:, 0]),
        transform(back, transform_each(fit.tried, centre)[:, 0]),
        fit.costs,
        transform(back, fit.world) if len(own) else nowhere,
        residual,
        fit.around,
        far | still,
        owner[fit.around],
        MappingProxyType(features),
    )
