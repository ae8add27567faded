"""Corrections of the reading of a recording's files, given by the user."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from pointbrush.errors import BadInputError
from pointbrush.formats.tables.names import AXES, DELIMITERS, POSES
from pointbrush.values.imports import LARGEST_SCALE, LISTS, MOST_COLUMNS

if TYPE_CHECKING:
    from pointbrush.frame import PointFrame

MEANINGS = ("x", "y", "z", "red", "green", "blue", "rgb", "intensity", "label", "instance")
"""Roles of a column; any other name keeps it as a field of its own."""
LEFT_OUT = "-"


@dataclass(frozen=True, slots=True)
class Corrections:
    """Choices of the user for reading files; they take precedence over the files' own data.

    The fields of ``ImportOptions`` describe them.  Raises BadInputError for an invalid value.
    """

    format: str | None = None
    columns: tuple[str, ...] = ()
    delimiter: str | None = None
    decimal_comma: bool | None = None
    scale: float = 1.0
    up: str | None = None
    topic: str | None = None
    sensors: Literal["one", "all"] = "one"
    sensor: tuple[str, ...] = ()
    extrinsics: str | None = None
    clock_offset: tuple[str, ...] = ()
    poses: str = "auto"
    by_order: bool = False
    drop_invalid: bool = False

    def __post_init__(self) -> None:
        if len(self.columns) > MOST_COLUMNS or not all(
            part.strip() and len(part) <= 200 for part in self.columns
        ):
            raise BadInputError(
                f"columns: expected up to {MOST_COLUMNS} meanings ({', '.join(MEANINGS)}, or "
                f"{LEFT_OUT!r} for none) or pairs 'column=meaning', got {len(self.columns)} or an "
                "empty one"
            )
        if len({"=" in part for part in self.columns}) > 1:
            raise BadInputError("columns: expected meanings in order or pairs, got both")
        if self.delimiter is not None and (
            len(self.delimiter) != 1 and self.delimiter not in DELIMITERS
        ):
            raise BadInputError(
                f"delimiter: expected one character or {', '.join(DELIMITERS)}, got "
                f"{self.delimiter[:20]!r}"
            )
        if not (math.isfinite(self.scale) and 0 < self.scale <= LARGEST_SCALE):
            raise BadInputError(
                f"scale: expected metres per unit, above 0 and up to {LARGEST_SCALE:g}, got "
                f"{self.scale}"
            )
        if self.sensors not in ("one", "all"):
            raise BadInputError(f"sensors: expected one or all, got {self.sensors[:20]!r}")
        if self.up is not None and self.up not in AXES:
            raise BadInputError(f"up: expected one of {', '.join(AXES)}, got {self.up[:20]!r}")

    @property
    def separator(self) -> str | None:
        """The character between values of a text, None for runs of spaces or without a choice."""
        separator = DELIMITERS.get(self.delimiter or "", self.delimiter)
        return None if separator == " " else separator

    @property
    def topics(self) -> list[str]:
        """The topics that the user named."""
        return [topic.strip() for topic in (self.topic or "").split(",") if topic.strip()]

    @property
    def poses_file(self) -> Path | None:
        """The file of poses that the user named, or None."""
        return None if self.poses in POSES else Path(self.poses)

    def applied(self, frame: PointFrame) -> PointFrame:
        """Return a frame in metres, and without its pose if poses are left out."""
        pose = None if self.poses == "none" else frame.pose
        if self.scale == 1.0:
            return frame if pose is frame.pose else replace(frame, pose=pose)
        if pose is not None:
            pose = pose.copy()
            pose[:3, 3] *= self.scale
        viewpoint = frame.viewpoint
        return replace(
            frame,
            xyz=frame.xyz.astype("float64") * self.scale,
            pose=pose,
            viewpoint=None if viewpoint is None else viewpoint * self.scale,
        )


def parse_corrections(given: Mapping[str, Any]) -> Corrections:
    """Corrections from options, of which lists may be one text with commas.

    Raises BadInputError.
    """
    values = {name: value for name, value in given.items() if value not in (None, "")}
    for name in LISTS:
        parts = values.get(name, ())
        parts = parts.split(",") if isinstance(parts, str) else parts
        values[name] = tuple(str(part).strip() for part in parts)
    if isinstance(values.get("topic"), list | tuple):
        values["topic"] = ",".join(values["topic"])
    if isinstance(values.get("up"), str):
        values["up"] = values["up"].lower().removeprefix("+")
    return Corrections(**values)


def meanings(names: Sequence[str], columns: Sequence[str], where: str) -> dict[str, str]:
    """Return the meaning of each column by its name in the file, in order.

    ``columns`` is ``Corrections.columns``.  Raises BadInputError if they do not fit ``names``.
    """
    if columns and "=" in columns[0]:
        pairs = dict(part.split("=", 1) for part in columns)
        absent = [name for name in pairs if name not in names]
        if absent:
            raise BadInputError(
                f"{where}: expected columns of {', '.join(names)}, got {absent[0]!r}"
            )
        return {name: pairs.get(name, name) for name in names}
    if len(columns) != len(names):
        raise BadInputError(
            f"{where}: expected meanings for {len(names)} columns ({', '.join(names)[:200]}), got "
            f"{len(columns)}"
        )
    return dict(zip(names, columns, strict=True))
