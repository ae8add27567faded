"""Tracking methods by name: built-in ones and plug-ins of installed packages.

A package adds one with an entry point of the group ``pointbrush.tracking``.  Its object, called
without arguments, returns a ``Method``.  Source: docs/tracking.md.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import cache, partial
from importlib.metadata import entry_points
from typing import TYPE_CHECKING

from pointbrush.errors import BadInputError
from pointbrush.tracking.interface import Method

if TYPE_CHECKING:
    from pointbrush.tracking.compute.rigid import IcpStep
    from pointbrush.tracking.explanation import Watch
    from pointbrush.tracking.options import TrackerOptions

    WatchIcp = Callable[[int, int, IcpStep], None]

GROUP = "pointbrush.tracking"
"""Group of entry points that add a method."""
COLOUR_NEIGHBOURS = 12
"""Number of nearest points among which colour ICP selects the most similar colour."""


# Imported on demand: the server process does no tracking and starts without the trackers'
# dependencies.
def _auto(watch: Watch | None = None, options: TrackerOptions | None = None) -> Method:
    from pointbrush.tracking.icp import PaperTracker
    from pointbrush.tracking.jumps import AcrossJumps
    from pointbrush.tracking.options import TrackerOptions
    from pointbrush.tracking.tracker import AutoTracker

    options = options or TrackerOptions()
    step = PaperTracker(reach=options.jumps.reach_spacings)
    return AcrossJumps(AutoTracker(watch, options), step, options)


def _icp(watch: WatchIcp | None = None) -> Method:
    from pointbrush.tracking.icp import PaperTracker

    return PaperTracker(watch=watch)


def _colour_icp(watch: WatchIcp | None = None) -> Method:
    from pointbrush.tracking.icp import PaperTracker

    return PaperTracker(k=COLOUR_NEIGHBOURS, watch=watch)


def _both_sides(method: Method) -> Method:
    from pointbrush.tracking.bidirectional import BothSides

    return BothSides(method)


def watched(name: str, watch: Watch, watch_icp: WatchIcp) -> Method:
    """Return a built-in method that reports the steps for each label in each frame.

    ``watch`` gets the steps of ``auto``, ``watch_icp`` the iterations of ``icp`` and ``color-icp``.
    Raises BadInputError for another method.
    """
    match name:
        case "auto":
            return _both_sides(_auto(watch))
        case "icp":
            return _both_sides(_icp(watch_icp))
        case "color-icp":
            return _both_sides(_colour_icp(watch_icp))
    raise BadInputError(f"method: expected one that explains itself (auto, icp), got {name!r}")


def with_options(options: TrackerOptions) -> Method:
    """Return ``auto`` with the given options, for experiments."""
    return _both_sides(_auto(options=options))


_BUILT_IN: dict[str, Callable[[], Method]] = {"auto": _auto, "icp": _icp, "color-icp": _colour_icp}


@cache
def _plugins() -> dict[str, Callable[[], Method]]:
    return {
        entry.name: partial(_load, entry.name)
        for entry in entry_points(group=GROUP)
        if entry.name not in _BUILT_IN
    }


def _load(name: str) -> Method:
    """Return the method of an installed plug-in; raises BadInputError if it has no ``track``."""
    entry = next(e for e in entry_points(group=GROUP) if e.name == name)
    method: Method = entry.load()()
    if not callable(getattr(method, "track", None)):
        raise BadInputError(f"method {name}: expected an object with track(), got {method!r}")
    return method


class _Methods(Mapping[str, Callable[[], Method]]):
    """Factories by name of methods with checked inputs, bidirectional between painted frames."""

    def __getitem__(self, name: str) -> Callable[[], Method]:
        factory = _BUILT_IN.get(name) or _plugins()[name]
        return lambda: _both_sides(factory())

    def __iter__(self) -> Iterator[str]:
        return iter([*_BUILT_IN, *_plugins()])

    def __len__(self) -> int:
        return len(_BUILT_IN) + len(_plugins())


METHODS: Mapping[str, Callable[[], Method]] = _Methods()
