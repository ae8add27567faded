"""Boxes as maps, the form shared by the journal, REST and the socket."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from pointbrush.errors import BadInputError
from pointbrush.geometry.oriented_box import AttributeValue, BoxPose, OrientedBox
from pointbrush.names import require_visible
from pointbrush.values import boxes as values
from pointbrush.values.boxes import Box
from pointbrush.values.kinds import FARTHEST, LONGEST_SIDE
from pointbrush.values.taxonomy import MOST_ATTRIBUTES, NAME_LIMIT, TEXT_LIMIT

Fields = dict[str, Any]
"""``label``, ``size``, ``poses`` by frame, ``attributes``, ``provenance`` and ``heading_known`` of
a box, as in JSON.  A change of it has some of these, None for a removed value, and ``exists`` if it
creates or removes the box."""

_MAPS = ("poses", "attributes")
_POSE_FIELDS = ("centre", "quaternion", "provenance", "confidence", "attributes")


def fields_of(box: OrientedBox) -> Fields:
    """Return the fields of a box, with poses in the order of frames."""
    return {
        "label": box.label,
        "size": box.size.tolist(),
        "poses": {str(frame): _pose_fields(box.poses[frame]) for frame in sorted(box.poses)},
        "attributes": dict(box.attributes),
        "provenance": box.provenance,
        "heading_known": box.heading_known,
    }


def _pose_fields(pose: BoxPose) -> Fields:
    return {
        "centre": pose.centre.tolist(),
        "quaternion": pose.quaternion.tolist(),
        "provenance": pose.provenance,
        "confidence": pose.confidence,
        "attributes": dict(pose.attributes),
    }


def box_of(number: int, fields: Mapping[str, Any]) -> OrientedBox:
    """Build the box ``number`` from its fields; raises BadInputError."""
    poses = {int(frame): _pose_of(pose) for frame, pose in fields["poses"].items()}
    size = _floats("size", fields["size"])
    if not size.max(initial=0) <= LONGEST_SIDE:
        raise BadInputError(f"size: expected at most {LONGEST_SIDE:,.0f} m, got {size.tolist()}")
    if not poses:
        raise BadInputError("poses: expected one frame at least; remove the box instead")
    return OrientedBox(
        number,
        fields["label"],
        size,
        {frame: poses[frame] for frame in sorted(poses)},
        check_attributes(fields["attributes"]),
        fields["provenance"],
        fields["heading_known"],
    )


def _pose_of(pose: Mapping[str, Any]) -> BoxPose:
    missing = [name for name in ("centre", "quaternion") if name not in pose]
    if missing:
        raise BadInputError(f"poses: expected centre and quaternion, got no {missing[0]}")
    centre, quaternion = (_floats(name, pose[name]) for name in ("centre", "quaternion"))
    if not np.abs(centre).max(initial=0) <= FARTHEST:
        raise BadInputError(f"centre: expected at most {FARTHEST:g} m, got {centre.tolist()}")
    norm = float(np.linalg.norm(quaternion))
    if np.isfinite(norm) and norm > 1e-9 and abs(norm - 1) > 1e-12:
        quaternion = quaternion / norm
    return BoxPose(
        centre,
        quaternion,
        pose.get("provenance", "drawn"),
        float(pose.get("confidence", 1.0)),
        check_attributes(pose.get("attributes", {})),
    )


def _floats(name: str, values: Any) -> np.ndarray[Any, np.dtype[np.float64]]:
    try:
        return np.asarray(values, np.float64)
    except (TypeError, ValueError):
        raise BadInputError(f"{name}: expected numbers, got {str(values)[:80]}") from None


def check_attributes(given: Mapping[str, Any]) -> dict[str, AttributeValue]:
    """Check names, values and number of attributes; raises BadInputError."""
    if len(given) > MOST_ATTRIBUTES:
        raise BadInputError(f"attributes: expected at most {MOST_ATTRIBUTES}, got {len(given)}")
    for name, value in given.items():
        if not 1 <= len(name) <= NAME_LIMIT:
            raise BadInputError(
                f"attributes: expected names of 1 to {NAME_LIMIT} characters, got {name[:80]!r}"
            )
        require_visible("attribute name", name)
        if isinstance(value, str):
            if len(value) > TEXT_LIMIT:
                raise BadInputError(f"attribute {name}: expected at most {TEXT_LIMIT} characters")
            require_visible(f"attribute {name}", value)
        elif not isinstance(value, bool | int | float) or not np.isfinite(value):
            raise BadInputError(
                f"attribute {name}: expected text, a number, true or false, got {str(value)[:80]}"
            )
    return dict(given)


# ── changes ──────────────────────────────────────────────────────────────────────────────────


def difference(before: Fields | None, after: Fields | None) -> Fields:
    """Return the change from ``before`` to ``after`` (None: no box); empty if they are equal."""
    if before == after:
        return {}
    if before is None or after is None:
        return {"exists": False} if after is None else {"exists": True, **after}
    change: Fields = {}
    for name, value in after.items():
        old = before[name]
        if value == old:
            continue
        if name not in _MAPS:
            change[name] = value
            continue
        part = {key: each for key, each in value.items() if old.get(key) != each}
        change[name] = part | dict.fromkeys(old.keys() - value.keys())
    return change


def changed_by(fields: Fields, change: Mapping[str, Any]) -> Fields:
    """Apply a change to the fields of a box; a creation ignores the earlier fields."""
    made = {} if change.get("exists") else dict(fields)
    for name, value in change.items():
        made[name] = _merged(made.get(name, {}), value) if name in _MAPS else value
    return made


def _merged(old: Mapping[str, Any], news: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in {**old, **news}.items() if value is not None}


def change_of(change: Mapping[str, Any]) -> Callable[[Fields], Fields]:
    """Return a function that applies a requested change to the fields of a box.

    A pose may have some of its fields; the others keep their values.  The provenance of a pose and
    of the size is *drawn* by default.  Attributes are merged; None removes an attribute, or a
    frame's pose.
    """

    def do(fields: Fields) -> Fields:
        whole = dict(change)
        if "size" in change:
            whole.setdefault("provenance", "drawn")
        poses = change.get("poses", {})
        whole["poses"] = {
            frame: None if news is None else _pose_changed(fields["poses"].get(frame, {}), news)
            for frame, news in poses.items()
        }
        return changed_by(fields, whole)

    return do


def _pose_changed(old: Mapping[str, Any], news: Mapping[str, Any]) -> Fields:
    moved = {"centre", "quaternion"} & news.keys()
    made = {**old, **({"provenance": "drawn", "confidence": 1.0} if moved else {}), **news}
    made["attributes"] = _merged(old.get("attributes", {}), news.get("attributes") or {})
    return {name: made[name] for name in _POSE_FIELDS if made.get(name) is not None}


def box_value(box: OrientedBox) -> Box:
    """Return a box as REST and the socket have it."""
    poses = {
        str(frame): values.BoxPose(
            tuple(pose.centre.tolist()), tuple(pose.quaternion.tolist()), pose.provenance,
            pose.confidence, dict(pose.attributes),
        )
        for frame, pose in sorted(box.poses.items())
    }  # fmt: skip
    return Box(
        box.id, box.label, tuple(box.size.tolist()), poses, dict(box.attributes), box.provenance,
        box.heading_known,
    )  # fmt: skip
