"""ROS 2 bags in SQLite (``.db3``) with PointCloud2 messages."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from functools import partial
from pathlib import Path

from pointbrush.errors import BadInputError
from pointbrush.formats.ros.bag import Bag, BagMessage, Topic, read_bag, unpack_message

# Views are refused, because a query of a view may run forever.
KINDS = "SELECT name, type FROM sqlite_master WHERE name IN ('topics', 'messages')"
COUNTS = """
    SELECT topics.name, topics.type, count(messages.id)
    FROM topics LEFT JOIN messages ON messages.topic_id = topics.id
    GROUP BY topics.name, topics.type
"""
MESSAGES = """
    SELECT messages.timestamp, messages.data
    FROM messages JOIN topics ON messages.topic_id = topics.id
    WHERE topics.name = ? ORDER BY messages.id
"""


def topics_of(path: Path) -> list[Topic]:
    """List a bag's topics; raises BadInputError for a file that is no bag, or damaged."""
    with _opened(path) as database:
        kinds = dict(database.execute(KINDS).fetchall())
        if kinds != {"topics": "table", "messages": "table"}:
            raise BadInputError(
                f"{path.name}: expected a ROS 2 bag with the tables topics and messages"
            )
        rows = database.execute(COUNTS).fetchall()
    # SQLite keeps any type in any column.
    if not all(isinstance(name, str) for name, _, _ in rows):
        raise BadInputError(f"{path.name}: expected topics with names")
    return [Topic(name, str(kind), int(count)) for name, kind, count in rows]


def messages_of(path: Path, topic: str) -> Iterator[BagMessage]:
    """Messages in the order of recording; raises BadInputError for a damaged file."""
    with _opened(path) as database:
        for time, message in database.execute(MESSAGES, (topic,)):
            if not isinstance(time, int) or not isinstance(message, bytes):
                raise BadInputError(f"{path.name}: expected messages as bytes with a time")
            yield BagMessage("cdr", time / 1e9, unpack_message(path.name, message))


BAG = Bag(topics_of, messages_of)
read_rosbag2 = partial(read_bag, BAG)


@contextmanager
def _opened(path: Path) -> Iterator[sqlite3.Connection]:
    """A read-only connection; SQLite's errors become BadInputError."""
    if path.exists() and path.stat().st_size == 0:
        raise BadInputError(f"{path.name}: expected a bag, got an empty file (0 bytes)")
    try:
        # Immutable: no journal or lock is written beside the user's file.
        address = f"{path.absolute().as_uri()}?mode=ro&immutable=1"
        with closing(sqlite3.connect(address, uri=True)) as database:
            database.text_factory = partial(str, encoding="utf-8", errors="replace")
            yield database
    # Even the text of SQLite's error can contain bytes of the damaged file.
    except (sqlite3.Error, UnicodeError) as error:
        raise BadInputError(f"{path.name}: expected a ROS 2 bag, {error}") from None
