"""Attributes of boxes as words, for formats without another place for them."""

from __future__ import annotations

from pointbrush.geometry.oriented_box import Attributes, AttributeValue


def word_of(value: AttributeValue) -> str:
    """Write a value as a word: ``true``, ``0.5``, ``parked``."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def value_of(word: str) -> AttributeValue:
    """Read the value that ``word_of`` wrote."""
    if word in ("true", "false"):
        return word == "true"
    try:
        return float(word)
    except ValueError:
        return word


def dotted(name: str, value: AttributeValue) -> str:
    """Write an attribute in the style of nuScenes: ``vehicle.parked``."""
    return f"{name}.{word_of(value)}"


def of_dotted(text: str) -> tuple[str, AttributeValue]:
    """Read a text of ``dotted``; a word without a dot is true."""
    name, dot, word = text.partition(".")
    return name, value_of(word) if dot else True


def as_text(attributes: Attributes) -> str:
    """Write attributes as one text: ``occluded, parked: true``."""
    return ", ".join(f"{name}: {word_of(value)}" for name, value in sorted(attributes.items()))


def of_text(text: str) -> dict[str, AttributeValue]:
    """Read a text of ``as_text``; a word without a colon is true."""
    parts = [part.partition(":") for part in text.split(",") if part.strip()]
    return {name.strip(): value_of(word.strip()) if colon else True for name, colon, word in parts}
