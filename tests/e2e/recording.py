"""The small recording that the page's tests open, and what is written on it."""

from __future__ import annotations

from collections.abc import Callable
from io import BytesIO

import numpy as np
from numpy.typing import NDArray

from tests.e2e.desk import Desk
from tests.e2e.server import LiveServer

SEQUENCE = "juggling"
# The truth's labels of a person, and of a pin that flies in the first frames.
PERSON = 7
PIN = 5
# Frame and truth's label → the middle of what it labels, source coordinates.
Truth = Callable[[int, int], list[float]]


def painted(server: LiveServer, frame: int, label: int = 1) -> int:
    return int((server.annotation(SEQUENCE, frame) == label).sum())


def name_person(desk: Desk, server: LiveServer) -> None:
    """The first label, chosen in a window."""
    label = server.create_label(SEQUENCE, "person", "#ff5d5d")
    desk.until(f"pb.state.activeLabel.value === {label}")


def paint_person(
    desk: Desk, truth: Truth, frame: int = 0, *, length: float = 0.12, above: float = 0.0
) -> None:
    """A stroke upward over the person, ``length`` metres from ``above`` their middle on."""
    x, y, z = truth(frame, PERSON)
    desk.paint([[x, y + above, z], [x, y + above + length, z]])
    desk.settled()


def shows_paint(desk: Desk, server: LiveServer, least: int) -> None:
    """The first label has more than ``least`` points in frame 0, and the window shows as many."""
    count = painted(server, 0)
    assert count > least
    desk.until(f"pb.labels()[1] === {count}")


def room_of(server: LiveServer) -> NDArray[np.float64]:
    """``T_room_local`` (4, 4) as the server has it."""
    manifest = server.request("GET", f"sequences/{SEQUENCE}").json()
    assert manifest["shift"] == [0, 0, 0]
    return np.array(manifest["room"]).reshape(4, 4)


def heights(server: LiveServer, xyz: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of source coordinates (n, 3), metres above the floor of the room."""
    up = room_of(server)[1]
    above: NDArray[np.float64] = xyz @ up[:3] + up[3]
    return above


def stand_crooked(server: LiveServer) -> NDArray[np.float64]:
    """Stand the recording as a badly found floor would; its true floor's points (n, 3)."""
    xyz = server.points(SEQUENCE, 0).astype(np.float64)
    floor = xyz[np.abs(heights(server, xyz)) < 0.02]
    tilt = np.eye(4)
    c, s = np.cos(0.14), np.sin(0.14)
    tilt[1:3, 1:4] = [[c, -s, 0.25], [s, c, 0.0]]
    room = (tilt @ room_of(server)).ravel().tolist()
    server.request("PATCH", f"sequences/{SEQUENCE}", json={"room": room})
    assert np.abs(heights(server, floor)).mean() > 0.1
    return floor


def tip_over(desk: Desk, server: LiveServer) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Another person's program stands the recording crooked, and the page shows it so at once.

    Returns the room that the import found (4, 4), and the true floor's points (n, 3).
    """
    found = room_of(server)
    floor = stand_crooked(server)
    stands_as(desk, room_of(server))
    return found, floor


def stands_as(desk: Desk, room: NDArray[np.float64]) -> None:
    """Wait until the page stands the recording as ``room`` (4, 4) says."""
    desk.until(f"Math.abs(pb.engine.viewer.room.matrix.elements[13] - {room[1, 3]}) < 1e-6")


def corners_of(floor: NDArray[np.float64]) -> list[list[float]]:
    """Three of the points of a floor that lie far apart, none at its very edge."""
    flat = floor[:, [0, 2]]
    low, high = np.quantile(flat, [0.3, 0.75], axis=0)
    ends = [[low[0], low[1]], [high[0], low[1]], [(low[0] + high[0]) / 2, high[1]]]
    return [floor[np.argmin(np.linalg.norm(flat - end, axis=1))].tolist() for end in ends]


def put_dust(server: LiveServer) -> None:
    """The first label on points all over the room: nobody can be sure where such an object went."""
    values = np.zeros(len(server.points(SEQUENCE, 0)), np.uint16)
    values[np.random.default_rng(0).choice(len(values), 60, replace=False)] = 1
    buffer = BytesIO()
    np.save(buffer, values)
    path = f"sequences/{SEQUENCE}/frames/0/annotation"
    server.request("PUT", path, content=buffer.getvalue())
