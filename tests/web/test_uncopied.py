from __future__ import annotations

import pytest
from websockets.frames import Frame, Opcode

from pointbrush.web.uncopied import header


@pytest.mark.parametrize("length", [0, 1, 125, 126, 65_535, 65_536, 2**20])
def test_what_goes_ahead_is_what_the_library_would_write(length: int) -> None:
    data = bytes(length)
    assert header(length) + data == Frame(Opcode.BINARY, data).serialize(mask=False)
