"""The roles of callers.  Each role includes all earlier ones."""

from __future__ import annotations

from typing import get_args

from pointbrush.errors import BadInputError, ForbiddenError
from pointbrush.values.kinds import Role as Role

ROLES: tuple[Role, ...] = get_args(get_args(Role)[0])
"""All roles, lowest first."""


def require_known(role: str) -> None:
    """Raise BadInputError for an unknown role."""
    if role not in ROLES:
        raise BadInputError(f"role: expected one of {', '.join(ROLES)}, got {role!r}")


def includes(role: Role, needed: Role) -> bool:
    """Return whether ``role`` includes ``needed``."""
    return ROLES.index(role) >= ROLES.index(needed)


def require(role: Role, needed: Role) -> None:
    """Raise ForbiddenError with the name of the needed role unless ``role`` includes it."""
    if not includes(role, needed):
        raise ForbiddenError(f"expected the role {needed} or higher, this token's is {role}")
