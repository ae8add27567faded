from __future__ import annotations

from pathlib import Path

from pointbrush.streaming.reference import generate

DOCS = Path(__file__).parents[2] / "docs"


def test_the_page_of_messages_is_fresh() -> None:
    text = (DOCS / "messages.md").read_text(encoding="utf-8")
    assert text == generate(), "run `python -m pointbrush.streaming.reference`"


def test_every_message_of_the_contract_is_described() -> None:
    text = generate()
    for name in (
        "hello", "open", "play", "pause", "seek", "credit", "stroke_begin", "stroke_samples",
        "stroke_end", "undo", "redo", "track", "presence", "welcome", "sequence", "frame",
        "annotation", "stroke_result", "labels", "job", "error",
    ):  # fmt: skip
        assert f"### {name}\n" in text
