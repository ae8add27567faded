"""Frames of a depth camera over the socket: as depth images to who reads these, as points else."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pointbrush.client import Client
from pointbrush.sequences import RecordingInfo, Sequence, import_frames, open_sequence
from tests.depth_camera import depth_camera
from tests.rigs import corrections, mount, rig
from tests.sequences.depth_decoder import decode_depth, unproject
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
    import_frames(
        [rig(0)], settings.workspace / "sequences" / "rig", RecordingInfo("rig", "rig", 30.0)
    )
    with serving(settings) as running:
        yield running


@pytest.fixture(scope="module")
def camera(served: Served) -> Sequence:
    return open_sequence(served.workspace.settings.workspace / "sequences" / "camera")


async def receive_all(
    client: Viewer, frame: int, sequence: str = "camera"
) -> tuple[Message, HeldFrame]:
    """The description of the recording, and all points of a frame."""
    info = await client.open(sequence, frame=frame)
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
        shown = unproject(lattice, pixels.pixel, pixels.depth)
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


def test_a_rig_sends_depth_images_of_its_cameras_and_points_of_its_lidar(served: Served) -> None:
    stored = open_sequence(served.workspace.settings.workspace / "sequences" / "rig")[0]

    async def scenario() -> None:
        async with viewer(served.url, served.token, keep_data=True) as client:
            await client.hello("Anna", depth=True)
            info, depth = await receive_all(client, 0, "rig")
            assert kinds_of(client, 0) == {"depth"}
            assert info["lattice"] is None
            assert [s["name"] for s in info["sensors"]] == ["left", "right", "top"]
            assert [s["lattice"] is None for s in info["sensors"]] == [False, False, True]
            assert info["sensors"][1]["T_frame_sensor"] == [mount(1).ravel().tolist()]
            assert ["origin" in chunk for chunk in depth.chunks] == [
                chunk["sensor"] == 2 for chunk in depth.chunks
            ]
            assert [c["sensor"] for c in depth.chunks] == stored.chunk_table["sensor"].tolist()
            served.workspace.update_sequence("rig", corrections=corrections())
            again = await client.until("sequence")
            assert again["identity"] != info["identity"]
            assert np.allclose(
                np.reshape(again["sensors"][1]["correction"], (4, 4)), corrections()[1]
            )
            sent = len(client.log)
            while not any(m["type"] == "depth" and m["final"] for m in client.log[sent:]):
                await client.receive()
            # A page that was away holds points of other mounts.
            fields = {"revision": info["revision"], "held": [[0, len(stored.chunks)]]}
            await client.open("rig", identity=info["identity"], **fields)
            await client.until("depth", frame=0)
        async with viewer(served.url, served.token, keep_data=True) as client:
            await client.hello("Bert")
            _, points = await receive_all(client, 0, "rig")
            assert kinds_of(client, 0) == {"frame"}
        assert b"".join(points.data) == stored.wire(0, len(stored.chunks)).tobytes()

    run(scenario)
    with Client(served.url, served.token) as client:
        recording = client["rig"]
        [left, right, top] = recording.manifest.sensors
        assert (left.type, right.points, top.times) == ("depth", (13568,), (None,))
        np.testing.assert_allclose(np.reshape(right.mounts[0], (4, 4)), mount(1) @ corrections()[1])
        points = recording.frames[0].points()
        np.testing.assert_array_equal(points["sensor"], rig(0).sensor)
