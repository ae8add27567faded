"""The socket, as a page sees it: edits, its own and those of others."""

from __future__ import annotations

import io
import uuid
from typing import Any

import httpx
import numpy as np

from pointbrush.labels import Category
from pointbrush.streaming.shared.board import STATES
from tests.serving import Served
from tests.streaming.acting import paint, run, settled, stored_values
from tests.streaming.client import Viewer, cells_of, two_viewers, viewer


def test_a_stroke_reaches_every_viewer_of_the_frame(served: Served) -> None:
    async def scenario() -> None:
        async with two_viewers(served) as (anna, ben):
            for client in (anna, ben):
                await client.open("wall", frame=1)
                await client.until("frame", frame=1, final=True)
            done = await paint(anna, 1)
            assert done["changed"] == done["touched"] > 0
            assert done["edit"] == done["id"]
            for client in (anna, ben):
                await settled(client, 1, done["revision"])
                np.testing.assert_array_equal(client.frames[1].values, stored_values(served, 1))
                assert client.gaps == 0

    run(scenario)


def test_a_stroke_on_several_frames_is_one_edit_that_all_of_them_hear_of(served: Served) -> None:
    async def scenario() -> None:
        async with two_viewers(served) as (anna, ben):
            await anna.open("wall", frame=4)
            await ben.open("wall", frame=9)
            await ben.until("frame", frame=9, final=True)
            await anna.send(type="seek", frame=4, around=[9, 7])
            missing = {4, 7, 9}
            while missing:
                message = await anna.until("frame", final=True)
                missing.discard(message["frame"])
            done = await paint(anna, 4, frames=[7, 9])
            for client, frames in ((anna, (4, 7, 9)), (ben, (9,))):
                for frame in frames:
                    await settled(client, frame, done["revision"])
                    values = stored_values(served, frame)
                    np.testing.assert_array_equal(client.frames[frame].values, values)
            # Sent again, as after a lost answer, it is answered and counts once.
            await anna.send(
                type="stroke_begin", id=done["id"], frame=4, brush={"label": 1, "frames": [7, 9]}
            )
            await anna.send(type="stroke_end", id=done["id"])
            again = await anna.until("stroke_result", final=True, id=done["id"])
            assert (again["revision"], again["changed"]) == (done["revision"], done["changed"])
            undo = str(uuid.uuid4())
            await anna.send(type="undo", id=undo)
            undone = await anna.until("stroke_result", id=undo)
            assert undone["changed"] == done["changed"]

    run(scenario)


def test_a_stroke_takes_the_points_that_the_page_found(served: Served) -> None:
    async def end(client: Viewer, frame: int, runs: list[list[int]]) -> dict[str, Any]:
        stroke = str(uuid.uuid4())
        brush = {"label": 1, "radius": 0.3}
        await client.send(type="stroke_begin", id=stroke, frame=1, brush=brush)
        sample = {"origin": [0.0, 0.0, 3.0]}
        await client.send(type="stroke_samples", id=stroke, samples=[sample])
        touched = [{"frame": frame, "runs": np.array(runs, "<u4").tobytes()}]
        await client.send(type="stroke_end", id=stroke, touched=touched)
        while True:
            answer = await client.receive()
            if answer["type"] == "error" or (answer["type"] == "stroke_result" and answer["final"]):
                return answer

    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.open("wall", frame=1)
            await client.until("frame", frame=1, final=True)
            # Other tests paint on this recording, too.
            before = stored_values(served, 1)
            a, b, c, d = np.flatnonzero(before == 0)[:4].tolist()
            done = await end(client, 1, [[a, 1], [b, 1], [c, 1]])
            assert (done["touched"], done["changed"]) == (3, 3)
            before[[a, b, c]] = 1
            np.testing.assert_array_equal(stored_values(served, 1), before)
            assert (await end(client, 1, [[a, 1], [b, 1], [c, 1], [d, 1]]))["changed"] == 1
            before[d] = 1
            count = len(before)
            for frame, runs in ((1, [[count - 1, 2]]), (1, [[5, 2], [6, 1]]), (2, [[0, 1]])):
                assert (await end(client, frame, runs))["status"] == 422
            np.testing.assert_array_equal(stored_values(served, 1), before)

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
            cell = next(cell for cell in cells_of(timeline) if cell["frames"] == 2)
            assert STATES[cell["states"]] == "painted"
            assert cell["painted"] == cell["points"] == labels["counts"]["1"] - before
            undo = str(uuid.uuid4())
            await client.send(type="undo", id=undo)
            undone = await client.until("stroke_result", id=undo)
            assert undone["changed"] == done["changed"]
            await client.send(type="undo", id=str(uuid.uuid4()))
            error = await client.until("error")
            assert error["status"] == 409

    run(scenario)


def test_what_is_sent_in_one_piece_is_answered_one_by_one_in_order(served: Served) -> None:
    async def scenario() -> None:
        strokes = [str(uuid.uuid4()) for _ in range(4)]
        async with viewer(served.url, served.token) as client:
            await client.open("wall", frame=3)
            await client.until("frame", frame=3, final=True)
            for number, stroke in enumerate(strokes):
                # The second has a label that does not exist; one answer says so.
                brush = {"label": 999 if number == 1 else 1, "radius": 0.2}
                sample = {"origin": [0.5 * number - 0.7, 0.1, 3.0]}
                await client.send(type="stroke_begin", id=stroke, frame=3, brush=brush)
                await client.send(type="stroke_samples", id=stroke, samples=[sample])
                await client.send(type="stroke_end", id=stroke)
            undo = str(uuid.uuid4())
            await client.send(type="undo", id=undo)
            await client.until("stroke_result", id=undo)
        answers = [m for m in client.log if m["type"] in ("stroke_result", "error")]
        told = [(m.get("id") or m["about"], m.get("final")) for m in answers]
        good = [(stroke, final) for stroke in strokes for final in (False, True)]
        assert told == [*good[:2], (strokes[1], None), *good[4:], (undo, True)]
        *done, undone = answers
        changed = [m["changed"] for m in done if m.get("final") and m["changed"]]
        assert undone["changed"] == changed[-1]

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
        async with two_viewers(served) as (anna, ben):
            await ben.open("wall", frame=5)
            await ben.until("frame", frame=5, final=True)
            await ben.send(type="seek", frame=9)
            await ben.until("frame", frame=9, final=True)
            await anna.open("wall", frame=5)
            done = await paint(anna, 5, radius=0.8)
            await settled(ben, 5, done["revision"])
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
            await settled(client, 7, revision)
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


def test_locked_and_unknown_labels(served: Served) -> None:
    locked = served.workspace.labels.create_label("wall", "somebody", name="locked")
    served.workspace.labels.update_label("wall", "somebody", locked.id, locked=True)

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
    served.workspace.labels.update_label("wall", "somebody", locked.id, locked=False)
    served.workspace.labels.delete_label("wall", "somebody", locked.id)


def test_what_a_viewer_hides_is_left_alone(served: Served) -> None:
    under = served.workspace.labels.create_label("wall", "somebody", name="under").id

    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.open("wall", frame=6)
            done = await paint(client, 6, label=under, radius=0.5)
            before = stored_values(served, 6) == under
            assert before.sum() == done["changed"]
            brush = {"label": 1, "radius": 100, "hidden": [under]}
            stroke = str(uuid.uuid4())
            await client.send(type="stroke_begin", id=stroke, frame=6, brush=brush)
            sample = {"origin": [0, 0, 0]}
            await client.send(type="stroke_samples", id=stroke, samples=[sample])
            said = await client.until("stroke_result", id=stroke)
            await client.send(type="stroke_end", id=stroke)
            done = await client.until("stroke_result", id=stroke, final=True)
            assert said["changed"] == done["changed"] == (~before).sum()
            np.testing.assert_array_equal(stored_values(served, 6) == under, before)
            refused = str(uuid.uuid4())
            brush = {"label": under, "hidden": [under]}
            await client.send(type="stroke_begin", id=refused, frame=6, brush=brush)
            error = await client.until("error", about=refused)
            assert error["status"] == 409
            assert error["detail"] == (
                f"label: 'under' ({under}) is hidden; show it to paint with it"
            )

    run(scenario)


async def told_confidence(client: Viewer, label: int, frame: int) -> None:
    """Receive until the timeline's last word on a label in a frame has a confidence."""
    while True:
        cells = [c for m in client.log if m["type"] == "timeline" for c in cells_of(m)]
        mine = [cell for cell in cells if cell["labels"] == label and cell["frames"] == frame]
        if mine and np.isfinite(mine[-1]["confidence"]):
            return
        await client.receive()


def test_tracking_shows_what_it_finds_and_undoes_in_one_step(served: Served) -> None:
    label = served.workspace.labels.create_label("wall", "somebody", name="moving").id

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
            job = await client.until("job", state="done")
            assert (job["kind"], job["sequence"]) == ("tracking", "wall")
            for frame in (10, 11):
                await settled(client, frame, served.workspace.labels.edits("wall")[0].revision)
            await told_confidence(client, label, 10)
            tracked = [m for m in client.log if m["type"] == "annotation" and m["provisional"]]
            assert {message["frame"] for message in tracked} <= {9, 10, 11}
            assert tracked
            for frame in (10, 11):
                np.testing.assert_array_equal(
                    client.frames[frame].values, stored_values(served, frame)
                )
            await client.send(type="undo", id=str(uuid.uuid4()))
            undone = await client.until("stroke_result", final=True)
            await settled(client, 10, undone["revision"])
            assert not (stored_values(served, 10) == label).any()

    run(scenario)


def test_a_new_name_of_a_class_reaches_every_viewer(served: Served) -> None:
    async def scenario() -> None:
        async with two_viewers(served) as (anna, ben):
            for client in (anna, ben):
                await client.open("wall", frame=1)
                await client.until("labels")
            taxonomy = served.workspace.labels.taxonomy
            served.workspace.labels.update_label("wall", "ann", 1, category="pin")
            number = taxonomy.numbers(["pin"])["pin"]
            taxonomy.put([Category(number, "needle")])
            for client in (anna, ben):
                while (await client.until("labels"))["labels"][0]["category"] != "needle":
                    pass

    run(scenario)
