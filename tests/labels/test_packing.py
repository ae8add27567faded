from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pointbrush.labels.packing import (
    BLOCK,
    Change,
    decode_change,
    decode_states,
    deleted_of,
    encode_change,
    encode_states,
    label_of,
    provenance_of,
    writer_of,
)


@given(
    st.lists(st.integers(0, BLOCK - 1), unique=True, max_size=300),
    st.integers(1, 2**38),
    st.integers(0, 2**32),
)
def test_a_change_comes_back_as_it_was(points: list[int], writers: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    indices = np.array(sorted(points), np.int64)
    before, after = (
        (rng.integers(0, writers, len(points), np.uint64) << np.uint64(25))
        | rng.integers(0, 1 << 25, len(points), np.uint64)
        for _ in range(2)
    )
    change = decode_change(encode_change(Change(indices, before, after)))
    assert (change.indices == indices).all()
    assert (change.before == before).all()
    assert (change.after == after).all()


def test_a_whole_block_of_different_words_fits() -> None:
    words = np.arange(2 * BLOCK, dtype=np.uint64)
    change = Change(np.arange(BLOCK), words[:BLOCK], words[BLOCK:])
    again = decode_change(encode_change(change))
    assert (again.after == change.after).all()
    assert (again.indices == change.indices).all()
    assert (decode_states(encode_states(words[:BLOCK])) == words[:BLOCK]).all()


def test_a_word_has_four_parts() -> None:
    word = np.array([(123_456 << 25) | (1 << 24) | (3 << 16) | 65_534], np.uint64)
    parts = (writer_of(word)[0], deleted_of(word)[0], provenance_of(word)[0], label_of(word)[0])
    assert parts == (123_456, True, 3, 65_534)
