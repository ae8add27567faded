"""Files in the cache are whole, kept while they are in use, and within the bound otherwise."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from pointbrush.errors import DamagedError
from pointbrush.sequences.storage.file_cache import FileCache, Hold, held

SIZE = 100


class Source:
    """Files of ``SIZE`` bytes, and how often each was fetched."""

    def __init__(self, folder: Path, capacity: int) -> None:
        self.cache, self.fetched = FileCache(folder, capacity), list[str]()

    def hold(self, name: str) -> Hold:
        def fetch(target: Path) -> None:
            self.fetched.append(name)
            target.write_bytes(name.encode() * SIZE)

        return Hold([self.cache.hold(self.path(name), SIZE, fetch)])

    def read(self, name: str) -> None:
        with self.hold(name):
            assert self.path(name).read_bytes() == name.encode() * SIZE

    def path(self, name: str) -> Path:
        return self.cache.folder / "recording" / name

    def here(self) -> set[str]:
        return {path.name for path in (self.cache.folder / "recording").iterdir()}


@pytest.fixture
def source_of(tmp_path: Path) -> Callable[[int], Source]:
    return lambda capacity: Source(tmp_path / "cache", capacity)


def test_the_least_recently_used_file_goes_and_one_that_is_held_stays(
    source_of: Callable[[int], Source],
) -> None:
    source = source_of(3 * SIZE)
    with source.hold("a"):
        for name in "bcb":
            source.read(name)
        assert source.fetched == ["a", "b", "c"]
        source.read("d")
        assert source.here() == {"a", "d"}  # `b` too, for some room; `a`, the oldest, is in use
        assert source.path("a").read_bytes() == b"a" * SIZE
    source.read("e")
    source.read("f")
    assert "a" not in source.here()


def test_what_is_held_may_exceed_the_bound(source_of: Callable[[int], Source]) -> None:
    source = source_of(SIZE // 2)
    with source.hold("a"), source.hold("b"):
        assert source.here() == {"a", "b"}
        assert source.fetched == ["a", "b"]


def test_a_lost_or_truncated_file_comes_anew(source_of: Callable[[int], Source]) -> None:
    source = source_of(10 * SIZE)
    source.read("a")
    source.path("a").unlink()
    source.read("a")
    source.path("a").write_bytes(b"a")
    source.read("a")
    assert source.fetched == ["a"] * 3


def test_readers_at_once_fetch_once(source_of: Callable[[int], Source]) -> None:
    source = source_of(10 * SIZE)
    threads = [threading.Thread(target=source.read, args=["a"]) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert source.fetched == ["a"]


def test_a_fetch_that_fails_or_brings_another_length_leaves_nothing(tmp_path: Path) -> None:
    cache, path = FileCache(tmp_path, 10 * SIZE), tmp_path / "recording" / "a"

    def fail(target: Path) -> None:
        target.write_bytes(b"half")
        raise ConnectionError

    with pytest.raises(ConnectionError):
        cache.hold(path, SIZE, fail)
    with pytest.raises(DamagedError, match="expected 100 bytes of a, got 4"):
        cache.hold(path, SIZE, lambda target: (target.write_bytes(b"half"), None)[1])
    assert held(path, SIZE) is None
    assert list(path.parent.iterdir()) == []
