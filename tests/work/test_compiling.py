"""Compiling the loops once on a machine: told while it is done, and not done again."""

from __future__ import annotations

from pathlib import Path

import pytest

from pointbrush.work import prepare
from pointbrush.work.compiling import are_compiled
from pointbrush.work.prepare import compile_loops


def test_loops_are_compiled_once_for_a_version_and_progress_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    done: list[str] = []
    steps = [(name, lambda name=name: done.append(name)) for name in ("import", "tracking")]
    monkeypatch.setattr(prepare, "STEPS", steps)
    told: list[tuple[float, str]] = []
    for _ in range(2):
        compile_loops(lambda share, message: told.append((share, message)))
        assert are_compiled()
    assert done == ["import", "tracking"]
    assert [share for share, _ in told] == [0.0, 0.5]
    assert all("once on this machine" in message for _, message in told)
    monkeypatch.setattr("pointbrush.__version__", "another")
    assert not are_compiled()


def test_what_was_interrupted_is_begun_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))

    def interrupted() -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(prepare, "STEPS", [("import", interrupted)])
    with pytest.raises(KeyboardInterrupt):
        compile_loops(lambda _share, _message: None)
    assert not are_compiled()
