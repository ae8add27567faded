"""Read an export as a dataset for torch's DataLoader; the script itself does not need torch.

    python docs/examples/dataset.py http://127.0.0.1:8080 TOKEN juggling juggling.zip

In a training script:

    from torch.utils.data import DataLoader
    loader = DataLoader(LabelledFrames("juggling.zip", points=8192), batch_size=4, num_workers=2)
    for batch in loader:
        batch["xyz"], batch["rgb"], batch["label"]     # (4, 8192, 3), (4, 8192, 3), (4, 8192)
"""

from __future__ import annotations

import io
import json
import sys
import zipfile
from pathlib import Path

import numpy as np

from pointbrush.client import Client


class LabelledFrames:
    """An npz export: item i is a dict of arrays of frame i.

    ``points``: number of points that are drawn from each frame, so that frames stack to batches;
    None keeps all points.  ``classes``: numbers of the categories by name, equal in all exports of
    a workspace; ``label`` contains these numbers, 0 is unlabeled.
    """

    def __init__(self, export: str | Path, points: int | None = None) -> None:
        self.export, self.points = Path(export), points
        with zipfile.ZipFile(self.export) as archive:
            self.names = sorted(name for name in archive.namelist() if name.endswith(".npz"))
            labels = json.loads(archive.read("palette.json"))["labels"]
            self.classes: dict[str, int] = json.loads(archive.read("classes.json"))
        self.class_of = np.zeros(1 << 16, np.int64)
        for label in labels:
            self.class_of[label["id"]] = self.classes[label["category"] or label["name"]]

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, index: int) -> dict[str, np.ndarray]:
        # Open the archive for each item, since the workers of a DataLoader are separate processes.
        with (
            zipfile.ZipFile(self.export) as archive,
            np.load(io.BytesIO(archive.read(self.names[index]))) as arrays,
        ):
            xyz = arrays["xyz"].astype(np.float32)
            rgb = arrays["rgb"].astype(np.float32) / 255 if "rgb" in arrays else np.zeros_like(xyz)
            label = self.class_of[arrays["label"]]
        if self.points is not None:
            rng = np.random.default_rng(index)
            chosen = rng.choice(len(xyz), self.points, replace=len(xyz) < self.points)
            xyz, rgb, label = xyz[chosen], rgb[chosen], label[chosen]
        return {"xyz": xyz, "rgb": rgb, "label": label}

    def counts(self) -> dict[str, int]:
        """Count the points of each class, for weights of a loss."""
        found = np.zeros(max(self.classes.values(), default=0) + 1, np.int64)
        for frame in self:
            found += np.bincount(frame["label"], minlength=len(found))
        return {name: int(found[number]) for name, number in self.classes.items()}


def main(url: str, token: str, sequence: str, out: str) -> None:
    """Export a recording and print its number of points per class."""
    with Client(url, token) as client:
        client[sequence].export("npz", Path(out))
    frames = LabelledFrames(out)
    counts = {name: count for name, count in frames.counts().items() if count}
    print(f"{len(frames)} frames, {sum(counts.values()):,} labelled points")
    for name, count in counts.items():
        print(f"{count:>12,} {name}, class {frames.classes[name]}")


if __name__ == "__main__":
    main(*sys.argv[1:5])
