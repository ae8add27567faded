"""Labels of a recording: its palette, and palettes as files."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, ClassVar

from pointbrush.values.base import Body, Rule, Value
from pointbrush.values.kinds import VISIBLE, Color, FrameIndex, LabelId, Name, PaintId

CategoryName = Annotated[str, Rule(max_length=200, pattern=f"^{VISIBLE}*$")]
Gap = Annotated[float, Rule(gt=0, le=100, allow_inf_nan=False)]


@dataclass(frozen=True, slots=True)
class Label(Value):
    """An entry of the palette."""

    id: int
    """1 to 65534; never given to another label of the recording."""
    name: str
    """Text that people see, unique in the recording."""
    category: str
    """Name of the label's class; empty: none."""
    color: Color
    """``#rrggbb``."""
    locked: bool
    """Edits change neither the label nor its points."""
    visible: bool
    """The page shows its points; edits skip hidden points."""
    points: int | None = field(default=None, compare=False)
    """Number of its points in all frames, without deleted ones; only lists of labels have it."""


@dataclass(frozen=True, slots=True)
class NewLabel(Body):
    """A new label; the server chooses a missing ``id`` and ``color``."""

    name: Name
    """Text that people see."""
    category: CategoryName = ""
    """Name of a class; empty: none."""
    color: Color | None = None
    """``#rrggbb``; null: a colour that differs from the palette's."""
    id: PaintId | None = None
    """Number of the label; null: the lowest free one."""
    locked: bool = False
    """Refuse edits of the label and its points."""
    visible: bool = True
    """Show its points on the page."""
    distinct: bool = False
    """Replace a name or colour that is in use by a free one, for example "pin 2"."""


@dataclass(frozen=True, slots=True)
class LabelPatch(Body):
    """Changes of a label; missing fields and null do not change it."""

    name: Name | None = None
    """New text that people see."""
    category: CategoryName | None = None
    """Name of its new class; empty: none."""
    color: Color | None = None
    """New colour, ``#rrggbb``."""
    locked: bool | None = None
    """Refuse edits of the label and its points."""
    visible: bool | None = None
    """Show its points on the page."""


@dataclass(frozen=True, slots=True)
class Merge(Body):
    """Labels to merge into another label."""

    labels: Annotated[tuple[PaintId, ...], Rule(min_length=1, max_length=1000)]
    """Ids of the labels that are removed."""


@dataclass(frozen=True, slots=True)
class Division(Body):
    """Rule that divides a label's points in a frame into parts."""

    frame: FrameIndex
    """Number of the frame."""
    gap: Gap | None = None
    """Metres between parts; null: more than the spacing of the points."""
    least: Annotated[int, Rule(ge=1, le=10**9)] = 10
    """Least points of a part; smaller parts stay with the label."""


@dataclass(frozen=True, slots=True)
class PaletteLabel(Value):
    """A label without its id; other fields of an exported ``palette.json`` are ignored."""

    EXTENSIBLE: ClassVar[bool] = True

    name: Name
    """Text that people see."""
    category: CategoryName = ""
    """Name of its class; empty: none."""
    color: Color | None = None
    """``#rrggbb``; null: the default colour of its id."""


@dataclass(frozen=True, slots=True)
class PaletteAddition(Body):
    """Labels to add, or a template that contains them."""

    template: Annotated[str, Rule(max_length=64)] | None = None
    """Name of a well-known dataset, from ``GET /templates``."""
    labels: Annotated[tuple[PaletteLabel, ...], Rule(max_length=65534)] = ()
    """Labels of a file; those whose name and category the palette has are skipped."""


@dataclass(frozen=True, slots=True)
class PaletteOrder(Body):
    """Order of the palette."""

    labels: Annotated[tuple[LabelId, ...], Rule(max_length=65534)]
    """Ids of labels, first to last; missing labels follow."""


@dataclass(frozen=True, slots=True)
class Palette(Value):
    """A palette as a file."""

    labels: tuple[PaletteLabel, ...]
    """Its labels, in order."""


@dataclass(frozen=True, slots=True)
class OfferedCategories(Value):
    """Categories for labels."""

    selected: bool
    """The project selects them: labels get no other category."""
    names: tuple[str, ...]
    """Their names, by number."""


@dataclass(frozen=True, slots=True)
class AddedLabels(Value):
    """Result of an addition to the palette."""

    added: tuple[str, ...]
    """Names of the new labels."""
