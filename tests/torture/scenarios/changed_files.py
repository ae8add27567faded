"""Uploaded files with changed numbers, bytes and lengths."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections import Counter

from tests.torture.framework import Arena, scenario

CLASSIFIERS = 500
"""Classifier files of a round."""
FILES = 10
"""Files of a round for each family of readers."""
LONGEST = 1000.0
"""Seconds after which a round counts as hanging; a file takes some milliseconds."""


def _run(module: str, *arguments: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", module, *map(str, arguments)]
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    return subprocess.run(
        command, env=environment, capture_output=True, text=True, timeout=LONGEST, check=False
    )


@scenario("classifier files with changed numbers are read and used for predictions")
def mutated_classifiers(arena: Arena) -> None:
    """A third of them at least is right, and is used."""
    for number in arena.rounds():
        first = arena.seed * 1_000_000 + number * CLASSIFIERS
        with arena.tally.expect("errors"):
            done = _run("tests.classify.mutated_files", first, CLASSIFIERS)
            assert done.returncode == 0, f"seed {first}: {done.returncode} {done.stderr}"
            counts = json.loads(done.stdout)
            assert counts["reached"] + counts["refused"] == CLASSIFIERS, f"seed {first}: {counts}"
            assert counts["reached"] >= CLASSIFIERS / 3, f"seed {first}: {counts}"
            arena.tally.answered += counts["reached"]


@scenario("changed files of each family of readers are imported, each in a process that may die")
def mutated_imports(arena: Arena) -> None:
    """Each is read, or refused in words: no signal, 10 s of a processor and 1 GiB at most."""
    results = arena.folder / "results.jsonl"
    for number in arena.rounds():
        first = arena.seed * 1_000_000 + number * FILES + 1
        given = ("--seed", first, "--files", FILES, "--results", results)
        with arena.tally.expect("errors"):
            done = _run("tests.formats.mutated_files", *given)
            assert done.returncode == 0, done.stdout + done.stderr
    counts = Counter(json.loads(line)["what"] for line in results.read_text().splitlines())
    arena.tally.answered += counts["read"]
