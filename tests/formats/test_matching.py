"""Files that come beside frames: matched by name, time or number, or refused by name."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pointbrush.errors import BadInputError
from pointbrush.formats import reported
from pointbrush.formats.times.matching import FrameName, frames_of_numbers, match, matched, partners

WORDS = st.text("abcxyz", min_size=1, max_size=6)


def frames(*names: str) -> list[FrameName]:
    return [FrameName(name) for name in names]


@given(
    names=st.lists(WORDS, min_size=2, max_size=8, unique=True),
    chosen=st.randoms(use_true_random=False),
    before=st.sampled_from(["", "label_", "seg-"]),
    after=st.sampled_from(["", "_v1", ".label"]),
)
def test_some_files_in_any_order_go_to_the_frames_of_their_names(
    names: list[str], chosen: object, before: str, after: str
) -> None:
    numbered = [f"{name}_{number:03d}.ply" for number, name in enumerate(names)]
    some = chosen.sample(range(len(names)), chosen.randint(1, len(names)))  # type: ignore[attr-defined]
    files = [f"{before}{numbered[k].removesuffix('.ply')}{after}.npy" for k in some]
    assert match(files, frames(*numbered)) == some


@given(st.lists(st.integers(0, 999), min_size=2, max_size=9, unique=True), st.data())
def test_numbers_match_where_names_differ(numbers: list[int], data: st.DataObject) -> None:
    known = frames(*(f"scan_{number:04d}_cam2.pcd" for number in numbers))
    order = data.draw(st.permutations(range(len(numbers))))
    files = [f"out/{numbers[k]}.txt" for k in order]
    assert match(files, known) == list(order)


def test_the_only_one_of_its_folder_is_of_the_frame_of_that_name() -> None:
    files = ["train/b/segment.npy", "train/a/segment.npy"]
    assert match(files, frames("a.ply", "b.ply")) == [1, 0]


def test_times_are_matched_to_the_nearest_frame() -> None:
    known = [FrameName(f"{k}.bin", 1_600_000_000 + k / 10) for k in range(5)]
    files = ["1600000000.301000.json", "1600000000.099000.json"]
    assert match(files, known) == [3, 1]


def test_frames_of_one_file_are_counted() -> None:
    assert match(["000002.label", "000000.label"], [FrameName("drive.bag")] * 3) == [2, 0]


@pytest.mark.parametrize(
    ("files", "named"),
    [
        (["a.label", "b.label"], "1 of no frame: b.label"),
        (["x.label", "y.label"], "2 of no frame: x.label, y.label"),
        (["a.label", "a.npy"], "several of one: a.label, a.npy"),
    ],
)
def test_what_fits_no_frame_or_one_twice_is_named(files: list[str], named: str) -> None:
    with pytest.raises(BadInputError, match=named) as refused:
        match(files, frames("a.ply", "c.ply"))
    assert "--by-order" in str(refused.value)


def test_files_are_taken_in_their_order_only_when_asked() -> None:
    known = frames("a.ply", "c.ply")
    assert match(["x.npy", "y.npy"], known, by_order=True) == [0, 1]
    assert match(["x.npy", "y.npy"], known, by_order=True, times=[7.0, 5.0]) == [1, 0]
    with pytest.raises(BadInputError, match="expected 2 files, one a frame, got 1"):
        match(["x.npy"], known, by_order=True)
    assert match(["predicted.npy"], frames("hall.las")) == [0]


@given(
    st.lists(st.floats(0, 100), max_size=8),
    st.lists(st.floats(0, 100), max_size=8),
    st.floats(0.01, 50),
)
def test_the_nearest_time_is_found_within_a_limit(
    times: list[float], among: list[float], most: float
) -> None:
    found = matched([FrameName("", t) for t in times], [FrameName("", t) for t in among], most)
    for time, place in zip(times, found, strict=True):
        least = min((abs(other - time) for other in among), default=float("inf"))
        if place is None:
            assert least > most
        else:
            assert abs(among[place] - time) == least <= most


def test_names_that_are_times_are_never_numbers() -> None:
    poses = [FrameName(f"0.{k}.txt") for k in range(3)]
    with pytest.raises(BadInputError, match=r"names, times or numbers of the frames .*--by-order"):
        partners(frames("000000.pcd", "000001.pcd"), poses)
    assert partners(frames("a.pcd", "b.pcd"), poses[:2], by_order=True) == [0, 1]


def test_a_picture_of_one_name_costs_no_other_its_time() -> None:
    depths = frames("100.500.png", "101.500.png", "102.500.png")
    colors = frames("100.500.jpg", "101.508.jpg", "102.493.jpg")
    assert partners(depths, colors) == [0, 1, 2]


@given(
    first=st.integers(0, 40),
    count=st.integers(1, 20),
    step=st.sampled_from([1, 2, 5]),
    random=st.randoms(use_true_random=False),
)
def test_numbers_of_a_drive_go_to_the_files_of_these_numbers(
    first: int, count: int, step: int, random: object
) -> None:
    numbers = range(first, first + count * step, step)
    files = frames(*(f"{number:06d}.bin" for number in numbers))
    whole = range(first + count * step + 7)
    assert frames_of_numbers(whole, files) == {
        number: numbers.index(number) if number in numbers else None for number in whole
    }
    some = random.sample(numbers, random.randint(1, count))  # type: ignore[attr-defined]
    assert frames_of_numbers(some, files) == {number: numbers.index(number) for number in some}


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (["000002.bin", "000003.bin", "000004.bin"], "by position: the files are numbered 2 to 4"),
        (["a.bin", "b.bin", "c.bin"], ""),
        (["drive_7.bag"] * 3, ""),
        (["000000.bin", "000001.bin", "000002.bin"], ""),
    ],
)
def test_numbers_that_no_name_fits_are_positions(names: list[str], said: str) -> None:
    with reported() as warnings:
        assert frames_of_numbers([0, 1, 2], frames(*names)) == {0: 0, 1: 1, 2: 2}
    assert said in " ".join(warnings)
    assert bool(said) == bool(warnings)
