"""Content of an export: frames with their annotation, and the palette with its numbers."""

from __future__ import annotations

import json
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import BadInputError
from pointbrush.formats.boxes.scene import SceneFrame
from pointbrush.formats.masks.mask import PictureMask
from pointbrush.formats.readers.las_header import FieldScale, scalings_of
from pointbrush.formats.tables.datasets import SEMANTIC_KITTI
from pointbrush.formats.tables.numbering import Numbering, numbering_of
from pointbrush.formats.tables.table import Table, stored_name
from pointbrush.frame import PointFrame

Array = NDArray[Any]


class PaletteEntry(Protocol):
    """A label of the palette."""

    @property
    def id(self) -> int:
        """1..65534."""

    @property
    def name(self) -> str:
        """Displayed name."""

    @property
    def category(self) -> str:
        """Class of the label, "" if the label is a class of its own."""

    @property
    def color(self) -> str:
        """``#rrggbb``."""

    @property
    def instance(self) -> int | None:
        """Its number in the source, 0 for a class without instances; None without a source."""


@dataclass(frozen=True, slots=True)
class Split:
    """Split of a recording's frames for training.

    ``val`` (validation) are frames by index, the others are "train"; ``by`` describes the choice
    for users.
    """

    val: range = range(0)
    by: str = "default"

    def of(self, index: int) -> str:
        """Name the split of a frame."""
        return "val" if index in self.val else "train"


def stem_of(index: int) -> str:
    """File name of a frame, without ending."""
    return f"{index:06d}"


def sizes_of(label: NDArray[np.uint16], deleted: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Points of each label that are not deleted, by label id."""
    return np.bincount(label[~deleted], minlength=1).astype(np.int64)


@dataclass(frozen=True, eq=False)
class LabeledFrame:
    """Frame ``index`` of a sequence, or a block of it, with its annotation in source order.

    ``label`` (N,) uint16, 0 = unlabeled; ``provenance`` (N,) uint8; ``deleted`` (N,) bool;
    ``tracks`` the frame's track states as in the tracks call; ``up`` (3,) points away from the
    floor in source coordinates; ``other`` further fields of the source (N,), ``header`` its header.
    ``rows`` (N,): the points' rows in the source, or None: all rows; ``dropped``: number of other
    rows.
    Raises BadInputError when lengths differ.
    """

    index: int
    points: PointFrame
    label: NDArray[np.uint16]
    provenance: NDArray[np.uint8]
    deleted: NDArray[np.bool_]
    tracks: Sequence[Mapping[str, Any]] = field(default_factory=list)
    up: NDArray[np.float64] = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    other: Mapping[str, Array] = field(default_factory=dict)
    header: bytes | None = None
    rows: NDArray[np.int64] | None = None
    dropped: int = 0
    recording: str = ""
    """Id of the recording that the frame is of."""
    split: Split = Split()
    boxes: SceneFrame | None = None
    """The frame with the boxes of its labels, for formats that write boxes."""
    masks: Sequence[PictureMask] = ()
    """Its labels in the pictures of its cameras, for formats that write masks."""
    sensor: str = ""
    """Name of the sensor if the points are those of one of several, in its coordinates."""

    def __post_init__(self) -> None:
        lengths = {len(self.label), len(self.provenance), len(self.deleted)}
        if lengths != {len(self.points)}:
            raise BadInputError(
                f"frame {self.index}: expected {len(self.points)} labels, got {sorted(lengths)}"
            )

    @property
    def stem(self) -> str:
        """File name of the frame, without ending."""
        return stem_of(self.index)

    @property
    def count(self) -> int:
        """Points of the frame."""
        return len(self.points)

    @property
    def kept(self) -> int:
        """Points that are not deleted."""
        return int(np.count_nonzero(~self.deleted))

    @property
    def sizes(self) -> NDArray[np.int64]:
        """Points of each label that are not deleted, by label id."""
        return sizes_of(self.label, self.deleted)

    def blocks(self) -> Iterator[LabeledFrame]:
        """Yield the frame itself."""
        yield self

    @property
    def keep(self) -> NDArray[np.int64]:
        """Numbers of the points that are not deleted."""
        return np.flatnonzero(~self.deleted)


@dataclass(frozen=True, eq=False)
class BlockedFrame:
    """A frame too large for memory: each call of ``read`` returns its blocks.

    ``count`` points, ``kept`` of them not deleted; ``sizes`` as ``sizes_of``; the rest as of a
    LabeledFrame.
    """

    index: int
    count: int
    kept: int
    sizes: NDArray[np.int64]
    read: Callable[[], Iterator[LabeledFrame]]
    tracks: Sequence[Mapping[str, Any]]
    up: NDArray[np.float64]
    header: bytes | None = None
    rows: NDArray[np.int64] | None = None
    dropped: int = 0
    recording: str = ""
    split: Split = Split()
    boxes: SceneFrame | None = None
    masks: Sequence[PictureMask] = ()

    @property
    def stem(self) -> str:
        """File name of the frame, without ending."""
        return stem_of(self.index)

    def blocks(self) -> Iterator[LabeledFrame]:
        """Return the points in order, in one block or more; can be called repeatedly."""
        return self.read()


ExportFrame = LabeledFrame | BlockedFrame
"""A frame to write, whole or in blocks of consecutive source points."""


@dataclass(frozen=True, slots=True, eq=False)
class DatasetNumbers:
    """By label id, (65536,): a dataset's number of its ``category`` and of the ``instance``.

    ``plain``: a class without instances; its points may have the instances of their source.
    """

    category: NDArray[np.uint16]
    instance: NDArray[np.uint16]
    plain: NDArray[np.bool_]


def _free_instance(wish: int, taken: Collection[int]) -> int:
    if wish not in taken:
        return wish
    return next(number for number in range(65535, 0, -1) if number not in taken)


class Palette:
    """The labels with category numbers and instances within each.

    ``numbers``: the workspace's numbers by category name; without them 1, 2, … by first label.
    A label without category is a category with the label's name.
    """

    def __init__(
        self,
        entries: Sequence[PaletteEntry],
        numbers: Mapping[str, int] | None = None,
        datasets: Mapping[str, Mapping[str, int]] | None = None,
    ) -> None:
        """``datasets``: numbers of categories by name in each dataset."""
        self._datasets = datasets or {}
        self.entries = sorted(entries, key=lambda entry: entry.id)
        self.categories: dict[str, int] = {}
        self._category = np.zeros(1 << 16, np.uint16)
        self._instance = np.zeros(1 << 16, np.uint16)
        sizes: dict[int, int] = {}
        for entry in self.entries:
            name = category_of(entry)
            given = len(self.categories) + 1 if numbers is None else numbers[name]
            number = self.categories.setdefault(name, given)
            sizes[number] = sizes.get(number, 0) + 1
            self._category[entry.id] = number
            self._instance[entry.id] = sizes[number]

    def category(self, label: NDArray[np.uint16]) -> NDArray[np.uint16]:
        """The category number of each label id; 0 for 0."""
        return self._category[label]

    def instance(self, label: NDArray[np.uint16]) -> NDArray[np.uint16]:
        """The number of each label within its category, from 1; 0 for 0."""
        return self._instance[label]

    def numbers_in(self, numbering: Numbering) -> dict[str, int]:
        """Return the number of each category in a numbering, the workspace's categories first."""
        numbers = numbering.completed(self._datasets.get(numbering.name, {}), self.categories)
        return {name: numbers[name] for name in self.categories if name in numbers}

    def of_dataset(self, dataset: str) -> DatasetNumbers:
        """Each label's class and instance in a dataset's files.

        A category that the dataset does not have gets a number by ``numbering_of``, 0 if none is
        free.  A label without a source gets its id as instance, or, if another label of its class
        has this instance, the greatest free one.  The same applies to a source instance that
        another label has, after a merge of classes.
        """
        mine = self.numbers_in(numbering_of(dataset))
        category, instance = np.zeros((2, 1 << 16), np.uint16)
        used: dict[int, set[int]] = {}
        for entry in self.entries:
            if entry.instance is not None:
                used.setdefault(int(self._category[entry.id]), set()).add(entry.instance)
        given: dict[int, set[int]] = {}
        for entry in self.entries:
            category[entry.id] = mine.get(category_of(entry), 0)
            own = int(self._category[entry.id])
            others, before = used.setdefault(own, set()), given.setdefault(own, set())
            wish = entry.instance
            if wish is None or (wish and wish in before):
                wish = _free_instance(entry.id, others)
            instance[entry.id] = wish
            others.add(wish)
            before.add(wish)
        plain = np.zeros(1 << 16, np.bool_)
        plain[[entry.id for entry in self.entries if entry.instance == 0]] = True
        return DatasetNumbers(category, instance, plain)

    def document(self) -> dict[str, Any]:
        """Return the palette as it is stored with exports."""
        known = {name: self.of_dataset(name) for name in {*self._datasets, SEMANTIC_KITTI.name}}
        labels = [
            {
                "id": entry.id,
                "name": entry.name,
                "category": category_of(entry),
                "categoryless": not entry.category,
                "category_id": int(self._category[entry.id]),
                "instance": int(self._instance[entry.id]),
                "color": entry.color,
                "source_instance": entry.instance,
                "datasets": {
                    name: [int(numbers.category[entry.id]), int(numbers.instance[entry.id])]
                    for name, numbers in known.items()
                },
            }
            for entry in self.entries
        ]
        categories = [{"id": number, "name": name} for name, number in self.categories.items()]
        return {"labels": labels, "categories": categories}

    def json(self) -> bytes:
        """``document`` as UTF-8 JSON."""
        return json.dumps(self.document(), indent=1, ensure_ascii=False).encode()


def category_of(entry: PaletteEntry) -> str:
    """Return the category of a label, or its name without one."""
    return entry.category or entry.name


def point_table(frame: ExportFrame, palette: Palette, *, stored: bool = False) -> Table:
    """The points that are not deleted, as ``point_columns``, and the source's further fields.

    ``stored``: fields as stored in the source, with names by ``stored_name``.
    """

    def columns(block: LabeledFrame) -> dict[str, Array]:
        made = point_columns(block, palette, block.keep)
        if stored:
            return made | {stored_name(name): v[block.keep] for name, v in block.other.items()}
        return made | other_columns(block, made, block.keep)

    if isinstance(frame, LabeledFrame):
        return Table.of(columns(frame))
    return Table(frame.kept, lambda: (columns(block) for block in frame.blocks()))


def other_columns(
    frame: LabeledFrame, ours: Iterable[str], keep: NDArray[np.int64]
) -> dict[str, Array]:
    """Return the source's further fields of the points ``keep``, in order and type.

    A field with the name of a pointbrush field is renamed to ``source_…``, so that both are kept.
    """
    scalings = {} if frame.header is None else scalings_of(frame.header)
    reserved = {name.lower() for name in ours} | {"rgb", "rgba"}
    plain = {name: "_".join(name.split()) or "field" for name in frame.other}
    taken = reserved | {name.lower() for name in plain.values()}
    columns: dict[str, Array] = {}
    for name, values in frame.other.items():
        called = plain[name]
        if called.lower() in reserved or called in columns:
            while called.lower() in taken:
                called = f"source_{called}"
            taken.add(called.lower())
        scaling = scalings.get(name, FieldScale())
        columns[called] = values[keep] if scaling.whole else scaling.values(values[keep])
    return columns


def point_columns(
    frame: LabeledFrame, palette: Palette, keep: NDArray[np.int64]
) -> dict[str, Array]:
    """The columns x y z [red green blue] [intensity] label category instance of ``keep``."""
    points, label = frame.points, frame.label[keep]
    columns: dict[str, Array] = {axis: points.xyz[keep, i] for i, axis in enumerate("xyz")}
    if points.rgb is not None:
        rgb = points.rgb[keep]
        columns |= {color: rgb[:, i] for i, color in enumerate(("red", "green", "blue"))}
    if points.intensity is not None:
        columns["intensity"] = points.intensity[keep]
    columns["label"] = label
    columns["category"] = palette.category(label)
    columns["instance"] = palette.instance(label)
    return columns
