"""Strokes that are given up, and frames that take none."""

from __future__ import annotations

import uuid
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from pointbrush.frame import PointFrame
from pointbrush.sequences import RecordingInfo, import_frames
from tests.serving import Served, serving, settings_in, surface
from tests.streaming.acting import run
from tests.streaming.client import Viewer, viewer


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Served]:
    settings = settings_in(tmp_path)
    nothing = PointFrame(np.empty((0, 3), np.float32), np.empty((0, 3), np.uint8))
    import_frames(
        iter([surface(2_000, 0), nothing]),
        settings.workspace / "sequences" / "wall",
        RecordingInfo("wall", "wall", 30.0),
    )
    with serving(settings) as running:
        running.workspace.labels.create_label("wall", "somebody", name="pin")
        yield running


async def begin(client: Viewer, frame: int = 0, **brush: object) -> str:
    stroke = str(uuid.uuid4())
    fields = {"label": 1, "radius": 0.5, **brush}
    await client.send(type="stroke_begin", id=stroke, frame=frame, brush=fields)
    return stroke


def test_a_stroke_that_is_given_up_leaves_nothing(served: Served) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.open("wall", frame=0)
            for _ in range(12):  # more than may be live at a time
                stroke = await begin(client)
                sample = {"origin": [0.0, 0.0, 3.0]}
                await client.send(type="stroke_samples", id=stroke, samples=[sample])
                await client.until("stroke_result", id=stroke)
                await client.send(type="stroke_cancel", id=stroke)
            await client.send(type="stroke_end", id=stroke)
            assert "has begun" in (await client.until("error", about=stroke))["detail"]

    run(scenario)
    assert [edit.kind for edit in served.workspace.labels.edits("wall")] == ["label"]


@pytest.mark.parametrize(
    "brush",
    [
        {"shape": "sphere"},
        {"shape": "ray"},
        {"shape": "grow"},
        {"shape": "plane"},
        {"shape": "box", "center": [0.0, 0.0, 0.0], "size": [1.0, 1.0, 1.0]},
        {
            "shape": "lasso",
            "polygon": [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            "matrix": np.eye(4).ravel().tolist(),
        },
    ],
)
def test_an_empty_frame_takes_no_strokes(served: Served, brush: dict[str, object]) -> None:
    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.open("wall", frame=0)
            stroke = await begin(client, frame=1, **brush)
            refused = await client.until("error", about=stroke)
            assert "the frame is empty" in refused["detail"]

    run(scenario)


@pytest.mark.parametrize("change", [{"locked": True}, {"visible": False}, None])
def test_a_stroke_ends_where_its_label_may_not_be_painted_with_any_more(
    served: Served, change: dict[str, bool] | None
) -> None:
    workspace = served.workspace

    async def scenario() -> None:
        async with viewer(served.url, served.token) as client:
            await client.open("wall", frame=0)
            stroke, sample = await begin(client), {"origin": [0.0, 0.0, 3.0]}
            await client.send(type="stroke_samples", id=stroke, samples=[sample])
            await client.until("stroke_result", id=stroke)
            if change is None:
                workspace.labels.delete_label("wall", "somebody", 1)
            else:
                workspace.labels.update_label("wall", "somebody", 1, **change)
            await client.send(type="stroke_samples", id=stroke, samples=[sample])
            refused = await client.until("error", about=stroke)
            assert "label" in refused["detail"]
            await client.send(type="stroke_end", id=stroke)

    run(scenario)
    assert {edit.kind for edit in workspace.labels.edits("wall")} == {"label"}
