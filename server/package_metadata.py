"""Metadata hook: the classifiers and addresses that `pointbrush` and `pointbrush-client` share.

A release sets ``POINTBRUSH_REPOSITORY`` to the repository's address.  The packages then name the
address, and relative links of the readme lead to it; without the variable they name no address.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

CLASSIFIERS = (
    "Development Status :: 4 - Beta",
    "Intended Audience :: Science/Research",
    "Operating System :: MacOS",
    "Operating System :: POSIX :: Linux",
    "Programming Language :: Python :: 3",
    "Programming Language :: Python :: 3.11",
    "Programming Language :: Python :: 3.12",
    "Programming Language :: Python :: 3.13",
    "Topic :: Scientific/Engineering :: Image Recognition",
    "Typing :: Typed",
)
PLACES = {
    "Source": "",
    "Documentation": "/blob/{tag}/docs/index.md",
    "Changelog": "/blob/{tag}/CHANGELOG.md",
    "Issues": "/issues",
}
"""Names of the addresses, and their paths below the repository."""
PICTURE = re.compile(r"(!\[[^]]*\])\((?!\w+:)([^)]+)\)")
LINK = re.compile(r"\]\((?!\w+:|#)([^)]+)\)")


class PackageMetadata(MetadataHookInterface):
    """Adds the common fields, and ``classifiers`` and ``readme`` of the package's hook."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Fill in ``classifiers``, ``urls`` and ``readme``."""
        metadata["classifiers"] = sorted({*CLASSIFIERS, *self.config.get("classifiers", ())})
        text = (Path(self.root) / self.config["readme"]).read_text(encoding="utf-8")
        if repository := os.environ.get("POINTBRUSH_REPOSITORY", "").rstrip("/"):
            tag = f"v{metadata['version']}"
            metadata["urls"] = {
                name: repository + path.format(tag=tag) for name, path in PLACES.items()
            }
            text = PICTURE.sub(rf"\1({repository}/raw/{tag}/\2)", text)
            text = LINK.sub(rf"]({repository}/blob/{tag}/\1)", text)
        metadata["readme"] = {"content-type": "text/markdown", "text": text}
