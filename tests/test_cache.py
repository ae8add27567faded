"""The cache keeps what was used last, within its size."""

from __future__ import annotations

from pointbrush.sequences.storage.cache import Cache


def test_the_least_recently_used_goes_first() -> None:
    made: list[str] = []
    cache: Cache[str, str] = Cache(10)

    def get(key: str, size: int) -> str:
        return cache.get(key, lambda: made.append(key) or key.upper(), size)

    assert [get("a", 4), get("b", 4), get("a", 4)] == ["A", "B", "A"]
    assert made == ["a", "b"]
    get("c", 4)  # b goes: a was used since
    get("a", 4)
    get("b", 4)
    assert made == ["a", "b", "c", "b"]


def test_the_newest_stays_however_large() -> None:
    cache: Cache[int, int] = Cache(10)
    assert cache.get(1, lambda: 1, 500) == 1
    assert cache.get(1, lambda: 2, 500) == 1
    assert cache.get(2, lambda: 2, 1) == 2
    assert cache.get(1, lambda: 3, 1) == 3
