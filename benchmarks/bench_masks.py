"""Labels of points from masks of pictures, and masks from labels: accuracy and time.

    python benchmarks/bench_masks.py [--seeds 1,2] [--frames 30] [--verbose]

Generated recordings: the true mask of a colour camera 5 cm beside the depth camera labels the
points, with an exact calibration and with errors of 1 pixel and 2 cm.  Columns for each kind: the
mean IoU of labels with 200 seen points or more, over the points that the camera sees; the share of
these points in doubt; the share of wrong labels among the labelled points.  Rows "again": masks are
drawn from the labels and lifted; the shares of wrong labels, and of seen labels that are missing.

Recorded lidar, if it is beside the checkout, with outlines of vehicles drawn by hand.  Columns for
each vehicle: seen points, the share of them that is labelled, and other points with its label.
"""

from __future__ import annotations

import argparse
import time
from collections import defaultdict

import numpy as np
from mask_scenes import REAL, Scene, generated, recorded, with_errors

from pointbrush.masks import IN_DOUBT, View, draw, lift

LEAST_POINTS = 200
"""Least number of seen points of a label that is measured."""
ERRORS = {"exact": (0.0, 0.0), "1 px, 2 cm": (1.0, 0.02)}
"""Errors of the calibration in pixels and metres, by name."""


def scores(scene: Scene, found: np.ndarray) -> tuple[float, float, float]:
    """Return the mean IoU over seen points, and the shares in doubt and of wrong labels."""
    ious = []
    for label in np.unique(scene.truth[scene.seen & (scene.truth > 0)]):
        true, ours = (each[scene.seen] == label for each in (scene.truth, found))
        if true.sum() >= LEAST_POINTS:
            ious.append((true & ours).sum() / (true | ours).sum())
    labelled = found > 0
    wrong = (found != scene.truth)[labelled].mean() if labelled.any() else 0.0
    return float(np.mean(ious)), float((found == IN_DOUBT)[scene.seen].mean()), float(wrong)


def round_trip(scene: Scene, view: View) -> tuple[float, float]:
    """Return the shares of wrong and of missing labels after they are drawn and lifted."""
    back = lift([(view, draw(view, scene.truth))], scene.xyz)
    drawn = (scene.truth > 0) & (scene.seen if not view.exact else True)
    return (
        float(((back > 0) & (back != scene.truth)).mean()),
        float((back[drawn] != scene.truth[drawn]).mean()),
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", default="1,2")
    parser.add_argument("--frames", type=int, default=30)
    parser.add_argument("--verbose", action="store_true")
    arguments = parser.parse_args()
    rows, seconds = defaultdict(list), []
    for scene in generated(tuple(map(int, arguments.seeds.split(","))), arguments.frames):
        kind = scene.name.split()[0]
        for name, (pixels, metres) in ERRORS.items():
            view = View.of_camera(with_errors(scene.camera, pixels, metres, len(rows)), scene.xyz)
            begin = time.process_time()
            found = lift([(view, scene.mask)], scene.xyz)
            seconds.append(time.process_time() - begin)
            row = scores(scene, found)
            rows[kind, name].append(row)
            if arguments.verbose:
                print(scene.name, name, *(f"{each:.4f}" for each in row))
        for view in (scene.lattice, View.of_camera(scene.camera, scene.xyz)):
            rows[kind, f"again {view.name}"].append(round_trip(scene, view))
    for (kind, name), found in rows.items():
        print(f"{kind:10} {name:12}", *(f"{each:.4f}" for each in np.mean(found, axis=0)))
    print(f"{np.median(seconds):.2f} s of processor time a frame")
    if REAL.is_dir():
        for scene in recorded():
            print_recorded(scene)


def print_recorded(scene: Scene) -> None:
    """Print the scores of the outlined vehicles, and of the round trip of all instances."""
    view = View.of_camera(scene.camera, scene.xyz)
    found = lift([(view, scene.mask)], scene.xyz)
    for label in np.unique(scene.mask[scene.mask > 0]):
        true = (scene.truth == label) & scene.seen
        wrong = ((found == label) & (scene.truth != label)).sum()
        print(f"{scene.name} {label}: {true.sum()} {(found == label)[true].mean():.3f} {wrong}")
    print(f"{scene.name} again {view.name}", *(f"{x:.4f}" for x in round_trip(scene, view)))


if __name__ == "__main__":
    main()
