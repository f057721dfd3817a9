"""Sorted MF4 records with a block of zeros among them, as a disk leaves it: no samples of nought at the clock's zero."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from mf4_files import START, Builder, bus_builder, frames_of, opened, values_of

from parsers.mf4.zeros import REASON

COUNT, RECORD = 200, 16
MS = 1_000_000


def measured(values: list[float], *, double: bool = False) -> Builder:
    """One channel, every 10 ms."""
    b = Builder()
    b.header("dg")
    b.data_group("dg", "cg", "dt")
    b.group("cg", "t", RECORD, cycles=len(values))
    rule = "" if double else b.rule("ms", 1, [0.0, 0.001])
    b.channel("t", 0, 64, kind=2, data_type=4 if double else 0, rule=rule, after="v")
    b.channel("v", 8, 64, data_type=4)
    rows = [
        struct.pack("<dd", 0.01 * k, v) if double else struct.pack("<Qd", 10 * k, v)
        for k, v in enumerate(values)
    ]
    b.add("dt", "DT", [], b"".join(rows))
    return b


def zeroed(b: Builder, begin: int, end: int) -> bytes:
    kind, links, data = b.blocks["dt"]
    b.blocks["dt"] = (kind, links, data[:begin] + bytes(end - begin) + data[end:])
    return b.build()


@pytest.mark.parametrize("double", [False, True])
@pytest.mark.parametrize(("begin", "end"), [(80 * RECORD, 90 * RECORD), (80 * RECORD - 5, 90 * RECORD + 9)])
def test_a_zeroed_block_is_no_samples_and_is_told(tmp_path: Path, double: bool, begin: int, end: int) -> None:
    """Records that are zeroed in part are left out with it: the one before and the one behind."""
    values = [500.0 + k for k in range(COUNT)]
    reader, log = opened(tmp_path / "a.mf4", zeroed(measured(values, double=double), begin, end))
    time_ns, got = values_of(reader, "v")["v"]
    kept = [k for k in range(COUNT) if not 79 <= k <= 90]
    assert got == [values[k] for k in kept]
    np.testing.assert_allclose(time_ns, [10 * MS * k for k in kept], atol=1)
    assert log.status == "malformed"
    assert log.rejected[REASON] == 12
    assert log.lost_spans_ns == [(START + 780 * MS, START + 910 * MS)]
    assert any("block of it was lost" in note for note in log.notes)


def test_zeros_that_the_log_begins_with_are_samples(tmp_path: Path) -> None:
    values = [0.0] * 5 + [1.0] * 20 + [0.0] * 5
    reader, log = opened(tmp_path / "a.mf4", measured(values).build())
    assert values_of(reader, "v")["v"][1] == values
    assert log.status == "complete"


def test_a_clock_that_stands_still_loses_nothing_here(tmp_path: Path) -> None:
    b = measured([0.0] * 50)
    kind, links, data = b.blocks["dt"]
    b.blocks["dt"] = (kind, links, bytes(len(data)))
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert len(values_of(reader, "v")["v"][1]) == 50
    assert log.status == "complete"


@pytest.mark.parametrize(("kind", "size"), [("fixed", 78), ("blocks", 22)])
def test_frames_beside_a_zeroed_block(tmp_path: Path, kind: str, size: int) -> None:
    whole, _ = opened(tmp_path / "a.mf4", bus_builder(kind).build())
    frames = frames_of(whole)
    reader, log = opened(tmp_path / "b.mf4", zeroed(bus_builder(kind), 4 * size, 6 * size))
    assert frames_of(reader) == [*frames[:3], *frames[7:]]
    assert log.status == "malformed"
    assert dict(log.rejected) == {REASON: 4}
    assert log.lost_spans_ns == [(START + frames[2][0], START + frames[7][0])]
