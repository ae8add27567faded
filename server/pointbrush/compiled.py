"""Loops over points that NumPy has no call for, compiled by Numba when they are first run.

What was compiled is kept beside the modules, in the user's cache where those cannot be written, or
where ``NUMBA_CACHE_DIR`` says, so that it is done once on a machine.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar, cast

import numba

logger = logging.getLogger(__name__)
P = ParamSpec("P")
R = TypeVar("R")


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


def _compiled(function: Callable[P, R], **options: bool) -> Callable[P, R]:
    njit = cast(Callable[..., Any], numba.njit)
    try:
        made = njit(cache=True, nogil=True, error_model="numpy", **options)(function)
    except RuntimeError:  # no place to keep it
        logger.info("%s will be compiled by each process anew", function.__name__)
        made = njit(nogil=True, error_model="numpy", **options)(function)
    return cast(Callable[P, R], made)
