"""Plain .msg text to records of its fields, a line at a time; what is unusual in it is left to the full grammar.

Real definitions hold fields, constants and comments. The grammar of the whole language takes twenty times as long (4 ms for
four topics' types, while the log waits), and 40 ms to load.
Source: http://wiki.ros.org/msg, https://docs.ros.org/en/rolling/Concepts/Basic/About-Interfaces.html.
"""

from __future__ import annotations

import re

from parsers.ros.fields import FILLER, FieldSpec, Shape, full_name

_COMMENT = r"[ \t]*(?:#.*)?"
_NOTHING = re.compile(_COMMENT)
_BASES = "bool|byte|char|float32|float64|u?int8|u?int16|u?int32|u?int64|string"
_CONSTANT = re.compile(rf"[ \t]*(?:{_BASES})[ \t]+[A-Z][A-Z0-9_]*[ \t]*=[ \t]*\S.*")
_FIELD = re.compile(
    rf"[ \t]*(?:({_BASES})(?:(?<=string)<=[0-9]+)?|((?:[a-z][a-z0-9_]*/(?:msg/)?)?[A-Z][A-Za-z0-9_]*|time|duration))"
    rf"(\[(?:(<=)?([0-9]{{1,18}}))?\])?[ \t]+([A-Za-z][A-Za-z0-9_]*){_COMMENT}"
)
_NAMES = {
    "time": "builtin_interfaces/msg/Time",
    "duration": "builtin_interfaces/msg/Duration",
    "Header": "std_msgs/msg/Header",
}


def plain_fields(type_name: str, text: str) -> tuple[FieldSpec, ...] | None:
    """Fields of a type by the text between its title and the next rule; None where a line is not plain.

    type_name: "pkg/msg/Type", to whose package bare names of other types belong.
    """
    found: list[FieldSpec] = []
    for line in text.split("\n"):
        match = _FIELD.fullmatch(line)
        if match is None:
            if _NOTHING.fullmatch(line) or _CONSTANT.fullmatch(line):
                continue
            return None
        field = _field(type_name, match)
        if field.name != FILLER:
            found.append(field)
    return tuple(found)


def _field(type_name: str, match: re.Match[str]) -> FieldSpec:
    base, ref, brackets, bound, count, name = match.groups()
    shape: Shape = "scalar"
    if brackets:
        shape = "array" if count and not bound else "sequence"
    if ref:
        ref = _NAMES.get(ref) or full_name(ref if "/" in ref else f"{type_name.partition('/')[0]}/{ref}")
    return FieldSpec(name, base or "", ref or "", shape, int(count or 0))
