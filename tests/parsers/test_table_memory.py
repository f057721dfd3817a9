"""The kernel behind CSV and VBO: how much memory a table takes while it is read."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

from parsers.table_lines import DECIMALS, Clock
from parsers.table_ranges import read_table
from parsers.table_rows import RowCollector, RowPlan, RowRules
from parsers.table_swar import PADDING
from parsers.table_text import Encoding

SECONDS: Clock = (DECIMALS, 0, 1, 10**9, 0)


def test_room_is_made_by_what_can_be_there() -> None:
    """Blank lines promise rows that never come: no room is made for them beyond what the bytes could hold."""
    collector = RowCollector(RowPlan(RowRules(44, 1000, 1000), tuple(range(1000))))
    text = bytearray(b"\n" * 200_000 + bytes(PADDING))
    tracemalloc.start()
    collector.take(text, 0, 200_000, 200_000, 8_000_000)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 80_000_000
    assert collector.finish() == []


def test_memory_does_not_grow_with_the_file(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    text = b"".join(b"%d.5,1.25,-3.75,8\n" % k for k in range(20_000))
    with path.open("wb") as file:
        for _ in range(40):
            file.write(text)
    plan = RowPlan(RowRules(44, 4, 4), (1, 2, 3), (0,), SECONDS)
    size = path.stat().st_size
    peaks = []
    # half of it has blocks enough for as many to be under way at once as ever are
    for part_of in (2, 1):
        tracemalloc.start()
        rows = sum(
            part.rows
            for part in read_table(path, Encoding("utf-8"), 0, size // part_of, plan, block_bytes=500_000)
        )
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert rows == 800_000
    assert peaks[1] < 1.5 * peaks[0]
    assert peaks[1] < 8_000_000
