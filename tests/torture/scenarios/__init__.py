"""The scenarios, by what fails."""

from __future__ import annotations

import importlib
import pkgutil


def load() -> None:
    """Import every module here, which registers its scenarios."""
    for module in pkgutil.iter_modules(__path__):
        importlib.import_module(f"{__name__}.{module.name}")
