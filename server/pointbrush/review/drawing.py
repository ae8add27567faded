"""Drawing in a viser page: labelled points, the steps of tracking a label, and plots."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray
from viser import uplot

from pointbrush.labels import Label
from pointbrush.tracking.compute.rigid import IcpStep
from pointbrush.tracking.explanation import Explanation

PLAIN = 160
"""Grey of points without a colour."""
F64 = NDArray[np.float64]
Colors = NDArray[np.uint8]
ROOT = "/steps"
PREDICTED, TRIED, TAKEN = (90, 170, 255), (255, 180, 60), (80, 220, 120)
STATIC, MOVING, LINK = (95, 95, 105), (255, 120, 200), (255, 210, 90)
NEAR, FAR = np.array([40, 200, 120.0]), np.array([255, 60, 60.0])
FAR_RESIDUAL = 0.05
"""Residual with the colour FAR, metres."""
PAIRS = 400
"""Limit of drawn pairs of an iteration."""
STEPS = ("Predicted poses", "Hypotheses", "Registered surface", "Background", "Claims")
Curves = tuple[NDArray[np.float64], ...]
WIDTH = 2.0
ASPECT = 2.2


def lookup(palette: Iterable[Label]) -> NDArray[np.uint8]:
    """Return label colours (65536, 3) by label id."""
    table = np.full((65_536, 3), PLAIN, np.uint8)
    for label in palette:
        table[label.id] = tuple(bytes.fromhex(label.color[1:]))
    return table


def blend(
    rgb: NDArray[np.uint8] | None,
    label: NDArray[np.uint16],
    colors: NDArray[np.uint8],
    share: float,
) -> NDArray[np.uint8]:
    """Return colours (N, 3) with a ``share`` 0..1 of the label's colour on labelled points (N,)."""
    base = np.full((len(label), 3), PLAIN, np.uint8) if rgb is None else rgb.copy()
    labeled = label > 0
    mixed = (1 - share) * base[labeled] + share * colors[label[labeled]]
    base[labeled] = np.round(mixed).astype(np.uint8)
    return base


@dataclass(frozen=True)
class Drawing:
    """A ``scene`` in room coordinates; ``room`` is ``T_room_local`` (4, 4)."""

    scene: viser.SceneApi
    room: F64
    point_size: float

    def clear(self) -> None:
        """Remove all objects."""
        self.scene.remove_by_name(ROOT)

    def explanation(
        self, found: Explanation, xyz: NDArray[np.float32], palette: Colors, shown: Sequence[str]
    ) -> None:
        """Draw the ``shown`` of STEPS; ``xyz`` (N, 3) are the frame's points, local."""
        self.clear()
        if "Predicted poses" in shown:
            self._spots("predicted", found.predicted, PREDICTED)
        if "Hypotheses" in shown and len(found.costs):
            self._hypotheses(found)
        if "Registered surface" in shown and len(found.residual):
            share = np.clip(found.residual / FAR_RESIDUAL, 0, 1)[:, None]
            self._points("surface", found.surface, (NEAR + share * (FAR - NEAR)).astype(np.uint8))
        around = xyz[found.around]
        if "Background" in shown and len(around):
            colors = np.where(found.static[:, None], STATIC, MOVING).astype(np.uint8)
            self._points("background", around, colors)
        if "Claims" in shown and len(around):
            self._points("claims", around, palette[found.owner])

    def iteration(self, step: IcpStep) -> None:
        """Draw the pairs of an iteration of ICP, coloured by their residual."""
        self.clear()
        some = slice(None, None, max(1, len(step.moved) // PAIRS))
        share = np.clip(step.distance / FAR_RESIDUAL, 0, 1)[:, None]
        colors = (NEAR + share * (FAR - NEAR)).astype(np.uint8)
        self._points("moved", step.moved, colors)
        pairs = np.stack([step.moved[some], step.matched[some]], axis=1)
        self._lines("pairs", pairs, LINK)

    def trails(self, paths: Sequence[tuple[F64, Colors]]) -> None:
        """Draw paths (F, 3) of labels, each in a colour (3,)."""
        self.scene.remove_by_name("/trails")
        for number, (path, color) in enumerate(paths):
            if len(path) > 1:
                segments = np.stack([path[:-1], path[1:]], axis=1)
                self.scene.add_line_segments(
                    f"/trails/{number}",
                    self._room(segments.reshape(-1, 3)).reshape(-1, 2, 3),
                    np.broadcast_to(color, segments.shape).astype(np.uint8),
                    thickness=2.0,
                    thickness_units="screen",
                )

    def _hypotheses(self, found: Explanation) -> None:
        best = int(found.costs.argmin())
        self._spots("hypotheses", found.hypotheses, TRIED)
        self._spots("taken", found.hypotheses[best : best + 1], TAKEN)
        for number in np.argsort(found.costs)[:8].tolist():
            at = self._room(found.hypotheses[number][None])[0]
            self.scene.add_label(
                f"{ROOT}/costs/{number}", f"{found.costs[number]:.2f}", position=at
            )

    def _room(self, xyz: NDArray[np.floating]) -> NDArray[np.float32]:
        return (xyz @ self.room[:3, :3].T + self.room[:3, 3]).astype(np.float32)

    def _points(self, name: str, xyz: NDArray[np.floating], colors: Colors) -> None:
        self.scene.add_point_cloud(
            f"{ROOT}/{name}", points=self._room(xyz), colors=colors, point_size=self.point_size * 2
        )

    def _spots(self, name: str, xyz: F64, color: tuple[int, int, int]) -> None:
        if len(xyz):
            colors = np.broadcast_to(np.array(color, np.uint8), xyz.shape)
            self.scene.add_point_cloud(
                f"{ROOT}/{name}",
                points=self._room(xyz),
                colors=np.ascontiguousarray(colors),
                point_size=self.point_size * 5,
                point_shape="circle",
            )

    def _lines(self, name: str, pairs: F64, color: tuple[int, int, int]) -> None:
        self.scene.add_line_segments(
            f"{ROOT}/{name}",
            self._room(pairs.reshape(-1, 3)).reshape(-1, 2, 3),
            np.broadcast_to(np.array(color, np.uint8), pairs.shape),
            thickness=1.0,
            thickness_units="screen",
        )


def verdict_text(found: Explanation) -> str:
    """Return a description of a frame's result and its evidence, as Markdown."""
    track = found.track
    lines = [
        f"**{track.state}**, confidence {track.confidence:.2f}, {track.points:,} points, "
        f"rmse {1000 * track.rmse:.1f} mm, inliers {track.inliers:.2f}"
    ]
    if len(found.costs):
        lines.append(
            f"{len(found.predicted)} predicted poses, {len(found.costs)} hypotheses registered: "
            f"costs {found.costs.min():.3f} to {found.costs.max():.3f}"
        )
    if found.features:
        lines += ["| feature | value |", "|---|---|"]
        lines += [f"| {name} | {value:.3f} |" for name, value in found.features.items()]
    elif track.state not in ("painted", "tracked"):
        lines.append("No hypothesis was registered: nothing that moved was near the predictions.")
    return "\n\n".join(lines[:2]) + "\n\n" + "\n".join(lines[2:])


def curves(
    tracks: Sequence[Mapping[str, Any]], palette: Sequence[Label], frames: int, key: str
) -> Curves:
    """Return frame numbers (F,), and values per frame (F,) for each label; NaN: no value."""
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
