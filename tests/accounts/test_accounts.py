from __future__ import annotations

import time

import pytest
from sqlalchemy import text

from pointbrush.errors import BadInputError, NotFoundError
from pointbrush.teamwork.store import WorkspaceStore


def test_a_secret_lets_in_and_is_not_stored(store: WorkspaceStore) -> None:
    secret = store.tokens.add("annotator", "Ada")
    token = store.tokens.check(secret)
    assert token is not None
    assert (token.role, token.name, token.revoked) == ("annotator", "Ada", None)
    with store.database.read() as connection:
        row = connection.execute(text("SELECT * FROM tokens")).one()
    assert secret not in map(str, row)
    assert len(secret) >= 43  # 256 bits


@pytest.mark.parametrize("wrong", ["", "x", "\udcff", "a" * 10_000])
def test_other_secrets_do_not(store: WorkspaceStore, wrong: str) -> None:
    store.tokens.add("viewer")
    assert store.tokens.check(wrong) is None


def test_expired_and_revoked_ones_do_not(store: WorkspaceStore) -> None:
    late = store.tokens.add("viewer", expires=time.time() - 1)
    soon = store.tokens.add("viewer", expires=time.time() + 60)
    assert store.tokens.check(late) is None
    assert store.tokens.check(soon) is not None
    revoked = store.tokens.revoke(store.tokens.list()[-1].id)
    assert revoked.revoked is not None
    assert store.tokens.check(soon) is None
    assert store.tokens.revoke(revoked.id) == revoked
    assert [token.valid for token in store.tokens.list()] == [False, False]


def test_unknown_roles_and_tokens_are_refused(store: WorkspaceStore) -> None:
    with pytest.raises(BadInputError, match="annotator"):
        store.tokens.add("king")
    with pytest.raises(NotFoundError):
        store.tokens.revoke("nothing")
