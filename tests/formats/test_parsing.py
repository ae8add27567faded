"""JSON, YAML and XML from elsewhere raise ValueErrors alone."""

from __future__ import annotations

import pytest

from pointbrush.formats.tables.parsing import parse_json, parse_xml, parse_yaml

ENTITIES = "<?xml version='1.0' encoding='utf-16'?><!DOCTYPE a [<!ENTITY b 'c'>]><a>&b;</a>"


def test_whole_numbers_of_any_length_are_numbers() -> None:
    found = parse_json('{"a": 1533151603547590000, "b": -1e3, "c": 1%s}' % ("0" * 400))
    assert found == {"a": 1533151603547590000, "b": -1000.0, "c": float("inf")}


def test_text_that_is_nested_too_deeply_is_refused() -> None:
    with pytest.raises(ValueError, match="nested"):
        parse_json("[" * 100_000)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[" * 100_000, "levels"),
        ("a: &a [1]\nb: *a", "without aliases"),
        ("a: 2001-13-45", "month"),
        ("a: " + "9" * 5000, "digits"),
        *((f"a: {tag}", ".") for tag in ("!!int ''", "!!bool no-one", "!!timestamp x")),
    ],
    ids=["deep", "alias", "date", "digits", "int", "bool", "timestamp"],
)
def test_yaml_that_needs_much_time_or_does_not_fit_its_tags_is_refused(
    text: str, words: str
) -> None:
    with pytest.raises(ValueError, match=words):
        parse_yaml(text)


@pytest.mark.parametrize(
    "data",
    [b"<?xml version='1.0' encoding='utf65536'?><a/>", b"<a>", ENTITIES.encode("utf-16")],
    ids=["encoding", "end", "entities"],
)
def test_xml_of_an_unknown_encoding_or_with_entities_is_refused(data: bytes) -> None:
    with pytest.raises(ValueError):
        parse_xml(data)
