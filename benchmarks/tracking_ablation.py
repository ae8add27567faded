"""`auto` with one of its ideas taken out."""

from __future__ import annotations

import pkgutil
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from types import ModuleType
from typing import Any
from unittest.mock import patch

import numpy as np

from pointbrush.tracking.segmentation.findings import Findings
from pointbrush.tracking.sensor.ego_motion import SAMPLE

TRACKING = "pointbrush.tracking"


def _claimed_only(_things: object, findings: Findings) -> tuple[dict[int, Any], Any]:
    return {}, ~findings.unclaimed()


def _no(*_: object, **__: object) -> None:
    pass


def _none(*_: object) -> Any:
    return np.empty(0, np.int64)


def _of_none(_self: object, _view: object, points: Any) -> Any:
    return np.zeros(len(points), bool)


def _at_hand(normal: Any) -> Any:
    return np.arange(0, len(normal), max(1, len(normal) // SAMPLE))


IDEAS: dict[str, tuple[str, Any]] = {
    # Where a thing is
    "motion": ("objects.motion.Motion.predictions", lambda self: self.poses[-1][None]),
    "sharing out": ("fitting.sharing.share_out", _no),
    "other guesses": ("fitting.recovery.proposals", lambda *_: []),
    "guesses in turn over places": ("fitting.fit._over_places", lambda *a: a[3]),
    "surface beside": ("geometry.registration.excess", lambda *_: 0.0),
    "staying": ("fitting.fit._rests", lambda *_: False),
    "what others left": ("disputes.KEPT", 0.0),
    "whole frame searched": ("fitting.relocation._is_astray", lambda *_: False),
    "much shows elsewhere": ("fitting.relocation._scrap", _no),
    "alone in its place": ("fitting.relocation._alone", _no),
    "looking back": ("smoothing.Smoother._go_back", _no),
    # Which points it has
    "background": (
        "background.depth_background.ImageBackground.static",
        lambda _s, _v, i: (np.zeros(len(i), bool), np.zeros(len(i), bool)),
    ),
    "hardly before the scene": ("background.depth_background.ImageBackground.faint", _of_none),
    "revealed": ("background.depth_background.ImageBackground.revealed", _of_none),
    "growing": ("segmentation.belong.grow", _claimed_only),
    "whole in the air": ("segmentation.alone.whole", _no),
    "painted end on": ("segmentation.alone._ends_all_round", _no),
    "uncovered by others": ("segmentation.belong._shown", lambda *a: a[3][:0]),
    "missed pieces": ("segmentation.regain.lost_pieces", _none),
    "outline": (
        "segmentation.belong._outlined",
        lambda thing, findings, new, _taken: (findings.claims[thing.label], new),
    ),
    "flying pixels": (
        "segmentation.flying_pixels.flying",
        lambda _view, points, _unit: np.zeros(len(points), bool),
    ),
    "rivals": (
        "objects.thing.Rivals.explain",
        lambda _self, xyz, *_: np.zeros(len(xyz), bool),
    ),
    "places looked through": (
        "objects.free_space.carved",
        lambda _glimpses, _view, _pose, points, _unit: np.zeros(len(points), bool),
    ),
    "colours that are its alone": (
        "objects.thing.Thing.distinct",
        lambda _self, colour: np.zeros(len(colour), bool),
    ),
    "colours never shown": (
        "objects.thing.Thing.strange",
        lambda _self, colour: np.zeros(len(colour), bool),
    ),
    # What is learnt of it, and how far it is trusted
    "model over frames": ("objects.model.Model.gather", _no),
    "bending": ("update.bending.strained", lambda *_: 0.0),
    "hidden by other colours": ("update.settle.hides", lambda *_: False),
    "slow-only keeping": ("update.withheld.withheld", lambda *_: np.empty((0, 3))),
    "swaps": ("swaps.Swaps.meet", _no),
    # People
    "scene of the whole run": ("background.scene.Scene._survey", lambda _: []),
    "noise of each place": ("background.depth_background.ImageBackground.calm", _no),
    "people together": ("people.joint_tracking.JointTracking.gather", _no),
    "steps by depth": ("people.displacement._stride", lambda _s, person, *_: person.step),
    "steps mended": ("people.ownership._mended", lambda *_: np.zeros(3)),
    "clothes": (
        "people.ownership._clothes",
        lambda sight, people: np.zeros((len(sight.owner), len(people))),
    ),
    "clothes seen later": ("people.group.dress", _no),
    "those without a label": ("people.arrivals.newcomers", lambda *_: []),
    "the missing come back": ("people.arrivals.come_back", lambda *_: set()),
    "parts of who came back": ("people.arrivals.merge", lambda *_: set()),
    "changed back": ("people.exchanges.exchange", _no),
    "doubts": ("people.group.Group.doubt", _no),
    "stature": ("people.stature.top_of", _no),
    # Sensors on the move
    "a swaying camera at rest": ("background.scene.steadied", _no),
    # Lidars
    "way of the sensor": ("sensor.ego_motion.stands", lambda *_: True),
    "shifts of the scenery": ("sensor.shifts.likely_shifts", lambda *_: np.empty((0, 3))),
    "planes that face all ways": ("sensor.ego_motion._all_ways", _at_hand),
    "ground": ("sensor.ground.on_ground", lambda xyz: np.zeros(len(xyz), bool)),
    "ground painted with it": (
        "segmentation.ground_below.painted_with_ground",
        lambda *_: False,
    ),
    "hidden from a lidar": ("sensor.range_image.range_image_of", _no),
    "rings": ("objects.shape.across_rings", lambda _xyz: 0.0),
    "tolerance by distance": ("objects.thing.Thing.come_to", _no),
    "what hangs together": ("people.bodies.hang_together", lambda *_: {}),
    "votes for shifts": ("fitting.recovery.shifts", lambda *_: []),
    "nothing leaves its way": ("fitting.fit.BEYOND", 0.0),
}
"""Idea -> where it is defined in the tracker, and what does nothing in its place."""


def found(idea: str) -> tuple[Any, str, Any]:
    """The module or class where an idea is defined, its name there, and what does nothing."""
    where, nothing = IDEAS[idea]
    path, name = f"{TRACKING}.{where}".rsplit(".", 1)
    return pkgutil.resolve_name(path), name, nothing


@contextmanager
def without(idea: str) -> Iterator[None]:
    """A context in which ``auto`` goes without an idea, whoever has imported it."""
    home, name, nothing = found(idea)
    old = vars(home)[name]
    users = [m for n, m in list(sys.modules.items()) if n.startswith(TRACKING)]
    with ExitStack() as taken_out:
        for user in users if isinstance(home, ModuleType) else [home]:
            if vars(user).get(name) is old:
                taken_out.enter_context(patch.object(user, name, nothing))
        yield
