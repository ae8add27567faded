"""The roles: what a caller may do.  Each includes those before it."""

from __future__ import annotations

from typing import Literal, get_args

from pointbrush.errors import ForbiddenError

Role = Literal["viewer", "annotator", "reviewer", "manager", "admin"]
ROLES: tuple[Role, ...] = get_args(Role)
"""From least to most."""


def includes(role: Role, needed: Role) -> bool:
    """Whether ``role`` may do what needs ``needed``."""
    return ROLES.index(role) >= ROLES.index(needed)


def require(role: Role, needed: Role) -> None:
    """Raise ForbiddenError, which names the role that is needed, unless ``role`` includes it."""
    if not includes(role, needed):
        raise ForbiddenError(f"expected the role {needed} or higher, this token's is {role}")
