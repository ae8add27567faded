"""Loops over points that NumPy has no call for, compiled by Numba when they are first run.

What was compiled is kept beside the modules, in the user's cache where those cannot be written, or
where ``NUMBA_CACHE_DIR`` says, so that it is done once on a machine.
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
"""The loops of the modules that were imported: Numba's dispatchers."""


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """The same function, compiled for the types that it is called with.

    Without the liberties that some compilers take with floating point: the same input gives the
    same labels.  A division by zero gives what NumPy gives.  Other threads run meanwhile.
    """
    return _compiled(function)


def innermost(function: Callable[P, R]) -> Callable[P, R]:
    """The same for what a compiled loop calls for every point: it makes and keeps no array.

    Without counting references to the arrays that it is given, which its caller holds: counting
    them, by atomic instructions, takes longer than looking through a few points.
    """
    return _compiled(function, _nrt=False)


@contextmanager
def each_compiled(call: Callable[[], None]) -> Iterator[None]:
    """Call ``call`` after each function that is compiled in the block; its errors end the block."""

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
    except RuntimeError:  # no place to keep it
        logger.info("%s will be compiled by each process anew", function.__name__)
        made = njit(nogil=True, error_model="numpy", **options)(function)
    _made.append(made)
    return cast(Callable[P, R], made)
