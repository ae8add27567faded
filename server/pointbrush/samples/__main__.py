"""Write a sample recording: ``python -m pointbrush.samples --kind juggling --out FOLDER``."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from pointbrush.errors import PointbrushError
from pointbrush.samples import KINDS, generate
from pointbrush.samples.generating import write
from pointbrush.samples.sensor import FPS


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit status."""
    parser = argparse.ArgumentParser(prog="python -m pointbrush.samples", description=__doc__)
    parser.add_argument("--kind", choices=sorted(KINDS), default="juggling")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--frames", type=int, default=90)
    parser.add_argument("--noise", type=float, default=1.0, help="multiplies the sensor's errors")
    parser.add_argument("--rate", type=float, default=FPS, help="frames a second")
    parser.add_argument("--step", type=int, default=1, help="keep every so many rows and columns")
    parser.add_argument("--out", type=Path, required=True, help="folder for the .npz files")
    parser.add_argument(
        "--option",
        action="append",
        type=_option,
        default=[],
        metavar="NAME=VALUE",
        help="an option of the kind, such as pins=3 or passing=false",
    )
    chosen = parser.parse_args(arguments)
    try:
        recording = generate(
            chosen.kind,
            chosen.seed,
            chosen.frames,
            noise=chosen.noise,
            rate=chosen.rate,
            **dict(chosen.option),
        )
        write(recording, chosen.out, step=chosen.step, progress=_show)
    except PointbrushError as error:
        print(f"pointbrush.samples: {error}", file=sys.stderr)
        return 1
    print(f"{chosen.out}: {chosen.frames} frames of {recording.name}")
    return 0


def _option(text: str) -> tuple[str, Any]:
    name, found, value = text.partition("=")
    if not found:
        raise argparse.ArgumentTypeError(f"expected NAME=VALUE, got {text!r}")
    try:
        return name, json.loads(value)
    except json.JSONDecodeError:
        return name, value


def _show(done: int, total: int) -> None:
    if sys.stderr.isatty():
        print(f"\rframe {done} of {total}", end="\n" if done == total else "", file=sys.stderr)


if __name__ == "__main__":
    sys.exit(main())
