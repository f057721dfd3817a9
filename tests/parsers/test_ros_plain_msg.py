"""Plain .msg text read line by line says what the full grammar says, or nothing at all."""

from __future__ import annotations

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from parsers.errors import LogError
from parsers.ros.fields import FieldSpec, full_name
from parsers.ros.grammar import _records, _sections, parse_types
from parsers.ros.plain_msg import plain_fields


@pytest.mark.parametrize("name", ["ROS1_NOETIC", "ROS2_FOXY", "ROS2_HUMBLE", "ROS2_JAZZY"])
def test_every_type_of_a_distribution_reads_as_by_the_grammar(name: str) -> None:
    store = get_typestore(Stores[name])
    version = 1 if name.startswith("ROS1") else 2
    read = 0
    for type_name in store.fielddefs:
        text, _ = store.generate_msgdef(type_name, ros_version=version)
        for section_name, section in _sections(type_name, text):
            plain = plain_fields(full_name(section_name), section)
            grammar = _records(get_types_from_msg(section, full_name(section_name)))
            assert list(grammar.values()) == [plain], section_name
            read += 1
    assert read > 300


TEXT = """\
# a comment = with [ signs ] of all kinds
int32 LIMIT=-5   # kept from above
string NAME = it's # no comment
  float64[9]   covariance # row major

uint8[<=12] few
string<=10 short
string<=10[3] shorts
Header header\t
time stamp
Own[] several
other_msgs/Thing one
other_msgs/msg/Thing[2] two
float64 from
"""


def test_what_authors_write() -> None:
    plain = plain_fields("pkg/msg/T", TEXT)
    assert plain is not None
    assert parse_types("pkg/T", TEXT, "ros1", "") == _records(get_types_from_msg(TEXT, "pkg/msg/T"))
    assert plain == (
        FieldSpec("covariance", "float64", "", "array", 9),
        FieldSpec("few", "uint8", "", "sequence", 12),
        FieldSpec("short", "string", "", "scalar", 0),
        FieldSpec("shorts", "string", "", "array", 3),
        FieldSpec("header", "", "std_msgs/msg/Header", "scalar", 0),
        FieldSpec("stamp", "", "builtin_interfaces/msg/Time", "scalar", 0),
        FieldSpec("several", "", "pkg/msg/Own", "sequence", 0),
        FieldSpec("one", "", "other_msgs/msg/Thing", "scalar", 0),
        FieldSpec("two", "", "other_msgs/msg/Thing", "array", 2),
        FieldSpec("from", "float64", "", "scalar", 0),
    )


@pytest.mark.parametrize(
    "line",
    ["int32 x 5", "wstring w", "@optional", "float64", "float64[x] y", "float64[ 3] x", "int32 x;", "3"],
)
def test_unusual_lines_are_left_to_the_grammar(line: str) -> None:
    assert plain_fields("p/msg/T", f"float64 y\n{line}\n") is None


WORDS = st.sampled_from(
    [
        "float64",
        "string<=3",
        "float64<=3",
        "uint8",
        "string",
        "p/A",
        "A",
        "time",
        "x",
        "X",
        "=",
        "3",
        "[]",
        "[3]",
        "[<=4]",
        "#",
        " ",
        "\t",
        "\n",
    ]
)


LINES = st.sampled_from(["float64 x\n", "uint8[3] y\n", "string X\n", "float32 z # unit\n", "time stamp\n"])


@example("float64 x\nuint8[3] y\n")
@given(st.lists(WORDS | LINES, max_size=25).map("".join))
def test_what_the_grammar_takes_is_never_read_otherwise(text: str) -> None:
    plain = plain_fields("p/msg/T", text)
    try:
        grammar = _records(get_types_from_msg(text, "p/msg/T"))
    except Exception:  # rosbags raises its own error and Python's
        return
    if plain is not None:
        assert list(grammar.values()) == [plain]


def test_both_read_lines_of_the_random_texts() -> None:
    text = "float64 x\nuint8[3] y\n"
    grammar = _records(get_types_from_msg(text, "p/msg/T"))
    assert list(grammar.values()) == [plain_fields("p/msg/T", text)]
    assert grammar


def test_a_bad_line_is_still_an_error() -> None:
    with pytest.raises(LogError, match="cannot be parsed"):
        parse_types("p/T", "float64 x\nfloat64\n", "ros1", "")
