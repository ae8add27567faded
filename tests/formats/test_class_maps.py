"""Class names from YAML of data sets and XML of point_labeler, in their own colour orders."""

from __future__ import annotations

import pytest

from pointbrush.errors import BadInputError
from pointbrush.formats.tables.class_maps import parse_map
from pointbrush.formats.tables.datasets import ClassName

# The layout of PRBonn/semantic-kitti-api config/semantic-kitti.yaml, with classes of our own.
YAML = """# classes of our yard
name: "yard"
labels:
  0 : "unlabeled"
  3 : "grass"
  17: "person"
  20: rake
color_map: # bgr
  0 : [0, 0, 0]
  3 : [0, 100, 20]
  17: [40, 20, 204]
content: {0: 0.5, 3: 0.4, 17: 0.1}
learning_map: {0: 0, 3: 1, 17: 2}
learning_map_inv: {0: 0, 1: 3, 2: 17}
learning_ignore: {0: True}
split: {train: [0, 1]}
"""
# The layout of jbehley/point_labeler assets/labels.xml.
XML = """<!-- classes of our yard -->
<config>
  <label><id>0</id><name>unlabeled</name><color>0 0 0</color></label>
  <label>
    <id>17</id>
    <name>on rails</name>
    <description>trams, etc.</description>
    <color>204 20 40</color>
    <root>object</root>
    <moving>256</moving>
  </label>
</config>
"""


def test_yaml_of_a_data_set_names_raw_classes_with_colours_in_bgr() -> None:
    assert parse_map("yard.yaml", YAML) == {
        3: ClassName("grass", "#146400"),
        17: ClassName("person", "#cc1428"),
        20: ClassName("rake"),
    }


def test_an_order_of_colours_that_the_file_states_is_its_order() -> None:
    assert parse_map("y", YAML.replace("# bgr", "# RGB"))[17].color == "#2814cc"


def test_xml_of_point_labeler() -> None:
    assert parse_map("labels.xml", XML) == {17: ClassName("on rails", "#cc1428")}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("names: [a, b]\n", "expected YAML with 'labels'"),
        ("labels:\n  a: [\n", "expected YAML of class names"),
        ("labels: {car: 3}\n", "expected class numbers"),
        ("labels: {3: yes}\n", "expected class numbers .* with names"),
        ("labels: {3: a}\ncolor_map: {3: [1, 2]}\n", "expected three numbers 0 to 255"),
        ("labels: {3: a}\ncolor_map: {3: [1, 2, 256]}\n", "expected three numbers 0 to 255"),
        ("labels: !!python/object/apply:os.getcwd []\n", "expected YAML of class names"),
        ("labels: " + "[" * 5000, "expected YAML of class names"),
        ("labels:\n" + "#" * (1 << 18), "at most 262144 characters of YAML"),
        ("<config/>", "expected XML with 'label' elements, got 'config'"),
        ("<config>", "expected XML of class names"),
        ("<!DOCTYPE a [<!ENTITY b 'c'>]><a>&b;</a>", "no entities"),
        ("<c><label><id>1</id><name>a</name><color>red</color></label></c>", "three numbers"),
        ("<c><label><name>a</name></label></c>", "expected class numbers"),
    ],
)
def test_other_content_says_what_is_wrong(text: str, said: str) -> None:
    with pytest.raises(BadInputError, match=f"m: .*{said}"):
        parse_map("m", text)
