"""The review of a recording: states and notes, suspicious things, agreement, reports."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pointbrush.client.connection import Client

Place = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Standing:
    """State of frames ``first`` to ``last``; None: of ``label`` as a whole.

    ``label`` None: the frames themselves; ``place`` that the note is pinned to, source metres;
    ``at`` ISO 8601; ``changed``: labels changed after the state was given.
    """

    first: int | None
    last: int | None
    label: int | None
    state: str
    note: str
    place: Place | None
    assignee: str
    by: str
    at: str | None
    changed: bool


@dataclass(frozen=True, slots=True)
class Finding:
    """A suspicious thing; ``place`` in frame ``first``, source metres."""

    id: str
    kind: str
    text: str
    labels: tuple[int, ...]
    first: int | None
    last: int | None
    place: Place | None
    settled: bool


class Review:
    """The review of one recording."""

    def __init__(self, client: Client, sequence: str) -> None:
        self._client, self._sequence = client, sequence

    def _call(self, method: str, path: str, **options: Any) -> Any:
        return self._client.call(method, f"/sequences/{self._sequence}{path}", **options)

    def counts(self) -> dict[str, int]:
        """Return how many frames are open, in review, accepted and rejected."""
        found: dict[str, int] = self._call("GET", "/review").json()["counts"]
        return found

    def standings(self) -> list[Standing]:
        """Return runs of frames about which anything was said, then labels as a whole."""
        told = self._call("GET", "/review").json()
        return [_standing(entry) for entry in (*told["frames"], *told["labels"])]

    def frame(self, frame: int, label: int | None = None) -> Standing:
        """Return how a frame stands, or a label in it."""
        query = {} if label is None else {"label": label}
        return _standing(self._call("GET", f"/frames/{frame}/review", params=query).json())

    def put(
        self,
        first: int | None = None,
        last: int | None = None,
        *,
        label: int | None = None,
        state: str | None = None,
        note: str | None = None,
        place: Sequence[float] | None = None,
        assignee: str | None = None,
    ) -> None:
        """Set what is given of frames ``first`` to ``last`` (the same unless given), or a label.

        Raises ForbiddenError below the role that it needs, NotFoundError, BadInputError.
        """
        given = {
            "first": first,
            "last": first if last is None else last,
            "label": label,
            "state": state,
            "note": note,
            "place": None if place is None else [float(value) for value in place],
            "assignee": assignee,
        }
        body = {name: value for name, value in given.items() if value is not None}
        self._call("PUT", "/review", json=body)

    def history(self, limit: int = 100) -> list[dict[str, Any]]:
        """Return who decided what, the newest first."""
        found: list[dict[str, Any]] = self._call(
            "GET", "/review/history", params={"limit": limit}
        ).json()
        return found

    def checks(self, frames: str | None = None) -> list[Finding]:
        """Return suspicious things, in frames ``I:J`` where given."""
        query = {} if frames is None else {"frames": frames}
        found = self._call("GET", "/checks", params=query).json()["findings"]
        return [_finding(entry) for entry in found]

    def agreement(self, other: str, by: str = "name") -> dict[str, Any]:
        """Return IoU of each label, and points of each frame that differ, with a recording's.

        ``by``: "name" or "category".
        """
        query = {"with": other, "by": by}
        found: dict[str, Any] = self._call("GET", "/agreement", params=query).json()
        return found

    def difference(self, other: str, frame: int, by: str = "name") -> bytes:
        """Return a PNG of a frame from above: where the labels differ."""
        query = {"with": other, "by": by}
        content: bytes = self._call("GET", f"/frames/{frame}/agreement", params=query).content
        return content

    def report(self, out: Path, table: str = "frames") -> Path:
        """Write the report to a file, .html or .csv; returns its path.

        ``table`` of a .csv: "frames", "labels" or "people".
        """
        csv = out.suffix.lower() == ".csv"
        query = {"format": "csv", "table": table} if csv else {"format": "html"}
        out.write_bytes(self._call("GET", "/report", params=query).content)
        return out


def _standing(entry: dict[str, Any]) -> Standing:
    fields = {name: entry[name] for name in Standing.__dataclass_fields__}
    return Standing(**{**fields, "place": _place(entry["place"])})


def _finding(entry: dict[str, Any]) -> Finding:
    fields = {name: entry[name] for name in Finding.__dataclass_fields__}
    return Finding(**{**fields, "labels": tuple(entry["labels"]), "place": _place(entry["place"])})


def _place(values: list[float] | None) -> Place | None:
    return None if values is None else (values[0], values[1], values[2])
