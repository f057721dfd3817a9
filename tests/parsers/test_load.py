"""From logs to a drive: order in time, several logs, what is left out, and the record of all of it."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import polars as pl
import pytest

import parsers.load
import parsers.opened_log
from parsers.channels import ChannelInfo, Chunk
from parsers.checks.check import Checked
from parsers.drive import Decision
from parsers.errors import DatabaseError, LogError, MappingError
from parsers.load import LoadOptions, hash_logs, load_drive
from parsers.log_hash import BackgroundHash
from parsers.mapping import read_map
from parsers.timebase import LATEST_NS, MAX_GAPS, NS


class Tape:
    """A log in memory: chunks as given. Its channel "v" is a speed, "x" nothing known."""

    name, title, suffixes = "tape", "Tape", (".tape",)
    clock, start_utc_ns = "the tape's clock", None

    def __init__(
        self, *chunks: object, absolute: bool = False, lost: tuple[tuple[int, int], ...] = ()
    ) -> None:
        self.chunks, self.absolute, self.lost = chunks, absolute, lost
        self.channels = tuple(
            ChannelInfo(name, "g", unit, "table") for name, unit in (("speed", "m/s"), ("x", None))
        )

    def claims(self, path: Path, head: bytes) -> bool:
        return True

    def open(self, path: Path, options: object, log: object) -> Tape:
        self.log = log
        return self

    def read(self, wanted: frozenset[str]) -> Iterator[Chunk]:
        assert wanted == {"speed"}
        self.log.lost_spans_ns.extend(self.lost)
        for chunk in self.chunks:
            if isinstance(chunk, Exception):
                raise chunk
            time_ns, values = chunk
            self.log.messages += len(time_ns)
            yield Chunk(
                "g", np.asarray(time_ns, dtype=np.int64), {"speed": np.asarray(values, dtype=np.float64)}
            )


@pytest.fixture
def play(tmp_path, monkeypatch):
    """Load tapes as if they were the logs of one drive."""

    def load(*tapes: Tape, fix: bool = True):
        paths = []
        for number in range(len(tapes)):
            path = tmp_path / f"{number}.tape"
            path.write_bytes(b"tape")
            paths.append(path)
        found = dict(zip(paths, tapes, strict=True))
        monkeypatch.setattr(parsers.opened_log, "find_importer", found.__getitem__)
        monkeypatch.setattr(parsers.load, "find_importer", found.__getitem__)
        return load_drive(paths, LoadOptions(fix=fix))

    return load


def row(start_s: float, count: int, step_s: float = 0.1):
    time_ns = (start_s * NS + np.arange(count) * step_s * NS).astype(np.int64)
    return time_ns, 10 + np.sin(time_ns / NS)


def test_rows_are_ordered_and_what_was_done_is_counted(play):
    time_ns, values = row(0, 100)
    late = np.r_[0:40, 41, 40, 42:100, 99]
    drive = play(Tape((time_ns[late], values[late])))
    assert np.array_equal(drive.signals["speed"].time_ns, time_ns)
    assert np.array_equal(drive.signals["speed"].values, values)
    record = drive.record
    assert (record.messages, record.out_of_order, record.duplicates, record.clock_jumps) == (101, 1, 1, 0)
    assert (record.duration_s, drive.start_ns) == (pytest.approx(9.9), 0)


@pytest.mark.parametrize(("second", "status"), [(400, "malformed"), (20, "complete")])
def test_a_clock_that_starts_again_is_said_with_what_it_took(play, second, status):
    (first_ns, first), (again_ns, again) = row(0, 1000), row(0, second)
    drive = play(Tape((np.r_[first_ns, again_ns], np.r_[first, again])))
    record = drive.record
    assert (record.status, record.clock_jumps) == (status, 1)
    assert record.rejected["row beyond a jump of the clock"] == second
    assert len(drive.signals["speed"].values) == 1000
    assert any(f"{second} of {1000 + second} rows" in note for note in record.notes) == (
        status == "malformed"
    )


def test_stamps_that_no_clock_shows_are_rejected(play):
    time_ns, values = row(0, 100)
    extreme = np.array([np.iinfo(np.int64).min, LATEST_NS + 1, np.iinfo(np.int64).max])
    drive = play(Tape((np.r_[time_ns[:50], extreme, time_ns[50:]], np.r_[values[:50], 1, 2, 3, values[50:]])))
    assert np.array_equal(drive.signals["speed"].time_ns, time_ns)
    assert drive.record.rejected == {"row whose time stamp is impossible": 3}
    with pytest.raises(LogError, match=r"no signal has two valid samples: speed.*3 x row whose time stamp"):
        play(Tape((extreme, [1.0, 2.0, 3.0])))


@pytest.mark.parametrize("offset", [-LATEST_NS, LATEST_NS - 100 * NS])
def test_the_outermost_stamps_that_are_possible(play, offset):
    time_ns, values = row(0, 100)
    drive = play(Tape((time_ns + offset, values), absolute=True))
    assert drive.start_ns == offset
    assert drive.record.duration_s == pytest.approx(9.9)


def test_a_disk_that_fails_in_the_middle_is_a_log_error(play):
    with pytest.raises(LogError, match=r"0\.tape: cannot be read \(Input/output error\)"):
        play(Tape(row(0, 10), OSError(5, "Input/output error")))


def test_too_few_samples_are_no_signal(play):
    with pytest.raises(LogError, match="no signal has two valid samples: speed"):
        play(Tape(([0], [1.0])))
    with pytest.raises(LogError, match="no signal has two valid samples: speed"):
        play(Tape((row(0, 50)[0], np.r_[[1.0], np.full(49, np.nan)])))
    with pytest.raises(LogError, match=r"holds no readable data \(Tape\)"):
        play(Tape())


def test_of_a_log_that_gave_nothing_the_damage_is_said_before_the_channels(tmp_path):
    sample = Path(__file__).resolve().parents[2] / "sample_logs" / "ros" / "drive_ros1.mcap"
    content = bytearray(sample.read_bytes())
    content[20_000:20_064] = bytes(64)  # in its only chunk; the topics stand in the summary behind it
    path = tmp_path / "drive.mcap"
    path.write_bytes(content)
    with pytest.raises(
        LogError,
        match=r"\(MCAP\); the chunk at byte 42 is damaged.*in lists that do not say.*not recognised: 2 of 65",
    ):
        load_drive([path])


def test_values_out_of_their_range_and_signals_without_samples_are_said(tmp_path):
    path, given = tmp_path / "log.csv", tmp_path / "map.toml"
    rows = "".join(f"{k / 100},{k},{k - 50},\n" for k in range(200))
    path.write_text("t [s],v,p,y\n" + rows, encoding="utf-8")
    given.write_text(
        '[signals.speed]\nchannel = "v"\nunit = "km/h"\nvalid_range = [0, 119]\n'
        '[signals.pitch_rate]\nchannel = "p"\nunit = "deg/s"\nvalid_range = [500, 600]\n'
        '[signals.accel_y]\nchannel = "y"\nunit = "g"\n',
        encoding="utf-8",
    )
    record = load_drive([path], LoadOptions(read_map(given), fix=False)).record
    assert record.rejected == {
        "speed: value outside of its valid range": 80,
        "pitch_rate: value outside of its valid range": 200,
    }
    said = "left out, since the channel has fewer than two valid samples: accel_y, pitch_rate"
    assert said in record.notes


def test_messages_that_say_they_have_none_are_counted_and_rows_of_another_axle_are_not(tmp_path):
    path, given = tmp_path / "log.csv", tmp_path / "map.toml"
    rows = "".join(f"{k / 100},{k % 7},{-1 if k < 60 else 0},{k % 2}\n" for k in range(200))
    path.write_text("t [s],v,v_covariance[0],axle\n" + rows, encoding="utf-8")
    for channel, low, rejected in (("v_covariance[0]", -0.5, 60), ("axle", 0.5, 0)):
        given.write_text(
            f'[signals.speed]\nchannel = "v"\nunit = "m/s"\nwhere = ["{channel}", {low}, 1e300]\n',
            encoding="utf-8",
        )
        record = load_drive([path], LoadOptions(read_map(given), fix=False)).record
        assert sum(record.rejected.values()) == rejected
        assert all("says it has none (covariance below 0)" in reason for reason in record.rejected)


def test_where_a_map_does_not_fit_a_damaged_log_the_damage_is_said(tmp_path):
    path, given = tmp_path / "log.log", tmp_path / "map.toml"
    path.write_text("(1700000000.000000) can0 123#0102\n(1700000000.010000) can0 123#0102\n")
    given.write_text('[signals.speed]\nchannel = "M.v"\nunit = "km/h"\n')
    with pytest.raises(MappingError, match=r"'M\.v' is not in the log.*of the log is said: .*no database"):
        load_drive([path], LoadOptions(read_map(given)))


def test_a_database_that_cannot_be_used_stops_only_where_it_was_named(tmp_path):
    path, bad, good = tmp_path / "log.log", tmp_path / "bad.dbc", tmp_path / "good.dbc"
    path.write_text("".join(f"({1700000000 + k / 100:.6f}) can0 123#{k:02X}00\n" for k in range(100)))
    bad.write_bytes(b"")
    text = 'VERSION ""\nBU_: E\nBO_ 291 M: 2 E\n SG_ VehicleSpeed : 0|16@1+ (0.1,0) [0|0] "km/h" E\n'
    good.write_bytes(text.encode("utf-16"))
    drive = load_drive([path], LoadOptions(dbc=(bad, good), dbc_given=False))
    assert len(drive.signals["speed"].values) == 100
    assert any("bad.dbc beside the log is left out" in note for note in drive.record.notes)
    with pytest.raises(DatabaseError, match=r"bad\.dbc"):
        load_drive([path], LoadOptions(dbc=(bad, good)))


def test_a_database_that_no_log_has_frames_for_is_said(tmp_path):
    table, frames, base = tmp_path / "log.csv", tmp_path / "log.log", tmp_path / "a.dbc"
    table.write_text("time_s,speed_mps\n" + "".join(f"{1700000000 + k / 100:.2f},{k}\n" for k in range(100)))
    frames.write_text("".join(f"({1700000000 + k / 100:.6f}) can0 123#{k:02X}00\n" for k in range(100)))
    base.write_text('VERSION ""\nBU_: E\nBO_ 291 M: 2 E\n SG_ v : 0|16@1+ (0.1,0) [0|0] "km/h" E\n')
    said = [
        any("--dbc a.dbc was not used" in note for note in load_drive(logs, options).record.notes)
        for logs, options in (
            ([table], LoadOptions(dbc=(base,))),
            ([table], LoadOptions(dbc=(base,), dbc_given=False)),
            ([table], LoadOptions()),
            ([table, frames], LoadOptions(dbc=(base,))),
        )
    ]
    assert said == [True, False, False, False]


def test_parts_in_a_row_become_one_and_an_overlap_counts_once(play):
    time_ns, values = row(0, 200)
    for overlap in (0, 1, 9):
        first, second = (time_ns[:100], values[:100]), (time_ns[100 - overlap :], values[100 - overlap :])
        for tapes in ((first, second), (second, first)):
            drive = play(*map(Tape, tapes))
            assert np.array_equal(drive.signals["speed"].time_ns, time_ns)
            assert np.array_equal(drive.signals["speed"].values, values)
            assert drive.record.messages == 200 + overlap
            assert all(entry.used for entry in drive.record.mapped)


def test_three_parts_with_a_pause(play):
    parts = [row(0, 50), row(60, 80), row(30, 50)]
    drive = play(*map(Tape, parts))
    assert np.array_equal(drive.signals["speed"].time_ns, np.concatenate([parts[i][0] for i in (0, 2, 1)]))
    assert [(round(g.start_s, 1), round(g.end_s, 1)) for g in drive.record.gaps] == [
        (4.9, 30.0),
        (34.9, 60.0),
    ]


@pytest.mark.parametrize("second", [row(5, 20), row(0, 100), row(-5, 80), row(2.5, 2)])
def test_a_second_recorder_of_the_same_span_is_left_out_and_said(play, second):
    # a sensor of its own, whose values are never quite the same
    second = second[0], second[1] + 0.01
    first = row(0, 100)
    drive = play(Tape(second), Tape(first))
    longest = max((second, first), key=lambda part: len(part[0]))
    assert np.array_equal(drive.signals["speed"].time_ns, longest[0])
    assert sum(entry.used for entry in drive.record.mapped) == 1
    (unused,) = [entry for entry in drive.record.mapped if not entry.used]
    assert unused.rule.startswith("left out, another log has it")
    assert any("speed is in several logs over the same time" in note for note in drive.record.notes)


def test_clocks_that_have_nothing_in_common(play):
    with pytest.raises(LogError, match="stamps count from its own start"):
        play(Tape(row(0, 50)), Tape(row(1.7e9, 50), absolute=True))
    with pytest.raises(LogError, match="more than two days apart"):
        play(Tape(row(1.7e9, 50), absolute=True), Tape(row(1.7e9 + 3 * 86400, 50), absolute=True))


def test_when_the_checks_leave_nothing_the_error_says_what_they_found(play, monkeypatch):
    found = Decision("speed", "range", "speed stands still", "left out", "50 equal samples", True)
    monkeypatch.setattr(parsers.load, "check_all", lambda *_, **__: Checked({}, (found,), (), ()))
    with pytest.raises(LogError, match=r"0\.tape: no signal is left after the checks.*speed stands still"):
        play(Tape(row(0, 50)))


def test_gaps_are_listed_up_to_a_bound_and_a_note_says_how_many_there_are(play):
    step = np.full(4000, NS // 100)
    step[1::2] = 3 * NS // 10
    step[2001] = 90 * NS
    time_ns = np.concatenate([np.arange(30000) * NS // 100, 300 * NS + np.cumsum(step)])
    drive = play(Tape((time_ns, np.full(len(time_ns), 1.0) + np.arange(len(time_ns)) % 7)))
    assert len(drive.record.gaps) == MAX_GAPS
    assert max(gap.end_s - gap.start_s for gap in drive.record.gaps) == pytest.approx(90)
    (note,) = [note for note in drive.record.notes if "gaps" in note]
    assert note == f"there are 2000 gaps: only the {MAX_GAPS} longest are listed"


def test_damaged_spans_are_listed_up_to_a_bound(play):
    lost = tuple((i * NS, i * NS + 10 + i) for i in range(MAX_GAPS + 500))
    drive = play(Tape(row(0, 50), lost=lost))
    assert sum(gap.signal == "lost" for gap in drive.record.gaps) == MAX_GAPS
    assert (
        f"there are {MAX_GAPS + 500} damaged spans: only the {MAX_GAPS} longest are listed"
        in drive.record.notes
    )


def test_a_mapping_file_that_is_given_must_fit_one_of_several_logs(tmp_path):
    time = np.arange(100) / 10
    pl.DataFrame({"time_s": time, "a": np.sin(time)}).write_csv(tmp_path / "one.csv")
    pl.DataFrame({"time_s": time, "b": 10 + np.sin(time)}).write_csv(tmp_path / "two.csv")
    logs = [tmp_path / "one.csv", tmp_path / "two.csv"]
    text = '[signals.accel_y]\nchannel = "a"\nunit = "m/s2"\n[signals.speed]\nchannel = "{}"\nunit = "m/s"\n'
    mapping = tmp_path / "map.toml"
    mapping.write_text(text.format("b"), encoding="utf-8")
    drive = load_drive(logs, LoadOptions(read_map(mapping)))
    assert set(drive.signals) == {"accel_y", "speed"}
    mapping.write_text(text.format("c"), encoding="utf-8")
    with pytest.raises(MappingError, match="maps speed to 'c', which is not in any of the logs"):
        load_drive(logs, LoadOptions(read_map(mapping)))


def test_the_hash_of_logs(tmp_path):
    one, two = tmp_path / "one", tmp_path / "two"
    one.write_bytes(b"abc")
    two.write_bytes(b"abc")
    # the SHA-256 of "abc" as FIPS 180-2 prints it
    assert hash_logs([one]).startswith("ba7816bf8f01cfea414140de5dae2223")
    assert hash_logs([one]) == hash_logs([two])
    assert hash_logs([one, two]) != hash_logs([one])
    with pytest.raises(LogError, match="cannot be read"):
        hash_logs([tmp_path / "none"])


def test_the_hash_of_a_folder_knows_its_names(tmp_path):
    def folder(name, **files):
        made = tmp_path / name
        for file, content in files.items():
            (made / file).parent.mkdir(parents=True, exist_ok=True)
            (made / file).write_bytes(content)
        return hash_logs([made])

    first = folder("first", a=b"12", b=b"3")
    assert folder("again", b=b"3", a=b"12") == first
    assert folder("renamed", a=b"12", c=b"3") != first
    assert folder("moved", **{"a": b"12", "deep/b": b"3"}) != first
    assert folder("shifted", a=b"1", b=b"23") != first


def test_an_error_does_not_wait_for_the_hash(tmp_path, monkeypatch):
    started, seen = threading.Event(), []

    def endless(paths, stop):
        started.set()
        seen.append(stop.wait(20))
        return ""

    monkeypatch.setattr("parsers.log_hash.hash_logs", endless)

    def work():
        with BackgroundHash([tmp_path]):
            started.wait(20)
            raise KeyError

    with pytest.raises(KeyError):
        work()
    assert seen == [True]


def test_rows_without_a_fix_are_counted_and_no_places(tmp_path: Path) -> None:
    path = tmp_path / "drive.csv"
    rows = [f"{k / 10},{0 if k < 30 else 48.1},{0 if k < 30 else 11.5},9.81" for k in range(100)]
    path.write_text("\n".join(["time [s],latitude [deg],longitude [deg],accel_z [m/s2]", *rows]))
    drive = load_drive([path], LoadOptions(fix=False))
    assert len(drive.signals["latitude"].values) == len(drive.signals["longitude"].values) == 70
    assert drive.signals["latitude"].values.min() == 48.1
    said = "row without a position fix, or value outside of its valid range"
    assert drive.record.rejected == {f"latitude: {said}": 30, f"longitude: {said}": 30}
