"""Protobuf payloads: every value equals what the protobuf library reads, and damaged ones never crash."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from google.protobuf.message import DecodeError
from hypothesis import given, settings
from hypothesis import strategies as st
from protobuf_files import build, check_same, decode, peer_value, scalars_file

from parsers.protobuf_decode import ProtobufDecoder
from parsers.ros.contract import Decoded

EXTREMES = {
    "double": [0.1, -1e300, math.inf],
    "float": [0.5, -3.25, 1e30],
    "int64": [-(2**63), 2**53 - 1, -1],
    "uint64": [2**63, 1, 2**53 - 1],
    "int32": [-(2**31), 2**31 - 1, -1],
    "fixed64": [2**63, 5, 0],
    "fixed32": [2**32 - 1, 7, 0],
    "bool": [True, False, True],
    "uint32": [2**32 - 1, 127, 128],
    "sfixed32": [-(2**31), 2**31 - 1, -1],
    "sfixed64": [-(2**53), 2**53 - 1, -1],
    "sint32": [-(2**31), 2**31 - 1, -1],
    "sint64": [-(2**53), 2**53 - 1, -1],
}


@pytest.fixture(scope="module")
def root() -> tuple[ProtobufDecoder, Any]:
    return build(scalars_file(), "t.Root")


def full_messages(peer: Any) -> list[Any]:
    messages = []
    for i in range(40):
        m = peer()
        for name, values in EXTREMES.items():
            setattr(m, f"f_{name}", values[i % 3])
            getattr(m, f"p_{name}").extend((values * 4)[: i % 12])
            getattr(m, f"u_{name}").extend((values * 4)[: (i + 5) % 12])
        m.timestamp.seconds, m.timestamp.nanos = 1_700_000_000 + i, 123_456_789
        m.kind = (0, -3, 70000)[i % 3]
        if i % 2:
            m.inner.x = i / 7
        if i % 3:
            m.inner.many.extend([1.5, -2.5])
        for k in range(i % 10):
            item = m.items.add(x=k + 0.25, y=-k)
            item.many.extend([k] * k)
        m.note = "text" * i
        if i % 4 == 1:
            m.one_a = i
        elif i % 4 == 2:
            m.one_b.y = i
        elif i % 4 == 3:
            m.one_text = "t"
        if i % 5:
            m.maybe = i % 3
        m.again.f_double = 5.0
        messages.append(m)
    return [*messages, peer()]


def test_every_value_equals_the_library(root: tuple[ProtobufDecoder, Any]) -> None:
    decoder, peer = root
    messages = full_messages(peer)
    decoded = decode(decoder, [m.SerializeToString() for m in messages])
    assert decoded.bad == 0
    assert len(decoded.columns) > 250
    check_same(decoded, messages)
    assert decoded.stamp_ns is not None
    assert decoded.stamp_ns.tolist() == [(1_700_000_000 + i) * 10**9 + 123_456_789 for i in range(40)] + [0]


def test_only_wanted_columns_with_same_values(root: tuple[ProtobufDecoder, Any]) -> None:
    decoder, peer = root
    messages = full_messages(peer)
    wanted = ["items[2].many[1]", "one_a", "p_double[3]", "no.such", "inner.x", "items[0].y"]
    decoded = decode(decoder, [m.SerializeToString() for m in messages], wanted)
    assert list(decoded.columns) == wanted
    assert np.isnan(decoded.columns["no.such"]).all()
    check_same(Decoded({k: v for k, v in decoded.columns.items() if k != "no.such"}, None, 0), messages)


def test_repeated_occurrences_merge_and_the_last_wins(root: tuple[ProtobufDecoder, Any]) -> None:
    decoder, peer = root
    first = peer(
        f_double=1.0, inner={"x": 1.0, "many": [1, 2]}, one_b={"x": 3.0, "many": [9]}, items=[{"x": 1}]
    )
    second = peer(f_double=2.0, inner={"y": 5, "many": [3]}, one_a=4.0, items=[{"y": 2}])
    third = peer(one_b={"y": 6, "many": [8]}, p_int32=[1], u_int32=[2])
    fourth = peer(one_text="x")
    parts = [m.SerializeToString() for m in (first, second, third, fourth)]
    payloads = [b"".join(parts[:k]) for k in range(1, 5)] + [parts[0] + parts[2], parts[2] + parts[2]]
    messages = [peer.FromString(p) for p in payloads]
    decoded = decode(decoder, payloads)
    check_same(decoded, messages)
    assert decoded.bad == 0
    assert (decoded.columns["f_double"][1], decoded.columns["inner.x"][1]) == (2.0, 1.0)


def test_unknown_fields_groups_and_wrong_wire_types_are_skipped(root: tuple[ProtobufDecoder, Any]) -> None:
    decoder, peer = root
    value = peer(f_double=2.5).SerializeToString()
    group = b"\xfb\x3e" + b"\x08\x01" + b"\x13\x14" + b"\xfc\x3e"
    unknown = b"\xf8\x3e\x05" + b"\xf9\x3e" + bytes(8) + b"\xfd\x3e" + bytes(4) + b"\xfa\x3e\x02ab" + group
    wrong = b"\x08\x05"  # field 1 is a double, here a varint
    payloads = [unknown + value, value + unknown, value + wrong]
    decoded = decode(decoder, payloads, ["f_double"])
    assert decoded.bad == 0
    assert decoded.columns["f_double"].tolist() == [2.5] * 3


@pytest.mark.parametrize(
    "damaged",
    [
        b"\x08",
        b"\x09\x00",
        b"\x00\x01",
        b"\x0c",
        b"\xb2\x01\xff\xff\xff\xff\x0f",
        b"\xb2\x01\x05\x09",
        b"\xff" * 12,
        b"\xfb\x3e\x08\x01",
        b"\x0f\x00",
    ],
)
def test_damaged_payloads_are_counted_and_leave_the_others(
    root: tuple[ProtobufDecoder, Any], damaged: bytes
) -> None:
    decoder, peer = root
    with pytest.raises(DecodeError):
        peer.FromString(damaged)
    good = peer(f_double=1.0, timestamp={"seconds": 5}).SerializeToString()
    decoded = decode(decoder, [good, good + damaged, good])
    assert decoded.bad == 1
    np.testing.assert_array_equal(decoded.columns["f_double"], [1.0, math.nan, 1.0])
    assert decoded.stamp_ns is not None
    assert decoded.stamp_ns.tolist() == [5 * 10**9, 0, 5 * 10**9]


def test_fields_of_a_type_that_holds_itself(root: tuple[ProtobufDecoder, Any]) -> None:
    paths = [info.path for info in root[0].fields]
    assert "again.f_double" not in paths
    assert ("note", "text") in [(info.path, info.kind) for info in root[0].fields]
    assert len(paths) == len(set(paths))


@settings(max_examples=150, deadline=None)
@given(st.lists(st.binary(max_size=80), min_size=1, max_size=4))
def test_random_bytes_never_crash_and_agree_with_the_library(payloads: list[bytes]) -> None:
    decoder, peer = _CACHED
    decoded = decode(decoder, payloads)
    messages = []
    for payload in payloads:
        try:
            messages.append(peer.FromString(payload))
        except DecodeError:
            messages.append(None)
    # inner texts and unknown messages are not looked into here, so that the library may refuse more
    assert decoded.bad <= sum(m is None for m in messages)
    for i, m in enumerate(messages):
        if m is not None:
            for path, column in decoded.columns.items():
                np.testing.assert_equal(column[i], peer_value(m, path), err_msg=path)


@settings(max_examples=150, deadline=None)
@given(st.integers(0, 40), st.integers(0, 4000), st.binary(min_size=1, max_size=6))
def test_overwritten_bytes_never_crash(which: int, at: int, new: bytes) -> None:
    decoder, peer = _CACHED
    payload = bytearray(full_messages(peer)[which].SerializeToString())
    at = at % (len(payload) + 1)
    payload[at : at + len(new)] = new
    decoded = decode(decoder, [bytes(payload)])
    assert all(column.shape == (1,) for column in decoded.columns.values())


def test_offsets_outside_of_the_data_are_bad_not_read(root: tuple[ProtobufDecoder, Any]) -> None:
    data = np.zeros(4, dtype=np.uint8)
    offset, length = np.array([-1, 0, 2, 5]), np.array([2, 2**62, 3, 0])
    assert root[0].decode(data, offset, length, ["f_double"]).bad == 4


_CACHED = build(scalars_file(), "t.Root")


def test_any_mix_of_messages_equals_each_alone(root: tuple[ProtobufDecoder, Any]) -> None:
    """What was learnt from one message must not show in the next one."""
    decoder, peer = root
    messages = full_messages(peer)
    order = np.random.default_rng(8).integers(0, len(messages), 300)
    payloads = [m.SerializeToString() for m in messages]
    alone = [decode(decoder, [payload]) for payload in payloads]
    mixed = decode(decoder, [payloads[k] for k in order])
    for path, column in mixed.columns.items():
        np.testing.assert_array_equal(column, [alone[k].columns[path][0] for k in order], err_msg=path)
    assert mixed.stamp_ns is not None
    stamps = [each.stamp_ns for each in alone]
    assert mixed.stamp_ns.tolist() == [int(stamps[k][0]) for k in order if stamps[k] is not None]
