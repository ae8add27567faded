"""Mounts, types and clock offsets of sensors: from a calibration file, and the user's options."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, get_args

from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.formats.geometry.poses import pose_of
from pointbrush.formats.inside import require_inside
from pointbrush.formats.options import Limits
from pointbrush.formats.tables.parsing import parse_json
from pointbrush.geometry.mounts import Matrix, rigid_mount
from pointbrush.names import composed
from pointbrush.values.kinds import SensorType

FILES = ("extrinsics.json", "calibration.json", "calib.txt")
"""Calibration files in a folder with a folder for each sensor."""
TYPES: tuple[str, ...] = get_args(get_args(SensorType)[0])
MOST_BYTES = 1 << 20
"""Greatest size of a calibration file."""
AUTO = "auto"
"""Clock offset that is estimated."""
MOST_SECONDS = 1e10
"""Greatest clock offset, about 300 years: clocks that count from 1970 have offsets below it."""
MOUNT, TYPE, OFFSET = "T_frame_sensor", "type", "clock_offset_s"
"""Keys of a sensor in a calibration file."""


@dataclass(frozen=True, slots=True, eq=False)
class Extrinsics:
    """Facts about a sensor from a calibration file and from options.

    ``offset``: seconds to add to its times, so that they are on the reference sensor's clock; None
    to estimate them from motion.
    """

    T_frame_sensor: Matrix | None = None
    type: SensorType | None = None
    offset: float | None = 0.0


def read_extrinsics(path: Path, limits: Limits) -> dict[str, Extrinsics]:
    """Read a calibration file by the names of sensors.

    JSON: ``{"left": {"T_frame_sensor": 16 numbers, "type": …, "clock_offset_s": …}, …}``.  Text:
    lines ``left: 12 or 16 numbers``.  Raises NotFoundError, ForbiddenError, BadInputError.
    """
    if limits.roots:
        require_inside([path], limits.roots)
    if not path.is_file():
        raise NotFoundError(f"extrinsics: expected a file, there is no {path.name}")
    with path.open("rb") as file:
        data = file.read(MOST_BYTES + 1)
    if len(data) > MOST_BYTES:
        raise BadInputError(f"{path.name}: expected at most {MOST_BYTES:,} bytes, got more")
    text = data.decode("utf-8-sig", "replace")
    if path.suffix.lower() != ".json":
        return dict(_of_lines(path.name, text))
    try:
        document = parse_json(text)
    except ValueError as error:
        raise BadInputError(f"{path.name}: expected JSON, {error}") from None
    if not isinstance(document, dict) or not all(isinstance(v, dict) for v in document.values()):
        raise BadInputError(
            f'{path.name}: expected {{"NAME": {{"{MOUNT}": [16 numbers]}}, …}}, got other JSON'
        )
    return {
        composed(name): _of_json(f"{path.name}: {name}", given) for name, given in document.items()
    }


def _of_json(where: str, given: Mapping[str, Any]) -> Extrinsics:
    if MOUNT not in given:
        raise BadInputError(f"{where}: expected {MOUNT}, got {', '.join(given) or 'nothing'}")
    kind = given.get(TYPE)
    if kind is not None and kind not in TYPES:
        raise BadInputError(f"{where}: {TYPE}: expected one of {', '.join(TYPES)}, got {kind!r}")
    offset = _seconds(f"{where}: {OFFSET}", given.get(OFFSET, 0.0))
    return Extrinsics(rigid_mount(f"{where}: {MOUNT}", given[MOUNT]), kind, offset)


def _of_lines(file: str, text: str) -> Iterable[tuple[str, Extrinsics]]:
    for line in text.splitlines():
        name, colon, numbers = line.split("#")[0].rpartition(":")
        if colon:
            where = f"{file}: {name.strip()}"
            yield (
                composed(name.strip()),
                Extrinsics(rigid_mount(where, pose_of(where, numbers.split()))),
            )


def _seconds(where: str, value: Any) -> float | None:
    if value == AUTO:
        return None
    try:
        seconds = math.nan if isinstance(value, bool) else float(value)
    except (TypeError, ValueError):
        seconds = math.nan
    if not abs(seconds) <= MOST_SECONDS:
        raise BadInputError(
            f"{where}: expected seconds up to {MOST_SECONDS:g} or {AUTO}, got {str(value)[:40]!r}"
        )
    return seconds


def pairs_of(option: str, given: Iterable[str]) -> dict[str, str]:
    """Parse texts ``NAME=VALUE`` of an option; raises BadInputError, also for a repeated name."""
    found: dict[str, str] = {}
    for text in given:
        name, equals, value = (part.strip() for part in text.partition("="))
        name = composed(name)
        if not (name and equals and value):
            raise BadInputError(f"{option}: expected NAME=VALUE, got {text[:80]!r}")
        if name in found:
            raise BadInputError(f"{option}: expected each sensor once, got {name!r} twice")
        found[name] = value
    return found


def with_offsets(
    known: Mapping[str, Extrinsics], sensors: Collection[str], given: Iterable[str]
) -> dict[str, Extrinsics]:
    """Return the extrinsics of all ``sensors``, with clock offsets ``NAME=SECONDS`` of options.

    Raises BadInputError for offsets of unknown sensors.
    """
    found = {name: known.get(name, Extrinsics()) for name in sensors}
    for name, seconds in pairs_of("clock_offset", given).items():
        if name not in found:
            raise BadInputError(
                f"clock_offset: expected one of the sensors {', '.join(sensors)}, got {name!r}"
            )
        found[name] = replace(found[name], offset=_seconds(f"clock_offset: {name}", seconds))
    return found
