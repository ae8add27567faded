"""The tables of studies: participants with their steps and copies of recordings, and logs."""

from __future__ import annotations

from sqlalchemy import (
    Column,
    Double,
    ForeignKey,
    Integer,
    LargeBinary,
    String,
    Table,
    Text,
    UniqueConstraint,
)

from pointbrush.database.project_tables import metadata as metadata

study_participants = Table(
    "study_participants",
    metadata,
    Column("account", String(64), primary_key=True),  # random, the author of the edits
    Column("study", String(64), nullable=False),
    Column("number", Integer, nullable=False),  # 1, 2, … of the study
    Column("digest", String(64), nullable=False, unique=True),  # of the code
    Column("conditions", Text, nullable=False),  # JSON list of names, in order
    Column("finished", Text, nullable=False),  # JSON list of [began, ended, paused_s, answers]
    Column("copies", Text, nullable=False),  # JSON object: number of a sequence by its step
    Column("began", Double),  # of the current step, seconds since the epoch; NULL: none runs
    Column("paused", Double),  # time at which the running pause began, or NULL
    Column("paused_s", Double, nullable=False),  # seconds of earlier pauses of the current step
    Column("records", Integer, nullable=False),  # number of the next record of the log
    UniqueConstraint("study", "number"),
)

study_log = Table(
    "study_log",
    metadata,
    Column("participant", String(64), ForeignKey("study_participants.account"), primary_key=True),
    Column("first", Integer, primary_key=True, autoincrement=False),  # number of a record
    Column("received", Double, nullable=False),  # seconds since the epoch
    Column("records", LargeBinary, nullable=False),  # zlib of a JSON list
)
