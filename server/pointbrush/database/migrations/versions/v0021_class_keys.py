"""Labels store the permanent key of a class instead of its name; reserve official numbers.

Labels stored the name before, so the key of each class is its name.  Renaming a class lost its
labels; if the class has the official number of the name in these labels, they become its labels
again.  An official number that was assigned to a class with another name is withdrawn.
"""

from typing import Any

import sqlalchemy as sa
from alembic import op

from pointbrush.formats.tables.numbering import official_numbers, plain

revision = "0021"
down_revision = "0020"

CATEGORIES = sa.table(
    "categories",
    *map(sa.column, ("number", "name", "color", "key", "merged")),
)
NUMBERS = sa.table("dataset_numbers", *map(sa.column, ("dataset", "category", "number", "stated")))
LABELS = sa.table("labels", sa.column("category"))


def upgrade() -> None:
    op.add_column("categories", sa.Column("key", sa.String(512), nullable=False, server_default=""))
    op.add_column("categories", sa.Column("merged", sa.Integer, nullable=True))
    op.add_column(
        "categories", sa.Column("renamed", sa.BigInteger, nullable=False, server_default="0")
    )
    op.add_column(
        "dataset_numbers",
        sa.Column("stated", sa.Boolean, nullable=False, server_default=sa.false()),
    )
    op.execute(CATEGORIES.update().values(key=CATEGORIES.c.name))
    op.create_index("categories_key", "categories", ["key"], unique=True)
    _reserve(op.get_bind())


def _reserve(connection: Any) -> None:
    """Move official numbers from classes with other names to their own classes."""
    known = {row.number: row for row in connection.execute(sa.select(CATEGORIES))}
    for row in connection.execute(sa.select(NUMBERS)).all():
        entry = known[row.category]
        listed = official_numbers(row.dataset)
        words = [word for word, number in listed.items() if number == row.number]
        if not words or plain(entry.name) in words:
            continue
        is_row = sa.and_(NUMBERS.c.dataset == row.dataset, NUMBERS.c.number == row.number)
        # Numbers were assigned in sequence, to classes without a colour.
        if entry.number == row.number and not entry.color and _follows(entry.number, known):
            connection.execute(NUMBERS.delete().where(is_row))
            continue
        connection.execute(NUMBERS.update().where(is_row).values(stated=sa.true()))
        if entry.number == row.number:
            _bring_back(connection, words[0], row.number, known)


def _follows(number: int, known: dict[int, Any]) -> bool:
    return number == 1 or number - 1 in known


def _bring_back(connection: Any, word: str, number: int, known: dict[int, Any]) -> None:
    """Merge categories of labels with the first name of a renamed class into the class."""
    used = connection.execute(sa.select(LABELS.c.category).distinct()).scalars()
    for key in [each for each in used if plain(each) == word]:
        other = next((row.number for row in known.values() if row.key == key), None)
        if other is None:
            other = max(known) + 1
            values = {"number": other, "color": "", "key": key}
            connection.execute(CATEGORIES.insert().values(name=f"\n{other}", **values))
        hidden = {"name": f"\n{other}", "merged": number}
        connection.execute(CATEGORIES.update().where(CATEGORIES.c.number == other).values(**hidden))
        rows = sa.select(CATEGORIES).where(CATEGORIES.c.number == other)
        known[other] = connection.execute(rows).one()


def downgrade() -> None:
    op.drop_index("categories_key", "categories")
    hidden = CATEGORIES.c.merged.is_not(None)
    gone = sa.select(CATEGORIES.c.number).where(hidden)
    op.execute(NUMBERS.delete().where(NUMBERS.c.category.in_(gone)))
    op.execute(CATEGORIES.delete().where(hidden))
    with op.batch_alter_table("dataset_numbers") as numbers:
        numbers.drop_column("stated")
    with op.batch_alter_table("categories") as categories:
        for name in ("renamed", "merged", "key"):
            categories.drop_column(name)
