"""Values of REST are defined once, and every part of the description has a meaning."""

from __future__ import annotations

import typing
from collections.abc import Iterator
from contextlib import closing
from dataclasses import fields, is_dataclass
from itertools import combinations
from typing import Any

import pytest
from fastapi import FastAPI
from fastapi.routing import APIRoute

from pointbrush.client.uploads import ImportKeywords, LabelKeywords
from pointbrush.settings import Settings
from pointbrush.values import labels
from pointbrush.values.base import UNSET, Value
from pointbrush.values.classes import value_classes
from pointbrush.values.imports import ImportOptions, LabelImportOptions
from pointbrush.values.team import projects
from pointbrush.web.app import create_app
from pointbrush.web.strokes import FloorBody, ObjectBody, StrokeBody
from pointbrush.workspace import Workspace

OF_MESSAGES = (StrokeBody, FloorBody, ObjectBody)
"""Bodies with samples of a stroke extend messages of the socket, which are defined there."""


DIFFERENT = (
    *((each, "Snapshot") for each in ("AccountToken", "NewToken", "ProjectInfo")),
    ("Candidate", "PersonPoints"),
    ("ClassAgreement", "LabelAgreement"),
    *(("ClassFigures", other) for other in ("PersonFigures", "Statistics")),
    ("PersonPoints", "Place"),
    ("ProjectInfo", "Token"),
    ("Snapshot", "Token"),
    ("Standing", "TaskEvent"),
    ("Stretch", "TrackingRequest"),
    ("Task", "TaskEvent"),
)
"""Pairs whose fields have equal names and other meanings, such as the name of an account and of a
snapshot, or a person after a change and now."""


@pytest.fixture(scope="module")
def app(tmp_path_factory: pytest.TempPathFactory) -> Iterator[FastAPI]:
    settings = Settings(workspace=tmp_path_factory.mktemp("values") / "workspace")
    with closing(Workspace(settings)) as workspace:
        yield create_app(workspace, settings)


def kinds(annotation: Any) -> Iterator[type]:
    """Return the classes in an annotation."""
    parts = typing.get_args(annotation)
    if not parts and isinstance(annotation, type):
        yield annotation
    for part in parts:
        yield from kinds(part)


def test_each_body_and_answer_is_a_value(app: FastAPI) -> None:
    found: set[type] = set()
    for route in app.routes:
        if isinstance(route, APIRoute) and route.include_in_schema:
            bodies = [each.field_info.annotation for each in route.dependant.body_params]
            for each in (route.response_model, *bodies):
                found |= set(kinds(each))
    classes = {kind for kind in found if kind.__module__.startswith("pointbrush.")}
    strange = [kind for kind in classes if not issubclass(kind, (Value, *OF_MESSAGES))]
    assert len(classes) > 60
    assert strange == []


def parts_without_meaning(description: dict[str, Any]) -> Iterator[str]:
    """Return the fields and parameters without a description, or without one of an enum value."""
    for name, schema in description["components"]["schemas"].items():
        for field, each in schema.get("properties", {}).items():
            text = each.get("description", "")
            if not text or any(f"`{value}`" not in text for value in values_of(each)):
                yield f"{name}.{field}"
    for path, verbs in description["paths"].items():
        for verb, call in verbs.items():
            for each in call.get("parameters", []):
                schema = each["schema"]
                parts = (each, schema, *schema.get("anyOf", []))
                text = " ".join(part.get("description", "") for part in parts)
                if not text.strip() or any(f"`{v}`" not in text for v in values_of(schema)):
                    yield f"{verb.upper()} {path}: {each['name']}"


def values_of(schema: dict[str, Any]) -> list[str]:
    options = [schema, *schema.get("anyOf", [])]
    return [value for option in options for value in option.get("enum", [])]


def test_every_field_parameter_and_enum_value_is_described(app: FastAPI) -> None:
    assert list(parts_without_meaning(app.openapi())) == []


def fields_of(kind: type) -> set[tuple[str, Any]]:
    return {(each.name, each.type) for each in fields(kind)} if is_dataclass(kind) else set()


def defined_twice(one: type, other: type) -> bool:
    """Return whether most fields of a class are in both, but neither in one nor in a common base.

    "Most" is more than half of at least four fields.
    """
    here, there = fields_of(one), fields_of(other)
    bases = [fields_of(base) for base in set(one.__mro__) & set(other.__mro__)]
    shared = (here & there).difference(*bases)
    fewest = min(len(here), len(there))
    return fewest >= 4 and len(shared) > fewest / 2 and not (here <= there or there <= here)


def test_no_two_values_share_most_fields_without_containing_each_other() -> None:
    pairs = combinations(value_classes(), 2)
    alike = {(one.__name__, other.__name__) for one, other in pairs if defined_twice(one, other)}
    assert alike == set(DIFFERENT)


@pytest.mark.parametrize(
    ("keywords", "kind"), [(ImportKeywords, ImportOptions), (LabelKeywords, LabelImportOptions)]
)
def test_keywords_of_imports_are_the_fields_of_their_values(keywords: Any, kind: Any) -> None:
    assert keywords.__annotations__.keys() == {each.name for each in fields(kind)} - {"id"}


def test_a_change_tells_an_absent_field_from_null() -> None:
    assert projects.ProjectPatch().to_json() == {}
    assert projects.ProjectPatch(categories=None).to_json() == {"categories": None}
    assert projects.ProjectPatch().categories is UNSET
    assert labels.LabelPatch(locked=False).to_json() == {"locked": False}
