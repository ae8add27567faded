"""Shortages that may pass are 503 in words; what merely looks like one is not."""

from __future__ import annotations

import errno
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from pointbrush.sequences import Sequence as Recording
from pointbrush.system.resources import NO_THREAD
from pointbrush.web.routes import frames
from pointbrush.work.exporting import SENT, source_columns
from tests.serving import Served, add_sequence, serving, settings_in


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    folder: Path = tmp_path_factory.mktemp("short")
    settings = settings_in(folder)
    add_sequence(settings, "wall", frames=1, points=100)
    with serving(settings) as started:
        yield started


@pytest.mark.parametrize(
    ("error", "status", "words"),
    [
        (MemoryError(), 503, "too little memory"),
        (OSError(errno.ENOMEM, "x"), 503, "too little memory"),
        (RuntimeError(NO_THREAD), 503, "too little memory"),
        (ImportError("a.so: failed to map segment from shared object"), 503, "too little memory"),
        (ImportError("a.so: cannot open: Too many open files"), 503, "too many files"),
        (OSError(errno.EMFILE, "x"), 503, "too many files"),
        (RuntimeError("a fault"), 500, "its log has the reason"),
        (ImportError("no such module"), 500, "its log has the reason"),
    ],
)
def test_the_answer_says_what_is_short(
    served: Served, monkeypatch: pytest.MonkeyPatch, error: Exception, status: int, words: str
) -> None:
    def short(_: str) -> None:
        raise error

    monkeypatch.setattr(served.workspace.labels, "palette", short)
    answer = httpx.get(f"{served.url}/api/v1/sequences/wall/labels", headers=served.headers)
    assert (answer.status_code, words in answer.json()["detail"]) == (status, True)


def test_an_answer_that_runs_out_of_memory_breaks_off_with_a_line_in_the_log(
    served: Served, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def short(recording: Recording, frame: int, names: Collection[str] = SENT) -> Iterator[Any]:
        if names == ("rgb",):
            raise MemoryError
        yield from source_columns(recording, frame, names)

    monkeypatch.setattr(frames, "source_columns", short)
    url = f"{served.url}/api/v1/sequences/wall/frames/0/points?format=npz"
    with pytest.raises(httpx.RemoteProtocolError):
        httpx.get(url, headers=served.headers)
    assert [record.exc_info for record in caplog.records if record.exc_info] == []
    assert "too little memory" in caplog.text
