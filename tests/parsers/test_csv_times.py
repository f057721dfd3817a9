"""Times in text tables: numbers, dates and times of day in any unit, without loss."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from csv_tables import read
from csv_time_cases import TIMES
from hypothesis import given, settings
from hypothesis import strategies as st

from parsers.channels import ByteArray
from parsers.csv_log import CsvImporter
from parsers.errors import LogError
from parsers.importer import ImportLog, ReadOptions
from parsers.jit import kernel
from parsers.parquet_log import ParquetImporter
from parsers.table_bytes import address_of
from parsers.table_calendar import calendar_stamp
from parsers.table_guess import guess_unit
from parsers.table_stamps import decimal_stamp, unwrap_days


@pytest.mark.parametrize("case", TIMES)
def test_times(case: str, tmp_path: Path) -> None:
    text, options, expected = TIMES[case]
    table = read(tmp_path, text, options)
    assert table.time.tolist() == expected
    assert table.reader.absolute == (expected[0] > 10**18)
    if "epoch" in case:
        assert "states no unit" in table.said
    if case == "zone that means several":
        assert "has no one meaning (CST)" in table.said
    assert ("UTC, up to" in table.said) == (not table.log.zone_known)
    if case.startswith("zone") or case == "the shell's date":
        assert table.log.zone_known == (case != "zone that means several")
    if case == "iso blank":
        assert "no time zone" in table.said
    if case in ("rostopic", "stamp pair", "bare pair"):
        assert table.reader.clock.startswith("header stamp")


MONTH_NAMES = [
    ("January", "Januar", "janvier"), ("Feb", "Februar", "février"), ("March", "März", "mars"), ("Apr", "April", "avril"),
    ("May", "Mai", "mai"), ("June", "Juni", "juin"), ("July", "Juli", "juil."), ("August", "August", "août"),
    ("Sep", "September", "septembre"), ("October", "Oktober", "oct."), ("Nov", "November", "novembre"), ("Dec", "Dezember", "décembre"),
]  # fmt: skip


@pytest.mark.parametrize("codec", ["utf-8", "cp1252"])
@pytest.mark.parametrize("language", range(3))
def test_every_month_by_its_name(language: int, codec: str, tmp_path: Path) -> None:
    rows = "".join(
        f"16. {name}{' ' * (k % 2)} 2024 14:05:22,000;1\n"
        for k, name in enumerate(n[language] for n in MONTH_NAMES)
    )
    table = read(tmp_path, ("Zeit;a\n" + rows).encode(codec))
    assert table.time.tolist() == [
        int(datetime(2024, k + 1, 16, 14, 5, 22, tzinfo=UTC).timestamp()) * 10**9 for k in range(12)
    ]


@pytest.mark.parametrize(
    "text",
    ["16. Foo 2024 14:05:22", "2024年13月16日 14時05分", "2024年03月16日 14時05", "20240316 14:05:99", "Mar 2024 14:05:22",
     "14.05.22", "2024-03-16 14:05:22 something", "20241316140522"],
)  # fmt: skip
def test_what_is_no_time_of_any_spelling(text: str) -> None:
    data = np.frombuffer((text + "\0" * 8).encode(), dtype=np.uint8)
    size = len(text.encode())

    @kernel
    def stamp(data: ByteArray, size: int) -> tuple[bool, int, int]:
        start = address_of(data)
        return calendar_stamp(start, start + size, 1)

    valid, day, clock = stamp(data, size)
    assert not valid or (clock == 0 and day > 0)


def test_ambiguous_dates_are_said(tmp_path: Path) -> None:
    table = read(tmp_path, "time,a\n04/11/2014 08:00:00,1\n04/11/2014 08:00:01,2\n")
    assert "two ways" in table.said
    assert table.time[0] == int(datetime(2014, 11, 4, 8, tzinfo=UTC).timestamp()) * 10**9


@pytest.mark.parametrize(
    ("first", "second", "moment"),
    [
        ("03/04/2024", "03/05/2024", datetime(2024, 3, 4, 23, 58, tzinfo=UTC)),
        ("04/03/2024", "05/03/2024", datetime(2024, 3, 4, 23, 58, tzinfo=UTC)),
        ("03/12/2024", "03/13/2024", datetime(2024, 3, 12, 23, 58, tzinfo=UTC)),
        ("12-03-2024", "13-03-2024", datetime(2024, 3, 12, 23, 58, tzinfo=UTC)),
        ("12/31/2023", "01/01/2024", datetime(2023, 12, 31, 23, 58, tzinfo=UTC)),
    ],
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_the_order_of_a_date_is_told_by_how_the_drive_goes_on(
    first: str, second: str, moment: datetime, encoding: str, tmp_path: Path
) -> None:
    """Midnight is long behind the rows that are looked at first."""
    rows = []
    for k in range(12_000):
        at = 23 * 3600 + 58 * 60 + 0.02 * k
        clock = at % 86400
        day = first if at < 86400 else second
        rows.append(f"{day} {int(clock // 3600):02d}:{int(clock // 60 % 60):02d}:{clock % 60:06.3f},1\n")
    table = read(tmp_path, ("time,a\n" + "".join(rows)).encode(encoding))
    assert table.time[0] == int(moment.timestamp()) * 10**9
    assert table.time[-1] - table.time[0] == 11_999 * 20_000_000
    assert not table.log.rejected
    assert ("under which the times run on" in table.said) == (first[:2] != "12" and second[3:5] != "13")


def test_dates_of_a_spreadsheet_are_days(tmp_path: Path) -> None:
    """45413 is 2024-05-01; at 100 Hz a step is 1.16e-7 days."""
    rows = "".join(f"{45413 + k / 8_640_000:.12f},1\n" for k in range(200))
    table = read(tmp_path, "Time,a\n" + rows)
    assert (table.time[-1] - table.time[0]) / 1e9 == pytest.approx(1.99, abs=1e-5)
    assert table.reader.absolute
    assert table.time[0] == int(datetime(2024, 5, 1, tzinfo=UTC).timestamp()) * 10**9
    assert "taken as days" in table.said


def spelled(first: float, rate: int, rows: int) -> list[str]:
    """Times of day as HHMMSS.ss."""
    moments = (datetime(2024, 5, 1, tzinfo=UTC) + timedelta(seconds=first + k / rate) for k in range(rows))
    return [f"{each:%H%M%S}.{each.microsecond // 10_000:02d}" for each in moments]


@pytest.mark.parametrize("first", [8 * 3600 + 38 * 60 + 56.3, 23 * 3600 + 59 * 60 + 30.0])
@pytest.mark.parametrize("rows", [300, 30_000])
def test_times_of_day_spelled_as_numbers(tmp_path: Path, first: float, rows: int) -> None:
    table = read(tmp_path, "UTC Time,a\n" + "".join(f"{t},1\n" for t in spelled(first, 10, rows)))
    assert table.time[0] == round(first * 1e9)
    assert np.array_equal(np.diff(table.time), np.full(rows - 1, 100_000_000))
    assert "HHMMSS" in table.said


def test_times_of_day_that_the_map_file_states(tmp_path: Path) -> None:
    text = "clock,a\n235958,1\n235959,1\n000000,1\n"
    options = ReadOptions(time_channel="clock", time_unit="hhmmss")
    assert np.diff(read(tmp_path, text, options).time).tolist() == [10**9, 10**9]


@pytest.mark.parametrize("first", [221_350.0, 101_000.0])
def test_seconds_of_the_week_stay_seconds(tmp_path: Path, first: float) -> None:
    rows = "".join(f"{first + k / 10:.2f},1\n" for k in range(3000))
    assert read(tmp_path, "gps_time,a\n" + rows).time[-1] == round((first + 299.9) * 1e9)
    stated = "".join(f"{t},1\n" for t in spelled(8 * 3600, 10, 3000))
    assert read(tmp_path, "gps_time [s],a\n" + stated).time[0] == 80_000 * 10**9


@pytest.mark.parametrize(
    "bad",
    [
        "03:60.5",
        "03:5",
        "3.5",
        "0 cats 00:00:01",
        "1 day",
        "0 days 00:00:61.5",
        "99999 days 0:00:00",
        "03:00.5x",
    ],
)
def test_what_is_no_stretch_of_time_costs_its_row(bad: str, tmp_path: Path) -> None:
    table = read(tmp_path, f"time,a\n03:00.0,1\n03:00.5,1\n{bad},1\n03:01.5,1\n")
    assert table.time.tolist() == [180_000_000_000, 180_500_000_000, 181_500_000_000]
    assert table.log.rejected == {"row without a valid time": 1}


def test_dates_of_matlab_are_refused_not_taken_for_seconds(tmp_path: Path) -> None:
    rows = "".join(f"{739373 + k / 8_640_000:.12f},1\n" for k in range(200))
    with pytest.raises(LogError, match=r"datenum.*86400"):
        read(tmp_path, "Time,a\n" + rows)


def test_seconds_of_the_day_stay_seconds(tmp_path: Path) -> None:
    rows = "".join(f"{45413 + k / 100:.2f},1\n" for k in range(200))
    assert read(tmp_path, "Time,a\n" + rows).time[1] == 45413_010_000_000


def test_a_unit_stated_is_never_overruled(tmp_path: Path) -> None:
    table = read(tmp_path, "t [s],a\n0,1\n10,2\n20,3\n")
    assert table.time.tolist() == [0, 10 * 10**9, 20 * 10**9]
    assert "unit" not in table.said


@pytest.mark.parametrize(
    ("first", "epoch", "what"),
    [
        (134_043_000_000_000_000, 116_444_736_000_000_000, "FILETIME"),
        (638_954_240_000_000_000, 621_355_968_000_000_000, ".NET"),
    ],
)
def test_clocks_that_count_100_ns(first: int, epoch: int, what: str, tmp_path: Path) -> None:
    numbers = [first + 250_000 * k for k in range(10)]
    expected = [(number - epoch) * 100 for number in numbers]
    table = read(tmp_path, "timestamp,a\n" + "".join(f"{number},1\n" for number in numbers) + "17,1\n")
    assert table.time.tolist() == expected
    assert what in table.said
    assert table.log.rejected == {"row without a valid time": 1}
    pl.DataFrame({"timestamp": [*numbers, None], "a": 1.0}).write_parquet(tmp_path / "log.parquet")
    reader = ParquetImporter().open(tmp_path / "log.parquet", ReadOptions(), ImportLog())
    (chunk,) = reader.read(frozenset({"a"}))
    assert reader.absolute
    assert chunk.time_ns.tolist() == expected


@pytest.mark.parametrize("joint", [".", ",", ":"])
@pytest.mark.parametrize("date", ["", "7.10.2025 "])
def test_milliseconds_without_their_zeros(joint: str, date: str, tmp_path: Path) -> None:
    ms = np.arange(0, 4000, 25)
    cells = [f"{date}08:53:{20 + k // 1000}{joint}{k % 1000}" for k in ms.tolist()]
    table = read(tmp_path, "time;a\n" + "".join(f"{cell};1\n" for cell in cells))
    assert ((table.time - table.time[0]) // 1_000_000).tolist() == ms.tolist()
    assert "read as whole milliseconds" in table.said


def test_decimals_without_their_last_zeros_stay_decimals(tmp_path: Path) -> None:
    ms = np.arange(0, 4000, 25)
    cells = [f"08:53:{20 + k / 1000:06.3f}".rstrip("0") + "0" * (k % 1000 == 0) for k in ms.tolist()]
    table = read(tmp_path, "time,a\n" + "".join(f"{cell},1\n" for cell in cells))
    assert ((table.time - table.time[0]) // 1_000_000).tolist() == ms.tolist()
    assert "milliseconds" not in table.said


@pytest.mark.parametrize("codec", ["utf-8", "cp1252", "utf-16"])
@pytest.mark.parametrize("blank", ["\N{NO-BREAK SPACE}", "\N{NARROW NO-BREAK SPACE}", "\N{THIN SPACE}"])
def test_a_time_with_digits_in_groups_by_no_break_blanks(blank: str, codec: str, tmp_path: Path) -> None:
    ms = range(0, 9000, 25)
    cells = [f"{k // 1000}{blank}{k % 1000:03d}" if k >= 1000 else f"{k}" for k in ms]
    text = "Time [ms];a\n" + "".join(f"{cell};1,5\n" for cell in cells)
    if codec == "cp1252" and blank != "\N{NO-BREAK SPACE}":
        pytest.skip("not in that code page")
    table = read(tmp_path, text.encode(codec))
    assert (table.time // 1_000_000).tolist() == list(ms)
    assert "grouped by no-break blanks" in table.said


def test_digits_in_odd_groups_are_named(tmp_path: Path) -> None:
    rows = "".join(f"{k // 100}\N{NO-BREAK SPACE}{k % 100:02d};1,5\n" for k in range(1000, 9000, 25))
    with pytest.raises(LogError, match="grouped by no-break blanks"):
        read(tmp_path, "Time [ms];a\n" + rows)


@kernel
def decimal_bytes(data: ByteArray, unit_ns: int) -> tuple[bool, int]:
    start = address_of(data)
    return decimal_stamp(start, start + data.shape[0], 46, 0, unit_ns, 0)


@kernel
def calendar_bytes(data: ByteArray) -> tuple[bool, int, int]:
    start = address_of(data)
    return calendar_stamp(start, start + data.shape[0], 0)


@settings(max_examples=300, deadline=None)
@given(st.integers(-(2**62), 2**62))
def test_decimal_seconds_are_exact(nanos: int) -> None:
    sign = "-" if nanos < 0 else ""
    text = f"{sign}{abs(nanos) // 10**9}.{abs(nanos) % 10**9:09d}"
    valid, stamp = decimal_bytes(np.frombuffer(text.encode(), dtype=np.uint8), 10**9)
    other = np.frombuffer(text.replace("-", "\N{MINUS SIGN}").encode(), dtype=np.uint8)
    assert decimal_bytes(other, 10**9) == (valid, stamp)
    assert valid
    assert abs(stamp - nanos) <= (0 if len(text.strip("-").replace(".", "").lstrip("0")) <= 18 else 9)


@settings(max_examples=200, deadline=None)
@given(
    st.datetimes(datetime(1950, 1, 1), datetime(2150, 1, 1)),
    st.integers(-14 * 60, 14 * 60),
    st.sampled_from("T "),
)
def test_iso_times_are_exact(moment: datetime, zone: int, between: str) -> None:
    sign = "-" if zone < 0 else "+"
    text = f"{moment.isoformat(between)}{sign}{abs(zone) // 60:02d}:{abs(zone) % 60:02d}"
    data = np.frombuffer(text.encode(), dtype=np.uint8)
    valid, day, rest = calendar_bytes(data)
    expected = (moment - datetime(1970, 1, 1) - timedelta(minutes=zone)) // timedelta(microseconds=1) * 1000
    assert valid
    assert day + rest == expected


def test_times_of_day_run_on_over_midnight_and_back() -> None:
    hour = 3600 * 10**9
    clock = np.array([22, 23, 0, 1, 23, 0], dtype=np.int64) * hour
    assert (unwrap_days(clock, None) // hour).tolist() == [22, 23, 24, 25, 23, 24]
    assert (unwrap_days(np.array([1 * hour]), 47 * hour) // hour).tolist() == [49]


@pytest.mark.parametrize(
    ("values", "unit_ns"),
    [
        ([0, 0.01, 0.02], 10**9),
        ([0, 1, 2], 10**9),
        ([0, 10, 20], 10**6),
        ([0, 10000, 20000], 1000),
        ([0, 1e7, 2e7], 1),
        ([1.4e9] * 2, 10**9),
        ([1.4e9, 1.4e9 + 0.01, 1.4e9 + 0.02], 10**9),
        ([1.4e9, 1.4e9 + 30, 1.4e9 + 60], 10**9),
        # counters since the power came on: µs after 20 and 71 minutes, ms after 8 and 40 days, µs after 8 days, ns after 2
        ([1.2e9, 1.2e9 + 10_000, 1.2e9 + 20_000], 1000),
        ([4264967296, 4264987296, 4265007296], 1000),
        ([7e8, 7e8 + 10, 7e8 + 20], 10**6),
        ([3.4e9, 3.4e9 + 10, 3.4e9 + 20], 10**6),
        ([1.2e9, 1.2e9 + 100, 1.2e9 + 200], 10**6),
        ([7e11, 7e11 + 10_000, 7e11 + 20_000], 1000),
        ([1.8e14, 1.8e14 + 1e7, 1.8e14 + 2e7], 1),
        ([1.7e12, 1.7e12 + 10, 1.7e12 + 20], 10**6),
        ([1.7e15, 1.7e15 + 10_000, 1.7e15 + 20_000], 1000),
        ([1.7e18, 1.7e18 + 1e7, 1.7e18 + 2e7], 1),
        # 25 ms apart, in no order
        ([k * 7919 % 2000 * 25 for k in range(300)], 10**6),
        ([], 10**9),
    ],
)
def test_guessed_units(values: list[float], unit_ns: int) -> None:
    assert guess_unit(values)[0] == unit_ns


def test_a_counter_of_microseconds_runs_on_where_its_size_could_be_a_wall_clock(tmp_path: Path) -> None:
    stamps = [(4_294_900_000 + k * 20_000) % 2**32 for k in range(8)]
    table = read(tmp_path, "timestamp,a\n" + "".join(f"{stamp},{k}\n" for k, stamp in enumerate(stamps)))
    assert set(np.diff(table.time).tolist()) == {20_000_000}
    assert not table.reader.absolute
    assert "taken as us" in table.said


@pytest.mark.parametrize("zone", ["", "Z", "+02:00"])
def test_times_of_day_run_on_over_the_seams_of_blocks(zone: str, tmp_path: Path) -> None:
    moments = [(22 * 3600 + k * 60) % 86400 for k in range(400)]
    text = "Time,a\n" + "".join(
        f"{m // 3600:02}:{m // 60 % 60:02}:00{zone},{k}\n" for k, m in enumerate(moments)
    )
    path = tmp_path / "log.csv"
    path.write_text(text)
    reader = CsvImporter().open(path, ReadOptions(), ImportLog())
    reader._block_bytes = 100
    chunks = list(reader.read(frozenset({"a"})))
    assert len(chunks) > 20
    assert set(np.diff(np.concatenate([chunk.time_ns for chunk in chunks])).tolist()) == {60 * 10**9}


def test_a_column_called_time_whose_texts_are_none_is_shown(tmp_path: Path) -> None:
    rows = [f"a quarter past {k},{k},{k}" for k in range(1, 9)]
    with pytest.raises(
        LogError, match=r'column "Time" holds no time that cogest knows \(.a quarter past 1.\)'
    ):
        read(tmp_path, "Time,speed,yaw\n" + "\n".join(rows))


@pytest.mark.parametrize(
    ("first", "second", "apart_ns", "start"),
    [
        ("20251009T085320.000Z", "20251009T085320.010Z", 10_000_000, (2025, 10, 9, 8, 53, 20)),
        ("20251009T105320,25+0200", "20251009T105321,25+0200", 1_000_000_000, (2025, 10, 9, 8, 53, 20, 250_000)),
        ("20251231T2359", "20260101T0001", 120_000_000_000, (2025, 12, 31, 23, 59)),
        ("09.10.25 08:53:20.000", "09.10.25 08:53:20.010", 10_000_000, (2025, 10, 9, 8, 53, 20)),
        ("9.1.07 08:53", "10.1.07 08:54", 86_460_000_000_000, (2007, 1, 9, 8, 53)),
    ],
)  # fmt: skip
def test_dates_without_signs_and_with_short_years(
    first: str, second: str, apart_ns: int, start: tuple[int, ...], tmp_path: Path
) -> None:
    found = read(tmp_path, f"Time;a\n{first};1\n{second};2\n")
    begin = datetime(*start, tzinfo=UTC)  # type: ignore[misc,arg-type]
    at = round(begin.timestamp()) * 1_000_000_000 + begin.microsecond * 1000
    assert found.time.tolist() == [at, at + apart_ns]
    assert found.reader.absolute
    zone = first.endswith(("Z", "+0200"))
    assert ("state no time zone" in found.said) != zone
    assert ("are taken as day, month, year from 2000 on" in found.said) == ("." in first[:3])


@pytest.mark.parametrize(
    "text",
    [
        "20251309T085320",
        "20250009T085320",
        "20251009T256000",
        "20251009T08532",
        "20251009T",
        "2025100T085320",
        "20251009T0853.5",
    ],
)
def test_digits_that_are_no_date_are_none(text: str) -> None:
    assert not calendar_bytes(np.frombuffer(text.encode(), dtype=np.uint8))[0]
