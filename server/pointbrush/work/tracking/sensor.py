"""Properties of a recording's sensor, cached in its folder by the first run."""

from __future__ import annotations

import json
import logging
from dataclasses import asdict

from pointbrush.errors import BadInputError
from pointbrush.sequences import Sequence
from pointbrush.sequences.storage.checksums import SENSOR
from pointbrush.sequences.storage.files import replace_file
from pointbrush.tracking.duplicates import DistinctFrames
from pointbrush.tracking.interface import KnownSensor
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.examination import examine

log = logging.getLogger(__name__)

VERSION = 1
"""Version of the examination; results of other versions are recomputed."""


def sensor_of(recording: Sequence) -> KnownSensor:
    """Return the cached properties, or determine and cache them.

    A damaged file is replaced; in a read-only folder nothing is cached.
    """
    path = recording.path / SENSOR
    key = {"version": VERSION, "identity": recording.placement}
    try:
        return _decoded(path.read_bytes(), key)
    except FileNotFoundError:
        pass
    except (OSError, BadInputError) as error:
        log.warning("%s is found anew: %s", path, error)
    frames = DistinctFrames(recording.__getitem__)
    found = examine(frames, len(recording), TrackerOptions())
    try:
        replace_file(path, json.dumps(key | asdict(found), indent=1).encode())
    except OSError as error:
        log.info("%s is not kept: %s", path, error)
    return found


def _decoded(data: bytes, key: dict[str, object]) -> KnownSensor:
    try:
        given = json.loads(data)
        kept = {name: given.pop(name, None) for name in key}
        place = given.pop("place")
        if place is not None:
            x, y, z = map(float, place)
            place = (x, y, z)
        facts = KnownSensor(place=place, **given)
    except (ValueError, TypeError, AttributeError, KeyError) as error:
        raise BadInputError(f"expected facts about a sensor in JSON, got {error}") from error
    if kept != key:
        raise BadInputError(f"expected facts of {key}, got those of {kept}")
    return facts
