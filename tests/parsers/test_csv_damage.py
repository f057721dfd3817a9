"""Damaged text tables cost what is damaged, say when it was, and never crash."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from csv_tables import PLAIN, T, read

from parsers.csv_log import CsvImporter
from parsers.errors import LogError
from parsers.importer import ImportLog, ReadOptions


def test_missing_and_odd_cells(tmp_path: Path) -> None:
    rows = [
        "0,1",
        "1,",
        "2,NaN",
        "3,n/a",
        "4,--",
        "5,-",
        "6,inf",
        "7,-Infinity",
        "8,ERR",
        "9,0x1F",
        "10,null",
        "11,2.5",
        "12,1e999",
    ]
    table = read(
        tmp_path, "t,a\n" + "\n".join(rows) + "\n" + "\n".join(f"{k},3" for k in range(13, 40)) + "\n"
    )
    a = table.columns["a"]
    assert a[0] == 1
    assert np.isnan(a[1:11]).all()
    assert a[11] == 2.5
    assert table.log.rejected == {
        "cell with an infinite value": 2,
        "cell with text where a number was expected": 2,
    }
    assert "'ERR'" in table.said


def test_ragged_rows_are_counted(tmp_path: Path) -> None:
    table = read(tmp_path, "t,a,b\n0,1,2\n1,1,2\n2,1,2\n3,1\n4,1,2,3\n,1,2\nxx,1,2\n5,1,2\nt,a,b\n6,1,2\n")
    assert table.time.tolist() == [0, 10**9, 2 * 10**9, 5 * 10**9, 6 * 10**9]
    assert table.log.rejected == {
        "row with too few columns": 1,
        "row with too many columns": 1,
        "row without a valid time": 3,
        "cell with text where a number was expected": 2,
    }
    assert table.log.status == "complete"


@pytest.mark.parametrize(("lost", "status"), [(9, "complete"), (10, "malformed")])
def test_more_than_a_few_lost_rows_are_damage(tmp_path: Path, lost: int, status: str) -> None:
    rows = [f"{k},1,2" if k % 10 or k >= 10 * lost else f"{k},1" for k in range(200)]
    table = read(tmp_path, "t,a,b\n" + "\n".join(rows) + "\n")
    assert table.log.rejected == {"row with too few columns": lost}
    assert table.log.status == status
    said = f"{lost} of 200 rows could not be read and were left out ({lost} x row with too few columns)"
    assert (said in table.said) == (status == "malformed")


@pytest.mark.parametrize("empty", [",,", " , , ", '"","",""'])
def test_rows_without_anything_are_passed_over(tmp_path: Path, empty: str) -> None:
    rows = "".join(f"{k},1,2\n" for k in range(100))
    table = read(tmp_path, "t,a,b\n" + rows + f"{empty}\n" * 300)
    assert len(table.time) == 100
    assert not table.log.rejected
    assert table.log.status == "complete"


def test_truncated_last_row(tmp_path: Path) -> None:
    table = read(tmp_path, PLAIN + "0.04,5")
    assert table.time.tolist() == T
    assert table.log.status == "truncated"
    assert table.log.rejected == {"row with too few columns": 1}
    assert "4 rows" in table.said


WHOLE = "t,a,b\n" + "".join(f"{k / 10:.1f},{k},{20 + k / 100:.2f}\n" for k in range(200))
CUTS: dict[str, str | bytes] = {
    "decimals": WHOLE[:-4],
    "one decimal": WHOLE[:-2],
    "decimal commas": WHOLE[:-4].replace(",", ";").replace(".", ","),
    "carriage returns": WHOLE[:-4].replace("\n", "\r\n"),
    "old mac": WHOLE[:-4].replace("\n", "\r"),
    "utf-16": WHOLE[:-4].encode("utf-16"),
    "blanks": WHOLE[:-4].replace(",", "  "),
    "quotes": WHOLE.replace(",", '","').replace("\n", '"\n"')[:-6],
    "nothing left of it": WHOLE[:-6],
    "an exponent": "t,b\n" + "".join(f"{k / 10},1.{k:03}e-03\n" for k in range(200))[:-2],
    "the time": "a,t\n" + "".join(f"{k},{k / 10:.3f}\n" for k in range(200))[:-3],
    "a time of day": "a,t\n" + "".join(f"{k},08:10:{k % 60:02}.000\n" for k in range(200))[:-3],
    "separators at each end": WHOLE.replace("\n", ",\n")[:-3],
}


@pytest.mark.parametrize("case", CUTS)
def test_a_cut_within_the_last_cell_costs_its_row(case: str, tmp_path: Path) -> None:
    table = read(tmp_path, CUTS[case])
    assert len(table.time) == table.log.messages == 199
    assert table.log.rejected == {"row cut off at the end of the file": 1}
    assert table.log.status == "truncated"
    assert "199 rows before it are whole" in table.said


def test_a_cut_last_row_that_is_a_block_of_its_own(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text(WHOLE[:-4])
    log = ImportLog()
    reader = CsvImporter().open(path, ReadOptions(), log)
    reader._block_bytes = 8
    assert sum(len(chunk.time_ns) for chunk in reader.read(frozenset("ab"))) == 199
    assert log.status == "truncated"


@pytest.mark.parametrize(
    "text",
    [
        WHOLE[:-1],
        "t,a\n" + "".join(f"{k / 10},{k % 12}\n" for k in range(200))[:-1],
        "t,a,name\n" + "".join(f"{k},1.50,driver\n" for k in range(200)) + "200,1.50,end",
        WHOLE + "# end",
        "t,a\n0,1.50\n1,2",
    ],
    ids=["as long as usual", "others are as short", "a text", "a comment", "too few rows to tell"],
)
def test_a_last_line_without_end_that_may_be_whole_stays(text: str, tmp_path: Path) -> None:
    table = read(tmp_path, text)
    assert len(table.time) in (2, 200, 201)
    assert table.log.status == "complete"
    assert not table.log.rejected
    assert "no line end" in table.said


def test_zeros_in_the_middle(tmp_path: Path) -> None:
    lines = "".join(f"{k / 100},{k}\n" for k in range(1000))
    table = read(tmp_path, ("t,a\n" + lines).encode()[:6000] + bytes(700) + lines.encode()[6700:])
    assert table.log.status == "malformed"
    assert table.log.rejected["row with bytes that are no text"] == 1
    assert len(table.time) > 800


def test_a_tail_of_zeros_is_bounded(tmp_path: Path) -> None:
    table = read(tmp_path, PLAIN.encode() + bytes(13_000_000))
    assert table.time.tolist() == T
    assert table.log.status == "malformed"


ERRORS = {
    "one column": ("t\n1\n2\n3\n", ReadOptions(), "no rows of numbers"),
    "no time column": ("a,b\n1,2\n3,4\n5,6\n", ReadOptions(), r"no time column.*\[time\]"),
    "no header": ("1,2\n3,4\n5,6\n", ReadOptions(), r"no time column.*column_1"),
    "no such column": ("tme,b\n1,2\n3,4\n", ReadOptions(time_channel="time"), r'no column "time".*"tme"'),
    "header only": ("t,a,b\n", ReadOptions(), "no rows of numbers"),
    "prose": ("the quick brown\nfox jumps over the\nlazy dog\n", ReadOptions(), "no rows of numbers"),
    "numbers for iso": (
        "t,a\n1,2\n3,4\n",
        ReadOptions(time_channel="t", time_unit="iso8601"),
        "not ISO 8601",
    ),
    "no unit": ("t,a\n1,2\n3,4\n", ReadOptions(time_channel="t", time_unit="parsec"), "parsec"),
    "dates only": ("date,a\n2014-04-11,2\n2014-04-12,4\n", ReadOptions(), "time of day"),
    "empty": ("", ReadOptions(), "empty"),
    "binary": (b"t,a\n0,1\n" + bytes(range(256)), ReadOptions(), "not text"),
}


@pytest.mark.parametrize("case", ERRORS)
def test_errors_are_one_clear_line(case: str, tmp_path: Path) -> None:
    text, options, message = ERRORS[case]
    path = tmp_path / "log.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(LogError, match=message) as caught:
        CsvImporter().open(path, options, ImportLog())
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_damage_never_escapes_as_a_crash(tmp_path: Path) -> None:
    rng = np.random.default_rng(7)
    whole = ("t [s],a,b\n" + "".join(f"{k / 100},{k},{k * k}\n" for k in range(300))).encode()
    path = tmp_path / "log.csv"
    for cut, noise in itertools.product((0, 5, 9, 50, 1000, 2001), (0, 1, 40)):
        data = bytearray(whole[:cut] if cut else whole)
        for at in rng.integers(0, len(data), noise):
            data[at] = rng.integers(0, 256)
        path.write_bytes(bytes(data))
        log = ImportLog()
        try:
            reader = CsvImporter().open(path, ReadOptions(), log)
            rows = sum(len(chunk.time_ns) for chunk in reader.read(frozenset({"a"})))
        except LogError as error:
            assert str(path) in str(error)  # noqa: PT017
        else:
            assert 0 < rows <= 300


BREAKS = {
    "broken rows": ("garbage\n" * 50, [(990_000_000, 1_500_000_000)]),
    "bytes": ("1.0,\0\0\0\n" * 50, [(990_000_000, 1_500_000_000)]),
    "no times": ("n/a,1,2\n" * 50, [(990_000_000, 1_500_000_000)]),
    "comments": ("# pause\n" * 50, []),
    "nothing": ("", []),
}


@pytest.mark.parametrize("case", BREAKS)
@pytest.mark.parametrize("block_bytes", [200, 8_000_000])
def test_what_damage_takes_in_time_is_written_down(case: str, block_bytes: int, tmp_path: Path) -> None:
    broken, expected = BREAKS[case]
    rows = [f"{k / 100:.2f},{k},7\n" for k in range(300)]
    # a single bad row takes less than a quarter of a second with it
    rows[200] = "2.00,1\n"
    path = tmp_path / "log.csv"
    path.write_text("bad\n" * 3 + "t [s],a,b\n" + "".join(rows[:100]) + broken + "".join(rows[150:]))
    log = ImportLog()
    reader = CsvImporter().open(path, ReadOptions(), log)
    reader._block_bytes = block_bytes
    assert sum(len(chunk.time_ns) for chunk in reader.read(frozenset({"a"}))) == 249
    assert log.lost_spans_ns == expected


@pytest.mark.parametrize("block_bytes", [200, 8_000_000])
@pytest.mark.parametrize("size", [1, 30, 180])
def test_the_time_of_a_short_stretch_of_zeros_is_said(size: int, block_bytes: int, tmp_path: Path) -> None:
    """It takes less than a quarter of a second with it, and nobody knows how many rows it was."""
    whole = ("t [s],a,b\n" + "".join(f"{k / 100:.2f},{k:03},7\n" for k in range(300))).encode()
    begin = whole.index(b"1.00,100") + 6
    path = tmp_path / "log.csv"
    path.write_bytes(whole[:begin] + bytes(size) + whole[begin + size :])
    log = ImportLog()
    reader = CsvImporter().open(path, ReadOptions(), log)
    reader._block_bytes = block_bytes
    chunks = list(reader.read(frozenset({"a"})))
    time = np.concatenate([chunk.time_ns for chunk in chunks])
    k = int(np.argmax(np.diff(time)))
    assert time[k] == 990_000_000
    assert log.lost_spans_ns == [(int(time[k]), int(time[k + 1]))]
    assert log.status == "malformed"


@pytest.mark.parametrize("block_bytes", [200, 8_000_000])
def test_comments_within_the_table_are_counted(block_bytes: int, tmp_path: Path) -> None:
    rows = [f"{k / 100:.2f},{k},7\n" for k in range(300)]
    rows.insert(250, "# pause\n")
    rows.insert(100, "###ERROR###\n")
    path = tmp_path / "log.csv"
    path.write_text("# a head\nt [s],a,b\n" + "".join(rows))
    log = ImportLog()
    reader = CsvImporter().open(path, ReadOptions(), log)
    reader._block_bytes = block_bytes
    assert sum(len(chunk.time_ns) for chunk in reader.read(frozenset({"a"}))) == 300
    assert "2 lines within the table that begin with # were passed over as comments" in log.notes
    assert log.status == "complete"


def test_one_comment_is_one(tmp_path: Path) -> None:
    table = read(tmp_path, PLAIN + "# pause\n" + "0.04,1,2\n")
    assert "1 line within the table that begins with # was passed over as a comment" in table.said


def test_the_list_of_lost_spans_is_bounded(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("t [s],a\n" + "".join(f"{k},1\n{'x' if k >= 4000 else ''}\n" for k in range(6000)))
    log = ImportLog()
    list(CsvImporter().open(path, ReadOptions(), log).read(frozenset({"a"})))
    assert log.lost_spans_ns == [(k * 10**9, (k + 1) * 10**9) for k in range(4000, 5000)]
    assert any("lost" in note for note in log.notes)


@pytest.mark.parametrize("bad", ["00:0m:00", "Time59", "0\u00c0:00:00", "2014-04-11", "1"])
def test_a_damaged_time_of_day_costs_its_row(bad: str, tmp_path: Path) -> None:
    clock = [f"08:00:{k:02}" for k in range(20)]
    clock[7] = bad
    table = read(tmp_path, "Time,a\n" + "".join(f"{text},1\n" for text in clock))
    assert len(table.time) == 19
    assert not table.reader.absolute
    assert table.log.rejected == {"row without a valid time": 1}
    assert table.log.lost_spans_ns == [(28806 * 10**9, 28808 * 10**9)]


@pytest.mark.parametrize("broken", ["0,1", "0,1,2,3,4,5", "0,1\n0.01,1,2,3,4"])
def test_broken_rows_do_not_part_the_header_from_its_table(broken: str, tmp_path: Path) -> None:
    rows = "".join(f"{k / 100 + 1:.2f},{k % 7},{k % 5}\n" for k in range(60))
    table = read(tmp_path, f"time_s,accel_y_mps2,speed_mps\n{broken}\n{rows}")
    assert set(table.columns) == {"accel_y_mps2", "speed_mps"}
    assert len(table.time) == 60
    assert sum(table.log.rejected.values()) == broken.count("\n") + 1
