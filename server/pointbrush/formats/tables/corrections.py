"""Corrections of the reading of a recording's files, given by the user.

The flags of the command line and the options of REST and of import jobs derive from them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pointbrush.errors import BadInputError
from pointbrush.formats.tables.names import AXES, DELIMITERS, POSES
from pointbrush.settings.definitions import choice
from pointbrush.values.imports import LARGEST_SCALE, MOST_COLUMNS

if TYPE_CHECKING:
    from pointbrush.frame import PointFrame

MEANINGS = ("x", "y", "z", "red", "green", "blue", "rgb", "intensity", "label", "instance")
"""Roles of a column; any other name keeps it as a field of its own."""
LEFT_OUT = "-"


@dataclass(frozen=True, slots=True)
class Corrections:
    """Choices of the user for reading files; they take precedence over the files' own data.

    Raises BadInputError for an invalid value.
    """

    format: str | None = choice(None, "file format (default: detected)")
    columns: tuple[str, ...] = choice(
        (),
        "meanings of the columns in their order: x,y,z,intensity,red,green,blue,label,instance, or "
        "'-' for a column to leave out; or pairs: scalar_Foo=label",
    )
    delimiter: str | None = choice(
        None, f"delimiter of text files: a character, or {', '.join(DELIMITERS)}"
    )
    decimal_comma: bool | None = choice(None, "read 1,5 in text files as one and a half")
    scale: float = choice(
        1.0, "metres per unit of the files and their poses: 0.001 for millimetres (default: 1)"
    )
    up: str | None = choice(None, f"axis that points up, as in --up=-y: one of {', '.join(AXES)}")
    """"--up -y" would be read as an option -y."""
    topic: str | None = choice(None, "topic of a bag; topic#frame_id if sensors share a topic")
    poses: str = choice(
        "auto",
        f"{', '.join(POSES)} (VIEWPOINT of PCD files), or a file of poses with one line per frame "
        "(default: auto)",
    )
    by_order: bool = choice(
        False, "match poses with times, and colour images, to frames by their order"
    )
    drop_invalid: bool = choice(False, "leave out points that are NaN or infinite")

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
        if self.up is not None and self.up not in AXES:
            raise BadInputError(f"up: expected one of {', '.join(AXES)}, got {self.up[:20]!r}")

    @property
    def separator(self) -> str | None:
        """The character between values of a text, None for runs of spaces or without a choice."""
        separator = DELIMITERS.get(self.delimiter or "", self.delimiter)
        return None if separator == " " else separator

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
    """Corrections from options, of which ``columns`` may be one text with commas.

    Raises BadInputError.
    """
    values = {name: value for name, value in given.items() if value not in (None, "")}
    columns = values.get("columns", ())
    if isinstance(columns, str):
        columns = columns.split(",")
    values["columns"] = tuple(str(part).strip() for part in columns)
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
