"""The page's message types follow the models."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from pointbrush.streaming import schema, typescript


def test_the_committed_types_are_current(capsys: pytest.CaptureFixture[str]) -> None:
    assert typescript.main(["--check"]) == 0, capsys.readouterr().err


def test_check_fails_on_drift(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = ["--target", str(tmp_path)]
    assert typescript.main(["--check", *target]) == 1
    assert typescript.main(["--write", *target]) == 0
    assert typescript.main(["--check", *target]) == 0
    stale = tmp_path / "messages.ts"
    stale.write_text(stale.read_text().replace("frame: number", "frame: string", 1))
    assert typescript.main(["--check", *target]) == 1
    assert "is stale" in capsys.readouterr().err


def test_types_are_as_strict_as_typescript_can_say() -> None:
    text = typescript.messages()
    assert "  origin: [number, number, number];\n" in text
    assert "  direction?: [number, number, number];\n" in text
    assert "  data: Uint8Array;" in text
    assert "  counts: Record<string, number>;" in text
    assert "  hands?: ([number, number, number, number, number, number, number] | null)[];" in text


def test_values_are_those_that_the_page_imports_and_the_ones_inside_them(tmp_path: Path) -> None:
    module = tmp_path / "people" / "boxes.tsx"
    module.parent.mkdir()
    module.write_text(
        "import type { Found } from './found';\n"
        "import type {\n  BoxPose as Pose,\n  Boxes,\n} from '../protocol/values';\n"
    )
    assert typescript.imported(tmp_path) == {"BoxPose", "Boxes"}
    interfaces = re.findall(r"export interface (\w+)", typescript.values({"Boxes"}))
    assert interfaces == ["Box", "BoxPose", "Boxes"]


def test_a_schema_that_typescript_cannot_say_is_refused() -> None:
    with pytest.raises(ValueError, match="expected a schema"):
        typescript.type_of({"type": "mystery"})


def test_the_hash_follows_the_shape_and_not_the_prose(monkeypatch: pytest.MonkeyPatch) -> None:
    def digest(client: dict[str, object]) -> str:
        monkeypatch.setattr(schema, "client_schema", lambda: client)
        schema.schema_hash.cache_clear()
        return schema.schema_hash()

    title_field = {"properties": {"title": {"type": "string", "description": "old words"}}}
    reworded = {"properties": {"title": {"type": "string", "description": "new words"}}}
    retyped = {"properties": {"title": {"type": "integer", "description": "old words"}}}
    renamed = {"properties": {"name": {"type": "string", "description": "old words"}}}
    try:
        assert digest(title_field) == digest(reworded)
        assert len({digest(title_field), digest(retyped), digest(renamed)}) == 3
    finally:
        monkeypatch.undo()
        schema.schema_hash.cache_clear()
