"""Authors are accounts: tokens belong to one, sessions have one, and sign-ins are kept."""

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = "0004"
branch_labels = None
depends_on = None


def upgrade() -> None:
    op.create_table(
        "accounts",
        sa.Column("id", sa.String(256), primary_key=True),
        sa.Column("name", sa.Text, nullable=False),
    )
    op.create_table(
        "sign_ins",
        sa.Column("digest", sa.String(64), primary_key=True),
        sa.Column("token", sa.String(16)),
        sa.Column("owner", sa.String(64), nullable=False),
        sa.Column("account", sa.String(256), nullable=False),
        sa.Column("created", sa.Double, nullable=False),
        sa.Column("expires", sa.Double, nullable=False),
    )
    op.add_column("tokens", sa.Column("account", sa.String(256), nullable=False, server_default=""))
    # Edits have the name of their author, which becomes the account.  A token with the name of a
    # built-in account gets a separate account instead.
    own = (
        "lower(trim(name)) IN ('owner', 'command line', 'import') "
        "OR name LIKE 'owner:%' OR name LIKE 'session:%'"
    )
    op.execute(f"UPDATE tokens SET account = 'token ' || id WHERE name = '' OR {own}")  # noqa: S608
    op.execute("UPDATE tokens SET account = name WHERE account = ''")
    # The name of an account with a colon is read from here.
    op.execute(
        "INSERT INTO accounts (id, name) SELECT author, author FROM edits "
        "WHERE author LIKE '%:%' UNION SELECT account, account FROM tokens WHERE account LIKE '%:%'"
    )


def downgrade() -> None:
    op.drop_column("tokens", "account")
    op.drop_table("sign_ins")
    op.drop_table("accounts")
