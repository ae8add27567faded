"""The errors pointbrush raises on purpose.

Every message says what was expected and what came.  Nothing here knows HTTP or sockets: the
fronts (command line, web) translate a class into an exit code or a status.
"""

from __future__ import annotations


class PointbrushError(Exception):
    """Base of every error that is the user's to read; ``str(error)`` is one clear sentence."""

    title = "The request failed"

    def __init__(self, *args: object, private: str = "") -> None:
        """``private``: what only the server's operator may read (addresses, paths)."""
        super().__init__(*args)
        self.private = private

    @property
    def whole(self) -> str:
        """The sentence with what is private."""
        return f"{self} ({self.private})" if self.private else str(self)


class BadInputError(PointbrushError, ValueError):
    """A value, a file or a message is not what was expected."""

    title = "Bad input"


class NotFoundError(PointbrushError, LookupError):
    """A sequence, frame, label, edit, job or file that does not exist."""

    title = "Not found"


class ConflictError(PointbrushError):
    """The state changed under the caller (a stale revision), or forbids the change."""

    title = "Conflict"


class LockedLabelError(ConflictError):
    """The label is locked; locked labels are never changed."""

    title = "Label is locked"


class HiddenLabelError(ConflictError):
    """The label is hidden; a stroke neither paints with it nor changes its points."""

    title = "Label is hidden"


class TooLargeError(PointbrushError):
    """A body, file, archive, frame or count exceeds a stated limit."""

    title = "Too large"


class UnauthorizedError(PointbrushError):
    """No token, or a wrong, expired or revoked one."""

    title = "Not authorised"


class ForbiddenError(PointbrushError):
    """The token's role, the page's origin or a path does not allow this."""

    title = "Forbidden"


class ReadOnlyError(ForbiddenError):
    """The workspace's folder, or its database, may not be written here."""

    title = "Read-only"


class TooManyRequestsError(PointbrushError):
    """The caller exceeds a rate limit."""

    title = "Too many requests"


class UnavailableError(PointbrushError):
    """Disk full, or the database is away; nothing was changed, and trying again can work."""

    title = "Temporarily unavailable"


class DamagedError(PointbrushError):
    """A file of a recording is missing, cut short, or not what was imported; others are fine."""

    title = "Damaged recording"


class CancelledError(PointbrushError):
    """A job was cancelled by its user."""

    title = "Cancelled"
