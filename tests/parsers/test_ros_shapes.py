"""Messages whose shape changes: what the compiled decoder remembers of one message must never be used for another."""

from __future__ import annotations

import math
import struct

import numpy as np
import pytest

from parsers.ros.contract import Decoded, MessageDecoder
from parsers.ros.decoder import make_decoder
from parsers.ros.kernels import MAX_COUNTS, WAYS


def run(decoder: MessageDecoder, payloads: list[bytes], wanted: list[str]) -> Decoded:
    """Decode payloads that follow each other in one buffer; its last byte is the last payload's last."""
    length = np.array([len(payload) for payload in payloads], dtype=np.int64)
    data = np.frombuffer(b"".join(payloads), dtype=np.uint8)
    return decoder.decode(data, np.cumsum(length) - length, length, wanted)


def text(value: bytes, order: str = "<") -> bytes:
    return struct.pack(order + "I", len(value)) + value


@pytest.mark.parametrize("most", [2, 3, 9])
def test_texts_of_one_total_length_but_other_parts(most: int) -> None:
    """All messages are of one size; only the counts tell where the numbers are."""
    rng = np.random.default_rng(most)
    first = rng.integers(0, most + 1, 300)
    values = rng.standard_normal(300)
    payloads = [
        text(b"a" * a) + struct.pack("<d", x) + text(b"b" * (most - a)) + struct.pack("<h", i)
        for i, (a, x) in enumerate(zip(first.tolist(), values.tolist(), strict=True))
    ]
    assert len({len(payload) for payload in payloads}) == 1
    decoded = run(
        make_decoder("p/T", "string a\nfloat64 x\nstring b\nint16 y\n", "ros1"), payloads, ["y", "x"]
    )
    assert decoded.bad == 0
    np.testing.assert_array_equal(decoded.columns["x"], values)
    np.testing.assert_array_equal(decoded.columns["y"], np.arange(300))


def test_sequences_of_one_total_length_leave_what_is_absent_as_nan() -> None:
    decoder = make_decoder("p/T", "float64[] a\nfloat64[] b\ntime stamp\n", "ros1")
    payloads, a, b = [], [], []
    for i in range(60):
        n = i % (WAYS + 3)
        one, two = [float(i)] * n, [float(-i)] * (WAYS + 2 - n)
        payloads.append(
            struct.pack(f"<I{len(one)}d", len(one), *one)
            + struct.pack(f"<I{len(two)}d", len(two), *two)
            + struct.pack("<II", i, 5)
        )
        a.append(one[1] if len(one) > 1 else math.nan)
        b.append(two[2] if len(two) > 2 else math.nan)
    decoded = run(decoder, payloads, ["a[1]", "b[2]"])
    np.testing.assert_array_equal(decoded.columns["a[1]"], a)
    np.testing.assert_array_equal(decoded.columns["b[2]"], b)
    assert decoded.stamp_ns is not None
    assert decoded.stamp_ns.tolist() == [i * 10**9 + 5 for i in range(60)]


@pytest.mark.parametrize("texts", [MAX_COUNTS - 2, MAX_COUNTS - 1, MAX_COUNTS, MAX_COUNTS + 40])
def test_more_counts_than_are_remembered(texts: int) -> None:
    decoder = make_decoder("p/T", "string[] names\nfloat64 x\n", "ros1")
    rng = np.random.default_rng(texts)
    payloads = []
    for i in range(20):
        sizes = np.full(texts, 2)
        sizes[texts - 1], sizes[texts - 2] = 1 + i % 2, 3 - i % 2
        names = b"".join(text(rng.bytes(size)) for size in sizes.tolist())
        payloads.append(struct.pack("<I", texts) + names + struct.pack("<d", 0.5 * i))
    decoded = run(decoder, payloads, ["x"])
    assert decoded.bad == 0
    assert decoded.columns["x"].tolist() == [0.5 * i for i in range(20)]


KINDS = {
    "bool": "B", "int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I",
    "int64": "q", "uint64": "Q", "float32": "f", "float64": "d",
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("order", ["<", ">"])
def test_every_primitive_bit_by_bit(kind: str, order: str) -> None:
    """Random bits and the special ones (infinities, NaN, subnormals, both zeros), as Python's struct reads them."""
    size = struct.calcsize(KINDS[kind])
    rng = np.random.default_rng(size)
    special = [
        0,
        1,
        -1,
        1 << 31,
        0x7F800000,
        0xFF800000,
        0x7FC00000,
        0x007FFFFF,
        0x807FFFFF,
        0x00800000,
        0x3F800000,
    ]
    bits = [value & ((1 << 8 * size) - 1) for value in special]
    raws = [value.to_bytes(size, "little") for value in bits] + [rng.bytes(size) for _ in range(400)]
    head = b"\0\1\0\0" if order == "<" else b"\0\0\0\0"
    decoded = run(make_decoder("p/T", f"{kind} x\n", "cdr"), [head + raw for raw in raws], ["x"])
    expected = np.array([float(struct.unpack(order + KINDS[kind], raw)[0]) for raw in raws])
    assert decoded.bad == 0
    found = decoded.columns["x"]
    np.testing.assert_array_equal(found, expected)
    np.testing.assert_array_equal(np.signbit(found)[~np.isnan(found)], np.signbit(expected)[~np.isnan(found)])


def test_byte_orders_mixed_in_one_topic() -> None:
    """The same size and, as raw bytes, the same counts: only the encapsulation tells the two apart."""
    decoder = make_decoder("p/T", "float32[] a\nuint16 b\nfloat64 x\nbuiltin_interfaces/Time stamp\n", "cdr")
    payloads, values = [], []
    for i in range(40):
        order = "<" if i % 3 else ">"
        body = struct.pack(order + "IHxxdiI", 0, i, 0.25 * i, i, 7)
        if i % 2:
            body = struct.pack(order + "IfHxxxxxxdiI", 1, 2.5, i, 0.25 * i, i, 7)
        payloads.append((b"\0\1\0\0" if order == "<" else b"\0\0\0\0") + body)
        values.append((2.5 if i % 2 else math.nan, float(i), 0.25 * i))
    decoded = run(decoder, payloads, ["a[0]", "b", "x"])
    assert decoded.bad == 0
    np.testing.assert_array_equal(np.transpose(list(decoded.columns.values())), values)
    assert decoded.stamp_ns is not None
    assert decoded.stamp_ns.tolist() == [i * 10**9 + 7 for i in range(40)]


def test_a_damaged_message_between_good_ones_spoils_no_other() -> None:
    decoder = make_decoder("p/T", "string a\nfloat64 x\n", "ros1")
    good = [text(b"abc") + struct.pack("<d", float(i)) for i in range(6)]
    good[2] = text(b"abcd") + struct.pack("<d", 2.0)[:7]  # the same size, one byte short
    good[4] = struct.pack("<I", 2**32 - 1) + good[4][4:]
    decoded = run(decoder, good, ["x"])
    assert decoded.bad == 2
    np.testing.assert_array_equal(decoded.columns["x"], [0, 1, math.nan, 3, math.nan, 5])


def test_nothing_and_no_messages() -> None:
    decoder = make_decoder("p/T", "string a\nfloat64 x\n", "ros1")
    assert run(decoder, [text(b"") + bytes(8)], []).bad == 0
    assert run(decoder, [], ["x"]).columns["x"].shape == (0,)
    assert run(decoder, [b""], ["x", "no such field"]).bad == 1
    assert np.isnan(run(decoder, [text(b"") + bytes(8)], ["no such field"]).columns["no such field"]).all()
