"""Facts about a recording's sensor, kept in its folder from the first run over it on."""

from __future__ import annotations

import json
import logging
from dataclasses import asdict

from pointbrush.errors import BadInputError
from pointbrush.sequences import Sequence
from pointbrush.sequences.checksums import SENSOR
from pointbrush.sequences.files import replace_file
from pointbrush.tracking.duplicates import DistinctFrames
from pointbrush.tracking.interface import KnownSensor
from pointbrush.tracking.options import TrackerOptions
from pointbrush.tracking.sensors.examination import examine

log = logging.getLogger(__name__)

VERSION = 1
"""Of the examination: what another version kept is found anew."""


def sensor_of(recording: Sequence) -> KnownSensor:
    """Return the facts that are kept, or find and keep them.

    They can be found again: a damaged file is replaced, a folder that cannot be written keeps none.
    """
    path = recording.path / SENSOR
    key = {"version": VERSION, "identity": recording.identity}
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
