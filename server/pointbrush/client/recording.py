"""A recording on a server: its frames, labels, edits and exports."""

from __future__ import annotations

import io
import uuid
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload
from urllib.parse import quote

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pointbrush.client.review import Review
from pointbrush.client.values import Annotation, array_of, npy_of

if TYPE_CHECKING:
    from pointbrush.client.connection import Client

AHEAD = (0.0, 0.0, -1.0)
"""Direction of a sample that is a place alone."""


@dataclass(frozen=True, slots=True)
class Label:
    """A label of the palette."""

    id: int
    name: str
    category: str
    color: str
    locked: bool
    visible: bool


@dataclass(frozen=True, slots=True)
class Edit:
    """An edit that is durable: its id, how many points changed, the recording's revision."""

    edit: str
    changed: int
    revision: int


class Recording:
    """A recording; ``manifest`` as the server tells it."""

    def __init__(self, client: Client, manifest: dict[str, Any]) -> None:
        self._client, self.manifest = client, manifest
        self.id: str = manifest["id"]
        self.name: str = manifest["name"]
        self.frames = Frames(client, self.id, int(manifest["frames"]))
        self.review = Review(client, self.id)

    def __repr__(self) -> str:
        return f"Recording({self.id!r}, {len(self.frames)} frames)"

    def _call(self, method: str, path: str, **options: Any) -> Any:
        return self._client.call(method, f"/sequences/{self.id}{path}", **options)

    # ── palette ──────────────────────────────────────────────────────────────────────────

    def labels(self) -> list[Label]:
        """The palette, by id."""
        return [_label(entry) for entry in self._call("GET", "/labels").json()]

    def create_label(self, name: str, **fields: Any) -> Label:
        """Add a label; ``fields``: category, color."""
        return _label(self._call("POST", "/labels", json={"name": name, **fields}).json())

    # ── edits ────────────────────────────────────────────────────────────────────────────

    def undo(self) -> Edit:
        """Take back one's last edit; raises ConflictError when there is none."""
        return _edit(self._call("POST", "/undo").json())

    def redo(self) -> Edit:
        """Bring back what the last undo took."""
        return _edit(self._call("POST", "/redo").json())

    def track(
        self,
        labels: Sequence[int],
        start: int,
        stop: int,
        *,
        method: str = "auto",
        progress: bool = True,
        **options: Any,
    ) -> dict[str, Any]:
        """Carry labels from frame ``start`` to ``stop``, and wait; returns the job's result."""
        body = {"labels": list(labels), "start": start, "stop": stop, "method": method, **options}
        job = self._call("POST", "/tracking", json=body).json()
        return self._client.wait(job, progress=progress)

    def tracks(self) -> list[dict[str, Any]]:
        """Pose, confidence and state of every tracked label in every frame."""
        found: list[dict[str, Any]] = self._call("GET", "/tracks").json()
        return found

    def import_labels(
        self,
        files: Sequence[Path] | str,
        *,
        format: str | None = None,
        map: str | None = None,
        field: str | None = None,
        no_ground: bool = False,
        dry_run: bool = False,
        progress: bool = False,
    ) -> dict[str, Any]:
        """Import labels made elsewhere, from files here or a path on the server.

        ``map`` names classes: JSON, or lines ``number name``; ``field`` is that of the points that
        is labels; ``no_ground`` leaves the ground out of boxes.  Returns the report.
        """
        from pointbrush.client.connection import opened

        given = {"format": format, "map": map, "field": field}
        fields = {name: value for name, value in given.items() if value is not None}
        if no_ground:
            fields["no_ground"] = "true"
        query = {"dry_run": str(dry_run).lower()}
        if isinstance(files, str):
            body = {"path": files, **fields}
            answer = self._call("POST", "/annotations", json=body, params=query)
        else:
            with opened(list(files)) as parts:
                answer = self._call("POST", "/annotations", files=parts, data=fields, params=query)
        return self._client.wait(answer.json(), progress=progress)

    def export(self, format: str, out: Path, frames: str | None = None) -> Path:
        """Write an export of frames ``I:J`` to a .zip, whole or not at all; returns its path."""
        query = {"format": format} | ({} if frames is None else {"frames": frames})
        content = self._call("GET", "/export", params=query).content
        partial = out.with_name(f".{out.name}-{uuid.uuid4().hex}")
        try:
            partial.write_bytes(content)
            partial.replace(out)
        finally:
            partial.unlink(missing_ok=True)
        return out


class Frames(Sequence["Frame"]):
    """The frames of a recording."""

    def __init__(self, client: Client, sequence: str, count: int) -> None:
        self._client, self._sequence, self._count = client, sequence, count

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, index: int) -> Frame: ...
    @overload
    def __getitem__(self, index: slice) -> list[Frame]: ...
    def __getitem__(self, index: int | slice) -> Frame | list[Frame]:
        """A frame, or several; raises IndexError."""
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(self._count))]
        number = index + self._count if index < 0 else index
        if not 0 <= number < self._count:
            raise IndexError(f"expected a frame from 0 to {self._count - 1}, got {index}")
        return Frame(self._client, self._sequence, number)

    def __iter__(self) -> Iterator[Frame]:
        return (self[i] for i in range(self._count))


class Frame:
    """Frame ``index`` of a recording."""

    def __init__(self, client: Client, sequence: str, index: int) -> None:
        self._client, self._sequence, self.index = client, sequence, index

    def _call(self, method: str, path: str, **options: Any) -> Any:
        place = f"/sequences/{self._sequence}/frames/{self.index}{path}"
        return self._client.call(method, place, **options)

    def points(self) -> dict[str, NDArray[Any]]:
        """Arrays of the points: ``xyz`` (N, 3), and ``rgb``, ``intensity`` where there are."""
        content = self._call("GET", "/points", params={"format": "npz"}).content
        with np.load(io.BytesIO(content), allow_pickle=False) as stored:
            return dict(stored.items())

    def cameras(self) -> list[dict[str, Any]]:
        """The cameras that took a picture: name, width, height, K, distortion, T_camera_frame."""
        found: list[dict[str, Any]] = self._call("GET", "/cameras").json()
        return found

    def image(self, camera: str) -> bytes:
        """The picture of a camera as it was imported: JPEG, PNG or WebP."""
        content: bytes = self._call("GET", f"/images/{quote(camera, safe='')}").content
        return content

    def annotation(self, layer: str = "label") -> Annotation:
        """A layer (N,): ``label``, ``provenance`` or ``deleted``, with its ``etag``."""
        answer = self._call("GET", "/annotation", params={"layer": layer})
        return Annotation(array_of(answer), answer.headers["ETag"])

    def annotate(
        self, values: NDArray[Any], layer: str = "label", *, if_match: str | None = None
    ) -> Edit:
        """Replace a layer, as one edit.

        ``if_match``: the ``etag`` of what it was made from; ConflictError when the frame has
        changed since.
        """
        headers = {"Content-Type": "application/x-npy"}
        if if_match is not None:
            headers["If-Match"] = if_match
        content = npy_of(np.asarray(values))
        query = {"layer": layer}
        answer = self._call("PUT", "/annotation", content=content, headers=headers, params=query)
        return _edit(answer.json())

    def stroke(
        self,
        *,
        label: int = 0,
        samples: ArrayLike = (),
        directions: ArrayLike | None = None,
        tool: str = "paint",
        shape: str = "sphere",
        **fields: Any,
    ) -> Edit:
        """Apply a stroke: ``samples`` (S, 3) places or ray origins, ``directions`` (S, 3) of rays.

        ``fields`` are the stroke's own: radius, polygon and matrix, candidate, ….
        """
        origins = np.asarray(samples, np.float64).reshape(-1, 3)
        ways = np.broadcast_to(AHEAD if directions is None else directions, origins.shape)
        rays = [
            {"origin": origin, "direction": way}
            for origin, way in zip(origins.tolist(), np.asarray(ways).tolist(), strict=True)
        ]
        body = {"id": str(uuid.uuid4()), "label": label, "tool": tool, "shape": shape, **fields}
        return _edit(self._call("POST", "/strokes", json={**body, "samples": rays}).json())

    def objects(
        self, origins: ArrayLike, directions: ArrayLike, **fields: Any
    ) -> list[dict[str, Any]]:
        """Candidates of the object that rays (K, 3) point at, from part to group."""
        rays = [
            {"origin": origin, "direction": way}
            for origin, way in zip(
                np.asarray(origins, float).reshape(-1, 3).tolist(),
                np.asarray(directions, float).reshape(-1, 3).tolist(),
                strict=True,
            )
        ]
        answer = self._call("POST", "/object", json={"positives": rays, **fields})
        found: list[dict[str, Any]] = answer.json()["candidates"]
        return found


def _label(entry: dict[str, Any]) -> Label:
    return Label(**{name: entry[name] for name in Label.__dataclass_fields__})


def _edit(entry: dict[str, Any]) -> Edit:
    return Edit(entry["edit"], entry["changed"], entry["revision"])
