"""Small ray-cast recordings with exact truth for the tracking tests."""

from scenes.figures import person, room
from scenes.juggling import juggling
from scenes.raycaster import Camera, Frame, Part, Sensor
from scenes.street import street
from scenes.tabletop import tabletop
from scenes.walkers import carried, passing, swaying, walking

__all__ = [
    "Camera",
    "Frame",
    "Part",
    "Sensor",
    "carried",
    "juggling",
    "passing",
    "person",
    "room",
    "street",
    "swaying",
    "tabletop",
    "walking",
]
