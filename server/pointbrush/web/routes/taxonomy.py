"""The classes of the workspace, as a file too."""

from __future__ import annotations

from typing import Annotated

from fastapi import Path

from pointbrush.values.taxonomy import MergedCategories, Taxonomy, TaxonomyChange
from pointbrush.web.context import Ws
from pointbrush.web.security.auth import resource
from pointbrush.web.security.roles import needs

router = resource("taxonomy")
NumberPath = Annotated[int, Path(ge=1, le=65535, description="number of a category")]


@router.get("/taxonomy", **needs("viewer"))
def get_taxonomy(workspace: Ws) -> Taxonomy:
    """Return the classes of the workspace; the answer can be put into another workspace."""
    return workspace.labels.taxonomy.value()


@router.put("/taxonomy", **needs("manager", 409, 413))
def put_taxonomy(body: TaxonomyChange, workspace: Ws) -> Taxonomy:
    """Add classes, or change their names, colours and sizes; other classes do not change.

    Renaming a class changes no number: its labels and exports show the new name.
    """
    workspace.labels.taxonomy.put(body.categories, body.attributes)
    return workspace.labels.taxonomy.value()


@router.post("/taxonomy/{number}/merge", **needs("manager", 404, 409))
def merge_categories(number: NumberPath, body: MergedCategories, workspace: Ws) -> Taxonomy:
    """Merge other classes into this one: their labels in all recordings become labels of it."""
    workspace.labels.taxonomy.merge(number, body.categories)
    return workspace.labels.taxonomy.value()


@router.delete("/taxonomy/{number}", status_code=204, **needs("manager", 404, 409))
def delete_category(number: NumberPath, workspace: Ws) -> None:
    """Delete a class that no label uses."""
    workspace.labels.taxonomy.remove(number)
