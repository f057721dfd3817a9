"""The field tree of JSON messages: from a JSON schema, from some messages, or from both."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from parsers.field_notes import MAX_FIELDS, MAX_LIST, unit_in
from parsers.json_names import element_names, may_list_names, may_name, names_beside
from parsers.json_units import MOST_TEXTS, says_units, units_beside
from parsers.ros.contract import FieldInfo
from parsers.units import quantities_of

MAX_DEPTH = 16
_LONGEST_TEXT = 96
_NUMBERS = ("number", "integer", "boolean")


@dataclass
class JsonNode:
    """One place in a message. A place may be a number in one message and an object in the next.

    open: the schema does not say what is inside, so that only messages can. texts: the first different texts that messages have there.
    name: what a list of names beside its own calls it.
    """

    keys: dict[str, JsonNode] = field(default_factory=dict)
    items: list[JsonNode] = field(default_factory=list)
    number: bool = False
    text: bool = False
    open: bool = False
    unit: str | None = None
    comment: str = ""
    texts: tuple[str, ...] = ()
    name: str = ""

    def item(self, index: int) -> JsonNode:
        """The list element at an index, made where it is not there yet."""
        while len(self.items) <= index:
            self.items.append(JsonNode())
        return self.items[index]


def add_sample(node: JsonNode, value: Any, depth: int = 0) -> None:
    """Take in what one message has."""
    if isinstance(value, dict):
        if depth < MAX_DEPTH:
            for key, inner in value.items():
                add_sample(node.keys.setdefault(str(key), JsonNode()), inner, depth + 1)
    elif isinstance(value, list):
        if depth < MAX_DEPTH:
            for index, inner in enumerate(value[:MAX_LIST]):
                add_sample(node.item(index), inner, depth + 1)
    elif isinstance(value, str):
        node.text = True
        if len(node.texts) < MOST_TEXTS and value not in node.texts:
            node.texts += (value[:_LONGEST_TEXT],)
    elif value is not None:
        node.number = True


def read_sample(payload: bytes) -> Any:
    """One message as Python values, None where it is malformed."""
    try:
        return json.loads(payload.rstrip(b"\0").decode("utf-8-sig"))
    except (ValueError, RecursionError):
        return None


def _target(schema: Any, root: Any) -> Any:
    """The schema that a local reference ("#/$defs/Vector") means."""
    for _ in range(MAX_DEPTH):
        if not isinstance(schema, dict) or not isinstance(schema.get("$ref"), str):
            return schema
        place: Any = root
        for part in schema["$ref"].removeprefix("#").split("/")[1:]:
            part = part.replace("~1", "/").replace("~0", "~")
            place = place.get(part) if isinstance(place, dict) else None
        if place is None:
            return {}
        schema = place
    return {}


def _first_lengths(schema: dict[str, Any]) -> int:
    """How many elements a list of the schema can have, up to those that become channels."""
    most = schema.get("maxItems", MAX_LIST)
    return max(0, min(most, MAX_LIST)) if isinstance(most, int) else MAX_LIST


class _SchemaWalk:
    """Goes through a schema, not deeper than MAX_DEPTH and not over more places than could be channels."""

    def __init__(self, root: Any) -> None:
        self.root = root
        self.places = 0

    def add(self, node: JsonNode, schema: Any, depth: int) -> None:
        """Take in what a schema says of a place."""
        schema = _target(schema, self.root)
        self.places += 1
        if not isinstance(schema, dict) or depth >= MAX_DEPTH or self.places > 4 * MAX_FIELDS:
            node.open = True
            return
        self._describe(node, schema)
        for word in ("allOf", "anyOf", "oneOf"):
            for each in _list(schema.get(word)):
                self.add(node, each, depth + 1)
        kinds = schema.get("type")
        kinds = [kinds] if isinstance(kinds, str) else _list(kinds)
        node.number |= any(kind in _NUMBERS for kind in kinds)
        node.text |= "string" in kinds
        properties = schema.get("properties")
        if isinstance(properties, dict):
            for key, each in properties.items():
                self.add(node.keys.setdefault(str(key), JsonNode()), each, depth + 1)
            # by the specification a schema allows keys that it does not name, unless it says that there are none
            closed = any(
                schema.get(word) is False for word in ("additionalProperties", "unevaluatedProperties")
            )
            node.open |= "patternProperties" in schema or not closed
        if "array" in kinds or "items" in schema or "prefixItems" in schema:
            self._array(node, schema, depth)
        nothing = not (node.keys or node.items or node.number or node.text)
        node.open |= nothing and kinds != ["null"]

    def _array(self, node: JsonNode, schema: dict[str, Any], depth: int) -> None:
        items = schema.get("items")
        places = items if isinstance(items, list) else _list(schema.get("prefixItems"))
        for index, each in enumerate(places[:MAX_LIST]):
            self.add(node.item(index), each, depth + 1)
        if isinstance(items, dict):
            for index in range(len(places), _first_lengths(schema)):
                self.add(node.item(index), items, depth + 1)

    def _describe(self, node: JsonNode, schema: dict[str, Any]) -> None:
        words = schema.get("description") or schema.get("title")
        if isinstance(words, str) and not node.comment:
            node.comment = " ".join(words.split())
            node.unit = unit_in(node.comment)
        unit = schema.get("unit") or schema.get("units")
        if isinstance(unit, str) and quantities_of(unit):
            node.unit = unit


def _list(value: Any) -> list[Any]:
    return value if isinstance(value, list) else []


def add_schema(node: JsonNode, definition: bytes) -> bool:
    """Take in a JSON schema; False where it is not one, and the messages alone must do."""
    schema = read_sample(definition) if definition.strip() else None
    if not isinstance(schema, dict):
        return False
    _SchemaWalk(schema).add(node, schema, 0)
    return True


def has_open_places(node: JsonNode) -> bool:
    """Whether the schema leaves something to be found in the messages: places, or what unit or name a text states."""
    waiting = [node]
    while waiting:
        each = waiting.pop()
        if each.open or says_units(each.keys) or _named_inside(each):
            return True
        waiting += [*each.keys.values(), *each.items]
    return False


def _named_inside(node: JsonNode) -> bool:
    """Whether messages may name the elements of a list: inside each, or by texts beside a list of numbers."""
    texts = [key for key, inner in node.keys.items() if inner.text or any(item.text for item in inner.items)]
    if may_list_names(texts) and any(item.number for inner in node.keys.values() for item in inner.items):
        return True
    return any(may_name(item.keys) for item in node.items)


@dataclass(frozen=True)
class FlatTree:
    """Nodes with their paths, parents before children. clashes: paths that two places would share."""

    nodes: tuple[tuple[str, JsonNode], ...]
    fields: tuple[FieldInfo, ...]
    clashes: tuple[str, ...]
    full: bool


def flatten(root: JsonNode) -> FlatTree:
    """All places of a tree in their order, with the fields that they give."""
    nodes: list[tuple[str, JsonNode]] = []
    fields: list[FieldInfo] = []
    taken: set[str] = set()
    clashes: list[str] = []
    waiting: list[tuple[str, JsonNode, str]] = [("", root, "")]
    full = False
    while waiting:
        path, node, element = waiting.pop()
        nodes.append((path, node))
        _take_units(node)
        if path and (node.number or node.text):
            if path in taken:
                clashes.append(path)
                node.number = node.text = False
            elif len(fields) >= MAX_FIELDS:
                full, node.number = True, False
            else:
                taken.add(path)
                kind = "number" if node.number else "text"
                fields.append(FieldInfo(path, kind, node.unit, node.comment, element))
        waiting += reversed([*_inner(path, node, element)])
    return FlatTree(tuple(nodes), tuple(fields), tuple(clashes), full)


def _take_units(node: JsonNode) -> None:
    """Give the numbers of an object the units that its texts state."""
    if not says_units(node.keys):
        return
    texts = _texts(node)
    numbers = [
        key for key, inner in node.keys.items() if inner.number or any(each.number for each in inner.items)
    ]
    for key, unit in units_beside(texts, numbers).items():
        for inner in (node.keys[key], *node.keys[key].items):
            inner.unit = unit


def _inner(path: str, node: JsonNode, element: str) -> Iterable[tuple[str, JsonNode, str]]:
    """What is inside a place, with its path and the name of the list's element that it belongs to. element: the place's own."""
    listed = names_beside({key: _texts_at(inner) for key, inner in node.keys.items()})
    for key, inner in node.keys.items():
        yield (f"{path}.{key}" if path else key), inner, element
        if inner.items and len(listed) <= len(inner.items):
            _name_numbers(inner, listed)
    names = element_names([_texts(item) for item in node.items])
    for index, (inner, name) in enumerate(zip(node.items, names, strict=True)):
        inner.comment, inner.unit = inner.comment or node.comment, inner.unit or node.unit
        yield f"{path}[{index}]", inner, name or inner.name or element


def _name_numbers(node: JsonNode, names: list[str]) -> None:
    """Give the elements of a list of numbers their names."""
    for item, name in zip(node.items, names, strict=False):
        item.name = name if item.number else ""


def _texts(node: JsonNode) -> dict[str, tuple[str, ...]]:
    return {key: inner.texts for key, inner in node.keys.items() if inner.texts}


def _texts_at(node: JsonNode) -> list[tuple[str, ...]]:
    """The texts that messages have at a place, or at each place of a list of texts alone."""
    if node.texts:
        return [node.texts]
    texts = [item.texts for item in node.items]
    count = sum(bool(each) for each in texts)
    return texts[:count] if all(texts[:count]) and not any(item.number for item in node.items) else []
