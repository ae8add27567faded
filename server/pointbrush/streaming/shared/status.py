"""Status codes of our errors, in REST and in the socket's ``error`` message."""

from __future__ import annotations

from pointbrush import errors

STATUS: tuple[tuple[type[errors.PointbrushError], int], ...] = (
    (errors.NotFoundError, 404),
    (errors.ConflictError, 409),
    (errors.CancelledError, 409),
    (errors.TooLargeError, 413),
    (errors.UnauthorizedError, 401),
    (errors.ForbiddenError, 403),
    (errors.TooManyRequestsError, 429),
    (errors.UnavailableError, 503),
    # Not 503: a retry fails until the files are repaired.
    (errors.DamagedError, 500),
)


class MalformedError(errors.BadInputError):
    """Bytes that cannot even be parsed: 400, where a well-formed wrong value is 422."""

    title = "Malformed input"


def status_of(error: errors.PointbrushError) -> int:
    """Return the status of an error, from its most specific class."""
    for kind, status in STATUS:
        if isinstance(error, kind):
            return status
    refused = isinstance(error, errors.BadInputError) and not isinstance(error, MalformedError)
    return 422 if refused else 400
