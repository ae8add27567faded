"""The small recording that the page's tests open, and what is written on it."""

from __future__ import annotations

from collections.abc import Callable
from io import BytesIO

import numpy as np

from tests.e2e.desk import Desk
from tests.e2e.server import LiveServer

SEQUENCE = "juggling"
# The truth's label of a person.
PERSON = 7
# Frame and truth's label → the middle of what it labels, source coordinates.
Truth = Callable[[int, int], list[float]]


def painted(server: LiveServer, frame: int, label: int = 1) -> int:
    return int((server.annotation(SEQUENCE, frame) == label).sum())


def name_person(desk: Desk, server: LiveServer) -> None:
    """The first label, chosen in a window."""
    label = server.create_label(SEQUENCE, "person", "#ff5d5d")
    desk.until(f"pb.state.activeLabel.value === {label}")


def shows_paint(desk: Desk, server: LiveServer, least: int) -> None:
    """The first label has more than ``least`` points in frame 0, and the window shows as many."""
    count = painted(server, 0)
    assert count > least
    desk.until(f"pb.labels()[1] === {count}")


def put_dust(server: LiveServer) -> None:
    """The first label on points all over the room: nobody can be sure where such an object went."""
    values = np.zeros(len(server.points(SEQUENCE, 0)), np.uint16)
    values[np.random.default_rng(0).choice(len(values), 60, replace=False)] = 1
    buffer = BytesIO()
    np.save(buffer, values)
    path = f"sequences/{SEQUENCE}/frames/0/annotation"
    server.request("PUT", path, content=buffer.getvalue())
