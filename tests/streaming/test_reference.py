from __future__ import annotations

from pathlib import Path

from pointbrush.streaming.reference import generate

DOCS = Path(__file__).parents[2] / "docs"


def test_the_pages_of_messages_are_fresh() -> None:
    for name, text in generate().items():
        written = (DOCS / name).read_text(encoding="utf-8")
        assert written == text, "run `python -m pointbrush.streaming.reference`"


def test_every_message_of_the_contract_is_described() -> None:
    text = "".join(generate().values())
    for name in (
        "hello", "open", "play", "pause", "seek", "credit", "stroke_begin", "stroke_samples",
        "stroke_end", "undo", "redo", "track", "presence", "welcome", "sequence", "frame",
        "annotation", "stroke_result", "labels", "job", "error",
    ):  # fmt: skip
        assert f"## {name}\n" in text
