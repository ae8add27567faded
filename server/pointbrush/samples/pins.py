"""Juggling pins: a turned club, its colours, and how it is held.

A pin's own frame has its origin at the centre of mass and y from the knob to the top.
"""

from __future__ import annotations

from functools import partial

from pointbrush.samples.geometry import Array
from pointbrush.samples.render import Solid
from pointbrush.samples.shapes import Lathe
from pointbrush.samples.textures import Color, Material, banded, linear

BALANCE = 0.29
"""Height of the centre of mass above the knob's end, metres."""
GRIP = 0.12 - BALANCE
"""Grip of the hand: y in the pin's frame."""

_HEIGHTS = [0.0, 0.006, 0.022, 0.04, 0.06, 0.20, 0.29, 0.37, 0.43, 0.49, 0.512, 0.52]
_RADII = [0.008, 0.017, 0.019, 0.0135, 0.0125, 0.016, 0.033, 0.047, 0.0455, 0.031, 0.022, 0.008]
_SHAPE = Lathe([y - BALANCE for y in _HEIGHTS], _RADII)

COLORS = ("#d8342b", "#1f6fc4", "#f0b51f", "#2f9a4c", "#8a3fa8", "#e8702a", "#17a2a2", "#d14a8b")
"""Band colours of pins 1, 2, …"""


def paint(color: str, body: str = "#f1efe8") -> Material:
    """Return a pin's paint: dark knob, coloured handle, pale body with coloured bands."""
    tint, pale = linear(color), linear(body)
    black: Color = (0.03, 0.03, 0.035)
    limits: tuple[tuple[float, Color], ...] = (
        (0.035, black),
        (0.19, tint),
        (0.205, black),
        (0.30, pale),
        (0.345, tint),
        (0.405, pale),
        (0.435, tint),
        (0.50, pale),
        (0.53, black),
    )
    return Material(
        partial(banded, bands=tuple((y - BALANCE, c) for y, c in limits)), infrared=0.7, gloss=0.35
    )


def pin(material: Material, T_room_pin: Array, label: int) -> Solid:
    """Return a pin in place."""
    return Solid(_SHAPE, T_room_pin, material, label=label)
