"""All classes of values."""

from __future__ import annotations

import pkgutil
from importlib import import_module

from pointbrush import values
from pointbrush.values.base import Value


def value_classes() -> list[type[Value]]:
    """Return the classes of all values, by name."""
    modules = [
        import_module(each.name)
        for each in pkgutil.walk_packages(values.__path__, f"{values.__name__}.")
    ]
    found = {
        kind
        for module in modules
        for kind in vars(module).values()
        if isinstance(kind, type)
        and issubclass(kind, Value)
        and hasattr(kind, "__dataclass_fields__")
    }
    return sorted(found, key=lambda kind: kind.__name__)
