"""Order of frames by times that wrap, are set back, are equal or are not padded."""

from __future__ import annotations

from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from pointbrush.formats import open_source, reported
from pointbrush.formats.times.matching import FrameName, matched
from pointbrush.formats.times.time_order import irregular_steps, order_by_time
from pointbrush.formats.times.timing import in_order, order_of, rate_of, times_in_names

RATES = st.sampled_from([1.0, 5.0, 10.0, 20.0, 30.0])
JITTER = st.sampled_from([0.0, 0.02, 0.1])
"""Parts of a step by which a time is off."""


def even(count: int, rate: float, jitter: float, seed: int) -> list[float]:
    """Times of a sensor, seconds."""
    off = np.random.default_rng(seed).uniform(-jitter, jitter, count)
    return ((np.arange(count) + off) / rate).tolist()


def places(times: list[float], **more: bool) -> list[int]:
    return list(order_by_time(times, "times.txt", "by number", **more).places)


# ── a clock that is set back ─────────────────────────────────────────────────────────────────


@given(
    count=st.integers(5, 60),
    rate=RATES,
    jitter=JITTER,
    seed=st.integers(0, 99),
    at=st.floats(0.1, 0.9),
    back=st.sampled_from([0.04, 0.3, 1.0, 2.35, 60.0, 3600.0]),
)
def test_a_clock_that_is_set_back_changes_no_order(count, rate, jitter, seed, at, back):
    times, place = even(count, rate, jitter, seed), max(1, int(at * count))
    times = [time - back * (k >= place) for k, time in enumerate(times)]
    assert places(times) == list(range(count))
    if count >= 20:  # one odd step is little of them
        assert rate_of(times) == pytest.approx(rate, rel=0.15)


@given(
    count=st.integers(6, 60),
    rate=RATES,
    jitter=JITTER,
    seed=st.integers(0, 99),
    change=st.sampled_from(["swapped", "late", "reversed", "shuffled"]),
)
def test_frames_that_come_out_of_order_are_sorted(count, rate, jitter, seed, change):
    times, random = even(count, rate, jitter, seed), Random(seed)
    at = random.randrange(count - 3)
    if change == "swapped":
        times[at], times[at + 1] = times[at + 1], times[at]
    elif change == "late":
        times.insert(at + 3, times.pop(at))
    elif change == "reversed":
        times.reverse()
    else:
        random.shuffle(times)
    got = places(times, numbered=change != "shuffled")
    assert [times[place] for place in got] == sorted(times)


@given(st.lists(st.floats(-1e9, 1e10) | st.sampled_from([0.0, 1.0, 2.0]), max_size=30))
def test_every_frame_has_a_place_and_the_rate_is_a_number(times):
    assert sorted(places(times)) == list(range(len(times)))
    rate = rate_of(times)
    assert rate is None or 0.01 <= rate <= 1000


# ── names of seconds and nanoseconds ─────────────────────────────────────────────────────────


@given(
    count=st.integers(12, 40),
    rate=RATES,
    jitter=JITTER,
    seed=st.integers(0, 99),
    start=st.integers(0, 10**9 - 1),
    between=st.sampled_from([".", "_", "-"]),
    unit=st.sampled_from([10**9, 10**6]),
)
def test_fractions_that_are_not_padded_are_counts(count, rate, jitter, seed, start, between, unit):
    moments = [start // (10**9 // unit) + int(t * unit) for t in even(count, rate, jitter, seed)]
    moments = sorted({max(moment, 1000) for moment in moments})
    names = [f"{1_600_000_000 + m // unit}{between}{m % unit}" for m in moments]
    fractions = {len(str(moment % unit)) for moment in moments}
    if unit < 10**9:  # microseconds of any length may be decimals, unless these are less even
        decimals = sorted(float(f"{m // unit}.{m % unit}") for m in moments)
        assume(irregular_steps(decimals) > irregular_steps([m / unit for m in moments]))
    files = [Path(f"/scan/{name}.pcd") for name in Random(seed).sample(names, len(names))]
    ordered = in_order(files)
    times = times_in_names(ordered)
    if len(fractions) > 1 and times is not None:
        got = [ordered[place].stem for place in order_of(ordered, Path("/scan"), times).places]
        assert got == names


@given(
    count=st.integers(3, 40),
    seed=st.integers(0, 99),
    rate=RATES,
    jitter=JITTER,
    digits=st.sampled_from([6, 9]),
)
def test_padded_fractions_are_decimals(count, seed, rate, jitter, digits):
    names = [f"{1.6e9 + time:.{digits}f}" for time in even(count, rate, jitter, seed)]
    files = in_order([Path(f"{name}.pcd") for name in names])
    times = times_in_names(files)
    assert times == sorted(map(float, names))


def test_seconds_of_a_simulation_are_ordered_as_counts(tmp_path):
    counts = [5_000_000 + 100_000_000 * k for k in range(12)]
    names = [f"{12 + ns // 10**9}.{ns % 10**9}.pcd" for ns in counts]
    assert [path.name for path in in_order([Path(name) for name in sorted(names)])] == names


def test_labels_named_as_unpadded_frames_are_theirs():
    stems = [f"1600000000_{ns}" for ns in (5_000_000, 105_000_000, 505_000_000)]
    frames = [FrameName(f"{stem}.pcd", 1.6e9 + k / 10) for k, stem in enumerate(stems)]
    assert matched([FrameName(f"{stem}.label") for stem in stems[::-1]], frames) == [2, 1, 0]


# ── recordings ───────────────────────────────────────────────────────────────────────────────


def recording(folder: Path, names: list[str], times: list[float] | None = None) -> Path:
    folder.mkdir()
    for number, name in enumerate(names):
        (folder / f"{name}.xyz").write_text(f"{number} 0 0\n{number} 1 0\n")
    if times is not None:
        (folder / "times.txt").write_text("".join(f"{time}\n" for time in times))
    return folder


def found(path: Path) -> tuple[list[int], float | None, str, str]:
    """Order, rate, its words and the warnings of a recording whose frames are numbered in x."""
    with reported() as warnings, open_source([path]) as source:
        order = [int(frame.xyz[0, 0]) for frame in source.frames]
        return order, source.fps, source.listings[0].order, " ".join(warnings)


def test_times_of_the_hour_are_played_as_they_are_numbered(tmp_path):
    times = [3599.7, 3599.8, 3599.9, 0.0, 0.1]
    order, fps, source, said = found(
        recording(tmp_path / "a", [f"{k:06d}" for k in range(5)], times)
    )
    assert (order, fps) == ([0, 1, 2, 3, 4], 10)
    assert source == "by number in the file names (the times go back: times.txt)"
    assert "times.txt: ordered by number in the file names, the times go back 1 times" in said
    assert "first by 3599.9 s before frame 3; the frames are not sorted by time" in said


def test_equal_times_are_named_and_give_a_rate(tmp_path):
    order, fps, source, said = found(
        recording(tmp_path / "a", list("01234"), [5.0, 5.0, 5.1, 5.1, 5.2])
    )
    assert (order, fps, source) == ([0, 1, 2, 3, 4], 10, "by times.txt")
    assert "2 of 5 times are equal to the time before" in said


def test_names_without_numbers_are_sorted_by_their_times(tmp_path):
    names, times = ["elm", "fir", "oak", "yew"], [0.2, 0.3, 0.0, 0.1]
    order, fps, source, said = found(recording(tmp_path / "a", names, times))
    assert (order, fps, source, said) == ([2, 3, 0, 1], 10, "by times.txt", "")


def test_numbered_names_with_a_clock_that_was_set_back(tmp_path):
    names = [f"{k:06d}_{1_600_000_000 + k / 10 - (k > 3) * 7.23:.6f}" for k in range(9)]
    order, fps, source, said = found(recording(tmp_path / "a", names))
    assert (order, fps) == (list(range(9)), 10)
    assert "(the times go back: the times in the file names)" in source
    assert "first by 7.13 s before frame 4" in said
