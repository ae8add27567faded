"""The documented examples of services, running."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

EXAMPLES = Path(__file__).parents[1] / "docs" / "examples"


@contextmanager
def example_service(script: str) -> Iterator[str]:
    """Run an example that listens on a free port; yields its address."""
    with subprocess.Popen(
        [sys.executable, EXAMPLES / script, "--port", "0"], stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None
        found = re.search(r"http://\S+", process.stdout.readline())
        assert found is not None
        try:
            yield found[0]
        finally:
            process.terminate()
