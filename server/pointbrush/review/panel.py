"""A viser page on one sequence: frames, labels, doubtful tracks, plots, and explanations."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from pointbrush.errors import PointbrushError
from pointbrush.labels import Commit
from pointbrush.review.drawing import STEPS, Drawing, add_plot, blend, curves, lookup, verdict_text
from pointbrush.review.explaining import Explaining, ExplainRequest, first_frame
from pointbrush.settings import Settings
from pointbrush.work.annotate.accepting import Verdict
from pointbrush.work.doubts import is_doubtful
from pointbrush.work.events import Event
from pointbrush.workspace import Workspace

POINT_SIZE = 0.006
AUTHOR = "review"
SHOWN_FIRST = STEPS[:3]
NEARBY = 1.2
"""Initial distance of the camera from an explained label, metres."""
OVERVIEW = 2.0
"""Initial distance of the camera from a frame, in median distances of points from the centre."""
FROM = np.array([0.0, 0.35, 0.94])
"""Direction from the target to the camera, unit length, y up."""


def doubtful_frames(tracks: Sequence[Mapping[str, Any]]) -> list[int]:
    """Return frames, ascending, with a label lost, occluded or tracked with low confidence."""
    return sorted({int(track["frame"]) for track in tracks if is_doubtful(track)})


class ReviewPanel:
    """The panel's server; ``close`` stops it."""

    def __init__(
        self,
        workspace: Workspace,
        sequence: str,
        host: str = "127.0.0.1",
        port: int = 8081,
        *,
        explain: int | None = None,
        method: str = "auto",
    ) -> None:
        """Serve on ``host``:``port``; ``explain``: a label to track by ``method`` and explain.

        Raises NotFoundError for an unknown sequence or label, BadInputError for a label that has
        no points.
        """
        self._workspace, self._sequence = workspace, sequence
        self._recording = workspace.recording(sequence)
        self._explaining = self._explain(explain, method)
        self._owned: list[Workspace] = []
        self._server = viser.ViserServer(host=host, port=port, label="pointbrush review")
        self._server.scene.set_up_direction("+y")
        self._room = self._recording.manifest.T_room_local
        self._drawing = Drawing(self._server.scene, self._room, POINT_SIZE)
        self._server.gui.configure_theme(dark_mode=True, show_share_button=False)
        self._add_frames()
        self._add_steps()
        self._add_labels()
        self._add_judging()
        self._add_plots()
        self._server.on_client_connect(self._aim)
        self._unsubscribe = workspace.subscribe(self._on_event)
        self.show()

    # ── controls ────────────────────────────────────────────────────────────────────────

    def _explain(self, label: int | None, method: str) -> Explaining | None:
        if label is None:
            return None
        start = first_frame(self._workspace, self._sequence, label)
        last = len(self._recording) - 1
        request = ExplainRequest(label, start, last if start < last else 0, method)
        return Explaining(self._workspace, self._sequence, request)

    def _add_frames(self) -> None:
        gui, last = self._server.gui, len(self._recording) - 1
        self._frame = gui.add_slider("Frame", 0, max(last, 1), 1, 0)
        self._share = gui.add_slider("Label colour", 0.0, 1.0, 0.05, 0.7)
        self._trails = gui.add_checkbox("Trails", initial_value=True)
        self._doubts = gui.add_markdown("")
        doubt = gui.add_button_group("Doubts", ("Previous", "Next"))
        for control in (self._frame, self._share, self._trails):
            control.on_update(lambda _: self.show())
        doubt.on_click(lambda event: self.jump(-1 if event.target.value == "Previous" else 1))

    def _add_labels(self) -> None:
        with self._server.gui.add_folder("Labels"):
            self._labels = self._server.gui.add_html("")

    def _add_plots(self) -> None:
        tracks = self._workspace.labels.tracks(self._sequence)
        palette = self._workspace.labels.palette(self._sequence)
        self._plots: dict[str, Any] = {}
        if not palette:
            return
        with self._server.gui.add_folder("Over time"):
            for key, title in (("confidence", "Confidence"), ("inliers", "Share matched")):
                data = curves(tracks, palette, len(self._recording), key)
                self._plots[key] = add_plot(self._server.gui, title, data, palette)

    def _add_judging(self) -> None:
        gui, last = self._server.gui, len(self._recording) - 1
        names = [
            f"{label.id} {label.name}" for label in self._workspace.labels.palette(self._sequence)
        ]
        if not names:
            return
        with gui.add_folder("Judge a range"):
            self._judged = gui.add_dropdown("Label", tuple(names))
            self._from = gui.add_number("From", 0, min=0, max=last, step=1)
            self._to = gui.add_number("To", last, min=0, max=last, step=1)
            verdict = gui.add_button_group("Verdict", ("Accept", "Reject"))
            self._message = gui.add_markdown("")
        verdict.on_click(lambda event: self.judge(accept=event.target.value == "Accept"))

    def _add_steps(self) -> None:
        if self._explaining is None:
            return
        gui, request = self._server.gui, self._explaining.request
        by_id = {label.id: label.name for label in self._workspace.labels.palette(self._sequence)}
        self._steps: dict[str, Any] = {}
        self._iteration: Any = None
        with gui.add_folder(f"How {by_id[request.label]} is found ({request.method})"):
            if request.method == "auto":
                for name in STEPS:
                    self._steps[name] = gui.add_checkbox(name, initial_value=name in SHOWN_FIRST)
                    self._steps[name].on_update(lambda _: self.show())
            else:
                self._iteration = gui.add_slider("Iteration", 1, 50, 1, 1)
                self._iteration.on_update(lambda _: self.show())
            self._verdict = gui.add_markdown("")

    # ── actions ──────────────────────────────────────────────────────────────────────────

    @property
    def port(self) -> int:
        """Return the port of the page."""
        return int(self._server.get_port())

    @property
    def frame(self) -> int:
        """Return the shown frame."""
        return min(int(self._frame.value), len(self._recording) - 1)

    def show(self) -> None:
        """Send the current frame with its label colours."""
        stored = self._recording[self.frame]
        values = self._workspace.labels.values(self._sequence, self.frame)
        tracks = self._workspace.labels.tracks(self._sequence)
        kept = ~values.deleted
        colors = lookup(self._workspace.labels.palette(self._sequence))
        rgb = None if stored.rgb is None else stored.rgb[kept]
        self._server.scene.add_point_cloud(
            "/frame",
            points=(stored.xyz[kept] @ self._room[:3, :3].T + self._room[:3, 3]).astype(np.float32),
            colors=blend(rgb, values.label[kept], colors, float(self._share.value)),
            point_size=POINT_SIZE,
        )
        doubts = doubtful_frames(tracks)
        shown = ", ".join(map(str, doubts[:40])) or "none"
        self._doubts.content = f"**Doubtful frames:** {shown}"
        by_label = {track["label"]: track for track in tracks if track["frame"] == self.frame}
        self._labels.content = self._listed(np.bincount(values.label[kept], minlength=1), by_label)
        self._drawing.trails(self._paths(tracks, colors) if self._trails.value else [])
        self._show_steps(colors)

    def _listed(self, counts: NDArray[np.int64], tracks: Mapping[int, Mapping[str, Any]]) -> str:
        rows = []
        for label in self._workspace.labels.palette(self._sequence):
            points = int(counts[label.id]) if label.id < len(counts) else 0
            track = tracks.get(label.id)
            state = "" if track is None else f"{track['state']} {track['confidence']:.2f}"
            rows.append(
                f"<tr><td><span style='color:{label.color}'>●</span> {html.escape(label.name)}"
                f"</td><td style='text-align:right'>{points:,}</td><td>{state}</td></tr>"
            )
        return f"<table style='width:100%;font-size:0.85em'>{''.join(rows)}</table>"

    def _paths(
        self, tracks: Sequence[Mapping[str, Any]], colors: NDArray[np.uint8]
    ) -> list[tuple[NDArray[np.float64], NDArray[np.uint8]]]:
        """Return paths of the labels' centres by the poses since their painted frame."""
        ways: dict[int, list[tuple[int, Any]]] = {}
        for track in tracks:
            if track["state"] in ("tracked", "painted"):
                ways.setdefault(track["label"], []).append((track["frame"], track["pose"]))
        paths = []
        for label, way in ways.items():
            way.sort(key=lambda entry: entry[0])
            values = self._workspace.labels.values(self._sequence, way[0][0])
            own = self._recording[way[0][0]].coordinates[
                np.flatnonzero((values.label == label) & ~values.deleted)
            ]
            if not len(own):
                continue
            first = np.linalg.inv(np.asarray(way[0][1], np.float64).reshape(4, 4))
            middle = np.append(own.mean(axis=0, dtype=np.float64), 1.0)
            poses = [np.asarray(pose, np.float64).reshape(4, 4) @ first for _, pose in way]
            paths.append((np.array([(T @ middle)[:3] for T in poses]), colors[label]))
        return paths

    def _show_steps(self, colors: NDArray[np.uint8]) -> None:
        if self._explaining is None:
            return
        running = self._explaining
        if self._iteration is not None:
            steps = running.iterations.get(self.frame, [])
            if steps:
                step = steps[min(int(self._iteration.value), len(steps)) - 1]
                self._drawing.iteration(step)
                self._verdict.content = (
                    f"iteration {step.iteration} of {len(steps)}: "
                    f"rmse {1000 * step.rmse:.2f} mm, {len(step.moved):,} pairs"
                )
                return
        found = running.frames.get(self.frame)
        if found is None:
            self._drawing.clear()
            waiting = f"the run has not come to frame {self.frame} yet, or begins after it"
            self._verdict.content = running.error or waiting
            return
        shown = [name for name, box in self._steps.items() if box.value]
        xyz = np.asarray(self._recording[self.frame].xyz)
        self._drawing.explanation(found, xyz, colors, shown)
        self._verdict.content = verdict_text(found)

    def _aim(self, client: viser.ClientHandle) -> None:
        """Aim the camera at the explained label, or else the frame's centre, from the front."""
        running = self._explaining
        found = None if running is None else running.frames.get(self.frame)
        xyz = np.asarray(self._recording[self.frame].xyz, np.float64)
        if found is not None and len(found.surface):
            at, distance = found.surface.mean(axis=0), NEARBY
        elif len(xyz):
            at = np.median(xyz, axis=0)
            distance = OVERVIEW * float(np.median(np.linalg.norm(xyz - at, axis=1)))
        else:
            at, distance = np.zeros(3), NEARBY
        eye = self._recording[self.frame].viewpoint
        way = FROM
        if eye is not None and np.linalg.norm(eye - at) > 0:
            way = self._room[:3, :3] @ (eye - at)
            way = way / np.linalg.norm(way)
        at = self._room[:3, :3] @ at + self._room[:3, 3]
        client.camera.position, client.camera.look_at = at + distance * way, at

    def judge(self, *, accept: bool) -> None:
        """Accept or reject the tracked points of the chosen label in the chosen frames."""
        label = int(str(self._judged.value).split(" ", 1)[0])
        low, high = sorted((int(self._from.value), int(self._to.value)))
        verdict: Verdict = "accept" if accept else "reject"
        frames = range(low, high + 1)
        try:
            commit = self._workspace.verdicts.give(verdict, self._sequence, frames, [label], AUTHOR)
        except PointbrushError as error:
            self._message.content = f"**{error}**"
            return
        word = "accepted" if accept else "rejected"
        self._message.content = f"{word} frames {low} to {high}: {commit.changed:,} points changed"

    def jump(self, direction: int) -> None:
        """Go to the next (1) or previous (-1) doubtful frame, if there is one."""
        doubts = doubtful_frames(self._workspace.labels.tracks(self._sequence))
        ahead = [frame for frame in doubts if (frame - self.frame) * direction > 0]
        if ahead:
            self.go_to(min(ahead) if direction > 0 else max(ahead))

    def go_to(self, frame: int) -> None:
        """Show ``frame``."""
        slider: Any = self._frame  # viser declares the value as read-only, but documents setting it
        slider.value = frame

    def wait_for_explanation(self) -> None:
        """Wait until the explained label is tracked to the end, and show it."""
        if self._explaining is not None:
            self._explaining.wait()
            self.show()

    def close_with(self, workspace: Workspace) -> ReviewPanel:
        """Close a workspace together with the panel."""
        self._owned.append(workspace)
        return self

    def close(self) -> None:
        """Stop the server."""
        self._unsubscribe()
        if self._explaining is not None:
            self._explaining.close()
        self._server.stop()
        for workspace in self._owned:
            workspace.close()

    def _on_event(self, event: Event) -> None:
        if isinstance(event, Commit) and event.sequence == self._sequence:
            self._replot()
            self.show()

    def _replot(self) -> None:
        tracks = self._workspace.labels.tracks(self._sequence)
        palette = self._workspace.labels.palette(self._sequence)
        for key, plot in self._plots.items():
            data = curves(tracks, palette, len(self._recording), key)
            if len(data) == len(plot.data):
                plot.data = data


def open_panel(
    workspace: Workspace | Path | str, sequence: str, port: int = 8081, **options: Any
) -> ReviewPanel:
    """Open a panel on a workspace, or on the folder of one; ``options`` as ``ReviewPanel``."""
    if isinstance(workspace, Workspace):
        return ReviewPanel(workspace, sequence, port=port, **options)
    opened = Workspace(Settings(workspace=Path(workspace)))
    try:
        return ReviewPanel(opened, sequence, port=port, **options).close_with(opened)
    except BaseException:
        opened.close()
        raise
