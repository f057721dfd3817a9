"""Unsorted MF4 files built by hand: records of several groups in one block, damage among them."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest
from mf4_files import START, TIMES, opened, unsorted, values_of


@pytest.mark.parametrize("id_size", [1, 2, 4, 8])
def test_unsorted_records(tmp_path: Path, id_size: int) -> None:
    reader, log = opened(tmp_path / "a.mf4", unsorted(id_size).build())
    got = values_of(reader)
    assert got["v"] == (TIMES, list(range(100)))
    assert got["w"] == ([t * 1_000_000 for t in range(5, 1000, 30)], [k / 2 for k in range(0, 100, 3)])
    assert log.status == "complete"
    only, _ = opened(tmp_path / "a.mf4", unsorted(id_size).build())
    assert list(values_of(only, "w")) == ["w"]


@pytest.mark.parametrize("id_size", [1, 2])
def test_damaged_records_cost_themselves_only(tmp_path: Path, id_size: int) -> None:
    b = unsorted(id_size)
    kind, links, data = b.blocks["dt"]
    # by threes "v" and one "w"; this is the id of "v" number 24, and then 100 bytes more
    at = 8 * (3 * (10 + id_size) + 12 + id_size)
    b.blocks["dt"] = (kind, links, data[:at] + b"\x77" * 100 + data[at + 100 :])
    reader, log = opened(tmp_path / "a.mf4", b.build())
    got = values_of(reader)["v"]
    lost = 100 - len(got[1])
    assert 6 <= lost <= 8
    assert got[1] == [k for k in range(100) if not 24 <= k < 24 + lost]
    assert got[0] == [int(k) * 10_000_000 for k in got[1]]
    assert log.status == "malformed"
    assert log.rejected == {"damaged place in the MF4 file's records": 1}
    # the record before is "v" number 23; behind it comes "v" or, between, "w"
    assert log.lost_spans_ns[0][0] == START + 230_000_000
    assert START + 290_000_000 < log.lost_spans_ns[0][1] <= START + 330_000_000


def test_a_pause_is_no_damage(tmp_path: Path) -> None:
    b = unsorted(1)
    parts = [bytes([3]) + struct.pack("<QH", k * 10 + (k >= 50) * 9_000_000, k) for k in range(100)]
    b.add("dt", "DT", [], b"".join(parts))
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert values_of(reader)["v"][1] == list(range(100))
    assert log.status == "complete"


def test_damage_ends_the_walk_where_no_stamps_can_tell(tmp_path: Path) -> None:
    b = unsorted(1)
    b.blocks["ms"] = ("CC", b.blocks["ms"][1], struct.pack("<BBHHHdddd", 1, 0, 0, 0, 2, 0.0, 0.0, 0.0, 1e-12))
    kind, links, data = b.blocks["dt"]
    b.blocks["dt"] = (kind, links, data[:368] + b"\x77" + data[369:])
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert values_of(reader)["v"][1] == list(range(24))
    assert log.status == "malformed"
