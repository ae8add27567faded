"""Uploaded classifier files with changed numbers."""

from __future__ import annotations

import json
import os
import subprocess
import sys

from tests.torture.framework import Arena, scenario

FILES = 500
"""Files of a round."""
SECONDS_A_FILE = 1.0
"""After which a round counts as hanging; a file takes some milliseconds."""


@scenario("classifier files with changed numbers are read and used for predictions")
def mutated_classifiers(arena: Arena) -> None:
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    for number in arena.rounds():
        first = arena.seed * 1_000_000 + number * FILES
        command = [sys.executable, "-m", "tests.classify.mutated_files", str(first), str(FILES)]
        with arena.tally.expect("errors"):
            done = subprocess.run(
                command, env=environment, capture_output=True, text=True,
                timeout=FILES * SECONDS_A_FILE, check=False,
            )  # fmt: skip
            assert done.returncode == 0, f"seed {first}: {done.returncode} {done.stderr}"
            counts = json.loads(done.stdout)
            assert counts["reached"] + counts["refused"] == FILES, f"seed {first}: {counts}"
            assert counts["reached"] >= FILES / 3, f"seed {first}: {counts}"
            arena.tally.answered += counts["reached"]
