"""ROS 2 bags in SQLite (``.db3``) with PointCloud2 messages."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path

from pointbrush.errors import BadInputError
from pointbrush.formats.options import ReadOptions
from pointbrush.formats.pointcloud2 import TYPES, frame_of_message
from pointbrush.formats.recording import Topic, choose_topic
from pointbrush.frame import PointFrame

# Views could compute anything, for ever.
KINDS = "SELECT name, type FROM sqlite_master WHERE name IN ('topics', 'messages')"
COUNTS = """
    SELECT topics.name, topics.type, count(messages.id), min(messages.timestamp),
           max(messages.timestamp)
    FROM topics LEFT JOIN messages ON messages.topic_id = topics.id
    GROUP BY topics.name, topics.type
"""
MESSAGES = """
    SELECT messages.timestamp, messages.data
    FROM messages JOIN topics ON messages.topic_id = topics.id
    WHERE topics.name = ? ORDER BY messages.timestamp, messages.id
"""


def read_rosbag2(path: Path, options: ReadOptions) -> Iterator[PointFrame]:
    """The PointCloud2 messages of the topic that has most, by time.

    Raises BadInputError for a file that is no bag, damaged, or without such messages.
    """
    topic = survey_rosbag2(path).name
    with _opened(path) as database:
        for time, message in database.execute(MESSAGES, (topic,)):
            if not isinstance(time, int) or not isinstance(message, bytes):
                raise BadInputError(f"{path.name}: expected messages as bytes with a time")
            yield frame_of_message(f"{path.name} {topic}", message, "cdr", time / 1e9, options)


def survey_rosbag2(path: Path) -> Topic:
    """The topic that is read, its number of messages and their times."""
    with _opened(path) as database:
        kinds = dict(database.execute(KINDS).fetchall())
        if kinds != {"topics": "table", "messages": "table"}:
            raise BadInputError(
                f"{path.name}: expected a ROS 2 bag with the tables topics and messages"
            )
        rows = database.execute(COUNTS).fetchall()
    # SQLite keeps any type in any column.
    if not all(
        isinstance(name, str) and isinstance(start or 0, int) and isinstance(end or 0, int)
        for name, _, _, start, end in rows
    ):
        raise BadInputError(f"{path.name}: expected topics with names and times")
    clouds = {name: count for name, kind, count, _, _ in rows if kind in TYPES}
    topic = choose_topic(path.name, clouds, {str(row[0]): str(row[1]) for row in rows})
    _, _, count, start, end = next(row for row in rows if row[0] == topic)
    return Topic(topic, count, (start or 0) / 1e9, (end or 0) / 1e9)


@contextmanager
def _opened(path: Path) -> Iterator[sqlite3.Connection]:
    """A read-only connection; SQLite's errors become BadInputError."""
    if path.exists() and path.stat().st_size == 0:
        raise BadInputError(f"{path.name}: expected a bag, got an empty file (0 bytes)")
    try:
        # Immutable: no journal or lock is written beside a file of somebody else.
        address = f"{path.absolute().as_uri()}?mode=ro&immutable=1"
        with closing(sqlite3.connect(address, uri=True)) as database:
            database.text_factory = partial(str, encoding="utf-8", errors="replace")
            yield database
    # Even the text of SQLite's own complaint can hold bytes of the damaged file.
    except (sqlite3.Error, UnicodeError) as error:
        raise BadInputError(f"{path.name}: expected a ROS 2 bag, {error}") from None
