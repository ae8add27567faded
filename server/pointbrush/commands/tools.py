"""The commands that need no workspace."""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

from pointbrush.commands.answers import Answer
from pointbrush.commands.arguments import argument, verb
from pointbrush.errors import BadInputError, PointbrushError

BENCHMARKS = Path(__file__).parents[3] / "benchmarks"


@verb(argument("file", "file downloaded from that page", type=Path, metavar="FILE"))
def headset_report(given: argparse.Namespace, _place: object) -> Answer:
    """Print a headset's report of the page /check-headset."""
    from pointbrush.headset_report.model import read_report
    from pointbrush.headset_report.words import report_lines

    found = read_report(given.file)
    return Answer(found, report_lines(found))


@verb(argument("name", "one benchmark (default: all)", nargs="?"))
def bench(given: argparse.Namespace, _place: object) -> None:
    """Run the benchmarks of a checkout."""
    scripts = {path.stem.removeprefix("bench_"): path for path in BENCHMARKS.glob("bench_*.py")}
    if not scripts:
        raise BadInputError("bench: expected to run from a checkout of pointbrush")
    if given.name is not None and given.name not in scripts:
        raise BadInputError(f"bench: expected one of {', '.join(sorted(scripts))}")
    for name in [given.name] if given.name else sorted(scripts):
        print(f"== {name}", flush=True)
        if subprocess.run([sys.executable, scripts[name]], check=False).returncode:
            raise PointbrushError(f"benchmark {name} failed")
