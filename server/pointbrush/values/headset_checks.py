"""Checks of headsets."""

from __future__ import annotations

from dataclasses import dataclass

from pointbrush.values.base import Value


@dataclass(frozen=True, slots=True)
class HeadsetCheck(Value):
    """A check that can begin."""

    sequence: str
    """Id of the recording to try the controls in, which no list contains."""


@dataclass(frozen=True, slots=True)
class NewHeadsetReport(Value):
    """A report that was stored."""

    id: str
    """Id of the report."""
