"""`convert` of drives that do not fit into memory: the same tables and the same record as with all in memory."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from long_tapes import GROUPS, SMALL, Tape, both, drive, record, tables, with_faults

import parsers.load
import parsers.long_drive
import parsers.opened_log
import parsers.store
from parsers.channels import Chunk
from parsers.convert import convert_logs
from parsers.errors import LogError
from parsers.intake import Budget
from parsers.load import LoadOptions, load_drive
from parsers.store import write_drive
from parsers.timebase import NS
from parsers.windows import time_windows


@pytest.fixture
def tapes(tmp_path, monkeypatch):
    """Make tapes readable as the logs of one drive."""

    def make(*logs: Tape) -> list[Path]:
        paths = []
        for number in range(len(logs)):
            paths.append(tmp_path / f"{number}.tape")
            paths[-1].write_bytes(b"tape")
        found = dict(zip(paths, logs, strict=True))
        monkeypatch.setattr(parsers.opened_log, "find_importer", found.__getitem__)
        monkeypatch.setattr(parsers.load, "find_importer", found.__getitem__)
        return paths

    return make


def test_a_clean_drive(tapes, tmp_path) -> None:
    converted, notes = both(tapes(Tape(drive())), tmp_path)
    assert notes == []
    assert converted.record.decisions == ()
    assert len(converted.files) == len(GROUPS) + 1


def test_a_code_within_the_range_of_a_signal(tapes, tmp_path) -> None:
    rows = drive()
    rows["/imu"][1]["accel_x"][3000:3100] = -65.0
    converted, _ = both(tapes(Tape(rows)), tmp_path)
    assert [(each.signal, each.found[:11]) for each in converted.record.decisions] == [
        ("accel_x", "100 samples")
    ]


@pytest.mark.parametrize("window", [9_000, 31_000, 10**9])
@pytest.mark.parametrize("fix", [True, False])
def test_every_fault_at_once(tapes, tmp_path, window, fix) -> None:
    converted, notes = both(tapes(Tape(with_faults(drive()), 37)), tmp_path, fix=fix, window=window)
    assert notes == []
    made = converted.record
    assert made.clock_jumps == 1
    assert (
        min(
            made.out_of_order,
            made.duplicates,
            len(made.gaps),
            made.rejected["row beyond a jump of the clock"],
        )
        > 0
    )
    kinds = {decision.kind for decision in made.decisions}
    assert {"unit", "sign", "spikes"} <= kinds
    assert sum("code" in decision.found for decision in made.decisions) == 1
    assert sum("jump away and back" in decision.found for decision in made.decisions) >= 3


def test_bursts_at_the_edges_of_windows(tapes, tmp_path, monkeypatch) -> None:
    n = 20_000
    time_ns = np.arange(n) * 10_000_000
    speed = 20 + 5 * np.sin(time_ns / NS)
    inside = np.zeros(n, dtype=np.bool_)
    for number, at in enumerate(range(50, n - 50, 67)):
        speed[at : at + 1 + number % 5] += 30
        # where the edge before this sample would cut a burst in two
        inside[at + 1 : at + 1 + number % 5] = True
    edges: list[int] = []

    def noted(*arguments: object) -> list[tuple[int, int]]:
        windows = time_windows(*arguments)
        edges.extend(start for start, _ in windows)
        return windows

    monkeypatch.setattr(parsers.long_drive, "time_windows", noted)
    rows = {"/odom": (time_ns, {"speed": speed})}
    converted, _ = both(tapes(Tape(rows)), tmp_path, rows=1000, window=1600)
    starts = np.searchsorted(time_ns, edges)
    assert np.count_nonzero(inside[starts[starts < n]]) > 3
    (decision,) = converted.record.decisions
    assert decision.found.startswith(f"{np.count_nonzero(speed > 30)} samples of speed jump away and back")


def test_what_is_cut_off_goes_from_a_long_drive_too(tapes, tmp_path) -> None:
    n = 20_000
    time_ns = np.arange(n) * 10_000_000
    noise = 0.1 * np.random.default_rng(4).standard_normal(n)
    lateral = np.clip(5 * np.sin(time_ns / NS) + noise, -3.0, 3.0)
    rows = {"/imu": (time_ns, {"accel_y": lateral})}
    converted, _ = both(tapes(Tape(rows)), tmp_path, rows=1000, window=1600)
    (decision,) = converted.record.decisions
    assert decision.found.startswith(f"{np.count_nonzero(np.abs(lateral) == 3.0)} samples of accel_y stand")


def test_parts_in_a_row_that_overlap_a_little(tapes, tmp_path) -> None:
    logs = Tape(with_faults(drive(120, 1e9))), Tape(drive(150, 1e9 + 119.3, 2)), Tape(drive(60, 1e9 + 300, 3))
    record = both(tapes(*logs), tmp_path)[0].record
    assert record.duration_s > 350
    assert not any("left out" in note for note in record.notes)


def test_a_second_recorder_is_left_out(tapes, tmp_path) -> None:
    second = {group: rows for group, rows in drive(100, 1e9 + 60, 2).items() if group in ("/imu", "/gps")}
    converted, _ = both(tapes(Tape(drive()), Tape(second)), tmp_path)
    assert any("left out" in note for note in converted.record.notes)


def test_a_log_that_only_the_second_one_makes_too_large(tapes, tmp_path) -> None:
    first = {"/gps": drive(60)["/gps"]}
    converted, _ = both(tapes(Tape(first), Tape(drive(200, 1e9 + 60))), tmp_path, rows=100_000)
    assert converted.record.duration_s > 250


def test_a_channel_that_stands_still_and_one_out_of_range(tapes, tmp_path) -> None:
    rows = drive()
    rows["/imu"][1]["roll_rate"][:] = 0.01
    rows["/odom"][1]["steering_wheel_angle"][::3] = 1e5
    found = both(tapes(Tape(rows)), tmp_path)[0].record.decisions
    assert {each.found.split(" stands")[0] for each in found if each.action == "left out"} == {"roll_rate"}
    assert any("much of steering_wheel_angle is beyond" in each.found and each.applied for each in found)
    assert not any("steering_wheel_angle_rad" in table for table in tables(tmp_path / "long").values())


def test_a_channel_that_stands_still_only_where_the_checks_look_stays(tapes, tmp_path) -> None:
    rows = drive(400)
    rate = rows["/imu"][1]["roll_rate"]
    rate[100:] = 0.01
    budget = Budget(tmp_path / "out", **(SMALL | {"evidence": 200_000}))
    made = convert_logs(tapes(Tape(rows)), LoadOptions(), tmp_path / "out", budget)
    assert not [each for each in made.record.decisions if each.action == "left out"]
    assert all(each.used for each in made.record.mapped)


def test_a_long_drive_is_judged_on_blocks_and_the_record_says_so(tapes, tmp_path) -> None:
    rows = drive(600)
    rows["/imu"][1]["yaw_rate"][:] *= -1
    folder = tmp_path / "out"
    budget = Budget(folder, **(SMALL | {"evidence": 400_000, "evidence_s": 120.0}))
    made = convert_logs(tapes(Tape(rows)), LoadOptions(), folder, budget).record
    assert [each.signal for each in made.decisions if each.kind == "sign"] == ["yaw_rate"]
    (note,) = [each for each in made.notes if "judged on 32 blocks" in each]
    assert 60 <= float(note.split("blocks of it, ")[1].split(" s in all")[0]) <= 121
    (imu,) = [table for name, table in tables(folder).items() if name.startswith("imu")]
    assert np.allclose(imu["yaw_rate_radps"], -rows["/imu"][1]["yaw_rate"])


def test_stamps_of_very_many_different_steps(tapes, tmp_path) -> None:
    rows = drive(400)
    time_ns, columns = rows["/imu"]
    rows["/imu"] = (time_ns + np.random.default_rng(1).integers(0, 4_000_000, len(time_ns)), columns)
    options, folder = LoadOptions(), tmp_path / "long"
    paths = tapes(Tape(rows))
    write_drive(load_drive(paths, options), tmp_path / "whole")
    made = convert_logs(paths, options, folder, Budget(folder, **SMALL)).record
    assert any("steps rounded to" in note for note in made.notes)
    expected = {each["signal"]: each["rate_hz"] for each in record(tmp_path / "whole")["mapped"]}
    assert {each.signal: each.rate_hz for each in made.mapped} == pytest.approx(expected, rel=1e-3)
    assert all(table.equals(tables(folder)[name]) for name, table in tables(tmp_path / "whole").items())


def test_a_small_drive_stays_in_memory(tapes, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(parsers.long_drive, "survey_part", None)
    paths = tapes(Tape(drive(60)))
    made = convert_logs(paths, LoadOptions(), tmp_path / "out")
    write_drive(load_drive(paths), tmp_path / "whole")
    assert record(tmp_path / "out") == record(tmp_path / "whole")
    assert made.signals == 11


class Broken(Tape):
    """A log that ends with an error."""

    error: BaseException = KeyboardInterrupt()

    def read(self, wanted: frozenset[str]) -> Iterator[Chunk]:
        yield from super().read(wanted)
        raise self.error


@pytest.mark.parametrize(
    ("error", "raised"), [(KeyboardInterrupt(), KeyboardInterrupt), (OSError(5, "broken"), LogError)]
)
def test_an_interruption_leaves_nothing_behind(tapes, tmp_path, error, raised) -> None:
    log = Broken(drive())
    log.error = error
    folder = tmp_path / "out"
    with pytest.raises(raised):
        convert_logs(tapes(log), LoadOptions(), folder, Budget(folder, **SMALL))
    assert not folder.exists()


@pytest.mark.parametrize(
    "error", [OSError(28, "No space left on device"), KeyboardInterrupt(), ValueError("slip")]
)
def test_an_error_while_writing_leaves_the_earlier_tables(tapes, tmp_path, monkeypatch, error) -> None:
    folder = tmp_path / "out"
    paths = tapes(Tape(drive()))
    budget = Budget(folder, **SMALL)
    convert_logs(paths, LoadOptions(), folder, budget)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    calls = []

    def failing(*arguments: object) -> object:
        calls.append(1)
        if len(calls) > 5:
            raise error
        return parsers.store.group_table(*arguments)

    monkeypatch.setattr(parsers.long_drive, "group_table", failing)
    raised = LogError if isinstance(error, OSError) else type(error)
    with pytest.raises(raised):
        convert_logs(paths, LoadOptions(), folder, budget)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_a_full_disk_while_reading_is_said(tapes, tmp_path, monkeypatch) -> None:
    folder = tmp_path / "out"

    def full(*_: object) -> int:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("parsers.spool.Spool.put", full)
    with pytest.raises(LogError, match=r"out: cannot be written \(No space left on device\); choose another"):
        convert_logs(tapes(Tape(drive())), LoadOptions(), folder, Budget(folder, **SMALL))
    assert not folder.exists()


def test_tables_of_others_are_said_before_the_work(tapes, tmp_path) -> None:
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "mine.parquet").write_bytes(b"x")
    with pytest.raises(LogError, match="did not write"):
        convert_logs(tapes(Broken(drive())), LoadOptions(), folder)


def test_a_database_without_frames_is_said_of_a_long_log(tapes, tmp_path) -> None:
    folder = tmp_path / "out"
    options = LoadOptions(dbc=(tmp_path / "a.dbc",))
    record = convert_logs(tapes(Tape(drive())), options, folder, Budget(folder, **SMALL)).record
    assert any("--dbc a.dbc was not used" in note for note in record.notes)


def test_nothing_valid_in_a_long_log(tapes, tmp_path) -> None:
    rows = drive()
    for _, columns in rows.values():
        for values in columns.values():
            values[:] = np.nan
    folder = tmp_path / "out"
    with pytest.raises(LogError, match="no signal has two valid samples"):
        convert_logs(tapes(Tape(rows)), LoadOptions(), folder, Budget(folder, **SMALL))
    assert not folder.exists()
