"""Parse JSON and XML of untrusted files: every file that cannot be parsed raises ValueError."""

from __future__ import annotations

import json
from typing import Any
from xml.etree import ElementTree

GREATEST = 2.0**63


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
