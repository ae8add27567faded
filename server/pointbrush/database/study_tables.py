"""The tables of studies: participants, their steps, copies of recordings and logs."""

from __future__ import annotations

from sqlalchemy import (
    Column,
    Double,
    ForeignKey,
    Index,
    Integer,
    LargeBinary,
    String,
    Table,
    Text,
    UniqueConstraint,
)

from pointbrush.database.project_tables import metadata as metadata


def _participant() -> Column[str]:
    return Column(
        "participant", String(64), ForeignKey("study_participants.account"), primary_key=True
    )


study_participants = Table(
    "study_participants",
    metadata,
    Column("account", String(64), primary_key=True),  # random, the author of the edits
    Column("study", String(64), nullable=False),
    Column("number", Integer, nullable=False),  # 1, 2, … of the study
    Column("digest", String(64), nullable=False, unique=True),  # of the code
    Column("conditions", Text, nullable=False),  # JSON list of names, in order
    Column("step", Integer, nullable=False),  # number of the current step
    Column("began", Double),  # of the current step, seconds since the epoch; NULL: not begun
    Column("paused", Double),  # time at which the running pause began, or NULL
    Column("paused_s", Double, nullable=False),  # seconds of earlier pauses of the current step
    Column("records", Integer, nullable=False),  # number of the next record of the log
    Column("seen", Double),  # time of the last call, or NULL
    UniqueConstraint("study", "number"),
)

study_steps = Table(
    "study_steps",
    metadata,
    _participant(),
    Column("step", Integer, primary_key=True, autoincrement=False),
    Column("began", Double, nullable=False),
    Column("ended", Double, nullable=False),
    Column("paused_s", Double, nullable=False),
    Column("answers", Text, nullable=False),  # JSON list of integers
)

study_copies = Table(
    "study_copies",
    metadata,
    _participant(),
    Column("step", Integer, primary_key=True, autoincrement=False),
    Column("sequence", Integer, nullable=False),  # number of the copy
    Index("study_copies_sequence", "sequence"),
)

study_log = Table(
    "study_log",
    metadata,
    _participant(),
    Column("first", Integer, primary_key=True, autoincrement=False),  # number of a record
    Column("received", Double, nullable=False),  # seconds since the epoch
    Column("records", LargeBinary, nullable=False),  # zlib of a JSON list
)
