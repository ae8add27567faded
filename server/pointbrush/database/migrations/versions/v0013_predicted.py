"""Points may be predicted, with a confidence, in bits of the journal's words that were 0 before.

The tables stay; an older pointbrush, which would misread these words, refuses the database.
"""

revision = "0013"
down_revision = "0012"


def upgrade() -> None:
    pass


def downgrade() -> None:
    pass
