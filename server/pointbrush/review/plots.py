"""Confidence and inliers of labels over the frames, as viser's plots take them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray
from viser import uplot

from pointbrush.labels import Label

Curves = tuple[NDArray[np.float64], ...]
WIDTH = 2.0
ASPECT = 2.2


def curves(
    tracks: Sequence[Mapping[str, Any]], palette: Sequence[Label], frames: int, key: str
) -> Curves:
    """Frame numbers (F,), and a value (F,) a frame for each label; NaN where there is none."""
    values = {label.id: np.full(frames, np.nan) for label in palette}
    for track in tracks:
        if track["label"] in values and 0 <= track["frame"] < frames:
            values[track["label"]][track["frame"]] = track[key]
    return (np.arange(frames, dtype=np.float64), *values.values())


def add_plot(gui: viser.GuiApi, title: str, data: Curves, palette: Sequence[Label]) -> Any:
    """Add a plot of values 0 to 1 with a line for each label."""
    lines = [
        uplot.Series(label=label.name, stroke=label.color, width=WIDTH, spanGaps=False)
        for label in palette
    ]
    return gui.add_uplot(
        data,
        (uplot.Series(label="frame"), *lines),
        title=title,
        scales={"x": uplot.Scale(time=False, auto=True), "y": uplot.Scale(range=(0.0, 1.05))},
        aspect=ASPECT,
        legend=uplot.Legend(show=True),
    )
