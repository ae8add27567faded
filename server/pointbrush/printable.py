"""Facts that commands print, as a workspace here and the client of a server both have them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Protocol


class About(Protocol):
    """Facts of a recording."""

    @property
    def id(self) -> str: ...  # noqa: D102
    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def source(self) -> str: ...  # noqa: D102
    @property
    def frames(self) -> int: ...  # noqa: D102
    @property
    def fps(self) -> float: ...  # noqa: D102
    @property
    def points(self) -> Sequence[int]: ...  # noqa: D102
    @property
    def fields(self) -> Sequence[str]: ...  # noqa: D102


class Entry(Protocol):
    """A label of a palette."""

    @property
    def id(self) -> int: ...  # noqa: D102
    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def color(self) -> str: ...  # noqa: D102
    @property
    def category(self) -> str: ...  # noqa: D102


class CountedEntry(Entry, Protocol):
    """A label of a palette with the number of its points in all frames."""

    @property
    def points(self) -> int | None: ...  # noqa: D102


class TokenEntry(Protocol):
    """A token's record."""

    @property
    def id(self) -> str: ...  # noqa: D102
    @property
    def role(self) -> str: ...  # noqa: D102
    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def valid(self) -> bool: ...  # noqa: D102
    @property
    def revoked(self) -> object: ...  # noqa: D102


class ExportFormat(Protocol):
    """An export format."""

    @property
    def title(self) -> str: ...  # noqa: D102
    @property
    def cannot_hold(self) -> Sequence[str]: ...  # noqa: D102
    @property
    def classes(self) -> bool: ...  # noqa: D102


class Boxed(Protocol):
    """A box of a label."""

    @property
    def label(self) -> int: ...  # noqa: D102


class Suspicious(Protocol):
    """A suspicious thing in the labels of a recording."""

    @property
    def first(self) -> int | None: ...  # noqa: D102
    @property
    def last(self) -> int | None: ...  # noqa: D102
    @property
    def text(self) -> str: ...  # noqa: D102
    @property
    def settled(self) -> bool: ...  # noqa: D102


class Agreeing(Protocol):
    """A label of two recordings."""

    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def iou(self) -> float: ...  # noqa: D102


class Scored(Protocol):
    """Scores of boxes that are the same from a 3D IoU on."""

    @property
    def iou(self) -> float: ...  # noqa: D102
    @property
    def ap(self) -> float: ...  # noqa: D102
    @property
    def precision(self) -> float: ...  # noqa: D102
    @property
    def recall(self) -> float: ...  # noqa: D102


class ComparedClass(Protocol):
    """Boxes of a class in two recordings."""

    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def first(self) -> int: ...  # noqa: D102
    @property
    def second(self) -> int: ...  # noqa: D102
    @property
    def scores(self) -> Sequence[Scored]: ...  # noqa: D102


class Taught(Protocol):
    """A classifier as the workspace and the client have it."""

    @property
    def id(self) -> str: ...  # noqa: D102
    @property
    def examples(self) -> Mapping[str, int]: ...  # noqa: D102
    @property
    def taught_by(self) -> Mapping[str, int]: ...  # noqa: D102
    @property
    def score(self) -> float | None: ...  # noqa: D102
