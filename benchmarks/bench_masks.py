"""Labels of points from masks of pictures, and masks from labels: accuracy and time.

    python benchmarks/bench_masks.py [--seeds 1,2] [--frames 30] [--verbose]

Generated: the true mask of a colour camera 5 cm beside the depth camera, with an exact calibration
and with errors of 1 pixel and 2 cm.  Printed a kind: the mean IoU of labels with 200 seen points or
more, over points that the camera sees, the share of these points in doubt, and the share of points
with another label among all labelled ones.  Then masks drawn of the labels and lifted again: the
shares of wrong labels, and of seen labelled points that stay unlabelled.

Recorded, if it is beside the checkout: lidar with outlines of vehicles drawn by hand.  Printed a
vehicle: seen points, the share that is labelled, and other points with its label; then the masks of
all instances again.
"""

from __future__ import annotations

import argparse
import time
from collections import defaultdict

import numpy as np
from mask_scenes import REAL, Scene, generated, recorded

from pointbrush.masks import IN_DOUBT, View, draw, lift

LEAST = 200
"""Seen points of a label that counts."""
ERRORS = {"exact": (0.0, 0.0), "1 px, 2 cm": (1.0, 0.02)}
"""Errors of calibrations: pixels, metres."""


def scores(scene: Scene, found: np.ndarray) -> tuple[float, float, float]:
    """Return the mean IoU over seen points, shares of points in doubt and of wrong labels."""
    ious = []
    for label in np.unique(scene.truth[scene.seen & (scene.truth > 0)]):
        true, ours = (each[scene.seen] == label for each in (scene.truth, found))
        if true.sum() >= LEAST:
            ious.append((true & ours).sum() / (true | ours).sum())
    labelled = found > 0
    wrong = (found != scene.truth)[labelled].mean() if labelled.any() else 0.0
    return float(np.mean(ious)), float((found == IN_DOUBT)[scene.seen].mean()), float(wrong)


def returned(scene: Scene, view: View) -> tuple[float, float]:
    """Return the shares of wrong and of missing labels after a mask of them was lifted again."""
    back = lift([(view, draw(view, scene.truth))], scene.xyz)
    given = (scene.truth > 0) & (scene.seen if not view.exact else True)
    return (
        float(((back > 0) & (back != scene.truth)).mean()),
        float((back[given] != scene.truth[given]).mean()),
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", default="1,2")
    parser.add_argument("--frames", type=int, default=30)
    parser.add_argument("--verbose", action="store_true")
    asked = parser.parse_args()
    rows, seconds = defaultdict(list), []
    for scene in generated(tuple(map(int, asked.seeds.split(","))), asked.frames):
        kind = scene.name.split()[0]
        for name, (pixels, metres) in ERRORS.items():
            view = View.of_camera(scene.camera.off(pixels, metres, len(rows)), scene.xyz)
            begin = time.process_time()
            found = lift([(view, scene.mask)], scene.xyz)
            seconds.append(time.process_time() - begin)
            row = scores(scene, found)
            rows[kind, name].append(row)
            if asked.verbose:
                print(scene.name, name, *(f"{each:.4f}" for each in row))
        for view in (scene.lattice, View.of_camera(scene.camera, scene.xyz)):
            rows[kind, f"again {view.name}"].append(returned(scene, view))
    for (kind, name), found in rows.items():
        print(f"{kind:10} {name:12}", *(f"{each:.4f}" for each in np.mean(found, axis=0)))
    print(f"{np.median(seconds):.2f} s of processor time a frame")
    if REAL.is_dir():
        for scene in recorded():
            print_recorded(scene)


def print_recorded(scene: Scene) -> None:
    """Print the scores of the outlined vehicles, and of masks of all instances again."""
    view = View.of_camera(scene.camera, scene.xyz)
    found = lift([(view, scene.mask)], scene.xyz)
    for label in np.unique(scene.mask[scene.mask > 0]):
        true = (scene.truth == label) & scene.seen
        wrong = ((found == label) & (scene.truth != label)).sum()
        print(f"{scene.name} {label}: {true.sum()} {(found == label)[true].mean():.3f} {wrong}")
    print(f"{scene.name} again {view.name}", *(f"{x:.4f}" for x in returned(scene, view)))


if __name__ == "__main__":
    main()
