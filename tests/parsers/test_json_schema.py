"""What JSON messages say of their numbers: schemas, units beside them, and stamps."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest

from parsers.json_decode import make_json_decoder, needs_samples, numbers_as_texts
from tests.parsers.json_payloads import decode


def test_schema_gives_fields_units_and_comments() -> None:
    schema = {
        "$defs": {
            "v": {
                "type": "object",
                "properties": {"x": {"type": "number"}, "y": {"$ref": "#/$defs/n"}},
                "additionalProperties": False,
            },
            "n": {"type": ["null", "integer"]},
        },
        "type": "object",
        "properties": {
            "accel": {"$ref": "#/$defs/v", "description": "not looked at"},
            "yaw": {"type": "number", "description": "yaw rate\n[deg/s]"},
            "speed": {"type": "number", "unit": "km/h"},
            "index": {"type": "integer", "description": "which one [1]"},
            "wheels": {"type": "array", "items": {"type": "number"}, "maxItems": 4},
            "pair": {"type": "array", "items": [{"type": "number"}, {"type": "string"}]},
            "any": {"anyOf": [{"type": "null"}, {"type": "number"}]},
            "name": {"type": "string"},
        },
        "unevaluatedProperties": False,
    }
    data = json.dumps(schema).encode()
    assert not needs_samples(data)
    decoder = make_json_decoder(data)
    kinds = {info.path: info.kind for info in decoder.fields}
    assert list(kinds) == [
        "accel.x", "accel.y", "yaw", "speed", "index", *(f"wheels[{k}]" for k in range(4)),
        "pair[0]", "pair[1]", "any", "name",
    ]  # fmt: skip
    assert kinds["name"] == kinds["pair[1]"] == "text"
    units = {info.path: (info.unit, info.comment) for info in decoder.fields}
    assert units["yaw"] == ("deg/s", "yaw rate [deg/s]")
    assert units["speed"][0] == "km/h"
    assert units["index"][0] is None
    decoded = decode(decoder, [b'{"wheels":[1,2,3,4,5],"accel":{"y":2}}'])
    assert decoded.columns["wheels[3]"].tolist() == [4.0]
    assert decoded.columns["accel.y"].tolist() == [2.0]


@pytest.mark.parametrize("more", [True, {"type": "number"}, {}, None])
def test_keys_that_a_schema_allows_and_does_not_name_are_read(more: object) -> None:
    schema: dict[str, object] = {"type": "object", "properties": {"a": {"type": "number"}}}
    schema |= {} if more is None else {"additionalProperties": more}
    data = json.dumps(schema).encode()
    assert needs_samples(data)
    decoder = make_json_decoder(data, [b'{"a": 1, "e": 2, "n": {"x": 3}}'])
    decoded = decode(decoder, [b'{"a": 4, "e": 5, "n": {"x": 6}}'])
    assert [decoded.columns[name].tolist() for name in ("a", "e", "n.x")] == [[4.0], [5.0], [6.0]]


@pytest.mark.parametrize(
    "schema",
    [b"", b"no json", b'{"type":"object"}', b"[]", b'{"$ref":"#/x"}', b'{"$ref":"#"}', b'{"properties":{"a":{}}}',
     b'{"type":"array"}', b'{"properties":{"a":{"type":"array"}}}'],
)  # fmt: skip
def test_schemas_that_leave_it_to_the_messages(schema: bytes) -> None:
    assert needs_samples(schema)
    decoder = make_json_decoder(schema, [b'{"a": {"b": 1}}'])
    assert decode(decoder, [b'{"a": {"b": 2}}']).columns["a.b"].tolist() == [2.0]


def test_recursive_schema_is_bounded() -> None:
    schema = {
        "type": "object",
        "properties": {"v": {"type": "number"}, "l": {"$ref": "#"}, "r": {"$ref": "#"}},
    }
    decoder = make_json_decoder(json.dumps(schema).encode())
    assert len(decoder.fields) <= 2048


def units_of(messages: Sequence[Any], schema: bytes = b"") -> dict[str, str | None]:
    decoder = make_json_decoder(schema, [json.dumps(message).encode() for message in messages])
    return {info.path: info.unit for info in decoder.fields if info.kind == "number"}


@pytest.mark.parametrize(
    ("message", "units"),
    [
        (
            {"speed": {"value": 79.2, "unit": "km/h"}, "yaw": {"value": 1, "at": 2, "units": "deg/s"}},
            {"speed.value": "km/h", "yaw.value": "deg/s", "yaw.at": None},
        ),
        ({"speed": {"kmh": 79.2, "unit": "km/h"}}, {"speed.kmh": "km/h"}),
        ({"speed": 79.2, "speed_unit": "mph", "gear": 3}, {"speed": "mph", "gear": None}),
        ({"accel": {"values": [1, 2], "unit": "g"}}, {"accel.values[0]": "g", "accel.values[1]": "g"}),
        ({"speed": {"value": 1, "unit": "front"}}, {"speed.value": None}),
        ({"a": 1, "b": 2, "unit": "g"}, {"a": None, "b": None}),
    ],
)
def test_units_that_messages_state_beside_their_numbers(message: Any, units: dict[str, str | None]) -> None:
    assert units_of([message, message]) == units
    assert units_of([{}, message]) == units


def test_a_unit_that_changes_is_none_and_a_schema_s_text_is_looked_at() -> None:
    speed = [{"speed": {"value": 1, "unit": unit}} for unit in ("km/h", "mph")]
    assert units_of(speed) == {"speed.value": None}
    number = {
        "type": "object",
        "additionalProperties": False,
        "properties": {"value": {"type": "number"}, "unit": {"type": "string"}},
    }
    schema = json.dumps(number).encode()
    assert needs_samples(schema)
    assert units_of([{"value": 1, "unit": "km/h"}], schema) == {"value": "km/h"}


STAMPS = 1_710_597_922_000_000_000 + np.arange(20, dtype=np.int64) * 20_000_000


@pytest.mark.parametrize(
    ("key", "unit_ns"), [("timestamp", 1e9), ("ts", 1e6), ("Time", 1e3), ("timestamp_ns", 1.0)]
)
@pytest.mark.parametrize(
    "schema",
    [b"", b'{"type": "object", "properties": {"%s": {"type": "number"}}, "additionalProperties": false}'],
)
def test_a_stamp_that_is_one_number(key: str, unit_ns: float, schema: bytes) -> None:
    payloads = [json.dumps({key: at / unit_ns, "x": 1}).encode() for at in STAMPS.tolist()]
    definition = schema.replace(b"%s", key.encode())
    assert needs_samples(definition)
    decoder = make_json_decoder(definition, payloads)
    assert decoder.has_header
    for wanted in (["x"], [key], []):
        decoded = decode(decoder, payloads, wanted)
        assert [*decoded.columns] == wanted
        assert decoded.stamp_ns is not None
        assert np.abs(decoded.stamp_ns - STAMPS).max() < 1000
    late = decode(decoder, [*payloads, b'{"x": 2}', json.dumps({key: 5}).encode()], ["x"])
    assert late.stamp_ns is not None
    assert late.stamp_ns[-2:].tolist() == [0, 0]


@pytest.mark.parametrize("held", [0.02, "2024", True, None, {"a": 1}, 1e30])
def test_a_time_that_is_no_date_is_no_stamp(held: Any) -> None:
    payload = json.dumps({"timestamp": held, "x": 1}).encode()
    assert not make_json_decoder(b"", [payload]).has_header


def test_numbers_in_quotes_are_named() -> None:
    decoder = make_json_decoder(b"", [b'{"speed": "12.5", "id": "7", "name": "a", "x": 1.5}'])
    assert numbers_as_texts(decoder) == ["speed"]
