"""Calls that take a JSON body, or files in a form with the same options."""

from __future__ import annotations

from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from pointbrush.errors import BadInputError
from pointbrush.streaming.encoding import describe
from pointbrush.streaming.shared.status import MalformedError

Model = TypeVar("Model", bound=BaseModel)


def described(model: type[BaseModel], options: dict[str, Any]) -> dict[str, Any]:
    """Describe both bodies in OpenAPI: ``model`` as JSON, ``options`` of a form with ``files``."""
    files = {"type": "array", "minItems": 1, "items": {"type": "string", "format": "binary"}}
    form = {"type": "object", "required": ["files"], "properties": {"files": files, **options}}
    return {
        "requestBody": {
            "required": True,
            "content": {
                "application/json": {"schema": model.model_json_schema()},
                "multipart/form-data": {"schema": form},
            },
        }
    }


def parse_json(model: type[Model], body: bytes) -> Model:
    """Validate a JSON body; raises MalformedError for no JSON, BadInputError for other fields."""
    try:
        return model.model_validate_json(body)
    except ValidationError as error:
        found = error.errors()
        kind = MalformedError if found[0]["type"] == "json_invalid" else BadInputError
        raise kind(describe(found)) from None
