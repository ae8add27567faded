"""Context that handlers share: the workspace, and the parameters that many routes have."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Annotated, Any, Literal

from fastapi import Depends, Header, Path, Query, Request
from fastapi.dependencies.models import Dependant

from pointbrush.errors import BadInputError, TooLargeError
from pointbrush.streaming.messages import Uuid
from pointbrush.workspace import Workspace

SEQUENCE_ID = r"^[a-z0-9][a-z0-9._-]{0,63}$"
SequenceId = Annotated[str, Path(pattern=SEQUENCE_ID, max_length=64, description="sequence id")]


def id_query(description: str, alias: str | None = None) -> Any:
    """Return a query parameter that is an id of a recording, project, snapshot or classifier."""
    return Query(pattern=SEQUENCE_ID, max_length=64, description=description, alias=alias)


SnapshotQuery = Annotated[str | None, id_query("labels as they were in this snapshot")]
RecordingQuery = Annotated[str | None, id_query("only of this recording")]
ProjectId = Annotated[str, Path(pattern=SEQUENCE_ID, max_length=64, description="project id")]
FramePath = Annotated[int, Path(ge=0, lt=2**31, description="frame number, from 0")]
LabelPath = Annotated[int, Path(ge=1, le=65534, description="label id")]
EditId = Annotated[Uuid | None, Query(description="the edit's UUID, which is applied once")]
RunOrder = Annotated[
    Literal["source", "stored"],
    Query(description="order of `runs`: `source` as in the file, `stored` as in the chunks"),
]
IfNoneMatch = Annotated[
    str | None, Header(description="`ETag` of a kept answer, which is confirmed by 304")
]
JobPath = Annotated[Uuid, Path(description="job id")]


async def workspace_of(request: Request) -> Workspace:
    """The workspace that this app serves; on the event loop, which takes no thread."""
    workspace: Workspace = request.app.state.workspace
    return workspace


Ws = Annotated[Workspace, Depends(workspace_of)]


def whole_sequence(seq: SequenceId, workspace: Ws) -> str:
    """The id of a recording that can be opened; raises NotFoundError, DamagedError."""
    workspace.recording(seq)
    return seq


WholeSequence = Annotated[str, Depends(whole_sequence)]
"""Parameter of calls that only need labels; they also fail for a damaged recording."""


async def known_query(request: Request) -> None:
    """Refuse unknown query parameters, because a misspelt one would have no effect.

    Raises BadInputError.
    """
    if not request.query_params:
        return
    known = sorted(_query_names(request.scope["route"].dependant))
    unknown = [name for name in request.query_params if name not in known]
    if unknown:
        expected = f"only {', '.join(known)}" if known else "no parameters"
        raise BadInputError(f"query: expected {expected}, got {unknown[0][:60]!r}")


def _query_names(dependant: Dependant) -> set[str]:
    """Names of the query parameters of a call and of all that it depends on."""
    names = {field.alias for field in dependant.query_params}
    return names.union(*map(_query_names, dependant.dependencies))


async def body_within(request: Request, limit: int, what: str) -> bytearray:
    """The whole body; raises TooLargeError as soon as it is longer than ``limit`` bytes."""
    body = bytearray()
    async for piece in request.stream():
        if len(body) + len(piece) > limit:
            raise TooLargeError(f"{what}: expected at most {limit} bytes, got more")
        body += piece
    return body


def one_of(names: Iterable[str]) -> str:
    """Return a pattern that matches only these names; plug-ins add names, which no Literal can."""
    return f"^({'|'.join(sorted(map(re.escape, names)))})$"


def etag(revision: int) -> str:
    """A strong entity tag for a revision."""
    return f'"{revision}"'


def if_match(header: str | None) -> int | None:
    """The revision that an ``If-Match`` header names; None for absent or ``*``.

    Raises BadInputError for anything but one entity tag of ours.
    """
    if header is None or header.strip() == "*":
        return None
    text = header.strip()
    digits = text[1:-1] if len(text) > 2 and text[0] == text[-1] == '"' else text
    if not (digits.isascii() and digits.isdigit() and len(digits) < 19):
        raise BadInputError(f'If-Match: expected "REVISION", got {header[:60]!r}')
    return int(digits)
