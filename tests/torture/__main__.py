"""Try faults on the server and print a table of what they came to.

python -m tests.torture [--seconds 480] [--rounds 10] [--seed 1] [--only NAME,NAME] [--list]

Ends with 1 when an answered edit is lost, something differs from what was answered, or a call is
answered with a 5xx that the contract does not know.
"""

from __future__ import annotations

import argparse
import sys

from tests.torture import scenarios
from tests.torture.framework import HEAD, SCENARIOS, Row, run, shares

SECONDS = 480.0
"""Time of all scenarios together, without what they take to start and to compare."""
ROUNDS = 10
"""Rounds of a scenario, however long they take."""


def main() -> int:
    """Run the scenarios that are asked for."""
    parser = argparse.ArgumentParser(prog="python -m tests.torture", description=__doc__)
    parser.add_argument("--seconds", type=float, default=SECONDS)
    parser.add_argument("--rounds", type=int, default=ROUNDS, help="fewest of a scenario")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="names, with commas between them")
    parser.add_argument("--list", action="store_true", help="print the names")
    given = parser.parse_args()
    scenarios.load()
    unknown = [name for name in given.only.split(",") if name and name not in SCENARIOS]
    if unknown:
        parser.error(f"--only: expected names of --list, got {', '.join(unknown)}")
    chosen = [SCENARIOS[name] for name in given.only.split(",") if name] or SCENARIOS.values()
    if given.list:
        print("\n".join(f"{each.name}: {each.what}" for each in chosen))
        return 0
    time_of = shares(chosen, given.seconds)
    print(f"seed {given.seed}\n\n{HEAD}", flush=True)
    rows: list[Row] = []
    for each in chosen:
        rows.append(run(each, time_of[each.name], given.seed, given.rounds))
        print(rows[-1], flush=True)
        for note in rows[-1].tally.notes:
            print(f"{each.name}: {note}", file=sys.stderr, flush=True)
    return 0 if all(row.skipped or row.tally.sound for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
