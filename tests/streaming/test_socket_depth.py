"""Frames of a depth camera over the socket: as depth images to who reads these, as points else."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pointbrush.sequences import RecordingInfo, Sequence, import_frames, open_sequence
from pointbrush.sequences.depth.images import decode_depth
from tests.depth_camera import depth_camera
from tests.serving import Served, serving, settings_in
from tests.streaming.acting import run
from tests.streaming.client import HeldFrame, Message, Viewer, viewer


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """A server with a recording of a depth camera, whose second frame is not on the lattice."""
    settings = settings_in(tmp_path_factory.mktemp("depth"))
    first, other = depth_camera(0), depth_camera(1)
    frames = [first, replace(other, xyz=other.xyz + np.float32(0.0007))]
    import_frames(
        frames, settings.workspace / "sequences" / "camera", RecordingInfo("camera", "camera", 30.0)
    )
    with serving(settings) as running:
        yield running


@pytest.fixture(scope="module")
def camera(served: Served) -> Sequence:
    return open_sequence(served.workspace.settings.workspace / "sequences" / "camera")


async def receive_all(client: Viewer, frame: int) -> tuple[Message, HeldFrame]:
    """The description of the recording, and all points of a frame."""
    info = await client.open("camera", frame=frame)
    while not (frame in client.frames and client.frames[frame].final):
        await client.receive()
    return info, client.frames[frame]


def kinds_of(client: Viewer, frame: int) -> set[Any]:
    return {m["type"] for m in client.log if "chunks" in m and m["frame"] == frame}


def test_who_reads_depth_images_gets_the_same_points_in_a_fifth_of_the_bytes(
    served: Served, camera: Sequence
) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token, keep_data=True) as client:
            await client.hello("Anna", depth=True)
            info, depth = await receive_all(client, 0)
            assert kinds_of(client, 0) == {"depth"}
        async with viewer(served.url, served.token, keep_data=True) as client:
            await client.hello("Bert")
            _, points = await receive_all(client, 0)
            assert kinds_of(client, 0) == {"frame"}
        counted = [[(c["first"], c["count"]) for c in held.chunks] for held in (depth, points)]
        assert counted[0] == counted[1]
        assert 4 * sum(map(len, depth.data)) < sum(map(len, points.data))
        lattice, stored = camera.manifest.lattice, camera[0]
        assert lattice is not None
        chunks = [stored.depth(i, i + 1).tobytes() for i in range(len(stored.chunks))]
        assert b"".join(depth.data) == b"".join(chunks)
        pixels, _ = decode_depth(lattice, chunks)
        shown = lattice.unproject(pixels.pixel, pixels.depth)
        assert np.abs(shown - stored.xyz).max() <= info["position_error"]
        assert info["lattice"]["width"] == lattice.width

    run(scenario)


def test_a_frame_that_is_not_on_the_lattice_comes_as_points(
    served: Served, camera: Sequence
) -> None:
    assert camera[1].depth_ends is None

    async def scenario() -> None:
        async with viewer(served.url, served.token, keep_data=True) as client:
            await client.hello("Anna", depth=True)
            _, held = await receive_all(client, 1)
            assert kinds_of(client, 1) == {"frame"}
            assert held.points == camera.manifest.points[1]

    run(scenario)
