"""Base classes of values, and limits of their fields.

Pydantic reads the limits by the methods that it looks up by name; nothing here imports it.
"""

from __future__ import annotations

import inspect
import sys
import token
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, Field, asdict, field, fields
from functools import cache
from tokenize import TokenInfo, generate_tokens
from typing import Any, ClassVar, Final, Self

Schema = dict[str, Any]
IN_BODIES = "pointbrush_limits"
"""Key of ``Limits`` in the metadata of a core schema."""
SCALARS = ("int", "float", "str", "bool")


class _Unset:
    def __repr__(self) -> str:
        return "UNSET"

    def __reduce__(self) -> str:
        return "UNSET"  # copies are the same object


UNSET: Final[Any] = _Unset()
"""Value of a field that the sender left out, in bodies in which null has a meaning of its own."""


def optional() -> Any:
    """Return a field of a body that is ``UNSET`` if the sender leaves it out."""
    return field(default_factory=lambda: UNSET)


class Rule:
    """Limits of an annotated type: keys of pydantic's core schema, such as ``ge``."""

    def __init__(self, **limits: Any) -> None:
        self.limits = limits

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Schema:
        return {**handler(source), **self.limits}


class Limits(Rule):
    """Limits that hold in bodies alone: values that older versions stored are read unchanged."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Schema:
        schema: Schema = handler(source)
        return {**schema, "metadata": {**schema.get("metadata", {}), IN_BODIES: self.limits}}


class Items(Rule):
    """Fixed length of a tuple, which JSON schema describes as a list of one type."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Schema:
        items = handler(source)["items_schema"]
        count = {"min_length": len(items), "max_length": len(items)}
        return {
            "type": "tuple", "items_schema": items[:1], "variadic_item_index": 0, "strict": False,
            **count,
        }  # fmt: skip


class Patterns(Rule):
    """Patterns of a body's texts, by field: names that plug-ins add are known to routes alone."""

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Schema:
        schema: Schema = handler(source)
        body = schema
        while body["type"] != "dataclass-args":
            ref = body["type"] == "definition-ref"
            body = handler.resolve_ref_schema(body) if ref else body["schema"]
        for each in body["fields"]:
            if each["name"] in self.limits:
                text = each["schema"]
                while text["type"] != "str":
                    text = text["schema"]
                text["pattern"] = self.limits[each["name"]]
        return schema


class ClosedKeys:
    """No other keys than those of the key's pattern, which pydantic's JSON schema leaves open."""

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> Schema:
        return {**handler(core), "additionalProperties": False}


class Meanings:
    """Meaning of each value of an enumeration, which its descriptions list."""

    def __init__(self, meanings: Mapping[str, str]) -> None:
        self.text = "; ".join(f"`{value}`: {meaning}" for value, meaning in meanings.items())

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> Schema:
        return {**handler(core), "description": self.text}


class Repeated:
    """The flag of a field can be given several times; its values are a list."""


class Value:
    """Base of values.  The docstring below a field describes it in OpenAPI and the references."""

    __slots__ = ()
    EXTENSIBLE: ClassVar[bool] = False
    """Bodies may contain the value with further fields, which are ignored."""

    def __getitem__(self, name: str) -> Any:
        """Return a field by its name, so that scripts written for dict answers still run."""
        if name not in (each.name for each in fields(self)):  # type: ignore[arg-type]
            raise KeyError(name)
        return getattr(self, name)

    @classmethod
    def of(cls, source: object, **more: Any) -> Self:
        """Return the value with the fields ``more``; the others are attributes of ``source``.

        Lists become tuples.
        """
        names = (each.name for each in fields(cls) if each.name not in more)  # type: ignore[arg-type]
        found = more | {name: getattr(source, name) for name in names}
        return cls(**{name: _fixed(value) for name, value in found.items()})

    @classmethod
    def __get_pydantic_json_schema__(cls, core: Any, handler: Any) -> Schema:
        found: Schema = handler(core)
        resolved = handler.resolve_ref_schema(found)
        while "schema" in core:
            core = core["schema"]
        if core.get("extra_behavior") == "forbid":
            resolved["additionalProperties"] = False
        described = resolved["properties"]
        texts = descriptions(cls)
        for each in fields(cls):  # type: ignore[arg-type]
            shown, text = described[each.metadata.get("alias", each.name)], texts.get(each.name, "")
            more = " ".join(
                part.get("description", "") for part in (shown, *shown.get("anyOf", []))
            )
            if text not in more:  # the hook of a body runs several times
                shown["description"] = f"{text} {more}".strip()
        return found


class Body(Value):
    """Base of request bodies: unknown fields are refused, and types are not converted."""

    __slots__ = ()

    @classmethod
    def prepared(cls, value: Any) -> Any:
        """Return a body as JSON has it, in the form that is validated."""
        return integral(value)

    def to_json(self) -> dict[str, Any]:
        """Return the fields that differ from their defaults, as JSON has them."""
        values = asdict(self)  # type: ignore[call-overload]
        return {
            each.metadata.get("alias", each.name): values[each.name]
            for each in fields(self)  # type: ignore[arg-type]
            if values[each.name] != default_of(each)
        }

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: Any) -> Schema:
        schema = dict(handler(source))
        reference = {"ref": schema.pop("ref")}  # of the whole, which OpenAPI names
        _tighten(schema, handler, set())
        function = {"type": "no-info", "function": cls.prepared}
        return {"type": "function-before", "function": function, "schema": schema, **reference}


class Complete(Value):
    """Base of values with defaults for bodies, all of whose fields are in an answer."""

    __slots__ = ()
    __pydantic_config__: ClassVar[Schema] = {"json_schema_serialization_defaults_required": True}

    @classmethod
    def __get_pydantic_json_schema__(cls, core: Any, handler: Any) -> Schema:
        found = super().__get_pydantic_json_schema__(core, handler)
        if handler.mode == "serialization":
            for each in handler.resolve_ref_schema(found)["properties"].values():
                each.pop("default", None)
        return found


def _fixed(value: Any) -> Any:
    return tuple(map(_fixed, value)) if isinstance(value, list) else value


def default_of(each: Field[Any]) -> Any:
    """Return the default of a dataclass's field; MISSING for a required one."""
    return each.default if each.default_factory is MISSING else each.default_factory()


def integral(body: Any) -> Any:
    """Return a body with 3.0 as 3: both are the same integer in JSON."""
    if isinstance(body, dict):
        return {name: integral(value) for name, value in body.items()}
    if isinstance(body, list):
        return [integral(item) for item in body]
    return int(body) if isinstance(body, float) and body.is_integer() else body


def _tighten(schema: Any, handler: Any, seen: set[int]) -> None:
    """Refuse unknown fields and other types in a core schema and all schemas in it."""
    if id(schema) in seen or not isinstance(schema, dict | list):
        return
    seen.add(id(schema))
    if isinstance(schema, dict):
        if schema.get("type") == "definition-ref":
            _tighten(handler.resolve_ref_schema(schema), handler, seen)
        _tighten_one(schema)
    for each in list(schema.values() if isinstance(schema, dict) else schema):
        _tighten(each, handler, seen)


def _tighten_one(schema: Schema) -> None:
    kind, metadata = schema.get("type"), schema.get("metadata", {})
    schema.update(metadata.get(IN_BODIES, {}))
    if kind in SCALARS:
        schema["strict"] = True
    if kind == "dataclass" and not schema["cls"].EXTENSIBLE:
        schema["schema"]["extra_behavior"] = "forbid"


def descriptions(kind: Any) -> dict[str, str]:
    """Return the docstrings of a value's fields, by name; none if the source is not installed."""
    found: dict[str, str] = {}
    for base in reversed(kind.__mro__):
        found |= _docstrings(base.__module__).get(base.__qualname__, {})
    return found


@cache
def _docstrings(module: str) -> dict[str, dict[str, str]]:
    # Tokens, not a syntax tree: CPython 3.11 fails when two threads parse at once.
    try:
        lines = inspect.getsource(sys.modules[module]).splitlines(keepends=True)
    except (OSError, TypeError):
        return {}
    found: dict[str, dict[str, str]] = {}
    before = ""
    for pair in _statements(lines):
        match pair:
            case TokenInfo(token.NAME, "class", (_, 0)), TokenInfo(token.NAME, name):
                found[name] = {}
            case TokenInfo(token.NAME, before, (_, 4)), TokenInfo(token.OP, ":"):
                continue
            case TokenInfo(token.STRING, text, (_, 4)), _ if before:
                found[name][before] = " ".join(text.strip('"').split())
        before = ""
    return found


def _statements(lines: list[str]) -> Iterator[tuple[TokenInfo, TokenInfo]]:
    """Yield the first two tokens of each statement."""
    tokens: list[TokenInfo] = []
    for each in generate_tokens(iter(lines).__next__):
        if each.type == token.NEWLINE:
            yield tokens[0], tokens[1] if len(tokens) > 1 else each
            tokens.clear()
        elif each.type not in {token.COMMENT, token.DEDENT, token.INDENT, token.NL}:
            tokens.append(each)
