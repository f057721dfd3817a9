"""Columns that one call fills are those that are filled one by one; what is not plain is left to the other way."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from parsers.allocator import LARGE_PAGE, Slab
from parsers.can.decode import Payloads, decode_signal
from parsers.can.definitions import BitField, SignalDef
from parsers.can.plain import PlainColumns

ROWS = 1000


def payloads(width: int, seed: int) -> Payloads:
    """Payloads of so many words behind those of another message."""
    rng = np.random.default_rng(seed)
    flat = rng.integers(0, 2**64, 7 + ROWS * width, dtype=np.uint64)
    length = np.full(ROWS, 8 * width, np.uint16)
    return Payloads(np.arange(ROWS), length, flat[7:].reshape(-1, width), 8 * width, flat, 7)


def signals(width: int) -> list[SignalDef]:
    rng = np.random.default_rng(width)
    found = []
    for signed in (False, True):
        for little in (False, True):
            for bits in (1, 7, 12, 16, 33, 63):
                word = 64 * int(rng.integers(width))
                start = word + int(rng.integers(65 - bits))
                # counted from the highest bit of the first byte, as big endian fields are
                place = start if little else 8 * (start >> 3) + 7 - (start & 7)
                found.append(
                    SignalDef("s", BitField(place, bits, little), signed=signed, scale=0.25, offset=-3)
                )
    return found


@pytest.mark.parametrize("width", [1, 2, 8])
def test_columns_filled_together_are_those_filled_one_by_one(width: int) -> None:
    slab, given = Slab(4 * LARGE_PAGE), payloads(width, width)
    plain = PlainColumns(slab)
    columns = []
    for signal in signals(width):
        column = slab.empty(ROWS, np.float64)
        column[:] = np.nan
        assert plain.take(given, signal, column, codes=False)
        columns.append(column)
    plain.decode()
    for signal, column in zip(signals(width), columns, strict=True):
        assert column.tolist() == decode_signal(given, signal).values.tolist()


def test_what_is_not_plain_is_not_taken() -> None:
    slab, given = Slab(4 * LARGE_PAGE), payloads(2, 0)
    plain, column = PlainColumns(slab), slab.empty(ROWS, np.float64)
    signal = SignalDef("s", BitField(0, 16, True))
    assert plain.take(given, signal, column, codes=False)
    assert not plain.take(given, signal, column, codes=True)
    assert not plain.take(given, signal, np.empty(ROWS), codes=False)
    assert not plain.take(given, signal, column[::2], codes=False)
    assert not plain.take(given.rows(slice(0, 10)), signal, column[:10], codes=False)
    assert not plain.take(replace(given, shortest=1), signal, column, codes=False)
    for other in (
        SignalDef("s", BitField(60, 8, True)),
        SignalDef("s", BitField(0, 64, True)),
        SignalDef("s", BitField(0, 32, True), is_float=True),
        SignalDef("s", BitField(0, 16, True), invalid=(3,)),
        SignalDef("s", BitField(300, 16, True)),
    ):
        assert not plain.take(given, other, column, codes=False)


def test_a_slab_knows_its_columns() -> None:
    slab, other = Slab(4 * LARGE_PAGE), Slab(4 * LARGE_PAGE)
    first, second = slab.empty(3, np.float64), slab.empty(5, np.float64)
    for column in (first, second):
        at = slab.cell_of(column)
        slab.cells[at : at + column.size] = 7
        assert (column == 7).all()
    assert other.cell_of(first) == -1
    assert Slab(10).cell_of(np.empty(0)) == -1
