"""From the definition text of a ROS message type to plain records of its fields.

The grammar of .msg and .idl text is rosbags' work; here the text is cut into its types and made regular first, and plain
.msg text is read without it (`plain_msg`).
Sources: http://wiki.ros.org/msg, https://design.ros2.org/articles/legacy_interface_definition.html.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from parsers.errors import LogError
from parsers.ros.fields import FILLER, Encoding, FieldSpec, Shape, Types, full_name, short_name
from parsers.ros.plain_msg import plain_fields
from parsers.ros.usual_types import usual_fields

MAX_DEFINITION = 1 << 20
"""Longest definition text that is parsed, in characters; real ones reach some 100 000."""

# ROS 2 bags older than Iron hold no definitions; the types of these distributions are then taken.
_STANDARD_STORES: dict[Encoding, tuple[str, ...]] = {
    "ros1": ("ROS1_NOETIC",),
    "cdr": ("ROS2_HUMBLE", "ROS2_JAZZY", "ROS2_FOXY"),
}
_RULE = re.compile(r"^={20,}[ \t]*$", re.MULTILINE)
_TITLE = re.compile(r"\A\s*(MSG|IDL):[ \t]*(\S+)[ \t]*(?:\n|\Z)")
_PREPROCESSOR = re.compile(r"^[ \t]*#[^\n]*$", re.MULTILINE)
_WIDE_BOUND = re.compile(r"^([ \t]*wstring)<=\d+", re.MULTILINE)


def _spec(name: str, desc: Any) -> FieldSpec:
    """Turn one of rosbags' field descriptions into a record."""
    kind = desc[0].name
    shape: Shape = "scalar"
    size = 0
    if kind in ("ARRAY", "SEQUENCE"):
        shape = "array" if kind == "ARRAY" else "sequence"
        desc, size = desc[1]
        kind = desc[0].name
    if kind == "BASE":
        return FieldSpec(name, str(desc[1][0]), "", shape, int(size))
    ref = str(desc[1])
    if ref.endswith("/wstring"):  # rosbags' .msg grammar takes it for a type of the same package
        return FieldSpec(name, "wstring", "", shape, int(size))
    return FieldSpec(name, "", ref, shape, int(size))


def _records(fielddefs: Mapping[str, Any]) -> dict[str, tuple[FieldSpec, ...]]:
    # rosbags writes rosidl's filler of empty structures out, in ROS 1 too; the layout knows when it is there
    return {
        str(name): tuple(_spec(field, desc) for field, desc in entry[1] if field != FILLER)
        for name, entry in fielddefs.items()
    }


def standard_types(type_name: str, encoding: Encoding) -> Types | None:
    """All types of the first ROS distribution that knows `type_name`, or None where none does.

    Of a usual type of vehicles' packages only itself: what it uses is a distribution's.
    """
    from rosbags.typesys import Stores, get_typestore

    for store in _STANDARD_STORES[encoding]:
        fielddefs = get_typestore(Stores[store]).fielddefs
        if full_name(type_name) in fielddefs:
            return _records(fielddefs)
    usual = usual_fields(type_name)
    return None if usual is None else {full_name(type_name): usual}


def _sections(type_name: str, text: str) -> list[tuple[str, str]]:
    """Cut a definition into (type name, text); the first section may lack its title."""
    found: list[tuple[str, str]] = []
    for piece in _RULE.split(text.replace("\r\n", "\n").replace("\r", "\n")):
        title = _TITLE.match(piece)
        if title:
            found.append((title.group(2), piece[title.end() :]))
        elif not found:
            found.append((type_name, piece))
    if len(found) > 1 and not found[0][1].strip() and full_name(found[1][0]) == full_name(type_name):
        del found[0]  # the text began with a rule: what stood before it is nothing
    return found


def parse_types(type_name: str, text: str, encoding: Encoding, text_format: str) -> Types:
    """All types that a definition text holds; blank text means the standard type of that name.

    Raises LogError where the text cannot be parsed.
    """
    if len(text) > MAX_DEFINITION:
        raise LogError(
            f"the definition of message type {type_name} has {len(text)} characters, which cannot be right"
        )
    if not text.strip():
        standard = standard_types(type_name, encoding)
        return standard if standard is not None else {full_name(type_name): ()}
    idl = text_format.lower() in ("idl", "ros2idl", "omgidl")
    types: dict[str, tuple[FieldSpec, ...]] = {}
    for name, section in _sections(type_name, text):
        plain = None if idl else plain_fields(full_name(name), section)
        found = {full_name(name): plain} if plain is not None else _by_grammar(name, section, idl)
        for key, fields in found.items():
            types.setdefault(key, fields)
    return types


def _by_grammar(name: str, section: str, idl: bool) -> dict[str, tuple[FieldSpec, ...]]:
    """What the full grammar finds in a section's text. Raises LogError."""
    from rosbags.typesys import get_types_from_idl, get_types_from_msg

    try:
        if idl:
            parsed = get_types_from_idl(_PREPROCESSOR.sub("", section))
        else:
            parsed = get_types_from_msg(_WIDE_BOUND.sub(r"\1", section), full_name(name))
        return _records(parsed)
    except Exception as error:  # the parser meets untrusted text: whatever it raises means the same
        what = " ".join(str(error).split())[:80]
        raise LogError(f"the definition of message type {name} cannot be parsed ({what})") from error


def lookup(types: Types, name: str, encoding: Encoding) -> tuple[FieldSpec, ...]:
    """Fields of a type; standard types may be missing from the text. Raises LogError for an unknown one."""
    key = full_name(name)
    if key in types:
        return types[key]
    same = [known for known in types if known.rsplit("/", 1)[-1] == key.rsplit("/", 1)[-1]]
    if len(same) == 1:
        return types[same[0]]
    standard = standard_types(key, encoding)
    if standard is None:
        raise LogError(f"message type {short_name(name)} is not defined in the log and is no standard type")
    return standard[key]
