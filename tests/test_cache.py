"""The cache keeps what was used last, within its size."""

from __future__ import annotations

from pointbrush.cache import Cache


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


def test_a_replaced_entry_frees_its_size_and_evicted_entries_are_returned() -> None:
    cache: Cache[str, int] = Cache(10)
    assert cache.put("a", 1, 6) == []
    assert cache.put("a", 2, 3) == []
    assert cache.put("b", 3, 7) == []
    assert cache.put("c", 4, 5) == [("a", 2), ("b", 3)]
    assert (cache.known("a"), cache.known("c"), len(cache)) == (None, 4, 1)
    cache.drop("c", "d")
    assert cache.put("e", 5, 10) == []


def test_entries_without_a_size_are_counted() -> None:
    cache: Cache[int, int] = Cache(2)
    for number in range(4):
        cache.put(number, number)
    assert cache.held() == [2, 3]
