"""MCAP records: the walk over any bytes stays inside them, and the picker finds what the walk finds."""

from __future__ import annotations

import struct

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from parsers.mcap_pick import Picker, slot_table
from parsers.mcap_records import Walker, find_messages

Lying = tuple[int, bytes, int]
"""A record: its opcode, its content, and by how much its stated length is wrong."""
RECORDS = st.lists(st.tuples(st.integers(0, 255), st.binary(max_size=40), st.integers(-2, 2)), max_size=20)


def framed(records: list[Lying]) -> np.ndarray:
    """The bytes of the records, one behind the other."""
    raw = b"".join(
        bytes([op]) + struct.pack("<Q", max(0, len(body) + lie)) + body for op, body, lie in records
    )
    return np.frombuffer(bytearray(raw), dtype=np.uint8)


@settings(max_examples=300, deadline=None)
@given(RECORDS)
def test_walker_stays_inside(records: list[Lying]) -> None:
    data = framed(records)
    walker = Walker()
    total = 0
    for found in walker.walk(data):
        assert (found.offset >= 9).all()
        assert (found.offset + found.length <= data.size).all()
        messages, short = find_messages(data, found)
        assert messages.channel.size + short == (found.opcode == 5).sum()
        assert (messages.channel >= 0).all()
        total += found.opcode.size
    assert 0 <= walker.at <= data.size
    if all(op not in (0, 15) and lie == 0 for op, _, lie in records):
        assert total == len(records)


@settings(max_examples=200, deadline=None)
@given(RECORDS)
def test_picker_agrees_with_the_walker(records: list[Lying]) -> None:
    data = framed(records)
    walker = Walker()
    found = [find_messages(data, part) for part in walker.walk(data)]
    picker = Picker(slot_table([(0, 5), (2, 1), tuple(range(10, 1 << 16))]), 3)
    at, state, short = picker.walk(data, 0, data.size)
    assert (at, state, short) == (walker.at, walker.state, sum(part[1] for part in found))
    picks = {part.number: part for part in picker.take()}
    for number, ids in enumerate([[0, 5], [1, 2], range(10, 1 << 16)]):
        rows = [np.isin(part.channel, ids) for part, _ in found]
        offset = np.concatenate([part.offset[row] for (part, _), row in zip(found, rows, strict=True)])
        log_ns = np.concatenate([part.log_ns[row] for (part, _), row in zip(found, rows, strict=True)])
        got = picks.get(number)
        assert offset.tolist() == ([] if got is None else got.offset.tolist())
        assert log_ns.tolist() == ([] if got is None else got.log_ns.tolist())
