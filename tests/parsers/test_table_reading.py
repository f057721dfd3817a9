"""The kernel behind CSV and VBO: its quick way and its careful way agree, whatever stands in a table, and however the
file is cut into ranges, pieces and threads."""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import parsers.table_ranges
from parsers.table_lines import DECIMALS, ELAPSED, HHMMSS, MOMENT, TIME_OF_DAY, Clock
from parsers.table_ranges import RangeRows, read_table
from parsers.table_rows import RowBlock, RowCollector, RowCounts, RowPlan, RowRules
from parsers.table_swar import PADDING
from parsers.table_text import Encoding

SECONDS: Clock = (DECIMALS, 0, 1, 10**9, 0)
Outcome = tuple[list[int], list[bytes], list[int], RowCounts, bool, bool, bool]


def joined(blocks: list[RowBlock]) -> tuple[list[int], list[bytes], list[int]]:
    """Stamps, the numbers' bytes column by column, and the gaps of all blocks."""
    rows = 0
    gaps: list[int] = []
    for block in blocks:
        gaps += (block.gaps + rows).tolist()
        rows += len(block.time_ns)
    if not blocks:
        return [], [], []
    numbers = np.concatenate([block.numbers for block in blocks], axis=1)
    # one NaN is as good as another
    numbers[np.isnan(numbers)] = np.nan
    time_ns = np.concatenate([block.time_ns for block in blocks])
    return time_ns.tolist(), [column.tobytes() for column in numbers], gaps


def collect(text: bytes, plan: RowPlan, pieces: int = 1) -> Outcome:
    """All that a collector finds in a text of whole lines (but for the last), given in so many pieces."""
    collector = RowCollector(plan)
    lines = text.splitlines(keepends=True) if b"\r" not in text else [b + b"\n" for b in text.split(b"\n")]
    step = max(1, -(-len(lines) // pieces))
    for k in range(0, len(lines), step):
        part = b"".join(lines[k : k + step])
        buffer = bytearray(part + bytes(PADDING))
        buffer[len(part)] = 10
        if part:
            collector.take(buffer, 0, len(part), len(part), 0)
    found = joined(collector.finish())
    return *found, collector.counts, collector.left_out, collector.last_short, collector.last_kept


NUMBERS = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False).map(repr),
    st.integers(-(10**20), 10**20).map(str),
    st.decimals(-10000, 10000, places=6).map(str),
    st.sampled_from(["0", "-0.0", "+5", "5.", ".5", "1E-003", "1d5", "-1.247217E-02", "+3608.22250787"]),
)
ODD = st.sampled_from(
    [
        *(
            "",
            " ",
            "\t",
            '"',
            '""',
            "nan",
            "NaN",
            "-",
            ".",
            "n/a",
            "inf",
            "-Infinity",
            "x",
            "ERR",
            "e5",
            "1e",
            "--1",
        ),
        *(
            "1.2.3",
            "1,5",
            "1.234,5",
            "1e400",
            "1e-400",
            "9" * 25,
            "0." + "1" * 30,
            "1e99999",
            " 7",
            "7 ",
            "\t7",
            "7\t",
        ),
        *(
            '"7"',
            '" 7"',
            '"7 "',
            '"7"x',
            'x"7"',
            '"a,b;c\td e"',
            '"7',
            "7\r",
            "\r",
            "\r7",
            "\0",
            "7\x01",
            '"\x02"',
        ),
        *(
            "é",
            "\N{MINUS SIGN}7.5",
            "\N{MINUS SIGN}",
            "\x0b7",
            "#",
            "#7",
            "00012",
            "0x10",
            "1_0",
            "12:30",
            "2014-04-11",
            "2014-04-11 08:00:00",
            "235959.99",
            "03:00.5",
            "1 days 00:00:01.5",
        ),
    ]
)
ROW_ENDS = st.sampled_from(
    ["\n"] * 6 + ["\r\n"] * 4 + ["\r\r\n", " \n", " \r\n", "\t\n", "\n\n", "\n#a,b\n", ",\n"]
)


@st.composite
def tables(draw: st.DrawFn) -> tuple[bytes, RowPlan]:
    """A table that was well once, and a plan to read it."""
    spaces = draw(st.booleans())
    separator = " " if spaces else draw(st.sampled_from(",;\t|"))
    width = draw(st.integers(1, 12))
    quote = draw(st.sampled_from([34, 34, -1]))
    comma = draw(st.booleans())
    rules = RowRules(
        ord(separator),
        width,
        draw(st.sampled_from([width, max(1, width - 1)])),
        spaces,
        quote,
        draw(st.sampled_from([35, -1])),
        44 if comma else 46,
        draw(st.sampled_from([-1, 46 if comma else 44])),
        draw(st.sampled_from([False] * 5 + [True])),
    )
    columns = draw(st.permutations(range(width)))
    times = tuple(columns[: draw(st.integers(0, min(2, width)))])
    numbers = tuple(sorted(columns[len(times) : draw(st.integers(len(times), width))]))
    kind = (
        draw(st.sampled_from([DECIMALS, DECIMALS, TIME_OF_DAY, MOMENT, HHMMSS, ELAPSED]))
        if times
        else DECIMALS
    )
    odd = draw(st.integers(0, 6))
    lines = []
    for row in range(draw(st.integers(1, 12))):
        cells = [draw(ODD if draw(st.integers(0, 20)) < odd else NUMBERS) for _ in range(width)]
        if times and draw(st.integers(0, 9)) > 0:
            cells[times[0]] = {TIME_OF_DAY: f"08:00:{row:02}.5", MOMENT: f"2014-04-11T08:00:{row:02}Z"}.get(
                kind, f"{row}.25"
            )
        cells += [draw(NUMBERS)] * draw(st.sampled_from([0] * 9 + [1]))
        cells = cells[: len(cells) - draw(st.sampled_from([0] * 9 + [1, 2]))]
        lines.append(separator.join(cells) + draw(ROW_ENDS))
    text = "".join(lines).encode()
    damage = draw(st.lists(st.tuples(st.integers(0, len(text)), st.integers(0, 255)), max_size=odd))
    mutable = bytearray(text)
    for at, byte in damage:
        mutable[at : at + 1] = bytes([byte])
    return bytes(mutable), RowPlan(rules, numbers, times, (kind, 0, len(times), 10**9, 1))


@settings(max_examples=400, deadline=None)
@given(tables(), st.integers(1, 4))
def test_the_quick_way_equals_the_careful_way(table: tuple[bytes, RowPlan], pieces: int) -> None:
    text, plan = table
    careful = RowPlan(plan.rules, plan.numbers, plan.times, plan.clock, with_care=True)
    expected = collect(text, careful)
    assert collect(text, plan) == expected
    assert collect(text, plan, pieces)[:3] == expected[:3]


@pytest.mark.parametrize("cell", ["1e", "1d", "1e ", "1e+", "1d- s", "e", "1 e", "1 "])
def test_what_looks_like_the_beginning_of_an_exponent_or_a_unit_is_read_safely(cell: str) -> None:
    text = f"0.5,1\n{cell},2\n1.5,3\n".encode()
    quick, careful = (
        RowPlan(RowRules(ord(","), 2, 2, spaces=False), (1,), (0,), (0, 0, 1, 10**9, 1), with_care=care)
        for care in (False, True)
    )
    assert collect(text, quick) == collect(text, careful)


@settings(max_examples=300, deadline=None)
@given(st.lists(st.lists(NUMBERS, min_size=3, max_size=3), min_size=1, max_size=30), st.sampled_from(",; "))
def test_numbers_equal_pythons_to_the_last_bit(rows: list[list[str]], separator: str) -> None:
    text = "".join(separator.join(row) + "\n" for row in rows).encode()
    plan = RowPlan(RowRules(ord(separator), 3, 3, spaces=separator == " "), (0, 1, 2))
    _, columns, gaps, counts, *_ = collect(text, plan)
    expected = [[float(row[k].replace("d", "e")) for row in rows] for k in range(3)]
    assert columns == [np.array(column).tobytes() for column in expected]
    assert not gaps
    assert counts == RowCounts()


def test_random_digits_equal_pythons() -> None:
    rng = random.Random(3)
    cells = []
    for _ in range(40_000):
        whole, part = rng.randrange(0, 20), rng.randrange(0, 20)
        digits = (
            "".join(rng.choices("0123456789", k=whole)) + "." + "".join(rng.choices("0123456789", k=part))
        )
        power = f"e{rng.randrange(-330, 330)}" if rng.random() < 0.2 else ""
        cells.append(rng.choice(["", "-", "+"]) + (digits if whole + part else "0") + power)
    ended = "".join(f"{cell},{k}\n" for k, cell in enumerate(cells)).encode()
    _, (column, count), _, counts, *_ = collect(ended, RowPlan(RowRules(44, 2, 2), (0, 1)))
    expected = np.array([float(cell) for cell in cells])
    # what is beyond a double's range is infinite for Python too, and the same bytes
    assert column == expected.tobytes()
    assert count == np.arange(len(cells), dtype=np.float64).tobytes()
    assert counts == RowCounts()


def whole(parts: list[RangeRows]) -> tuple[object, ...]:
    """What all ranges of a file held, without where one ends and the next begins."""
    blocks = [block for part in parts for block in part.blocks]
    time_ns, numbers, _ = joined(blocks)
    names = ("too_few", "too_many", "binary", "no_time", "text_cells", "infinite_cells")
    counts = [sum(getattr(part.counts, name) for part in parts) for name in names]
    # a gap at a range's seam is said by `left_out` of the range before, so only the bad lines' places are compared
    seams, rows, left_out = set(), 0, False
    for part in parts:
        for block in part.blocks:
            seams |= {rows + gap for gap in block.gaps.tolist()} | ({rows} if left_out else set())
            rows, left_out = rows + len(block.time_ns), False
        left_out |= part.left_out
    return time_ns, numbers, counts, seams, any(part.ends_open for part in parts)


def noisy_table(rows: int, seed: int) -> bytes:
    rng = random.Random(seed)
    lines = [f"{k / 100:.2f},{rng.gauss(0, 1):.6f},{rng.randrange(99)},{rng.random()!r}" for k in range(rows)]
    for _ in range(rows // 20):
        lines[rng.randrange(rows)] = rng.choice(
            ["", "#x", "1,2", "a,b,c,d", "1,2,3,4,5", "7\0,1,2,3", "x" * 300]
        )
    return "\n".join(lines).encode()


@pytest.mark.parametrize("block_bytes", [1, 7, 100, 5000, 10**7])
@pytest.mark.parametrize("ending", [b"", b"\n", b"\r\n\n", b"\n1,2", b"\n\n\0\0\0"])
def test_ranges_and_threads_change_nothing(
    block_bytes: int, ending: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = b"\xef\xbb\xbft,a,b,c\n" + noisy_table(100 if block_bytes < 100 else 2000, 1) + ending
    path = tmp_path / "log.csv"
    path.write_bytes(text)
    plan = RowPlan(RowRules(44, 4, 4), (1, 2, 3), (0,), SECONDS)
    expected = whole(list(read_table(path, Encoding("utf-8", 3), 8, len(text), plan, block_bytes=10**8)))
    monkeypatch.setattr(parsers.table_ranges, "PIECE_BYTES", 300)
    for workers in (1, 2):
        parts = list(
            read_table(
                path, Encoding("utf-8", 3), 8, len(text), plan, block_bytes=block_bytes, workers=workers
            )
        )
        assert whole(parts) == expected
        assert [part.done for part in parts] == sorted(part.done for part in parts)


def test_wide_text_gives_the_same(tmp_path: Path) -> None:
    body = noisy_table(3000, 2).replace(b"\0", b"\1").decode()
    plan = RowPlan(RowRules(44, 4, 4), (1, 2, 3), (0,), SECONDS)
    path = tmp_path / "log.csv"
    path.write_bytes(body.encode())
    expected = whole(list(read_table(path, Encoding("utf-8"), 0, len(body), plan)))
    path.write_bytes(body.encode("utf-16"))
    for workers in (1, 2):
        parts = read_table(
            path, Encoding("utf-16-le", 2), 0, 2 * len(body) + 2, plan, block_bytes=4001, workers=workers
        )
        assert whole(list(parts)) == expected


def test_a_line_without_end_is_lost_alone(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    endless = b"7" * 9_000_000
    text = b"1,2\n2,3\n" + endless + b"\n3,4\n" + bytes(5_000_000) + b"\n4,5\n"
    path.write_bytes(text)
    plan = RowPlan(RowRules(44, 2, 2), (1,), (0,), SECONDS)
    for block_bytes in (1_000_000, 4_500_000, 10**8):
        parts = list(read_table(path, Encoding("utf-8"), 0, len(text), plan, block_bytes=block_bytes))
        time_ns, _, counts, seams, ends_open = whole(parts)
        assert time_ns == [10**9, 2 * 10**9, 3 * 10**9, 4 * 10**9]
        assert counts == [0, 0, 2, 0, 0, 0]
        assert seams == {2, 3}
        assert not ends_open


def test_long_cells_and_many_columns(tmp_path: Path) -> None:
    long = "0." + "1" * 100_000
    rows = [
        ",".join([str(k), *(f"{k}.{c}" for c in range(498)), long if k % 7 == 0 else "5"]) for k in range(60)
    ]
    text = "\n".join(rows).encode()
    path = tmp_path / "log.csv"
    path.write_bytes(text)
    plan = RowPlan(RowRules(44, 500, 500), tuple(range(1, 500)), (0,), SECONDS)
    parts = list(read_table(path, Encoding("utf-8"), 0, len(text), plan, block_bytes=150_000, workers=2))
    numbers = np.concatenate([block.numbers for part in parts for block in part.blocks], axis=1)
    expected = np.array([[float(cell) for cell in row.split(",")[1:]] for row in rows]).T
    np.testing.assert_array_equal(numbers, expected)


def test_many_hard_numbers_are_all_read() -> None:
    text = b"1e-400,1e400\n" * 20_000
    _, (small, large), *_ = collect(text, RowPlan(RowRules(44, 2, 2), (0, 1)))
    assert small == np.zeros(20_000).tobytes()
    assert large == np.full(20_000, np.inf).tobytes()


def test_a_hard_number_in_a_row_without_time_is_not_put_into_the_next_row() -> None:
    text = b"x,1e-400,1e-400\n1,2,1e400\nx,1e-400,7\n2,3,4\n"
    time_ns, (a, b), *_ = collect(text, RowPlan(RowRules(44, 3, 3), (1, 2), (0,), SECONDS))
    assert time_ns == [10**9, 2 * 10**9]
    assert a == np.array([2.0, 3.0]).tobytes()
    assert b == np.array([np.inf, 4.0]).tobytes()


def test_only_quotes_tell_a_decimal_comma_from_a_separator() -> None:
    text = b'1,2,3\n"1,5","2,5",3\n"1,5",2\n'
    _, (a, b, c), *_ = collect(text, RowPlan(RowRules(44, 3, 2, decimal=44), (0, 1, 2)))
    assert a == np.array([1.0, 1.5, 1.5]).tobytes()
    assert b == np.array([2.0, 2.5, 2.0]).tobytes()
    assert c == np.array([3.0, 3.0, np.nan]).tobytes()


@pytest.mark.parametrize("wanted", [(), (0,), (9,), (0, 9), (3, 4), (1, 5, 8), tuple(range(10))])
def test_unwanted_columns_are_skipped_by_count(wanted: tuple[int, ...]) -> None:
    """Words, quotes and rows of another width where nobody looks, in cells of 0 to 11 characters."""
    rng = random.Random(5)
    rows = []
    for k in range(400):
        cells = [
            f"{k * 10 + c}"[: rng.randrange(1, 5)] if c in wanted else "x" * rng.randrange(12)
            for c in range(10)
        ]
        free = [c for c in range(10) if c not in wanted]
        if free and k % 5 == 0:
            cells[rng.choice(free)] = rng.choice(['"a,b"', '"', 'x"y', "é" * 9, ' "a,b,c"'])
        rows.append(cells[: 10 + rng.choice([0] * 20 + [-1])] + ["1"] * rng.choice([0] * 20 + [1]))
    text = "".join(",".join(cells) + "\n" for cells in rows).encode()
    rules = RowRules(44, 10, 10)
    found = collect(text, RowPlan(rules, wanted))
    assert found == collect(text, RowPlan(rules, wanted, with_care=True))
    if len(wanted) == 10:
        kept = [[float(cell) for cell in cells] for cells in rows if len(cells) == 10]
        assert found[1] == [np.array(column).tobytes() for column in zip(*kept, strict=True)]
