"""Kill the whole server again and again while people edit; look whether anything is lost.

python benchmarks/soak_torture.py [--kills 200] [--seed 1] [--minutes 60]

Real `pointbrush serve` processes; four people over REST and the socket paint, erase, delete,
restore, undo, redo, change labels and track.  After every restart the journal is compared with
what was asked and answered, and every layer of every frame with a replay of it
(tests/faults/replay.py).  Ends with an error at the first broken promise.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

from tests.faults.torture import torture


def main() -> None:
    """Print one line."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=60, help="no kill after this time")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        workspace = Path(folder) / "workspace"
        print(
            torture(workspace, given.kills, given.seed, most_seconds=60 * given.minutes), flush=True
        )


if __name__ == "__main__":
    main()
