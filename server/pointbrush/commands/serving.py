"""The commands that serve a workspace."""

from __future__ import annotations

import argparse
import sys
from contextlib import suppress
from typing import TYPE_CHECKING

from pointbrush.commands.arguments import FROM_ONE, argument, verb
from pointbrush.commands.places import finished

if TYPE_CHECKING:
    from pointbrush.commands.local import LocalClient

SAMPLES = ("juggling", "stage", "aerial")
"""Sample recordings of `pointbrush demo`."""


@verb(
    argument(
        "--sample-frames", "number of frames of the sample (default: 90)", type=FROM_ONE, default=90
    ),
    argument("--sample", "the sample (default: juggling)", choices=SAMPLES, default="juggling"),
)
def demo(given: argparse.Namespace, place: LocalClient) -> None:
    """Make the sample recording and serve it."""
    from pointbrush.web.server import run

    workspace = place.workspace
    workspace.loops.begin()  # beside the sample, which takes one core
    if not any(manifest.source.startswith("sample") for manifest in workspace.library.manifests()):
        job = workspace.imports.begin_sample(frames=given.sample_frames, kind=given.sample)
        finished(place, job)
    # Ctrl+C ends a server, after it has drained; that is no failure.
    with suppress(KeyboardInterrupt):
        run(workspace, place.settings)


@verb()
def serve(_given: argparse.Namespace, place: LocalClient) -> None:
    """Serve the page, REST and the WebSocket."""
    from pointbrush.web.server import run

    workspace = place.workspace
    with suppress(KeyboardInterrupt):
        if workspace.read_only:
            print(f"pointbrush: {workspace.read_only}", file=sys.stderr, flush=True)
        run(workspace, place.settings)
