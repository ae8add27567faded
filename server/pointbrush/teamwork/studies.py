"""Participants of studies: their codes, steps, copies of recordings and logs."""

from __future__ import annotations

import json
import secrets
import zlib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, Row, bindparam, delete, func, insert, select, update

from pointbrush.accounts.accounts import MARK, PARTICIPANT, digest_of
from pointbrush.database.database import Database
from pointbrush.database.schema import jobs, sequences
from pointbrush.database.statements import Statement
from pointbrush.database.study_tables import (
    study_copies,
    study_log,
    study_participants,
    study_steps,
)
from pointbrush.errors import ConflictError, NotFoundError, TooLargeError
from pointbrush.values.study import LONGEST_LOG, MOST_PARTICIPANTS

Record = dict[str, Any]
"""A record of a log as JSON."""
_PARTICIPANTS = study_participants.c
_OF_DIGEST = Statement(
    select(_PARTICIPANTS.account).where(_PARTICIPANTS.digest == bindparam("digest"))
)


@dataclass(frozen=True, slots=True)
class Session:
    """A participant's session: the fields of ``study_participants`` without the digest."""

    account: str
    study: str
    number: int
    conditions: tuple[str, ...]
    step: int
    began: float | None
    paused: float | None
    paused_s: float
    records: int
    seen: float | None

    def elapsed(self, now: float) -> float:
        """Return the seconds of the current step without pauses."""
        until = now if self.paused is None else self.paused
        return 0.0 if self.began is None else max(0.0, until - self.began - self.paused_s)


@dataclass(frozen=True, slots=True)
class FinishedStep:
    """A finished step: begin and end (seconds since the epoch), pauses (seconds), answers."""

    began: float
    ended: float
    paused_s: float
    answers: tuple[int, ...]


class Studies:
    """The participants of all studies of one database; thread-safe."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def account_of(self, code: str) -> str | None:
        """Return the account that a code opens, or None."""
        found = self._database.look(_OF_DIGEST, {"digest": digest_of(code)})
        return None if found is None else str(found.account)

    def add(self, study: str, conditions: Callable[[int], Sequence[str]]) -> tuple[Session, str]:
        """Add a participant; return the session and the code, which is not stored.

        ``conditions``: function from the participant's number.  Raises ConflictError.
        """
        code, of_study = secrets.token_urlsafe(24), _PARTICIPANTS.study == study
        account = f"{PARTICIPANT}{MARK}{secrets.token_hex(16)}"
        with self._database.write() as connection:
            query = select(func.max(_PARTICIPANTS.number), func.count()).where(of_study)
            highest, count = connection.execute(query).one()
            if count >= MOST_PARTICIPANTS:
                raise ConflictError(f"participants: expected at most {MOST_PARTICIPANTS:,}")
            number = (highest or 0) + 1
            row = {"number": number, "conditions": json.dumps([*conditions(number)])}
            row |= {"account": account, "study": study, "digest": digest_of(code)}
            connection.execute(
                insert(study_participants), row | {"step": 0, "paused_s": 0.0, "records": 0}
            )
            return _session(connection, account), code

    def counts(self) -> Counter[str]:
        """Return the number of participants of each study."""
        query = select(_PARTICIPANTS.study, func.count()).group_by(_PARTICIPANTS.study)
        with self._database.read() as connection:
            return Counter(dict(connection.execute(query).tuples().all()))

    def all(self, study: str) -> list[Session]:
        """Return the participants of a study by number."""
        query = select(study_participants).where(_PARTICIPANTS.study == study)
        with self._database.read() as connection:
            return [_read(row) for row in connection.execute(query.order_by(_PARTICIPANTS.number))]

    def get(self, study: str, key: str) -> Session:
        """Return a participant by number or code; raises NotFoundError."""
        number, account = key.isdecimal() and int(key), self.account_of(key)
        for session in self.all(study):
            if session.number == number or session.account == account:
                return session
        raise NotFoundError(f"participant: expected the number or code of one, got {key[:8]!r}")

    def session(self, account: str) -> Session:
        """Return the session of an account; raises NotFoundError."""
        with self._database.read() as connection:
            return _session(connection, account)

    def see(self, account: str) -> tuple[Session, float]:
        """Note a call of the participant; return the session and the time of the call."""
        with self._database.write() as connection:
            now = self._database.now(connection)
            began = func.coalesce(_PARTICIPANTS.began, now)
            _change(connection, account, seen=now, began=began)
            return _session(connection, account), now

    def finish(self, account: str, step: int, answers: Sequence[int]) -> None:
        """End the current step and begin the next one; no effect if it has ended.

        Raises ConflictError for a later step, and while the session is paused.
        """
        with self._database.write() as connection:
            session, now = _session(connection, account, lock=True), self._database.now(connection)
            if step < session.step:
                return
            if step > session.step:
                raise ConflictError(f"number: expected that of the current step, {session.step}")
            if session.paused is not None:
                raise ConflictError("step: the experimenter has paused the session")
            row = {"participant": account, "step": step, "began": session.began or now}
            row |= {"ended": now, "paused_s": session.paused_s, "answers": json.dumps([*answers])}
            connection.execute(insert(study_steps), row)
            _change(connection, account, step=step + 1, began=now, paused_s=0.0, seen=now)

    def pause(self, account: str, *, paused: bool) -> None:
        """Pause a session, or continue it; a repeated call has no effect."""
        with self._database.write() as connection:
            session, now = _session(connection, account, lock=True), self._database.now(connection)
            if paused and session.paused is None:
                _change(connection, account, paused=now)
            elif not paused and session.paused is not None:
                begin = max(session.paused, session.began or now)
                total = session.paused_s + (now - begin if session.began else 0.0)
                _change(connection, account, paused=None, paused_s=total)

    def steps(self, account: str) -> dict[int, FinishedStep]:
        """Return the finished steps by number."""
        query = select(study_steps).where(study_steps.c.participant == account)
        with self._database.read() as connection:
            return {
                row.step: FinishedStep(
                    row.began, row.ended, row.paused_s, tuple(json.loads(row.answers))
                )
                for row in connection.execute(query)
            }

    # ── copies ───────────────────────────────────────────────────────────────────────────

    def copies(self, account: str) -> dict[int, str]:
        """Return the ids of the participant's copies by the number of their step."""
        joined = study_copies.join(sequences, sequences.c.number == study_copies.c.sequence)
        query = select(study_copies.c.step, sequences.c.id).select_from(joined)
        with self._database.read() as connection:
            rows = connection.execute(query.where(study_copies.c.participant == account))
            return {row.step: row.id for row in rows}

    def keep_copy(self, account: str, step: int, sequence: str) -> None:
        """Give a copy to a participant for a step."""
        number = select(sequences.c.number).where(
            sequences.c.id == sequence, sequences.c.deleted.is_(None)
        )
        row = {"participant": account, "step": step, "sequence": number.scalar_subquery()}
        with self._database.write() as connection:
            connection.execute(insert(study_copies).values(**row))

    # ── logs ─────────────────────────────────────────────────────────────────────────────

    def append(self, account: str, first: int, records: Sequence[Mapping[str, Any]]) -> int:
        """Append records, of which ``first`` is the number of the first one; return the next one.

        Records that are stored already have no effect.  Raises ConflictError for a gap and for
        other content, TooLargeError.
        """
        given: list[Record] = json.loads(json.dumps(records))
        with self._database.write() as connection:
            end = _session(connection, account, lock=True).records
            if first > end:
                raise ConflictError(
                    f"log: expected record {end} next, got {first}: records {end} to {first - 1} "
                    "are missing"
                )
            stored = _records(connection, account, first)[: len(given)] if first < end else []
            for number, (own, other) in enumerate(zip(stored, given, strict=False), first):
                if own != other:
                    raise ConflictError(f"log: record {number} is stored with other content")
            fresh = given[end - first :]
            if end + len(fresh) > LONGEST_LOG:
                raise TooLargeError(f"log: expected at most {LONGEST_LOG:,} records")
            if fresh:
                packed = zlib.compress(json.dumps(fresh, separators=(",", ":")).encode())
                row = {"participant": account, "first": end, "records": packed}
                now = self._database.now(connection)
                connection.execute(insert(study_log), row | {"received": now})
                _change(connection, account, records=end + len(fresh), seen=now)
            return end + len(fresh)

    def log(self, account: str) -> list[Record]:
        """Return all records, each with ``received``, the time of its receipt by the server."""
        query = select(study_log).where(study_log.c.participant == account)
        with self._database.read() as connection:
            rows = connection.execute(query.order_by(study_log.c.first)).all()
        return [
            record | {"received": row.received}
            for row in rows
            for record in json.loads(zlib.decompress(row.records))
        ]

    def erase(self, account: str) -> None:
        """Remove the rows of a participant, except labels; see ``Recordings.erase`` for these."""
        with self._database.write(erases=True) as connection:
            for table in (study_steps, study_copies, study_log):
                connection.execute(delete(table).where(table.c.participant == account))
            connection.execute(delete(study_participants).where(_PARTICIPANTS.account == account))
            connection.execute(delete(jobs).where(jobs.c.author == account))


def _session(connection: Connection, account: str, *, lock: bool = False) -> Session:
    query = select(study_participants).where(_PARTICIPANTS.account == account)
    row = connection.execute(query.with_for_update() if lock else query).one_or_none()
    if row is None:
        raise NotFoundError("participant: expected a known one")
    return _read(row)


def _read(row: Row[Any]) -> Session:
    fields = {name: getattr(row, name) for name in Session.__dataclass_fields__}
    return Session(**fields | {"conditions": tuple(json.loads(row.conditions))})


def _change(connection: Connection, account: str, **values: Any) -> None:
    is_row = _PARTICIPANTS.account == account
    connection.execute(update(study_participants).where(is_row).values(**values))


def _records(connection: Connection, account: str, first: int) -> list[Record]:
    """Return the stored records from ``first`` on."""
    columns, found = study_log.c, list[Record]()
    query = select(columns.first, columns.records).where(columns.participant == account)
    for row in connection.execute(query.order_by(columns.first.desc())):
        found[:0] = json.loads(zlib.decompress(row.records))
        if row.first <= first:
            return found[first - row.first :]
    return found
