"""Messages that one side writes and the other reads: the same files in Python and TypeScript.

``tests/golden/server_messages.json`` is written here (``python tests/streaming/
test_golden_messages.py``) and read by the page's tests; ``client_messages.json`` is written by
them (``UPDATE_GOLDEN=1 npm test``) and read here.
"""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any, get_args

import msgpack
import pytest

from pointbrush.streaming import messages as m
from pointbrush.streaming.encoding import decode, encode

GOLDEN = Path(__file__).parents[1] / "golden"
CHUNK = m.Chunk(
    index=2,
    level=1,
    first=4096,
    count=3,
    offset=7,
    nbytes=40,
    origin=[-1.5, 0.25, 3.0],
    scale=[0.001, 0.001, 0.0005],
    lo=[-1.5, 0.25, 3.0],
    hi=[1.0, 2.0, 4.75],
)
LABEL = m.Label(
    id=65534, name="Kegel – rot ☃", category="pin", color="#ff5d5d", locked=True, visible=False
)
SERVER: list[m.Message] = [
    m.Welcome(viewer="v1", author="Ada", role="annotator", version="0.1.0", credits=8),
    m.SequenceInfo(
        id="juggling",
        identity="9f86d081884c7d65",
        name="Juggling",
        frames=3,
        fps=29.97,
        points=[5, 2**31, 0],
        fields=["xyz", "rgb"],
        shift=[500000.0, -4000000.5, 0.0],
        lo=[-1.0, -2.0, 0.0],
        hi=[1.0, 2.0, 3.0],
        room=[float(i) for i in range(16)],
        cameras=True,
        large=False,
        position_error=0.0005,
        color_error=4.5,
        lattice=m.Lattice(
            width=512,
            height=424,
            axis=2,
            sign=1,
            tangent=[-0.6875, -0.5625],
            pitch=[0.00390625, 0.00390625],
            eye=[0.0, 1.5, 0.0],
            unit=0.001,
        ),
        sensors=[
            m.SensorInfo(
                name="links ☃",
                type="depth",
                lattice=None,
                T_frame_sensor=[[float(i) for i in range(16)]],
                correction=[float(i % 5 == 0) for i in range(16)],
            )
        ],
        revision=2**40,
        frame=1,
    ),
    m.Frame(
        sequence="juggling", frame=1, total=5, final=True, chunks=[CHUNK], data=bytes(range(256))
    ),
    m.Depth(
        sequence="juggling",
        frame=1,
        total=5,
        final=False,
        chunks=[
            m.DepthChunk(
                index=0,
                level=0,
                first=0,
                count=3,
                offset=0,
                nbytes=40,
                lo=[-1.5, 0.25, 3.0],
                hi=[1.0, 2.0, 4.75],
            )
        ],
        data=bytes(range(40)),
    ),
    m.Annotation(
        sequence="juggling",
        frame=1,
        revision=7,
        base=None,
        first=0,
        count=5,
        lengths=bytes([2, 0, 0, 0, 3, 0, 0, 0]),
        values=bytes([0, 0, 255, 255]),
    ),
    m.Annotation(
        sequence="juggling",
        frame=1,
        revision=8,
        base=7,
        edit="5f0c8a52-0b0e-4c0a-8a50-3a3f6a4d9f11",
        author="Ada",
        provisional=True,
        lengths=bytes([1, 0, 0, 0]),
        values=bytes([3, 0]),
    ),
    m.Candidates(
        id="5f0c8a52-0b0e-4c0a-8a50-3a3f6a4d9f11",
        frame=1,
        first=0,
        ready=False,
        candidates=[m.Candidate(id="c0ffee", level=0, score=0.75, points=3, runs=bytes(8))],
    ),
    m.Prepared(sequence="juggling", frame=1),
    m.Compiling(step="objects", share=0.25, seconds=None),
    m.StrokeResult(
        id="5f0c8a52-0b0e-4c0a-8a50-3a3f6a4d9f11",
        frame=1,
        touched=12,
        changed=10,
        edit=None,
        revision=8,
        final=False,
    ),
    m.Labels(
        sequence="juggling",
        revision=8,
        labels=[LABEL],
        counts={"65534": 10},
        undo="paint 10 points",
        redo=None,
    ),
    m.Timeline(
        sequence="juggling",
        revision=8,
        whole=True,
        frames=bytes.fromhex("0100000002000000"),
        labels=bytes.fromhex("feff0100"),
        points=bytes.fromhex("0a00000000000000"),
        painted=bytes(8),
        confidence=bytes.fromhex("0000403f0000c07f"),
        states=b"\x02\x00",
    ),
    m.Boxes(
        sequence="juggling",
        revision=9,
        whole=False,
        boxes=[
            m.Box(
                id=3,
                label=65534,
                size=(4.5, 1.75, 1.5),
                poses={
                    "7": m.BoxPose(
                        centre=(500010.5, -4000000.25, 0.75),
                        quaternion=(0.0, 0.0, 0.6, 0.8),
                        provenance="fitted",
                        confidence=0.5,
                        attributes={"truncated": 0.25},
                    )
                },
                attributes={"parked": True, "occluded": 2.0, "note": "rot ☃"},
                provenance="drawn",
                heading_known=False,
            )
        ],
        removed=[1, 2],
    ),
    m.Job(
        id="job1",
        kind="tracking",
        sequence="juggling",
        state="running",
        progress=0.5,
        message="frame 12",
        frame=12,
    ),
    m.ServerPresence(
        viewer="v2",
        name="Bo",
        color="#2fd5e0",
        left=False,
        frame=3,
        head=[0.0, 1.6, 0.0, 0.0, 0.0, 0.0, 1.0],
        hands=[None, [0.1, 1.2, -0.3, 0.0, 0.0, 0.0, 1.0]],
        brush=None,
        radius=0.05,
        label=3,
    ),
    m.Error(title="Conflict", detail="expected something to undo", status=409, about=None),
]


def plain(value: Any) -> Any:
    """JSON has no bytes: they are written as ``{"$bytes": base64}``."""
    if isinstance(value, bytes):
        return {"$bytes": base64.b64encode(value).decode()}
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return value


def written() -> list[dict[str, Any]]:
    return [
        {
            "bytes": base64.b64encode(encode(message)).decode(),
            "message": plain(message.model_dump()),
        }
        for message in SERVER
    ]


def types_of(union: Any) -> set[str]:
    members = get_args(get_args(union)[0])
    return {member.model_fields["type"].default for member in members}


def test_server_messages_are_the_golden_ones() -> None:
    assert json.loads((GOLDEN / "server_messages.json").read_text()) == written()


def test_every_server_message_is_among_them() -> None:
    assert {message.type for message in SERVER} == types_of(m.ServerMessage)  # type: ignore[attr-defined]


def golden_client() -> list[dict[str, Any]]:
    content: list[dict[str, Any]] = json.loads((GOLDEN / "client_messages.json").read_text())
    return content


@pytest.mark.parametrize("entry", golden_client(), ids=lambda entry: entry["message"]["type"])
def test_client_messages_of_the_page_are_understood(entry: dict[str, Any]) -> None:
    data = base64.b64decode(entry["bytes"])
    assert msgpack.unpackb(data) == entry["message"]
    understood = decode(data).model_dump()
    sent = entry["message"]
    assert {key: understood[key] for key in sent if key not in ("brush", "samples")} == {
        key: value for key, value in sent.items() if key not in ("brush", "samples")
    }


def test_every_client_message_is_among_them() -> None:
    assert {entry["message"]["type"] for entry in golden_client()} == types_of(m.ClientMessage)


if __name__ == "__main__":
    text = json.dumps(written(), indent=1, ensure_ascii=False) + "\n"
    (GOLDEN / "server_messages.json").write_text(text)
