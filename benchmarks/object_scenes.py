"""Frames with the instance of every point: generated ones by kind and seed, and recorded ones."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pointbrush.samples import generate
from pointbrush.selection.objects import ObjectFrame
from pointbrush.sensor_kind import SensorKind
from pointbrush_samples.contacts import contact_view
from pointbrush_samples.scanning import Labelled, home_scan, room_scan, room_view
from pointbrush_samples.street import street

REALDATA = Path(__file__).parent.parent.parent / "shared" / "realdata"
HELD_OUT = 900
"""Seeds from here on are never trained on."""


class Scene(NamedTuple):
    name: str
    frame: ObjectFrame
    instance: NDArray[np.int64]


def _recording(kind: str, seed: int) -> Scene:
    options = {"label_people": True}
    if kind == "walking":
        options = {"people": 1 + seed % 4}
    if kind == "tabletop":
        options["things"] = 4 + seed % 5
    if kind == "juggling" and seed % 2:
        options |= {"people": 1, "pins": 3 + seed % 3}
    recording = generate(kind, seed, 40, **options)
    frame = recording.frame(7 + seed % 30)
    T = recording.scene.camera_pose
    made = ObjectFrame(frame.xyz, frame.rgb, None, frame.viewpoint, "camera", T)
    return Scene(f"{kind} {seed}", made, recording.truth[7 + seed % 30].astype(np.int64))


def _labelled(
    name: str, make: Callable[[int], Labelled], sensor: SensorKind
) -> Callable[[int], Scene]:
    def scene(seed: int) -> Scene:
        made = make(seed)
        f = made.frame
        frame = ObjectFrame(f.xyz, f.rgb, f.intensity, f.viewpoint, sensor, made.T_room_frame)
        return Scene(f"{name} {seed}", frame, made.instance.astype(np.int64))

    return scene


GENERATED: dict[str, Callable[[int], Scene]] = {
    "juggling": lambda seed: _recording("juggling", seed),
    "tabletop": lambda seed: _recording("tabletop", seed),
    "walking": lambda seed: _recording("walking", seed),
    "contacts": _labelled("contacts", contact_view, "camera"),
    "view": _labelled("view", room_view, "camera"),
    "scan": _labelled("scan", room_scan, "room"),
    "home": _labelled("home", home_scan, "room"),
    "street": _labelled("street", street, "lidar"),
}
"""Kind of scene -> seed -> one frame of it."""


def recorded() -> Iterator[Scene]:
    """Frames of a car's lidar (Toyota's DGP test scenes, MIT) where they are at hand."""
    z_up = np.eye(4)
    z_up[:3, :3] = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
    for path in sorted(REALDATA.glob("dgp_scene_*/npz/*.npz")):
        stored = np.load(path)
        frame = ObjectFrame(stored["xyz"], None, stored["intensity"], np.zeros(3), "lidar", z_up)
        name = f"{path.parent.parent.name} {path.stem}"
        yield Scene(name, frame, stored["instance"].astype(np.int64))
