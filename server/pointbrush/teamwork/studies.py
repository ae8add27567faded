"""Participants of studies: their codes, steps, copies of recordings and logs."""

from __future__ import annotations

import json
import secrets
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

from sqlalchemy import Connection, Row, bindparam, delete, func, insert, select, update

from pointbrush.accounts.accounts import MARK, PARTICIPANT, digest_of
from pointbrush.database.database import Database
from pointbrush.database.schema import jobs, sequences
from pointbrush.database.statements import Statement
from pointbrush.database.study_tables import study_log, study_participants
from pointbrush.errors import BadInputError, ConflictError, NotFoundError, TooLargeError
from pointbrush.values.study import (
    LONGEST_LOG,
    MOST_PARTICIPANTS,
    MOST_RECORDS,
    ParticipantState,
)

Record = dict[str, Any]
"""A record of a log as JSON."""
CODE = "study-"
"""Beginning of every code, which distinguishes it from tokens."""
_COLUMNS = study_participants.c
_OF_DIGEST = Statement(select(_COLUMNS.account).where(_COLUMNS.digest == bindparam("digest")))


class FinishedStep(NamedTuple):
    """A finished step: begin and end (seconds since the epoch), pauses (seconds), answers."""

    began: float
    ended: float
    paused_s: float
    answers: list[int]


@dataclass(frozen=True, slots=True)
class Session:
    """A participant's session: the row of ``study_participants`` without the digest."""

    account: str
    study: str
    number: int
    conditions: tuple[str, ...]
    finished: tuple[FinishedStep, ...]
    copies: Mapping[int, int]
    """Number of the copy's sequence by the number of its step."""
    began: float | None
    paused: float | None
    paused_s: float
    records: int

    @property
    def step(self) -> int:
        """Return the number of the current step."""
        return len(self.finished)

    @property
    def state(self) -> ParticipantState:
        """Return the state of an unfinished session."""
        if self.paused is not None:
            return "paused"
        return "waiting" if self.began is None else "running"

    def elapsed(self, now: float) -> float:
        """Return the seconds of the current step without pauses."""
        until = now if self.paused is None else self.paused
        return 0.0 if self.began is None else max(0.0, until - self.began - self.paused_s)


class Studies:
    """The participants of all studies of one database; thread-safe.

    Every method with an ``account`` raises NotFoundError for an unknown one.
    """

    def __init__(self, database: Database) -> None:
        self._database = database

    def account_of(self, code: str) -> str | None:
        """Return the account that a code opens, or None; other secrets cost no query."""
        if not code.startswith(CODE):
            return None
        found = self._database.look(_OF_DIGEST, {"digest": digest_of(code)})
        return None if found is None else str(found.account)

    def add(self, study: str, conditions: Callable[[int], Sequence[str]]) -> tuple[Session, str]:
        """Add a participant; return the session and the code, which is not stored.

        ``conditions``: function from the participant's number.  Raises ConflictError.
        """
        code = f"{CODE}{secrets.token_urlsafe(24)}"
        account = f"{PARTICIPANT}{MARK}{secrets.token_hex(16)}"
        query = select(func.max(_COLUMNS.number), func.count()).where(_COLUMNS.study == study)
        with self._database.write() as connection:
            highest, count = connection.execute(query).one()
            if count >= MOST_PARTICIPANTS:
                raise ConflictError(f"participants: expected at most {MOST_PARTICIPANTS:,}")
            number = (highest or 0) + 1
            row = insert(study_participants).values(
                account=account, study=study, number=number, digest=digest_of(code), finished="[]",
                conditions=json.dumps(conditions(number)), copies="{}", paused_s=0.0, records=0,
            )  # fmt: skip
            connection.execute(row)
            return _session(connection, account), code

    def all(self, study: str) -> list[Session]:
        """Return the participants of a study by number."""
        query = select(study_participants).where(_COLUMNS.study == study)
        with self._database.read() as connection:
            return [_read(row) for row in connection.execute(query.order_by(_COLUMNS.number))]

    def get(self, study: str, key: str) -> Session:
        """Return a participant by number or code; raises NotFoundError."""
        account = self.account_of(key)
        for session in self.all(study):
            if account == session.account or str(session.number) == key:
                return session
        raise NotFoundError(f"participant: expected the number or code of one, got {key[:8]!r}")

    def session(self, account: str) -> Session:
        """Return the session of an account."""
        with self._database.read() as connection:
            return _session(connection, account)

    def begin(self, account: str) -> tuple[Session, float]:
        """Begin the session unless it has begun; return it and the time."""
        with self._database.read() as connection:
            session, now = _session(connection, account), self._database.now(connection)
        if session.began is not None or session.finished:
            return session, now
        with self._database.write() as connection:
            _change(connection, account, began=func.coalesce(_COLUMNS.began, now))
            return _session(connection, account), now

    def finish(
        self, account: str, step: int, answers: Sequence[int], *, last: bool = False
    ) -> None:
        """End the current step and begin the next one; no effect if it has ended.

        ``last``: the session ends.  Raises ConflictError for a later step, and while it is paused.
        """
        with self._database.write() as connection:
            session, now = _session(connection, account, lock=True), self._database.now(connection)
            if step < session.step:
                return
            if step > session.step:
                raise ConflictError(f"number: expected that of the current step, {session.step}")
            if session.paused is not None:
                raise ConflictError("step: the experimenter has paused the session")
            ended = FinishedStep(session.began or now, now, session.paused_s, [*answers])
            done = json.dumps([*session.finished, ended])
            began = None if last else now
            _change(connection, account, finished=done, began=began, paused_s=0.0)

    def pause(self, account: str, *, paused: bool) -> None:
        """Pause a session, or continue it; a repeated call has no effect."""
        with self._database.write() as connection:
            session, now = _session(connection, account, lock=True), self._database.now(connection)
            if paused and session.paused is None:
                _change(connection, account, paused=now)
            elif not paused and session.paused is not None:
                spent = now - max(session.paused, session.began or now)
                _change(connection, account, paused=None, paused_s=session.paused_s + spent)

    def copies(self, session: Session) -> dict[int, str]:
        """Return the ids of the participant's copies by the number of their step."""
        query = select(sequences.c.number, sequences.c.id).where(
            sequences.c.number.in_([*session.copies.values()]), sequences.c.deleted.is_(None)
        )
        with self._database.read() as connection:
            ids = {row.number: row.id for row in connection.execute(query)}
        return {step: ids[number] for step, number in session.copies.items() if number in ids}

    def keep_copy(self, account: str, step: int, sequence: str) -> None:
        """Give a copy to a participant for a step."""
        query = select(sequences.c.number).where(
            sequences.c.id == sequence, sequences.c.deleted.is_(None)
        )
        with self._database.write() as connection:
            number = connection.execute(query).scalar_one()
            known = _session(connection, account, lock=True).copies
            _change(connection, account, copies=json.dumps({**known, step: number}))

    # ── logs ─────────────────────────────────────────────────────────────────────────────

    def append(self, account: str, first: int, records: Sequence[Mapping[str, Any]]) -> int:
        """Append records, of which ``first`` is the number of the first one; return the next one.

        Records that are stored already have no effect.  Raises ConflictError for a gap and for
        other content, BadInputError for a step to come, TooLargeError.
        """
        given: list[Record] = json.loads(json.dumps(records))
        with self._database.write() as connection:
            session = _session(connection, account, lock=True)
            end, latest = session.records, max(each["step"] for each in given)
            if latest > session.step:
                raise BadInputError(f"step: expected at most {session.step}, got {latest}")
            if first > end:
                raise ConflictError(
                    f"log: expected record {end} next, got {first}: records {end} to {first - 1} "
                    "are missing"
                )
            known = _records(connection, account, first) if first < end else []
            for number, (own, other) in enumerate(zip(known, given, strict=False), first):
                if own != other | {"received": own["received"]}:
                    raise ConflictError(f"log: record {number} is stored with other content")
            fresh, following = given[end - first :], max(end, first + len(given))
            if following > LONGEST_LOG:
                raise TooLargeError(f"log: expected at most {LONGEST_LOG:,} records")
            if fresh:
                packed = zlib.compress(json.dumps(fresh, separators=(",", ":")).encode())
                row = {"participant": account, "first": end, "records": packed}
                now = self._database.now(connection)
                connection.execute(insert(study_log), row | {"received": now})
                _change(connection, account, records=following)
            return following

    def log(self, account: str) -> list[Record]:
        """Return all records, each with ``received``, the time of its receipt by the server."""
        with self._database.read() as connection:
            return _records(connection, account, 0)

    def erase(self, account: str) -> None:
        """Remove the rows of a participant, except labels; see ``Recordings.erase`` for these."""
        with self._database.write(erases=True) as connection:
            connection.execute(delete(study_log).where(study_log.c.participant == account))
            connection.execute(delete(study_participants).where(_COLUMNS.account == account))
            connection.execute(delete(jobs).where(jobs.c.author == account))
        self._database.empty_log()


def _session(connection: Connection, account: str, *, lock: bool = False) -> Session:
    query = select(study_participants).where(_COLUMNS.account == account)
    row = connection.execute(query.with_for_update() if lock else query).one_or_none()
    if row is None:
        raise NotFoundError("participant: expected a known one")
    return _read(row)


def _read(row: Row[Any]) -> Session:
    values = {each.name: getattr(row, each.name) for each in fields(Session)}
    copies = {int(step): number for step, number in json.loads(row.copies).items()}
    finished = tuple(FinishedStep(*each) for each in json.loads(row.finished))
    conditions = tuple(json.loads(row.conditions))
    return Session(**values | {"conditions": conditions, "finished": finished, "copies": copies})


def _change(connection: Connection, account: str, **values: Any) -> None:
    is_row = _COLUMNS.account == account
    connection.execute(update(study_participants).where(is_row).values(**values))


def _records(connection: Connection, account: str, first: int) -> list[Record]:
    """Return the stored records from ``first`` on, each with the time of its receipt."""
    columns = study_log.c
    query = select(study_log).where(
        columns.participant == account,
        columns.first > first - MOST_RECORDS,  # a row has at most so many
    )
    return [
        record | {"received": row.received}
        for row in connection.execute(query.order_by(columns.first))
        for number, record in enumerate(json.loads(zlib.decompress(row.records)), row.first)
        if number >= first
    ]
