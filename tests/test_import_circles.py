"""No module imports itself by way of others: inside functions and for types neither."""

from __future__ import annotations

from graphlib import CycleError, TopologicalSorter

import grimp
import pytest


def test_imports_make_no_circle() -> None:
    graph = grimp.build_graph("pointbrush")
    imported = {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}
    try:
        TopologicalSorter(imported).prepare()
    except CycleError as error:
        pytest.fail(f"imports: expected no circle, got {' → '.join(error.args[1])}")
