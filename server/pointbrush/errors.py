"""The errors that pointbrush raises on purpose.

Every message has the expected and the actual value.  The classes are independent of HTTP and
sockets: the front ends (command line, web) map a class to an exit code or a status.
"""

from __future__ import annotations


class PointbrushError(Exception):
    """Base class of errors for users; ``str(error)`` is one clear sentence."""

    title = "The request failed"

    def __init__(self, *args: object, private: str = "") -> None:
        """``private``: details only for the server's operator (addresses, paths)."""
        super().__init__(*args)
        self.private = private

    @property
    def whole(self) -> str:
        """Return the sentence with its private details."""
        return f"{self} ({self.private})" if self.private else str(self)


class BadInputError(PointbrushError, ValueError):
    """A value, a file or a message is invalid."""

    title = "Bad input"


class NotFoundError(PointbrushError, LookupError):
    """A sequence, frame, label, edit, job or file that does not exist."""

    title = "Not found"


class ConflictError(PointbrushError):
    """The state has changed since it was read (a stale revision), or does not allow the change."""

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
    """The token is missing, wrong, expired or revoked."""

    title = "Not authorised"


class ForbiddenError(PointbrushError):
    """The token's role, the page's origin or a path does not allow this."""

    title = "Forbidden"


class ReadOnlyError(ForbiddenError):
    """The workspace's folder, or its database, is read-only."""

    title = "Read-only"


class TooManyRequestsError(PointbrushError):
    """The caller exceeds a rate limit."""

    title = "Too many requests"


class UnavailableError(PointbrushError):
    """The disk is full or the database unreachable; nothing was changed, a retry can succeed."""

    title = "Temporarily unavailable"


class DamagedError(PointbrushError):
    """A file of a recording is missing, truncated or changed since its import."""

    title = "Damaged recording"


class CancelledError(PointbrushError):
    """A job was cancelled by its user."""

    title = "Cancelled"
