"""Store whether the heading of a box is known.

Earlier versions guessed the headings of fitted boxes, so these are unknown.
"""

import json
from typing import Any

import sqlalchemy as sa
from alembic import op

revision = "0023"
down_revision = "0022"

HEADING = "heading_known"
BOXES = sa.table("boxes", *map(sa.column, ("sequence", "id", "data")))
CHANGES = sa.table("edit_boxes", *map(sa.column, ("sequence", "revision", "box", "data")))


def upgrade() -> None:
    connection = op.get_bind()
    known: dict[tuple[int, int], bool] = {}
    for row in connection.execute(sa.select(BOXES)).all():
        fields = json.loads(row.data)
        known[row.sequence, row.id] = fields[HEADING] = fields["provenance"] != "fitted"
        is_row = sa.and_(BOXES.c.sequence == row.sequence, BOXES.c.id == row.id)
        _store(BOXES, is_row, fields)
    for row in connection.execute(sa.select(CHANGES)).all():
        change = json.loads(row.data)
        if change.get("exists"):  # it creates the box; a removed box has only such edits
            made = change["provenance"] != "fitted"
            change[HEADING] = known.get((row.sequence, row.box), made)
            _store(CHANGES, _of_change(row), change)


def downgrade() -> None:
    connection = op.get_bind()
    for row in connection.execute(sa.select(BOXES)).all():
        fields = json.loads(row.data)
        del fields[HEADING]
        is_row = sa.and_(BOXES.c.sequence == row.sequence, BOXES.c.id == row.id)
        _store(BOXES, is_row, fields)
    for row in connection.execute(sa.select(CHANGES)).all():
        change = json.loads(row.data)
        if change.pop(HEADING, None) is not None:
            _store(CHANGES, _of_change(row), change)


def _of_change(row: Any) -> Any:
    is_row = CHANGES.c.sequence == row.sequence, CHANGES.c.revision == row.revision
    return sa.and_(*is_row, CHANGES.c.box == row.box)


def _store(table: Any, is_row: Any, data: dict[str, Any]) -> None:
    op.execute(table.update().where(is_row).values(data=json.dumps(data)))
