"""Compare two annotations of the same points: two recordings imported from one source.

    python docs/examples/agreement.py http://127.0.0.1:8080 TOKEN by-ada by-grace report/

Labels match by name. The script writes a table of labels, a picture of the frame with the most
differences, and a progress report of each recording into the folder.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

from pointbrush.client import Client


def main(url: str, token: str, first: str, second: str, out: str) -> None:
    """Write the report."""
    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    with Client(url, token) as client:
        review = client[first].review
        found = review.agreement(second)
        if found.miou is None or found.same is None:
            raise SystemExit("neither recording has labels")
        print(f"{found.same:.1%} of the labelled points are the same, mean IoU {found.miou:.3f}")
        with (folder / "labels.csv").open("w", newline="", encoding="utf-8") as file:
            table = csv.writer(file)
            table.writerow(["label", "iou", first, second, "both"])
            for label in sorted(found.labels, key=lambda label: label.iou):
                print(f"{label.iou:.3f}  {label.name}")
                table.writerow([label.name, label.iou, label.first, label.second, label.both])
        worst = max(found.frames, key=lambda frame: frame.differ)
        (folder / "worst.png").write_bytes(review.difference(second, worst.frame))
        for name in (first, second):
            client[name].review.report(folder / f"{name}.html")
        print(f"frame {worst.frame} differs most, in {worst.differ:,} points: {folder}/worst.png")


if __name__ == "__main__":
    main(*sys.argv[1:6])
