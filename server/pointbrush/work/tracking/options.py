"""Choices of a person for a tracking run: wire, REST, command line and job follow from them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, get_args

from pointbrush.errors import BadInputError
from pointbrush.options import choice, chosen

Overwrite = Literal["never", "tracked", "all"]


@dataclass
class RunOptions:
    """Choices for one run, each with the command line's words on it.

    Those that ``TrackOptions`` has too reach the method.  Raises BadInputError.
    """

    method: str = choice("auto", "icp, color-icp or auto")
    overwrite: Overwrite = choice(
        "tracked", "which labels a run may replace (default: tracked; painted ones stay)"
    )
    continue_lost: bool = choice(False, "look on for a label after it was lost")
    until_painted: bool = choice(False, "end a label where it is painted again")
    stop_unsure: bool = choice(False, "end the run where a label is doubtful")

    def __post_init__(self) -> None:
        known = get_args(Overwrite)
        if self.overwrite not in known:
            raise BadInputError(
                f"overwrite: expected one of {', '.join(known)}, got {self.overwrite!r}"
            )

    @classmethod
    def of(cls, source: object) -> dict[str, Any]:
        """Return the choices among the attributes of ``source``, to be passed on by name."""
        return chosen(cls, source)
