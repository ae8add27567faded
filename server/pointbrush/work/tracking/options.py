"""Options of a tracking run, from which wire, REST, flags and job options are derived."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, get_args

from pointbrush.errors import BadInputError
from pointbrush.settings.definitions import choice, values_of

Overwrite = Literal["never", "tracked", "all"]


@dataclass
class RunOptions:
    """Options of a run, with help texts.

    Fields shared with ``TrackOptions`` are passed to the method.  Raises BadInputError.
    """

    method: str = choice(
        "auto", "tracking method: auto, icp, color-icp or a plug-in (default: auto)"
    )
    overwrite: Overwrite = choice(
        "tracked", "labels that the run may replace (default: tracked; painted labels stay)"
    )
    continue_lost: bool = choice(False, "continue to search for a lost label")
    until_painted: bool = choice(False, "stop tracking a label at a frame in which it is painted")
    stop_unsure: bool = choice(False, "stop the run at a doubtful label")

    def __post_init__(self) -> None:
        known = get_args(Overwrite)
        if self.overwrite not in known:
            raise BadInputError(
                f"overwrite: expected one of {', '.join(known)}, got {self.overwrite!r}"
            )

    @classmethod
    def of(cls, source: object) -> dict[str, Any]:
        """Return the options by name from attributes of ``source``."""
        return values_of(cls, source)
