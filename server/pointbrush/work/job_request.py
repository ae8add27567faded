"""Arguments of a job: a frozen dataclass, stored as JSON so that another server can restart it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from pointbrush.errors import BadInputError

if TYPE_CHECKING:
    from typing import Self


@dataclass(frozen=True)
class JobRequest:
    """Arguments of a job, which are stored as JSON with it."""

    call: ClassVar[str]
    """Key of the service that restarts the job."""

    def as_json(self) -> dict[str, Any]:
        """Return the record from which ``of_json`` makes the request."""
        from pydantic import TypeAdapter  # slow to import

        fields: dict[str, Any] = TypeAdapter(type(self)).dump_python(self, mode="json")
        return {"call": self.call} | fields

    @classmethod
    def of_json(cls, kept: Mapping[str, Any]) -> Self:
        """Return the request of a record; raises BadInputError if it cannot be read."""
        from pydantic import TypeAdapter

        try:
            return TypeAdapter(cls).validate_python(kept)
        except ValueError as error:
            raise BadInputError(f"the stored request cannot be read: {error}") from None
