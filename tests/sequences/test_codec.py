"""The vertex codec: its round trip, and the page's decoder."""

from __future__ import annotations

import base64
import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pointbrush.errors import BadInputError
from pointbrush.sequences.wire.encoder import encode_vertices
from tests.sequences.vertex_decoder import decode_vertices

ROOT = Path(__file__).parents[2]
MODULES = ROOT / "webxr_client" / "node_modules" / "meshoptimizer"


def vertices(seed: int, count: int, stride: int, spread: int) -> np.ndarray:
    """Random walks of differing roughness: all four ways to pack a group occur."""
    rng = np.random.default_rng(seed)
    rough = rng.integers(0, spread + 1, (-(-count // 16), stride)).repeat(16, axis=0)[:count]
    steps = rng.integers(-128, 128, (count, stride)) * rough // 128
    return np.cumsum(steps, axis=0).astype(np.uint8)


@given(
    st.integers(0, 2**32 - 1),
    st.integers(0, 1500),
    st.sampled_from([4, 8, 12, 16, 32, 36, 64, 256]),
    st.integers(0, 128),
    st.integers(0, 3),
)
def test_round_trip(seed: int, count: int, stride: int, spread: int, words: int) -> None:
    data = vertices(seed, count, stride, spread)
    stream = encode_vertices(data, min(words, stride // 4))
    assert np.array_equal(decode_vertices(stream, count, stride), data)


@pytest.mark.parametrize("shape", [(5,), (5, 10), (5, 0), (5, 260)])
def test_other_shapes_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(BadInputError, match="expected"):
        encode_vertices(np.zeros(shape, np.uint8))


def test_smooth_data_shrinks_constants_vanish_and_noise_does_not_grow() -> None:
    assert len(encode_vertices(vertices(1, 65536, 12, 2))) < 0.5 * 65536 * 12
    assert len(encode_vertices(np.full((65536, 12), 7, np.uint8))) < 1_000
    noise = np.random.default_rng(0).integers(0, 256, (65536, 12), np.uint8)
    assert len(encode_vertices(noise, 1)) < 1.002 * noise.nbytes


def test_words_have_differences_of_their_own() -> None:
    """A step across a multiple of 256 changes both bytes of a value, but is a small step."""
    values = (768 + np.random.default_rng(0).integers(-3, 4, (4096, 2))).astype("<u2")
    data = values.view(np.uint8)
    assert len(encode_vertices(data, 1)) < 0.8 * len(encode_vertices(data))


DECODE = """
import { MeshoptDecoder } from "MODULE";
let text = "";
for await (const part of process.stdin) text += part;
await MeshoptDecoder.ready;
const out = JSON.parse(text).map(({ count, stride, data }) => {
  const target = new Uint8Array(count * stride);
  MeshoptDecoder.decodeVertexBuffer(target, count, stride, Buffer.from(data, "base64"));
  return Buffer.from(target).toString("base64");
});
process.stdout.write(JSON.stringify(out));
"""


@pytest.mark.skipif(not MODULES.is_dir(), reason="the page's modules are not installed")
@pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")
def test_the_pages_decoder_reads_our_streams() -> None:
    cases = [
        vertices(seed, count, stride, spread)
        for seed, (count, stride, spread) in enumerate(
            [
                (1, 12, 9),
                (15, 12, 128),
                (16, 12, 1),
                (255, 12, 30),
                (256, 12, 0),
                (257, 12, 128),
                (65536, 12, 20),
                (4000, 16, 60),
                (4000, 64, 5),
                (700, 256, 128),
                (3, 4, 3),
            ]
        )
    ]
    given = [
        {
            "count": len(case),
            "stride": case.shape[1],
            "data": base64.b64encode(encode_vertices(case, words)).decode(),
        }
        for case in cases
        for words in (0, case.shape[1] // 8)
    ]
    module = next(MODULES.glob("meshopt_decoder.*js"))
    run = subprocess.run(
        ["node", "--input-type=module", "-e", DECODE.replace("MODULE", module.as_uri())],
        input=json.dumps(given),
        capture_output=True,
        text=True,
        timeout=60,
        check=True,
    )
    twice = [case for case in cases for _ in range(2)]
    for case, text in zip(twice, json.loads(run.stdout), strict=True):
        assert base64.b64decode(text) == case.tobytes()
