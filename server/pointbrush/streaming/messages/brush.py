"""The brush on the wire, derived from the table of shapes (``pointbrush.selection.SHAPES``)."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, create_model

from pointbrush.selection import MAX_FRAMES, SHAPES, TOOLS
from pointbrush.selection.box import BOX
from pointbrush.selection.shape import (
    EditName,
    Flag,
    Kind,
    Number,
    Numbers,
    Parameter,
    Rays,
    Text,
    Vertices,
    Whole,
)
from pointbrush.streaming.messages.values import Finite, FrameIndex, LabelId, Message, Sample, Uuid


def _type_of(kind: Kind) -> Any:
    """Return the pydantic type of a parameter's values."""
    match kind:
        case Number(above, most):
            return Annotated[float, Field(gt=above, le=most, allow_inf_nan=False)]
        case Flag():
            return bool
        case Whole(least, most):
            return Annotated[int, Field(ge=least, le=most)]
        case Text(most):
            return Annotated[str, Field(max_length=most)]
        case EditName():
            return Uuid
        case Numbers(shape):
            return _list_of(Finite, count=_product(shape))
        case Vertices(_, most):
            corner: Any = _list_of(Finite, count=2)
            return Annotated[list[corner], Field(max_length=most)]
        case Rays(most):
            return Annotated[list[Sample], Field(max_length=most)]


def _list_of(item: Any, count: int) -> Any:
    return Annotated[list[item], Field(min_length=count, max_length=count)]


def _product(shape: tuple[int, ...]) -> int:
    count = 1
    for length in shape:
        count *= length
    return count


def _field(parameter: Parameter, shapes: list[str]) -> tuple[Any, Any]:
    """Return a parameter's type and field; what has no default may be null for other shapes."""
    kind, default = _type_of(parameter.kind), parameter.default
    if default is None or isinstance(parameter.kind, Numbers):
        kind, default = kind | None, None
    if isinstance(parameter.kind, Rays):
        default = []
    return kind, Field(default, description=f"{', '.join(shapes)}: {parameter.about}")


def _parameters() -> dict[str, Any]:
    """Return the fields of all shapes' parameters, each once."""
    fields: dict[str, Any] = {}
    for shape in SHAPES.values():
        for parameter in shape.parameters:
            users = [other.name for other in SHAPES.values() if parameter in other.parameters]
            fields[parameter.name] = _field(parameter, users)
    return fields


_Parameters: Any = create_model("_Parameters", __base__=Message, **_parameters())


def _box() -> dict[str, Any]:
    """Return the fields of a box, those of the shape of that name."""
    return {
        each.name: (_type_of(each.kind), Field(*_default(each), description=each.about))
        for each in BOX.parameters
    }


def _default(parameter: Parameter) -> tuple[Any, ...]:
    return (...,) if parameter.default is None else (list(parameter.default),)


ClipBox: Any = create_model(
    "ClipBox",
    __base__=Message,
    __doc__="A box in the coordinates of the frame that a stroke is drawn in.",
    **_box(),
)


class Brush(_Parameters):  # type: ignore[misc]  # its base is made when it is imported
    """Action of a stroke on its samples."""

    label: LabelId = 0
    tool: Literal[TOOLS] = "paint"  # type: ignore[valid-type]
    shape: Literal[tuple(SHAPES)] = Field(  # type: ignore[valid-type]
        "sphere", description=" ".join(f"`{s.name}`: {s.about}" for s in SHAPES.values())
    )
    only_unlabeled: bool = False
    hidden: Annotated[list[LabelId], Field(max_length=65535)] = Field(
        [],
        description="labels that only this viewer hides, beside those that the palette hides; 0: "
        "points without a label. Their points are left alone, and rays pass through them.",
    )
    frames: Annotated[list[FrameIndex], Field(max_length=MAX_FRAMES)] = Field(
        [],
        description="painted beside the frame that the stroke is drawn in, as one edit: their "
        "points lie over it by the recording's poses, those of a tracked label by its track.",
    )
    clip: ClipBox | None = Field(
        None,
        description="what is shown: points outside this box are left alone, by every shape, and "
        "rays pass through them.",
    )
