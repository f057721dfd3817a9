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
from parsers.can.decode import decode_signal, frame_keys, j1939_codes, raw_values, rows_by_slot
from parsers.can.definitions import BitField, SignalDef
from parsers.can.frames import CanFrames
from parsers.importer import ImportLog


def frames_of(payloads: list[bytes], can_id: int = 0x100) -> CanFrames:
    """Frames with these payloads, packed back to back, 10 ms apart."""
    lengths = np.array([len(p) for p in payloads], dtype=np.uint8)
    ends = np.cumsum(lengths.astype(np.int64))
    return CanFrames(
        time_ns=np.arange(len(payloads), dtype=np.int64) * 10_000_000,
        can_id=np.full(len(payloads), can_id, dtype=np.uint32),
        bus=np.ones(len(payloads), dtype=np.int16),
        length=lengths,
        offset=ends - lengths,
        data=np.frombuffer(b"".join(payloads), dtype=np.uint8).copy(),
    )


def decode(payloads: list[bytes], signal: SignalDef, **how: bool) -> list[float]:
    frames = frames_of(payloads)
    rows = np.arange(len(payloads), dtype=np.int64)
    return decode_signal(frames, rows, signal, **how).values.tolist()


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
        rows = np.zeros(1, dtype=np.int64)
        raw, short = raw_values(frames_of([payload]), rows, BitField(start, bits, little))
        assert (int(raw[0]), bool(short[0])) == (expected, False)


def test_floats_of_all_widths() -> None:
    for bits, kind in ((16, np.float16), (32, np.float32), (64, np.float64)):
        values = np.array([0.0, -1.5, 6.25e-4, 65504.0, np.inf], dtype=kind)
        payloads = [b"\x07" + value.tobytes() for value in values]
        got = decode(payloads, SignalDef("s", BitField(8, bits, True), is_float=True))
        assert got == values.astype(float).tolist()
        swapped = [b"\x07" + value.tobytes()[::-1] for value in values]
        assert decode(swapped, SignalDef("s", BitField(15, bits, False), is_float=True)) == got


def test_short_frames_are_nan_and_long_ones_fine() -> None:
    signal = SignalDef("s", BitField(8, 16, True))
    frames = frames_of([b"\x00\x01\x02", b"\x00\x01", b"", b"\x00\x01\x02\xff\xff"])
    got = decode_signal(frames, np.arange(4, dtype=np.int64), signal)
    assert got.short.tolist() == [False, True, True, False]
    assert np.isnan(got.values).tolist() == [False, True, True, False]
    assert got.values[[0, 3]].tolist() == [0x0201, 0x0201]


def test_a_payload_outside_its_buffer_is_short_not_a_crash() -> None:
    frames = frames_of([b"\x01\x02"])
    wild = CanFrames(
        frames.time_ns.repeat(3), frames.can_id.repeat(3), frames.bus.repeat(3), frames.length.repeat(3),
        np.array([1, -1, 2**63 - 1], dtype=np.int64), frames.data,
    )  # fmt: skip
    for little in (True, False):
        _, short = raw_values(wild, np.arange(3, dtype=np.int64), BitField(7, 9, little))
        assert short.all()


def test_j1939_codes_become_nan_and_are_counted_apart() -> None:
    signal = SignalDef("s", BitField(0, 16, True), scale=1 / 256)
    codes = [0xFFFF, 0xFF00, 0xFE80, 0xFB00, 0xFDFF, 0xFAFF, 0]
    frames = frames_of([code.to_bytes(2, "little") for code in codes])
    got = decode_signal(frames, np.arange(len(codes), dtype=np.int64), signal, j1939=True)
    assert np.isnan(got.values).tolist() == [True, True, True, True, True, False, False]
    assert (got.not_available, got.errors, got.reserved) == (2, 1, 2)
    assert got.values[5] == 0xFAFF / 256
    plain = decode_signal(frames, np.arange(len(codes), dtype=np.int64), signal)
    assert not np.isnan(plain.values).any()
    maker = decode_signal(frames, np.arange(len(codes), dtype=np.int64), signal, j1939=True, proprietary=True)
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


def test_rows_by_slot_keeps_the_order_and_leaves_out_the_rest() -> None:
    slot = np.array([1, -1, 0, 1, 5, 1], dtype=np.int64)
    assert [rows.tolist() for rows in rows_by_slot(slot, 3)] == [[2], [0, 3, 5], []]


def test_keys_hold_bus_and_extended_id() -> None:
    frames = frames_of([b""], can_id=0x98FEF1FE)
    assert frame_keys(frames).tolist() == [(1 << 32) | 0x98FEF1FE]


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
    payloads = data.draw(st.lists(st.binary(min_size=size, max_size=size), min_size=1, max_size=8))
    peer = cantools.database.load_string(text, "dbc", strict=False)
    frames = frames_of(payloads)
    loaded = load_database(path, ImportLog())
    assert len(loaded) == len(lines)
    for message in loaded:
        (signal,) = message.signals
        got = decode_signal(frames, np.arange(len(payloads), dtype=np.int64), signal).values
        rows = [peer.decode_message(message.can_id, p, decode_choices=False) for p in payloads]
        want = np.array([float(row[signal.name]) for row in rows])
        if signal.field.length > 53:
            # cantools multiplies whole numbers without bound, float64 rounds once more
            np.testing.assert_allclose(got, want, rtol=1e-15, atol=0)
        else:
            assert got.tolist() == want.tolist()
