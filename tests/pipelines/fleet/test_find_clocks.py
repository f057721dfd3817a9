"""When recordings begin and end, told from little of them: as when all of them is read."""

from __future__ import annotations

import shutil

import pytest

from parsers.importer import ImportLog, ReadOptions
from parsers.load import LoadOptions, load_drive
from parsers.mapping import read_map
from parsers.registry import find_importer
from pipelines.fleet.clocks import NS, clock_of
from pipelines.fleet.entries import Entry
from pipelines.fleet.heads import Heads
from pipelines.fleet.logs import Log

LOGS = [
    "can/drive.asc",
    "can/drive.blf",
    "can/drive.log",
    "can/drive.mf4",
    "can/drive.trc",
    "csv/drive.csv",
    "fleet/suv/monday.mcap",
    "fleet/truck/depot.bag",
    "fleet/van/tour_2.mf4",
    "parquet/drive.parquet",
    "ros/drive_sqlite3/drive_sqlite3.db3",
    "tsv/drive.tsv",
    "vbo/drive.vbo",
]


def looked_at(path, options: ReadOptions | None = None) -> Log:
    found = Heads(lambda _: options or ReadOptions()).look(Entry(str(path), path.name, path.stat().st_size))
    assert isinstance(found, Log)
    return found


def options_for(path) -> ReadOptions:
    mapping = path.parent / "map.toml"
    if not mapping.exists():
        return ReadOptions()
    known = read_map(mapping)
    return ReadOptions(time_channel=known.time_channel, time_unit=known.time_unit)


@pytest.mark.parametrize("name", LOGS)
def test_it_is_what_reading_the_log_gives(samples, name):
    path = samples / name
    options = options_for(path)
    clock = clock_of(looked_at(path, options), options)
    assert clock is not None
    mapping = (
        read_map(path.parent / "map.toml", strict=False) if (path.parent / "map.toml").exists() else None
    )
    drive = load_drive([path], LoadOptions(map=mapping, dbc=tuple(path.parent.glob("*.dbc")), fix=False))
    first = min(int(signal.time_ns[0]) for signal in drive.signals.values())
    last = max(int(signal.time_ns[-1]) for signal in drive.signals.values())
    # frames without a signal, and a recorder's receipt before or after the sensors' own stamps
    assert clock.first_ns == pytest.approx(first, abs=NS // 10)
    assert clock.last_ns == pytest.approx(last, abs=NS // 10)
    reader = find_importer(path).open(path, ReadOptions(dbc=tuple(path.parent.glob("*.dbc"))), ImportLog())
    assert clock.absolute == reader.absolute


def test_a_folder_of_a_bag(samples):
    folder = samples / "ros" / "drive_sqlite3"
    log = Log(str(folder), "drive_sqlite3", 1, "drive_sqlite3", "rosbag2", "")
    single = clock_of(looked_at(folder / "drive_sqlite3.db3"), ReadOptions())
    assert clock_of(log, ReadOptions()) == single
    assert single is not None


def test_what_is_damaged_has_no_clock(samples, tmp_path):
    for name in ("can/drive.blf", "fleet/suv/monday.mcap", "fleet/truck/depot.bag", "parquet/drive.parquet"):
        source = samples / name
        cut = tmp_path / source.name
        cut.write_bytes(source.read_bytes()[:600])
        assert clock_of(looked_at(cut), ReadOptions()) is None, name


def test_the_tail_of_a_table_that_is_cut_does_not_count(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("time_s,speed_mps\n" + "".join(f"{k / 10:.1f},3.5\n" for k in range(100)) + "9999")
    clock = clock_of(looked_at(path), ReadOptions())
    assert clock is not None
    assert (clock.first_ns, clock.last_ns) == (0, 99 * NS // 10)


@pytest.mark.parametrize(
    ("first", "last"),
    [
        ("2024-05-01T10:00:00Z", "2024-05-01T10:00:59.500Z"),
        ("2024/05/01 10:00:00", "2024/05/01 10:00:59.5"),
        ("01.05.2024 10:00:00", "01.05.2024 10:00:59,5"),
        ("1714557600", "1714557659.5"),
        ("1714557600000", "1714557659500"),
    ],
)
def test_tables_with_a_calendar_or_numbers_since_1970(tmp_path, first, last):
    path = tmp_path / "a.csv"
    middle = "".join(f"{first[:-2]}{k:02d};3.5;1\n" for k in range(1, 9)) if first.endswith("00") else ""
    path.write_text(f"timestamp;speed_mps;x\n{first};3.4;1\n{middle}{last};3.6;1\n")
    clock = clock_of(looked_at(path), ReadOptions())
    assert clock is not None
    assert clock.absolute
    assert clock.first_ns == 1_714_557_600 * NS
    assert clock.last_ns == 1_714_557_600 * NS + 59_500_000_000


def test_the_header_is_learned_but_not_believed_blindly(tmp_path):
    heads = Heads(lambda _: ReadOptions())
    for name, text in (
        ("a.csv", "# no. 1\ntime_s,speed_mps\n0.0,3\n0.1,4\n0.2,5\n"),
        ("b.csv", "# no. 22\ntime_s,speed_mps\n10.0,3\n10.1,4\n10.2,5\n"),
        ("c.csv", "# no. 3\ntime_s,speed_mps\n2024-05-01T10:00:00Z,3\n2024-05-01T10:00:01Z,4\n"),
    ):
        (tmp_path / name).write_text(text)
    found = [
        heads.look(Entry(str(tmp_path / n), n, (tmp_path / n).stat().st_size))
        for n in ("a.csv", "b.csv", "c.csv")
    ]
    logs = [log for log in found if isinstance(log, Log)]
    assert len(logs) == 3
    assert logs[0].look is logs[1].look
    assert logs[2].look is not logs[0].look
    clocks = [clock_of(log, ReadOptions()) for log in logs]
    assert [c.first_ns for c in clocks if c] == [0, 10 * NS, 1_714_557_600 * NS]


def test_a_large_head_is_read_on(samples, tmp_path):
    path = tmp_path / "wide.csv"
    names = ["date", "clock", *(f"a_rather_long_channel_name_{k}" for k in range(900))]
    rows = [["01.05.2024", f"10:00:{k:02d}", *("1.5" for _ in range(900))] for k in range(40)]
    path.write_text("\n".join(";".join(row) for row in [names, *rows]) + "\n")
    clock = clock_of(looked_at(path), ReadOptions())
    assert clock is not None
    assert clock.duration_ns == 39 * NS
    shutil.rmtree(tmp_path)
