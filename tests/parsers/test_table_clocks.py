"""Clocks of tables that are coarser than the rows, or that start again at zero."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from csv_tables import read

from parsers.importer import ImportLog
from parsers.table_repeats import RepeatedStamps, repeat_share
from parsers.table_wraps import Counter, StandingDate, turns_of

SECOND = 1_000_000_000
MS = 1_000_000


def table(time: list[str], *columns: list[str], head: str = "time_s,accel_x,speed") -> str:
    rows = zip(time, *columns, strict=True)
    return head + "\n" + "\n".join(",".join(row) for row in rows) + "\n"


def count_from(start: int, rows: int) -> list[str]:
    return [str(start + k) for k in range(rows)]


def test_whole_seconds_of_a_fast_log_are_spread_and_no_row_is_lost(tmp_path: Path) -> None:
    rows = 1000
    time = [str((k + 13) // 50) for k in range(rows)]
    got = read(tmp_path, table(time, count_from(0, rows), count_from(7, rows)))
    assert np.array_equal(got.columns["accel_x"], np.arange(rows))
    assert np.array_equal(got.columns["speed"], np.arange(rows) + 7)
    assert np.abs(got.time - (np.arange(rows) + 13) * 20 * MS).max() <= 1
    assert "coarser than the rows, of which 50 share a stamp" in got.said


def test_rows_of_one_stamp_that_fill_different_columns_are_one_row(tmp_path: Path) -> None:
    text = "time_s,accel_x,speed\n" + "".join(f"{k / 100},{k},\n{k / 100},,{2 * k}\n" for k in range(200))
    got = read(tmp_path, text)
    assert np.array_equal(got.time, np.arange(200) * 10 * MS)
    assert np.array_equal(got.columns["accel_x"], np.arange(200))
    assert np.array_equal(got.columns["speed"], 2 * np.arange(200))
    assert "taken as one row" in got.said


def test_a_clock_that_is_fine_is_left_alone(tmp_path: Path) -> None:
    time = [str(k / 100) for k in range(100)]
    time[40] = time[39]
    got = read(tmp_path, table(time, count_from(0, 100), count_from(0, 100)))
    assert len(got.time) == 100
    assert got.time[40] == got.time[39]
    assert got.said == ""


def test_blocks_give_what_the_whole_gives() -> None:
    rng = np.random.default_rng(3)
    time_ns = np.repeat(np.arange(40) * SECOND, rng.integers(8, 13, 40))
    numbers = rng.normal(size=(2, len(time_ns)))
    log = ImportLog()
    whole = RepeatedStamps(log)
    parts = [whole.take(time_ns.copy(), numbers), whole.finish()]
    expected = np.concatenate([part[0] for part in parts if part is not None])
    assert len(expected) == len(time_ns)
    assert (np.diff(expected) > 0).all()
    pieces = RepeatedStamps(ImportLog())
    found, values = [], []
    for start in range(0, len(time_ns), 97):
        got = pieces.take(time_ns[start : start + 97], numbers[:, start : start + 97])
        found.append(got[0])
        values.append(got[1])
    rest = pieces.finish()
    assert rest is not None
    assert np.array_equal(np.concatenate([*values, rest[1]], axis=1), numbers)
    # the usual number of rows a stamp is that of the first block
    assert np.abs(np.concatenate([*found, rest[0]]) - expected).max() < 0.2 * SECOND


def test_rows_that_are_written_twice_count_once(tmp_path: Path) -> None:
    rows = [k // 2 for k in range(400)]
    got = read(tmp_path, table([f"{k / 40:.3f}" for k in rows], [str(k) for k in rows], ["5" for _ in rows]))
    assert np.array_equal(got.time, np.arange(200) * 25 * MS)
    assert np.array_equal(got.columns["accel_x"], np.arange(200))
    assert got.log.rejected == {"row that repeats the row before, stamp and all": 200}
    assert "coarser" not in got.said


def test_rows_of_a_vehicle_at_rest_are_no_rows_written_twice(tmp_path: Path) -> None:
    time = [str(k // 50) for k in range(1000)]
    got = read(tmp_path, table(time, ["0" for _ in time], ["1" for _ in time]))
    assert len(got.time) == 1000
    assert not got.log.rejected
    assert (np.diff(got.time) > 0).all()


def test_rows_written_twice_in_pieces() -> None:
    time_ns, numbers = np.repeat(np.arange(100) * SECOND, 2), np.repeat(np.arange(100.0), 2)[None, :]
    log = ImportLog()
    pieces = RepeatedStamps(log)
    parts = [pieces.take(time_ns[k : k + 33], numbers[:, k : k + 33]) for k in range(0, 200, 33)]
    kept = [t for t, _ in parts]
    # rows on both sides of a seam have one stamp, of which `timebase` keeps one
    assert np.array_equal(np.unique(np.concatenate(kept)), np.arange(100) * SECOND)


def test_share_of_repeated_cells() -> None:
    assert repeat_share(["1", "1", "2", "2", "", ""]) == pytest.approx(2 / 3)
    assert repeat_share([]) == 0


@pytest.mark.parametrize("bits", [16, 24, 32])
def test_a_counter_runs_on_over_its_end(tmp_path: Path, bits: int) -> None:
    rows, step = 600, 20
    first = 2**bits - 300 * step + 7
    time = [str((first + step * k) % 2**bits) for k in range(rows)]
    got = read(tmp_path, table(time, count_from(0, rows), count_from(0, rows), head="time_ms,accel_x,speed"))
    assert np.array_equal(np.diff(got.time), np.full(rows - 1, step * MS))
    assert "starts again at zero" in got.said


@pytest.mark.parametrize("bits", [16, 32])
def test_a_counter_with_a_sign_runs_on_at_its_negative_end(tmp_path: Path, bits: int) -> None:
    rows, step = 600, 20
    half = 2 ** (bits - 1)
    counted = half - 300 * step + 7 + step * np.arange(rows)
    time = [str(int((c + half) % 2**bits - half)) for c in counted]
    got = read(tmp_path, table(time, count_from(0, rows), count_from(0, rows), head="time_ms,accel_x,speed"))
    assert np.array_equal(np.diff(got.time), np.full(rows - 1, step * MS))
    assert "starts again at its negative end" in got.said


def test_a_counter_that_ends_between_two_blocks() -> None:
    counter = Counter(turns_of(MS), ImportLog())
    raw = (2**16 - 1000 + 20 * np.arange(100)) % 2**16 * MS
    parts = [counter.follow(raw[:50]), counter.follow(raw[50:])]
    assert np.array_equal(np.diff(np.concatenate(parts)), np.full(99, 20 * MS))


@pytest.mark.parametrize("back_to", [0, 30_000])
def test_a_clock_that_was_set_is_no_counter(back_to: int) -> None:
    log = ImportLog()
    counter = Counter(turns_of(MS), log)
    raw = np.concatenate([np.arange(0, 50_000, 20), np.arange(back_to, 40_000, 20)]) * MS
    assert np.array_equal(counter.follow(raw), raw)
    assert log.notes == []


@pytest.mark.parametrize("late", [0, 3, 10_000])
def test_a_date_that_stays_the_same_over_midnight(tmp_path: Path, late: int) -> None:
    """late: rows behind midnight at which the date changes at last."""
    ms = np.arange(0, 4000, 25)
    rows = []
    for k, at in enumerate((86_398_000 + ms).tolist()):
        behind = k - 80
        date = "08/10/2025" if behind >= late else "07/10/2025"
        second = at % 86_400_000 / 1000
        rows.append(f"{date},{int(second // 3600):02d}:{int(second // 60 % 60):02d}:{second % 60:06.3f},{k}")
    got = read(tmp_path, "Date,Time,accel_x\n" + "\n".join(rows) + "\n")
    assert ((got.time - got.time[0]) // MS).tolist() == ms.tolist()
    assert ("over midnight" in got.said) == (late > 0)


def test_a_standing_date_in_pieces() -> None:
    day = 86_400 * SECOND
    true = np.arange(100) * SECOND + day - 50 * SECOND
    written = true % day
    whole, pieces = StandingDate(ImportLog()), StandingDate(ImportLog())
    assert np.array_equal(whole.follow(written), true)
    parts = [pieces.follow(written[k : k + 7]) for k in range(0, 100, 7)]
    assert np.array_equal(np.concatenate(parts), true)
    # a clock that is set back by some hours is none that runs over midnight
    assert np.array_equal(
        StandingDate(ImportLog()).follow(np.array([20, 2]) * 3600 * SECOND), np.array([20, 2]) * 3600 * SECOND
    )
