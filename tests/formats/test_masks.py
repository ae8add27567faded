"""Masks in files as CVAT, LabelMe, VOC, Cityscapes, COCO and YOLO tools write them."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from pointbrush.errors import BadInputError
from pointbrush.formats import Limits
from pointbrush.formats.annotation import find_label_files
from pointbrush.formats.masks.mask import Mask
from pointbrush.formats.masks.registry import read_masks
from pointbrush.formats.masks.rle import compress_runs, decompress_runs, mask_of_runs, runs_of_mask
from pointbrush.formats.tables.datasets import ClassName
from pointbrush.values.masks import VOID

SIZE = (6, 4)
RED, GREEN, BLACK, BORDER = (128, 0, 0), (0, 128, 0), (0, 0, 0), (224, 224, 192)
PIXELS = np.array([[0, 1, 1, 0, 2, 2]] * 3 + [[0, 0, 0, 0, 0, 3]])
"""A picture with objects 1 and 2, and a void corner, in tests of indices and colours."""


def png(path: Path, pixels: np.ndarray, mode: str | None = None, palette: bool = False) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    image = Image.fromarray(pixels)
    if palette:
        colors = [BLACK, RED, GREEN, *[BORDER] * 253]
        image.putpalette([channel for each in colors for channel in each])
    image.convert(mode).save(path) if mode else image.save(path)


def colored(path: Path, colors: list[tuple[int, int, int]]) -> None:
    png(path, np.array(colors, np.uint8)[PIXELS])


def indexed(path: Path, void: int = 255) -> None:
    png(path, np.where(PIXELS == 3, void, PIXELS).astype(np.uint8), palette=True)


Words = dict[int, str]
Read = dict[str, tuple[np.ndarray, list[tuple[str, int]]]]


def read(place: Path, given: Mapping[int, ClassName] | None = None) -> tuple[str, Read]:
    """Return the format that is found, and places and keys of each mask with words for classes."""
    files = find_label_files(place, None, given or {}, Limits())
    named = {path: path.relative_to(place).as_posix() for path in files.paths}
    masks, names = read_masks(named, files.format, files.names, {}, own=False)
    found: Read = {}
    for each in masks:
        mask = each.read(SIZE)
        words = [(names[k].name if k in names else str(k), i) for k, i in mask.keys]
        found[each.name] = mask.place, words
    return files.format, found


def words_of(mask: np.ndarray, keys: list[tuple[str, int]]) -> list[list[str]]:
    table = {0: "", VOID: "?"} | {k: f"{w} {i}" if i else w for k, (w, i) in enumerate(keys, 1)}
    return [[table[int(value)] for value in row] for row in mask]


EXPECTED = [["", "car", "car", "", "man", "man"]] * 3 + [["", "", "", "", "", "?"]]


def test_cvat_writes_colours_and_a_labelmap(tmp_path: Path) -> None:
    colored(tmp_path / "SegmentationClass" / "000001.png", [BLACK, RED, GREEN, BORDER])
    colored(tmp_path / "SegmentationObject" / "000001.png", [BLACK, GREEN, RED, BORDER])
    (tmp_path / "ImageSets" / "Segmentation").mkdir(parents=True)
    (tmp_path / "ImageSets" / "Segmentation" / "default.txt").write_text("000001\n")
    (tmp_path / "labelmap.txt").write_text(
        "# label:color_rgb:parts:actions\nbackground:0,0,0::\nman:0,128,0::\ncar:128,0,0::\n"
    )
    format, found = read(tmp_path)
    assert format == "masks-png"
    (mask, keys) = found["SegmentationClass/000001.png"]
    assert [[word.split(" ")[0] for word in row] for row in words_of(mask, keys)] == EXPECTED
    assert sorted(keys) == [("car", -1), ("man", -2)]


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("class_names.txt", "_background_\ncar\nman\n"),
        ("classes.txt", "car\nman\n"),
        ("labels.json", '{"0": "background", "1": "car", "2": "man"}'),
        ("classes.json", '["car", "man"]'),
        ("classes.json", '{"car": 1, "man": 2}'),
        ("labels.json", '{"1": {"name": "car"}, "2": {"name": "man", "color": "#008000"}}'),
        ("label_colors.txt", "0 0 0 void\n0 128 0\tman\n128 0 0\tcar\n"),
    ],
)
@pytest.mark.parametrize("kind", ["indices", "colours"])
def test_classes_are_named_in_files_of_many_kinds(
    tmp_path: Path, file: str, text: str, kind: str
) -> None:
    """LabelMe, plain lists, JSON and CamVid; by colour only where the file states colours."""
    if kind == "indices":
        indexed(tmp_path / "SegmentationClass" / "1.png")
    elif file == "label_colors.txt":
        colored(tmp_path / "SegmentationClass" / "1.png", [BLACK, RED, GREEN, BORDER])
    else:
        grey = [(k, k, k) for k in (0, 1, 2, 255)]
        colored(tmp_path / "SegmentationClass" / "1.png", grey)
    (tmp_path / file).write_text(text)
    _, found = read(tmp_path)
    mask, keys = found["SegmentationClass/1.png"]
    assert words_of(mask, keys) == EXPECTED


def test_colours_without_names_are_classes(tmp_path: Path) -> None:
    colored(tmp_path / "1.png", [BLACK, RED, GREEN, BORDER])
    _, found = read(tmp_path)
    (mask, keys) = found["1.png"]
    assert {word for row in words_of(mask, keys) for word in row} == {"", "#800000", "#008000", "?"}


@pytest.mark.parametrize("mode", ["L", "1", "RGB"])
def test_a_binary_mask_is_class_1(tmp_path: Path, mode: str) -> None:
    png(tmp_path / "1.png", np.where(PIXELS == 1, 255, 0).astype(np.uint8), mode)
    _, found = read(tmp_path, {1: ClassName("car")})
    mask, keys = found["1.png"]
    assert keys == [("car", 0)]
    assert ((mask == 1) == (PIXELS == 1)).all()


def test_cityscapes_writes_class_and_object_in_16_bits(tmp_path: Path) -> None:
    numbers = np.choose(PIXELS, [0, 26_001, 26_002, 7]).astype(np.uint16)
    png(tmp_path / "a_000001_gtFine_instanceIds.png", numbers)
    png(tmp_path / "a_000001_gtFine_labelIds.png", (numbers % 251).astype(np.uint8))
    colored(tmp_path / "a_000001_gtFine_color.png", [BLACK, RED, GREEN, BORDER])
    (tmp_path / "classes.txt").write_text("7 road\n26 car\n")
    _, found = read(tmp_path)
    assert list(found) == ["a_000001_gtFine_instanceIds.png"]
    (mask, keys) = found["a_000001_gtFine_instanceIds.png"]
    assert keys == [("road", 0), ("car", 1), ("car", 2)]
    assert mask[0].tolist() == [0, 2, 2, 0, 3, 3]


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (
            lambda folder: png(folder / "1.png", np.full((4, 6), 4312, np.uint16)),
            "a/1.png: expected the classes of a classes.txt beside the masks .* got 16 bits",
        ),
        (
            lambda folder: png(folder / "1.png", np.zeros((5, 5), np.uint8), "P"),
            "a/1.png: expected a mask of 6x4 pixels, the size of the camera's pictures, got 5x5",
        ),
        (
            lambda folder: colored(folder / "SegmentationObject" / "1.png", [BLACK] * 4),
            "SegmentationObject/1.png: expected the classes of the objects in SegmentationClass",
        ),
        (
            lambda folder: (folder / "1.png").write_bytes(b"\x89PNG"),
            "a/1.png: expected a mask in PNG, got another kind",
        ),
    ],
)
def test_wrong_images_are_refused_in_words(tmp_path: Path, make: object, said: str) -> None:
    (tmp_path / "a").mkdir()
    make(tmp_path / "a")  # type: ignore[operator]
    with pytest.raises(BadInputError, match=said):
        read(tmp_path)


def test_photographs_are_no_masks(tmp_path: Path) -> None:
    noise = np.random.default_rng(0).integers(0, 255, (40, 60, 3), np.uint8)
    png(tmp_path / "images" / "1.png", noise)
    indexed(tmp_path / "masks" / "1.png")
    assert list(read(tmp_path)[1]) == ["masks/1.png"]


def coco(folder: Path, *annotations: Mapping[str, object], **more: object) -> None:
    image = {"id": 7, "file_name": "front/000001.jpg", "width": 6, "height": 4}
    listed = [
        {"id": k, "image_id": 7, "iscrowd": 0, **each} for k, each in enumerate(annotations, 1)
    ]
    categories = [{"id": 0, "name": "car"}, {"id": 3, "name": "man", "supercategory": ""}]
    document = {"images": [image], "annotations": listed, "categories": categories, **more}
    (folder / "instances_default.json").write_text(json.dumps(document))


MAN = {"category_id": 3, "segmentation": {"size": [4, 6], "counts": [16, 3, 1, 3, 1]}, "area": 6}
CAR = {"category_id": 0, "segmentation": [[1, 0, 3, 0, 3, 3, 1, 3]], "area": 6}


def test_coco_has_polygons_runs_and_tracks(tmp_path: Path) -> None:
    text = {"size": [4, 6], "counts": compress_runs(np.array([16, 3, 1, 3, 1]))}
    for man in (MAN, {**MAN, "segmentation": text}):
        coco(tmp_path, CAR | {"track_id": 5}, man | {"attributes": {"track_id": 9}})
        format, found = read(tmp_path)
        assert format == "masks-coco"
        (mask, keys) = found["instances_default/front/000001.jpg"]
        assert sorted(keys) == [("car", 5), ("man", 9)]
        assert words_of(mask, keys)[:3] == [["", "car 5", "car 5", "", "man 9", "man 9"]] * 3


def test_coco_without_tracks_and_with_tracks_from_0(tmp_path: Path) -> None:
    coco(tmp_path, CAR, MAN, {**MAN, "iscrowd": 1})
    (_, keys) = read(tmp_path)[1]["instances_default/front/000001.jpg"]
    assert sorted(keys) == [("car", -1), ("man", -2), ("man", 0)]
    coco(tmp_path, {**CAR, "attributes": {"track_id": 0}}, {**MAN, "attributes": {"track_id": 1}})
    (_, keys) = read(tmp_path)[1]["instances_default/front/000001.jpg"]
    assert sorted(keys) == [("car", 1), ("man", 2)]


def test_a_small_object_of_coco_lies_over_a_large_one(tmp_path: Path) -> None:
    large = {"category_id": 3, "segmentation": [[0, 0, 6, 0, 6, 4, 0, 4]], "area": 24}
    coco(tmp_path, CAR, large)
    (mask, keys) = read(tmp_path)[1]["instances_default/front/000001.jpg"]
    assert words_of(mask, keys)[0] == ["man -2", "car -1", "car -1", *["man -2"] * 3]


@pytest.mark.parametrize(
    ("annotation", "said"),
    [
        (
            {**MAN, "segmentation": {"size": [4, 6], "counts": [3, 4]}},
            "runs of 7 pixels, expected 24",
        ),
        ({**MAN, "segmentation": {"size": [6, 4], "counts": [24]}}, r"height and width \[6, 4\]"),
        ({**CAR, "segmentation": [[1, 2, 3, 4]]}, "a polygon of 4 numbers"),
        ({**CAR, "segmentation": {"size": [4, 6], "counts": "p"}}, "compressed runs"),
        ({**CAR, "track_id": -4}, "track id -4"),
        ({**CAR, "image_id": 8}, "expected COCO's images, annotations and categories"),
    ],
)
def test_wrong_annotations_are_refused_in_words(
    tmp_path: Path, annotation: dict[str, object], said: str
) -> None:
    coco(tmp_path, annotation)
    with pytest.raises(BadInputError, match=said):
        read(tmp_path)


YOLO = "1 0.6666 0 1 0 1 0.75 0.6666 0.75\n0 0.1667 0 0.5 0 0.5 0.75 0.1667 0.75\n"


@pytest.mark.parametrize("file", ["classes.txt", "data.yaml"])
def test_yolo_has_polygons_in_shares_of_the_picture(tmp_path: Path, file: str) -> None:
    named = "car\nman\n" if file == "classes.txt" else "train: images\nnames: [car, man]\n"
    (tmp_path / file).write_text(named)
    (tmp_path / "labels").mkdir()
    (tmp_path / "labels" / "000001.txt").write_text(YOLO)
    format, found = read(tmp_path)
    assert format == "masks-yolo"
    (mask, keys) = found["labels/000001.txt"]
    assert keys == [("man", -1), ("car", -2)]
    assert words_of(mask, keys)[0] == ["", "car -2", "car -2", "", "man -1", "man -1"]
    (tmp_path / "labels" / "000001.txt").write_text(YOLO + "0 0.5 0.5 0.1 0.1\n")
    with pytest.raises(BadInputError, match=r"000001.txt line 3: .* got a box, which has no mask"):
        read(tmp_path)


masks = st.builds(
    lambda seed, h, w, share: np.random.default_rng(seed).random((h, w)) < share,
    *(st.integers(0, 1 << 30), st.integers(1, 70), st.integers(1, 70), st.floats(0, 1)),
)


@given(masks)
def test_runs_are_those_of_the_coco_api(mask: np.ndarray) -> None:
    runs = runs_of_mask(mask)
    assert (mask_of_runs(runs, *mask.shape) == mask).all()
    text = compress_runs(runs)
    assert (decompress_runs(text) == runs).all()
    assert text == in_characters(runs.tolist())


def in_characters(runs: list[int]) -> str:
    """Describe runs by groups of five bits, the least ones first, as COCO's API documents them."""
    text = ""
    for k, run in enumerate(runs):
        value = run - runs[k - 2] if k > 2 else run
        groups = []
        while True:
            groups.append(value & 31)
            value >>= 5
            if value == (-1 if groups[-1] & 16 else 0):
                break
        text += "".join(chr(48 + each + 32) for each in groups[:-1]) + chr(48 + groups[-1])
    return text


@given(st.text(st.characters(min_codepoint=40, max_codepoint=120), max_size=40))
def test_other_texts_are_refused_or_runs(text: str) -> None:
    try:
        runs = decompress_runs(text)
    except ValueError:
        return
    assert runs.dtype == np.int64


def test_a_mask_with_too_many_objects_is_refused() -> None:
    keys = [(number, 0) for number in range(70_000)]
    with pytest.raises(BadInputError, match="at most 60,000 objects, got 70,000"):
        Mask.of_keys("a.png", keys, np.arange(70_000).reshape(700, 100))


@given(st.data())
def test_damaged_files_are_refused_or_read(data: st.DataObject) -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        text = {"size": [4, 6], "counts": compress_runs(np.array([16, 3, 1, 3, 1]))}
        coco(folder, CAR | {"track_id": 5}, {**MAN, "segmentation": text})
        indexed(folder / "front.png")
        path = folder / data.draw(st.sampled_from(["front.png", "instances_default.json"]))
        content = bytearray(path.read_bytes())
        for place in data.draw(st.lists(st.integers(0, len(content) - 1), min_size=1, max_size=4)):
            content[place] = data.draw(st.sampled_from(b'09.-[]{}"e,\x00\xff'))
        path.write_bytes(content)
        form = "masks-png" if path.suffix == ".png" else "masks-coco"
        try:
            masks, _ = read_masks({path: path.name}, form, {}, {}, own=True)
            for each in masks:
                each.read(SIZE)
        except BadInputError:
            pass
