"""Loops over points without a NumPy function, compiled by Numba at their first run.

Compiled loops are cached beside the modules, in the user's cache if their folder is read-only, or
in ``NUMBA_CACHE_DIR``, so that each machine compiles them once.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, ParamSpec, TypeVar, cast

import numba
from numba.core import event

logger = logging.getLogger(__name__)
P = ParamSpec("P")
R = TypeVar("R")
_made: list[Any] = []
"""The loops of the imported modules, as Numba's dispatchers."""


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Return the function compiled for the types of its arguments.

    Fast-math is off, so that equal input gives equal labels.  Division by zero behaves as in NumPy.
    The compiled function releases the GIL.
    """
    return _compiled(function)


def innermost(function: Callable[P, R]) -> Callable[P, R]:
    """Return a compiled function for calls by a loop at every point; it may not create arrays.

    It does not count references to its arrays, which the caller holds: atomic counting would take
    longer than a pass over a few points.
    """
    return _compiled(function, _nrt=False)


@contextmanager
def each_compiled(call: Callable[[], None]) -> Iterator[None]:
    """Call ``call`` after each function compiled in the block; an error in it ends the block."""

    class Each(event.Listener):
        def on_start(self, event: object) -> None:
            pass

        def on_end(self, event: object) -> None:  # noqa: ARG002 – Numba's interface
            call()

    with event.install_listener("numba:compile", Each()):
        yield


def share_compiled(packages: tuple[str, ...]) -> float:
    """Return the share, 0 to 1, of the loops of some packages that this process has compiled."""
    loops = [loop for loop in _made if loop.__module__.startswith(packages)]
    return sum(bool(loop.overloads) for loop in loops) / max(len(loops), 1)


def _compiled(function: Callable[P, R], **options: bool) -> Callable[P, R]:
    njit = cast(Callable[..., Any], numba.njit)
    try:
        made = njit(cache=True, nogil=True, error_model="numpy", **options)(function)
    except RuntimeError:  # no writable cache folder
        logger.info("%s will be compiled by each process anew", function.__name__)
        made = njit(nogil=True, error_model="numpy", **options)(function)
    _made.append(made)
    return cast(Callable[P, R], made)
