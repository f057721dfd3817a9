"""A ROS message type as records of its fields, and the names of types."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

Encoding = Literal["ros1", "cdr"]
Shape = Literal["scalar", "array", "sequence"]

TIME_TYPES = frozenset({"builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration"})

FILLER = "structure_needs_at_least_one_member"
"""What rosidl and rosbags put into an empty structure: no field of the type."""


@dataclass(frozen=True)
class FieldSpec:
    """One field of a type. `base` is a primitive's name, `ref` another type's; one of them is empty.

    size: elements of a fixed array; a sequence's upper bound (0: none) otherwise.
    """

    name: str
    base: str
    ref: str
    shape: Shape
    size: int


Types = Mapping[str, tuple[FieldSpec, ...]]


def full_name(name: str) -> str:
    """Type name as rosbags has it: "pkg/msg/Type", from "pkg/Type", "pkg/msg/Type" or "pkg::msg::Type"."""
    parts = [part for part in name.replace("::", "/").split("/") if part]
    if len(parts) == 2:
        parts.insert(1, "msg")
    return "/".join(parts)


def short_name(name: str) -> str:
    """Type name as cogest shows it: "pkg/Type" (services and actions keep their middle part)."""
    parts = full_name(name).split("/")
    if len(parts) == 3 and parts[1] == "msg":
        del parts[1]
    return "/".join(parts)
