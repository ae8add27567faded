"""Reports of headset checks: the newest ones of a workspace."""

from __future__ import annotations

import json
import secrets
from dataclasses import asdict

from sqlalchemy import delete, insert, select

from pointbrush.database.database import Database
from pointbrush.database.schema import headset_reports
from pointbrush.errors import TooLargeError
from pointbrush.values.headset_checks import HeadsetReport, HeadsetReportFile
from pointbrush.values.kinds import time_of

KEPT = 50
"""Reports of a workspace; a newer one replaces the oldest."""
LARGEST = 1 << 16
"""Bytes of a report's JSON; a check of one headset writes about 4,000."""


class HeadsetReports:
    """The headset reports of one database; thread-safe."""

    def __init__(self, database: Database) -> None:
        self._database = database

    def add(self, account: str, report: HeadsetReportFile) -> str:
        """Store a report and return its id; the oldest report above the limit is removed.

        Raises TooLargeError, ReadOnlyError and UnavailableError.
        """
        content = json.dumps(asdict(report))
        if len(content) > LARGEST:
            raise TooLargeError(f"report: expected at most {LARGEST:,} bytes, got {len(content):,}")
        table, columns = headset_reports, headset_reports.c
        key = secrets.token_hex(16)
        row: dict[str, object] = {"id": key, "account": account, "report": content}
        newest = select(columns.id).order_by(columns.received.desc()).limit(KEPT)
        with self._database.write() as connection:
            row["received"] = self._database.now(connection)
            connection.execute(insert(table), row)
            connection.execute(delete(table).where(columns.id.not_in(newest)))
        return key

    def all(self) -> list[HeadsetReport]:
        """Return the reports, newest first; raises UnavailableError."""
        from pydantic import TypeAdapter  # slow to import

        read = TypeAdapter(HeadsetReportFile).validate_json
        wanted = select(headset_reports).order_by(headset_reports.c.received.desc())
        with self._database.read() as connection:
            return [
                HeadsetReport(row.id, row.account, time_of(row.received), read(row.report))
                for row in connection.execute(wanted)
            ]
