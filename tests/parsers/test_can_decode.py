"""Bulk decoding against cantools, frame by frame, and against values worked out by hand."""

from __future__ import annotations

import math
from pathlib import Path

import cantools
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from parsers.can.database import load_database
from parsers.can.decode import Payloads, decode_signal, j1939_codes, raw_values, short
from parsers.can.definitions import BitField, SignalDef
from parsers.importer import ImportLog


def payloads_of(payloads: list[bytes]) -> Payloads:
    """These payloads, 10 ms apart; beyond each one's end is rubbish, as in the decoder's words."""
    width = max(1, -(-max(len(p) for p in payloads) // 8))
    padded = b"".join(p.ljust(8 * width, b"\xa5") for p in payloads)
    return Payloads(
        np.arange(len(payloads), dtype=np.int64) * 10_000_000,
        np.array([len(p) for p in payloads], np.uint16),
        np.frombuffer(padded, "<u8").astype(np.uint64).reshape(-1, width),
        min(len(p) for p in payloads),
    )


def decode(payloads: list[bytes], signal: SignalDef, **how: bool) -> list[float]:
    return decode_signal(payloads_of(payloads), signal, **how).values.tolist()


def test_little_endian_by_hand() -> None:
    signal = SignalDef("s", BitField(12, 12, True), scale=0.5, offset=-10)
    # bits 12-23 of 00 50 12: 0x125
    assert decode([bytes([0x00, 0x50, 0x12])], signal) == [0x125 * 0.5 - 10]


def test_big_endian_by_hand() -> None:
    signal = SignalDef("s", BitField(3, 12, False), signed=True)
    # low nibble of byte 0, then byte 1: 0xF85 is negative in 12 bits
    assert decode([bytes([0xAF, 0x85])], signal) == [0xF85 - 0x1000]


def test_big_endian_within_one_byte() -> None:
    signal = SignalDef("s", BitField(5, 3, False))
    assert decode([bytes([0b0010_1000])], signal) == [0b101]


@pytest.mark.parametrize("little", [True, False])
@pytest.mark.parametrize("bits", [1, 7, 8, 9, 33, 57, 63, 64])
def test_all_lengths_at_all_places(little: bool, bits: int) -> None:
    payload = np.random.default_rng(bits).integers(0, 256, 17, dtype=np.uint8).tobytes()
    for place in range(8 * 17 - bits):
        if little:
            start = place
            expected = (int.from_bytes(payload, "little") >> place) & ((1 << bits) - 1)
        else:
            start = 8 * (place // 8) + 7 - place % 8
            expected = (int.from_bytes(payload, "big") >> (8 * 17 - place - bits)) & ((1 << bits) - 1)
        one = payloads_of([payload])
        field = BitField(start, bits, little)
        assert (int(raw_values(one, field)[0]), bool(short(one, [field])[0])) == (expected, False)
        # the short way of fields in one word
        signed = expected - (1 << bits) if expected >> (bits - 1) else expected
        for is_signed, value in ((False, expected), (True, signed)):
            signal = SignalDef("s", field, signed=is_signed, scale=0.5, offset=3.0)
            assert decode_signal(one, signal).values[0] == float(value) * 0.5 + 3.0


def test_floats_of_all_widths() -> None:
    for bits, kind in ((16, np.float16), (32, np.float32), (64, np.float64)):
        values = np.array([0.0, -1.5, 6.25e-4, 65504.0, np.inf], dtype=kind)
        payloads = [b"\x07" + value.tobytes() for value in values]
        got = decode(payloads, SignalDef("s", BitField(8, bits, True), is_float=True))
        assert got == values.astype(float).tolist()
        swapped = [b"\x07" + value.tobytes()[::-1] for value in values]
        assert decode(swapped, SignalDef("s", BitField(15, bits, False), is_float=True)) == got


@pytest.mark.parametrize("signed", [True, False])
def test_short_frames_are_nan_and_long_ones_fine(signed: bool) -> None:
    signal = SignalDef("s", BitField(8, 16, True), signed=signed)
    payloads = payloads_of([b"\x00\x01\x02", b"\x00\x01", b"", b"\x00\x01\x02\xff\xff"])
    assert short(payloads, [signal.field]).tolist() == [False, True, True, False]
    got = decode_signal(payloads, signal)
    assert np.isnan(got.values).tolist() == [False, True, True, False]
    assert got.values[[0, 3]].tolist() == [0x0201, 0x0201]


def test_a_field_beyond_what_was_kept_is_nan() -> None:
    payloads = payloads_of([bytes(8), bytes(7)])
    for field in (BitField(60, 8, True), BitField(64, 1, True), BitField(600, 8, False)):
        assert np.isnan(decode_signal(payloads, SignalDef("s", field)).values).all()
        assert short(payloads, [field]).all()
        assert raw_values(payloads, field).tolist() == [0, 0]


def test_j1939_codes_become_nan_and_are_counted_apart() -> None:
    signal = SignalDef("s", BitField(0, 16, True), scale=1 / 256)
    codes = [0xFFFF, 0xFF00, 0xFE80, 0xFB00, 0xFDFF, 0xFAFF, 0]
    payloads = payloads_of([code.to_bytes(2, "little") for code in codes])
    got = decode_signal(payloads, signal, j1939=True)
    assert np.isnan(got.values).tolist() == [True, True, True, True, True, False, False]
    assert (got.not_available, got.errors, got.reserved) == (2, 1, 2)
    assert got.values[5] == 0xFAFF / 256
    plain = decode_signal(payloads, signal)
    assert not np.isnan(plain.values).any()
    maker = decode_signal(payloads, signal, j1939=True, proprietary=True)
    assert np.isnan(maker.values).tolist() == [True] + [False] * 6


def test_j1939_codes_by_length() -> None:
    assert j1939_codes(1) == []
    assert j1939_codes(2) == [(3, 3), (2, 2)]
    assert j1939_codes(8) == [(255, 255), (254, 254), (251, 253)]
    assert j1939_codes(10) == [(0x3FF, 0x3FF), (0x3FE, 0x3FE), (0x3FB, 0x3FD)]
    assert j1939_codes(32)[0] == (0xFF000000, 0xFFFFFFFF)


def test_value_table_codes_become_nan() -> None:
    signal = SignalDef("s", BitField(0, 8, True), signed=True, invalid=(0x80,))
    got = decode([b"\x7f", b"\x80", b"\x81"], signal)
    assert (got[0], math.isnan(got[1]), got[2]) == (127, True, -127)


@st.composite
def signal_line(draw: st.DrawFn, index: int, size: int) -> str:
    little = draw(st.booleans())
    bits = draw(st.integers(1, 64))
    place = draw(st.integers(0, 8 * size - bits))
    start = place if little else 8 * (place // 8) + 7 - place % 8
    sign = draw(st.sampled_from("+-"))
    scale = draw(st.sampled_from(["1", "2", "0.5", "0.1", "-0.0625", "1E-3", "0.00390625", "3.7"]))
    offset = draw(st.sampled_from(["0", "-40", "0.25", "-7.8125", "1000000"]))
    return (
        f' SG_ s{index} : {start}|{bits}@{int(little)}{sign} ({scale},{offset}) [0|0] "u{index}" Vector__XXX'
    )


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_equal_to_cantools_for_any_layout(tmp_path: Path, data: st.DataObject) -> None:
    # one message a signal: cantools cannot decode signals that overlap
    size = data.draw(st.sampled_from([8, 12, 64]))
    lines = [data.draw(signal_line(index, size)) for index in range(data.draw(st.integers(1, 5)))]
    messages = [f"BO_ {256 + i} M{i}: {size} X\n{line}\n" for i, line in enumerate(lines)]
    text = 'VERSION ""\n\nBU_:\n\n' + "\n".join(messages)
    path = tmp_path / "any.dbc"
    path.write_text(text)
    drawn = data.draw(st.lists(st.binary(min_size=size, max_size=size), min_size=1, max_size=8))
    peer = cantools.database.load_string(text, "dbc", strict=False)
    payloads = payloads_of(drawn)
    loaded = load_database(path, ImportLog())
    assert len(loaded) == len(lines)
    for message in loaded:
        (signal,) = message.signals
        got = decode_signal(payloads, signal).values
        rows = [peer.decode_message(message.can_id, p, decode_choices=False) for p in drawn]
        want = np.array([float(row[signal.name]) for row in rows])
        if signal.field.length > 53:
            # cantools multiplies whole numbers without bound, float64 rounds once more
            np.testing.assert_allclose(got, want, rtol=1e-15, atol=0)
        else:
            assert got.tolist() == want.tolist()
