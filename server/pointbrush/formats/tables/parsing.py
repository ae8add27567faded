"""Parse JSON, YAML and XML of untrusted files: every other file raises ValueError."""

from __future__ import annotations

import json
from typing import Any
from xml.etree import ElementTree

GREATEST = 2.0**63
DEEPEST_YAML = 64
"""Levels of lists and maps; the time to parse deeper ones grows with the square of the depth."""


def parse_json(data: str | bytes) -> Any:
    """Parse JSON; a whole number of more than 64 bits becomes a float.

    Raises ValueError, also for text that is nested too deeply.
    """
    try:
        return json.loads(data, parse_int=_whole)
    except RecursionError:
        raise ValueError("nested too deeply") from None


def _whole(digits: str) -> int | float:
    number = float(digits)
    return int(digits) if abs(number) < GREATEST else number


def parse_yaml(text: str) -> Any:
    """Parse YAML without aliases: a few lines of them can stand for any amount of data.

    Raises ValueError, also for text that is nested too deeply.
    """
    import yaml  # slow to import

    loader, depth = getattr(yaml, "CSafeLoader", yaml.SafeLoader), 0
    try:
        for event in yaml.parse(text, loader):
            if isinstance(event, yaml.AliasEvent):
                raise yaml.YAMLError("an alias (*name); write YAML without aliases")
            depth += isinstance(event, yaml.CollectionStartEvent)
            depth -= isinstance(event, yaml.CollectionEndEvent)
            if depth > DEEPEST_YAML:
                raise yaml.YAMLError(f"more than {DEEPEST_YAML} levels of lists and maps")
        return yaml.load(text, loader)  # noqa: S506 – both loaders are safe ones
    except (yaml.YAMLError, ValueError, LookupError, AttributeError) as error:
        # The last three are raised for values that do not fit their tags.
        raise ValueError(" ".join(str(error).split())[:200]) from None


def parse_xml(data: str | bytes) -> ElementTree.Element:
    """Parse XML without a document type: entities of its own could grow without bounds.

    Raises ValueError.
    """
    try:
        return ElementTree.fromstring(data, ElementTree.XMLParser(target=_Plain()))  # noqa: S314
    except (ElementTree.ParseError, LookupError) as error:  # LookupError: an unknown encoding
        raise ValueError(str(error)) from None


class _Plain(ElementTree.TreeBuilder):
    def doctype(self, *_: object) -> None:
        raise ValueError("expected no document type and no entities")
