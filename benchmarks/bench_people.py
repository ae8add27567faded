"""People found without a click: overlap with the truth of generated rooms, and processor time.

python benchmarks/bench_people.py [--seeds 100 101 …] [--sets juggling crowd walking empty]

``juggling``: the sample, two people; ``walking``: three people; ``crowd``: three to five people,
cut by the picture's border and overlapping, with a bag and a ball; ``empty``: the furnished rooms
of the sample without people.  ``iou``: mean over the people of whom a frame has at least ``LEAST``
points, 0 for a person who is not found.  ``wrong``: points of labels that lie on no person, largest
label.
``--recording FOLDER``: processor time for the first 90 frames of a recording in a workspace.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from pointbrush.frame import PointFrame
from pointbrush.masks.people.model import PersonModel
from pointbrush.masks.people.motion import find_motion
from pointbrush.masks.people.options import PeopleOptions
from pointbrush.masks.people.persons import find_persons
from pointbrush.masks.people.picture import DepthPicture, depth_picture, points_of
from pointbrush.samples import generate
from pointbrush.samples.recording import Recording
from pointbrush.sequences import open_sequence
from pointbrush.sequences.storage.recording_files import FolderFiles
from pointbrush.work.people.frames import Search

SEEDS = range(100, 110)
FRAMES = (5, 45, 85)
"""Each is compared with the others."""
LEAST = 1000
"""Points of the smallest person that counts, of some 200 000 of a frame."""
GOOD = 0.9
TIMED = 90
KINDS = ("juggling", "walking", "crowd", "empty")


class Score(NamedTuple):
    """Overlap of each person, points on no person of each label, and seconds."""

    iou: list[float]
    wrong: list[int]
    seconds: float


def search(
    frame: PointFrame, pose: NDArray[np.float64], model: PersonModel, others: Sequence[PointFrame]
) -> list[NDArray[np.int64]]:
    """Return the points of the people in a generated frame, compared with others."""
    options = PeopleOptions()
    picture, number = pictured(frame, pose, options)
    motion = find_motion(picture, [pictured(each, pose, options)[0] for each in others], options)
    people = find_persons(picture, model.probability, options, motion=motion)
    xyz = frame.xyz.astype(np.float32)
    return [points_of(person.mask, picture, number, xyz) for person in people]


def pictured(
    frame: PointFrame, pose: NDArray[np.float64], options: PeopleOptions
) -> tuple[DepthPicture, NDArray[np.int32]]:
    """Return a frame's picture, and the point of each pixel."""
    camera = frame.camera
    assert camera is not None
    assert frame.rgb is not None
    number = np.full((camera.height, camera.width), -1, np.int32)
    number.ravel()[frame.pixel] = np.arange(len(frame))
    xyz, pitch = frame.xyz.astype(np.float32), 1 / camera.fx
    return depth_picture(number, xyz, frame.rgb, np.zeros(3), pose, pitch, options.columns), number


def score(kind: str, seed: int, index: int, model: PersonModel) -> Score:
    """Search one frame of a generated recording."""
    made = recording_of(kind, seed)
    frame, truth = made.frame(index), made.truth[index]
    people = [each.id for each in made.labels if each.name.startswith("person")]
    others = [made.frame(each) for each in FRAMES if each != index]
    if kind == "empty":
        others = [without_people(made, each) for each in FRAMES if each != index]
        frame, truth, people = without_people(made, index), truth[truth == 0], []
    begun = time.process_time()
    found = search(frame, np.asarray(made.scene.camera_pose, np.float64), model, others)
    seconds = time.process_time() - begun
    truths = [truth == each for each in people if (truth == each).sum() >= LEAST]
    table = np.array([[overlap(each, numbers) for numbers in found] for each in truths])
    best = np.zeros(len(truths))
    if table.size:
        rows, columns = linear_sum_assignment(-table)
        best[rows] = table[rows, columns]
    on_person = np.isin(truth, people)
    wrong = [len(numbers) for numbers in found if on_person[numbers].mean() < 0.5]
    return Score(best.tolist(), wrong, seconds)


@cache
def recording_of(kind: str, seed: int) -> Recording:
    """Return the generated recording of a set."""
    options = {"people": 3 + seed % 3} if kind == "crowd" else {}
    return generate("juggling" if kind == "empty" else kind, seed, 90, **options)


def without_people(made: Recording, index: int) -> PointFrame:
    """Return a frame with the labelled points left out."""
    frame, keep = made.frame(index), made.truth[index] == 0
    columns = {name: getattr(frame, name)[keep] for name in ("xyz", "rgb", "pixel")}
    return PointFrame(**columns, camera=frame.camera, viewpoint=frame.viewpoint)


def overlap(truth: NDArray[np.bool_], numbers: NDArray[np.int64]) -> float:
    """Return the intersection of points over their union."""
    both = int(truth[numbers].sum())
    return both / (int(truth.sum()) + len(numbers) - both)


def time_recording(folder: Path, model: PersonModel) -> None:
    """Print the processor time for the first frames of a stored recording."""
    recording, options = open_sequence(FolderFiles(folder)), PeopleOptions()
    frames = range(min(TIMED, len(recording)))
    for _ in range(2):  # loops are compiled in the first round
        begun, searched = time.process_time(), Search(recording, model, options)
        found = [len(searched.people_in(frame)) for frame in frames]
        seconds = time.process_time() - begun
    print(f"{folder.name}: {len(frames)} frames in {seconds:.2f} s, {sum(found)} labels")


def main() -> None:
    """Print a line for each set."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seeds", type=int, nargs="+", default=list(SEEDS))
    parser.add_argument("--sets", nargs="+", default=KINDS, choices=KINDS)
    parser.add_argument("--recording", type=Path)
    given = parser.parse_args()
    model = PersonModel()
    if given.recording is not None:
        time_recording(given.recording, model)
        return
    print("set\tpeople\tiou\tlowest\tat least .90\tnot found\twrong\tms a frame")
    for kind in given.sets:
        scores = [score(kind, seed, index, model) for seed in given.seeds for index in FRAMES]
        iou = np.array([each for one in scores for each in one.iou])
        wrong = max((each for one in scores for each in one.wrong), default=0)
        ms = 1e3 * np.mean([one.seconds for one in scores])
        shown = "\t\t\t"
        if len(iou):
            good, lost = (iou >= GOOD).mean(), (iou == 0).mean()
            shown = f"{iou.mean():.3f}\t{iou.min():.2f}\t{good:.2f}\t{lost:.2f}"
        print(f"{kind}\t{len(iou)}\t{shown}\t{wrong}\t{ms:.0f}", flush=True)


if __name__ == "__main__":
    main()
