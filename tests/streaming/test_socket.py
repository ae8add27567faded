"""The socket, as a page sees it: order, refinement, deltas, resync, bad messages."""

from __future__ import annotations

import asyncio
import io
import time
import uuid
from collections.abc import Awaitable, Callable
from typing import Any

import httpx
import msgpack
import numpy as np
import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus

from pointbrush.sequences import open_sequence
from pointbrush.sequences.decoder import decode_points
from tests.serving import Served
from tests.streaming.client import HeldFrame, Viewer, viewer
from tests.streaming.conftest import FRAMES, POINTS

Scenario = Callable[[], Awaitable[None]]
RANDOM = np.random.default_rng(1)


def run(scenario: Scenario) -> None:
    asyncio.run(asyncio.wait_for(scenario(), 60))  # type: ignore[arg-type]


def stored_values(served: Served, frame: int) -> np.ndarray[Any, Any]:
    values = served.workspace.store.values("wall", frame)
    return np.where(values.deleted, np.uint16(65535), values.label)


async def paint(client: Viewer, frame: int, radius: float = 0.3, **brush: Any) -> dict[str, Any]:
    """A whole stroke somewhere where it changes something; the final answer."""
    chosen = {"label": 1, "radius": radius, **brush}
    while True:
        stroke = str(uuid.uuid4())
        await client.send(type="stroke_begin", id=stroke, frame=frame, brush=chosen)
        x, y = RANDOM.uniform(-2, 2, 2).tolist()
        await client.send(type="stroke_samples", id=stroke, samples=[{"origin": [x, y, 3.0]}])
        await client.send(type="stroke_end", id=stroke)
        answer = await client.until("stroke_result", final=True, id=stroke)
        if answer["changed"]:
            return answer


async def settled(client: Viewer, frame: int, revision: int) -> None:
    """Wait until the viewer has a frame's values of a revision."""
    while client.frames[frame].revision < revision:
        await client.receive()


async def shown(served: Served, frame: int) -> tuple[int, dict[int, HeldFrame]]:
    """The revision and the frames of a viewer who has seen all of a frame, and left."""
    async with viewer(served.url, served.token) as client:
        info = await client.open("wall", frame=frame)
        await client.until("frame", frame=frame, final=True)
    return info["revision"], client.frames


def test_opening_shows_the_frame_coarse_to_complete(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token, keep_data=True) as client:
            welcome = await client.hello("Anna")
            assert (welcome["role"], welcome["author"]) == ("admin", "Anna")
            info = await client.open("wall", frame=3)
            assert (info["frames"], info["frame"]) == (FRAMES, 3)
            while not (3 in client.frames and client.frames[3].final):
                await client.receive()
        held = client.frames[3]
        numbers = [chunk["first"] for chunk in held.chunks]
        assert numbers == sorted(numbers)
        # All points, each once: runs join without gap or overlap.
        ends = np.cumsum([chunk["count"] for chunk in held.chunks])
        assert numbers == [0, *ends[:-1].tolist()]
        assert ends[-1] == held.total == POINTS + 30
        kinds = [message["type"] for message in client.log]
        assert kinds[:2] == ["welcome", "sequence"]
        first = kinds.index("frame")
        assert "annotation" in kinds[:first], "points must not show without their labels"

    run(scenario)


def test_a_cap_on_points_holds_until_the_page_lifts_it(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token, auto_credit=False) as client:
            await client.send(type="credit", frames=0, points=1)
            await client.open("wall", frame=2)
            await client.drain(0.3)
            taken = len(client.arrivals)
            await client.send(type="credit", frames=taken, nbytes=client.nbytes, points=1)
            await client.drain(0.3)
            capped = client.frames[2]
            assert not capped.final
            first = sum(chunk["count"] for chunk in capped.chunks)
            assert first < capped.total
            late = len(client.arrivals) - taken
            await client.send(type="credit", frames=late, nbytes=client.nbytes, points=1)
            # A credit for no frame says only how the page keeps up.
            await client.send(type="credit", frames=0)
            client.auto_credit = True
            while not client.frames[2].final:
                await client.receive()
            assert sum(chunk["count"] for chunk in client.frames[2].chunks) == capped.total

    run(scenario)


def test_positions_are_within_the_manifests_error(served: Served) -> None:
    async def scenario() -> Viewer:
        async with viewer(served.url, served.token, keep_data=True) as client:
            info = await client.open("wall", frame=0)
            while not (0 in client.frames and client.frames[0].final):
                await client.receive()
            client.log.append(info)
            return client

    client = asyncio.run(scenario())
    path = served.workspace.settings.workspace / "sequences" / "wall"
    stored = open_sequence(path)[0]
    frames = [m for m in client.log if m["type"] == "frame" and m["frame"] == 0]
    for message in frames:
        for chunk in message["chunks"]:
            start, count = chunk["offset"], chunk["count"]
            data = message["data"][start : start + chunk["nbytes"]]
            raw = np.ascontiguousarray(decode_points(data, count))
            q = raw[:, :6].copy().view("<u2")
            xyz = np.array(chunk["origin"]) + q * np.array(chunk["scale"])
            exact = stored.xyz[chunk["first"] : chunk["first"] + count]
            assert np.abs(xyz - exact).max() <= client.log[-1]["position_error"] + 1e-6
            assert stored.rgb is not None
            np.testing.assert_array_equal(
                raw[:, 6:9], stored.rgb[chunk["first"] : chunk["first"] + count]
            )


def test_a_stroke_reaches_every_viewer_of_the_frame(served: Served) -> None:
    async def scenario() -> None:
        async with (
            viewer(served.url, served.token) as anna,
            viewer(served.url, served.token) as ben,
        ):
            for client in (anna, ben):
                await client.open("wall", frame=1)
                await client.until("frame", frame=1, final=True)
            done = await paint(anna, 1)
            assert done["changed"] == done["touched"] > 0
            assert done["edit"] == done["id"]
            for client in (anna, ben):
                await asyncio.wait_for(settled(client, 1, done["revision"]), 5)
                np.testing.assert_array_equal(client.frames[1].values, stored_values(served, 1))
                assert client.gaps == 0

    run(scenario)


def test_counts_timeline_and_undo_follow_an_edit(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.hello("Cleo")
            await client.open("wall", frame=2)
            labels = await client.until("labels")
            assert labels["undo"] is None
            assert [label["name"] for label in labels["labels"]] == ["pin"]
            before = labels["counts"].get("1", 0)
            done = await paint(client, 2)
            while (labels := await client.until("labels"))["revision"] < done["revision"]:
                pass
            assert labels["counts"]["1"] == before + done["changed"]
            assert labels["undo"]
            timeline = await client.until("timeline")
            assert not timeline["whole"]
            cell = next(cell for cell in timeline["cells"] if cell["frame"] == 2)
            assert cell["state"] == "painted"
            undo = str(uuid.uuid4())
            await client.send(type="undo", id=undo)
            undone = await client.until("stroke_result", id=undo)
            assert undone["changed"] == done["changed"]
            await client.send(type="undo", id=str(uuid.uuid4()))
            error = await client.until("error")
            assert error["status"] == 409

    run(scenario)


def test_a_live_stroke_counts_while_it_is_drawn_and_a_resent_one_applies_once(
    served: Served,
) -> None:
    async def scenario() -> None:
        stroke = str(uuid.uuid4())
        begin = {"type": "stroke_begin", "id": stroke, "frame": 4, "brush": {"label": 1}}
        samples = [{"origin": [0.1 * i, 0.2, 3.0]} for i in range(10)]
        answers = []
        for _ in range(2):
            async with viewer(served.url, served.token) as client:
                await client.open("wall", frame=4)
                await client.send(**begin)
                touched = []
                for sample in samples if not answers else samples[:3]:
                    await client.send(type="stroke_samples", id=stroke, samples=[sample])
                    if not answers:
                        result = await client.until("stroke_result", id=stroke)
                        assert not result["final"]
                        touched.append(result["touched"])
                assert touched == sorted(touched)
                await client.send(type="stroke_end", id=stroke)
                answers.append(await client.until("stroke_result", id=stroke, final=True))
        first, second = answers
        assert (first["revision"], first["changed"]) == (second["revision"], second["changed"])

    run(scenario)


def test_labels_of_cached_frames_stay_fresh_while_another_is_shown(served: Served) -> None:
    async def scenario() -> None:
        async with (
            viewer(served.url, served.token) as anna,
            viewer(served.url, served.token) as ben,
        ):
            await ben.open("wall", frame=5)
            await ben.until("frame", frame=5, final=True)
            await ben.send(type="seek", frame=9)
            await ben.until("frame", frame=9, final=True)
            await anna.open("wall", frame=5)
            done = await paint(anna, 5, radius=0.8)
            await asyncio.wait_for(settled(ben, 5, done["revision"]), 5)
            np.testing.assert_array_equal(ben.frames[5].values, stored_values(served, 5))
            # A frame that was forgotten is no longer spoken of, and comes whole again.
            await ben.send(type="forget", frames=[5])
            await ben.send(type="presence", frame=9)
            del ben.frames[5]
            await paint(anna, 5)
            await ben.send(type="seek", frame=5)
            await ben.until("frame", frame=5, final=True)
            np.testing.assert_array_equal(ben.frames[5].values, stored_values(served, 5))

    run(scenario)


def test_resuming_brings_what_was_missed(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as anna:
            await anna.open("wall", frame=6)
            revision, kept = await shown(served, 6)
            done = [await paint(anna, 6) for _ in range(3)][-1]
            async with viewer(served.url, served.token) as again:
                again.frames = kept
                await again.open("wall", frame=6, revision=revision)
                await asyncio.wait_for(settled(again, 6, done["revision"]), 5)
                assert again.gaps == 0
                np.testing.assert_array_equal(again.frames[6].values, stored_values(served, 6))

    run(scenario)


def test_points_that_a_viewer_kept_are_not_sent_again(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as anna:
            await anna.open("wall", frame=6)
            revision, kept = await shown(served, 6)
            done = await paint(anna, 6)
            unseen = await paint(anna, 3)
            async with viewer(served.url, served.token) as again:
                again.frames = {6: kept[6]}
                held = [[6, len(kept[6].chunks)]]
                await again.open("wall", frame=6, revision=revision, held=held)
                await asyncio.wait_for(settled(again, 6, done["revision"]), 5)
                await again.send(type="seek", frame=3)
                await again.until("frame", frame=3, final=True)
                assert 6 not in {frame for _, frame, _ in again.arrivals}
                assert again.frames[3].revision >= unseen["revision"]
                assert again.gaps == 0
                for frame in (3, 6):
                    wanted = stored_values(served, frame)
                    np.testing.assert_array_equal(again.frames[frame].values, wanted)

    run(scenario)


def test_what_is_held_needs_a_revision(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.send(type="open", sequence="wall", held=[[0, 1]])
            assert "revision" in (await client.until("error"))["detail"]

    run(scenario)


def test_a_revision_from_the_future_is_refused(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.send(type="open", sequence="wall", revision=10**9)
            assert (await client.until("error"))["status"] == 422
            assert not [message for message in client.log if message["type"] == "sequence"]
            await client.send(type="open", sequence="none", revision=1)
            assert (await client.until("error"))["status"] == 404

    run(scenario)


def metrics(served: Served) -> str:
    return httpx.get(f"{served.url}/metrics", headers=served.headers).raise_for_status().text


def test_what_was_changed_while_nobody_looked_is_seen(served: Served, api: httpx.Client) -> None:
    found: list[np.ndarray[Any, Any] | None] = []

    async def look() -> None:
        async with viewer(served.url, served.token) as client:
            await client.open("wall", frame=2)
            await client.until("frame", frame=2, final=True)
            found.append(client.frames[2].values)

    run(look)
    while "pointbrush_viewers 0.0" not in metrics(served):
        time.sleep(0.01)
    stroke = {"label": 1, "radius": 0.8, "samples": [{"origin": [0, 0, 3]}]}
    answer = api.post("/sequences/wall/frames/2/strokes", json=stroke).raise_for_status()
    assert answer.json()["changed"] > 0
    run(look)
    np.testing.assert_array_equal(found[1], stored_values(served, 2))


def test_rest_edits_reach_the_socket(served: Served, api: httpx.Client) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.open("wall", frame=7)
            await client.until("frame", frame=7, final=True)
            url = "/sequences/wall/frames/7/annotation"
            values = np.load(io.BytesIO(api.get(url).content)).copy()
            values[: len(values) // 2] = 1
            stream = io.BytesIO()
            np.save(stream, values)
            revision = api.put(url, content=stream.getvalue()).json()["revision"]
            await asyncio.wait_for(settled(client, 7, revision), 5)
            np.testing.assert_array_equal(client.frames[7].values, stored_values(served, 7))
            api.patch("/sequences/wall/labels/1", json={"color": "#0000ff"})
            while (await client.until("labels"))["labels"][0]["color"] != "#0000ff":
                pass

    run(scenario)


def test_deleted_points_have_their_own_value(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.open("wall", frame=8)
            await client.until("frame", frame=8, final=True)
            done = await paint(client, 8, tool="delete", label=0, radius=0.5)
            await settled(client, 8, done["revision"])
            values = client.frames[8].values
            assert values is not None
            assert (values == 65535).sum() == done["changed"] > 0

    run(scenario)


def test_presence_goes_to_the_others_in_the_same_sequence(served: Served) -> None:
    async def scenario() -> None:
        async with (
            viewer(served.url, served.token) as anna,
            viewer(served.url, served.token) as ben,
            viewer(served.url, served.token) as other,
        ):
            await anna.hello("Anna")
            await anna.open("wall")
            await ben.open("wall")
            await other.open("other")
            for i in range(200):
                await anna.send(type="presence", frame=3, head=[i, 0, 0, 0, 0, 0, 1])
            seen = await ben.until("presence", name="Anna")
            while seen["head"][0] != 199:
                seen = await ben.until("presence", name="Anna")
            told = [m for m in ben.log if m["type"] == "presence"]
            assert len(told) < 60, "newest wins: not every movement is relayed"
            await anna.socket.close()
            assert (await ben.until("presence", left=True))["name"] == "Anna"
            await other.drain(0.2)
            assert not [m for m in other.log if m["type"] == "presence"]
            assert not [m for m in anna.log if m["type"] == "presence"]

    run(scenario)


def test_roles(served: Served) -> None:
    secret = served.workspace.store.tokens.add("viewer", "looks only")

    async def scenario() -> None:
        async with viewer(served.url, secret) as client:
            welcome = await client.hello("Mallory")
            # A token with a name of its own cannot borrow another author's.
            assert (welcome["author"], welcome["role"]) == ("looks only", "viewer")
            await client.open("wall")
            stroke = str(uuid.uuid4())
            await client.send(type="stroke_begin", id=stroke, frame=0, brush={"label": 1})
            error = await client.until("error")
            assert (error["status"], error["about"]) == (403, stroke)

    run(scenario)


def test_a_revoked_tokens_socket_is_closed(served: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    from pointbrush.web import socket

    monkeypatch.setattr(socket, "RECHECK_SECONDS", 0.1)
    tokens = served.workspace.store.tokens
    secret = tokens.add("annotator", "leaves soon")

    async def scenario() -> None:
        async with viewer(served.url, secret) as client:
            await client.open("wall")
            tokens.revoke(next(token.id for token in tokens.list() if token.name == "leaves soon"))
            with pytest.raises(ConnectionClosed) as closed:
                await client.drain(10)
            assert closed.value.rcvd is not None
            assert closed.value.rcvd.code == 4401

    run(scenario)


def test_locked_and_unknown_labels(served: Served) -> None:
    locked = served.workspace.create_label("wall", "somebody", name="locked")
    served.workspace.update_label("wall", "somebody", locked.id, locked=True)

    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.open("wall")
            for label, status in ((locked.id, 409), (4321, 404)):
                stroke = str(uuid.uuid4())
                await client.send(type="stroke_begin", id=stroke, frame=0, brush={"label": label})
                await client.send(type="stroke_samples", id=stroke, samples=[])
                await client.send(type="stroke_end", id=stroke)
                error = await client.until("error")
                assert (error["status"], error["about"]) == (status, stroke)
            await client.drain(0.2)
            assert len([m for m in client.log if m["type"] == "error"]) == 2

    run(scenario)
    served.workspace.update_label("wall", "somebody", locked.id, locked=False)
    served.workspace.delete_label("wall", "somebody", locked.id)


def test_tracking_shows_what_it_finds_and_undoes_in_one_step(served: Served) -> None:
    label = served.workspace.create_label("wall", "somebody", name="moving").id

    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.hello("Tracker")
            await client.open("wall", frame=9)
            await client.until("frame", frame=9, final=True)
            await paint(client, 9, radius=0.5, label=label)
            run_id = str(uuid.uuid4())
            await client.send(
                type="track", id=run_id, labels=[label], start=9, stop=11, method="icp"
            )
            job = await client.until("job", timeout=60, state="done")
            assert (job["kind"], job["sequence"]) == ("tracking", "wall")
            await client.drain(0.3)
            tracked = [m for m in client.log if m["type"] == "annotation" and m["provisional"]]
            assert {message["frame"] for message in tracked} <= {9, 10, 11}
            assert tracked
            for frame in (10, 11):
                np.testing.assert_array_equal(
                    client.frames[frame].values, stored_values(served, frame)
                )
            cells = [c for m in client.log if m["type"] == "timeline" for c in m["cells"]]
            mine = [cell for cell in cells if cell["label"] == label and cell["frame"] == 10]
            assert mine[-1]["confidence"] is not None
            await client.send(type="undo", id=str(uuid.uuid4()))
            undone = await client.until("stroke_result", final=True)
            await settled(client, 10, undone["revision"])
            assert not (stored_values(served, 10) == label).any()

    run(scenario)


BAD = [
    (b"", 400),
    (b"\xc1", 400),
    (b"\x81", 400),
    (msgpack.packb([1, 2]), 400),
    (msgpack.packb({1: 2}), 400),
    (msgpack.packb({"type": "unknown"}), 422),
    (msgpack.packb({"type": "open"}), 422),
    (msgpack.packb({"type": "open", "sequence": "none"}), 404),
    (msgpack.packb({"type": "open", "sequence": "../wall"}), 404),
    (msgpack.packb({"type": "seek", "frame": -1}), 422),
    (msgpack.packb({"type": "seek", "frame": FRAMES}), 422),
    (msgpack.packb({"type": "seek", "frame": 2**63}), 422),
    (msgpack.packb({"type": "seek", "frame": 1.5}), 422),
    (msgpack.packb({"type": "seek", "frame": True}), 422),
    (msgpack.packb({"type": "play", "frame": 0, "speed": float("nan")}), 422),
    (msgpack.packb({"type": "play", "frame": 0, "speed": float("inf")}), 422),
    (msgpack.packb({"type": "credit", "frames": 10**6}), 422),
    (msgpack.packb({"type": "forget", "frames": [0] * 70_000}), 400),
    (msgpack.packb({"type": "pause", "extra": 1}), 422),
    (msgpack.packb({"type": "hello", "name": "x" * 65}), 422),
    (msgpack.packb({"type": "hello", "name": b"bytes"}), 400),
    (msgpack.packb({"type": "undo", "id": "not a uuid"}), 422),
    (msgpack.packb({"type": "stroke_end", "id": str(uuid.UUID(int=1))}), 422),
    (msgpack.packb(msgpack.ExtType(5, b"x")), 400),
    (b"\x91" * 5000, 400),
]


@pytest.mark.parametrize(("data", "status"), BAD, ids=lambda v: str(v)[:50])
def test_bad_messages_are_answered_and_the_session_goes_on(
    served: Served, data: bytes, status: int
) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.open("wall")
            await client.socket.send(data)
            error = await client.until("error")
            assert error["status"] == status, error
            assert error["detail"]
            await client.hello()

    run(scenario)


def test_messages_before_open(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            for message in (
                {"type": "play", "frame": 0},
                {"type": "seek", "frame": 0},
                {"type": "presence"},
                {"type": "undo", "id": str(uuid.uuid4())},
            ):
                await client.send(**message)
                assert (await client.until("error"))["status"] == 422

    run(scenario)


async def send_and_read(client: Viewer, data: bytes | str) -> None:
    await client.socket.send(data)
    await client.drain(5)


def test_too_large_and_text_messages_close_the_socket(served: Served) -> None:
    async def scenario() -> None:
        limit = served.workspace.settings.max_message
        for data, code in ((b"x" * (limit + 1), 1009), ("text", 1003)):
            async with viewer(served.url, served.token) as client:
                with pytest.raises(ConnectionClosed) as closed:
                    await send_and_read(client, data)
                assert closed.value.rcvd is not None
                assert closed.value.rcvd.code == code

    run(scenario)


@pytest.mark.parametrize(
    ("fields", "status"),
    [
        ({"token": ""}, 401),
        ({"token": "wrong"}, 401),
        ({"origin": "http://evil.example"}, 403),
        ({"protocol": "pointbrush.000000000000"}, 403),
    ],
)
def test_refused_handshakes(served: Served, fields: dict[str, Any], status: int) -> None:
    async def scenario() -> None:
        arguments = {"token": served.token} | fields
        with pytest.raises(InvalidStatus) as refused:
            async with viewer(served.url, **arguments):
                pass
        assert refused.value.response.status_code == status
        assert b"status" in refused.value.response.body

    run(scenario)


def test_own_origin_is_welcome(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token, origin=served.url) as client:
            await client.hello()

    run(scenario)


def test_deleting_a_sequence_tells_its_viewers(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.open("other")
            await asyncio.to_thread(served.workspace.delete_sequence, "other")
            assert (await client.until("error"))["status"] == 404
            await client.open("wall")

    run(scenario)
