"""Several files of one drive: pieces whose stamps begin anew, pieces that overlap, and what is said of them."""

from __future__ import annotations

import json
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from parsers.apart import apart_notes
from parsers.convert import convert_logs
from parsers.errors import LogError
from parsers.intake import Budget
from parsers.load import LoadOptions, load_drive
from parsers.store import write_drive
from parsers.store_folder import RECORD_FILE
from parsers.timebase import NS

DBC = """VERSION ""
BU_: E
BO_ 256 Motion: 4 E
 SG_ VehicleSpeed : 0|16@1+ (0.01,0) [0|0] "km/h" E
 SG_ YawRate : 16|16@1- (0.0001,0) [0|0] "rad/s" E
BO_ 257 Driver: 2 E
 SG_ SteeringWheelAngle : 0|16@1- (0.001,0) [0|0] "rad" E
"""
BEGAN = datetime(2026, 11, 23, 8)
SMALL = {"rows": 2_000, "pending": 600, "window": 3_000, "evidence": 1 << 40, "evidence_s": 1e9}


def counts(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Speed, yaw rate and steering wheel angle at these times of the drive, as the bus has them."""
    speed = np.rint(100 * (60 + t + 20 * np.sin(t / 7)))
    return speed, np.rint(1e4 * 0.3 * np.sin(t / 1.7)), np.rint(1e3 * 2 * np.sin(t / 1.7 + 0.2))


def frames(start: float, stop: float, zero: float) -> list[tuple[float, int, str]]:
    """(stamp, id, payload) of a piece of the drive; stamps count from `zero`."""
    found = []
    t = np.arange(round(start * 50), round(stop * 50)) / 50
    for at, speed, yaw, wheel in zip(t, *(c.astype("<i2") for c in counts(t)), strict=True):
        found.append((at - zero, 256, (speed.tobytes() + yaw.tobytes()).hex()))
        found.append((at - zero + 0.001, 257, wheel.tobytes().hex()))
    return found


def spaced(payload: str) -> str:
    return " ".join(payload[k : k + 2] for k in range(0, len(payload), 2))


def asc(path: Path, start: float, stop: float, zero: float, dated: float | None) -> Path:
    """dated: the header's date as seconds of the drive."""
    lines = ["base hex timestamps absolute"]
    if dated is not None:
        moment = BEGAN + timedelta(seconds=dated)
        lines.insert(0, moment.strftime("date Mon Nov 23 %H:%M:%S.000 %Y"))
    for t, key, payload in frames(start, stop, zero):
        lines.append(f"{t:11.6f} 1 {key:X} Rx d {len(payload) // 2} {spaced(payload)}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def trc(path: Path, start: float, stop: float, zero: float, dated: float) -> Path:
    days = (BEGAN - datetime(1899, 12, 30)) / timedelta(days=1) + dated / 86400
    lines = [";$FILEVERSION=2.1", f";$STARTTIME={days:.10f}", ";$COLUMNS=N,O,T,B,I,d,R,L,D"]
    for n, (t, key, payload) in enumerate(frames(start, stop, zero), 1):
        lines.append(f"{n:7d} {t * 1000:13.3f} DT 1 {key:04X} Rx -  {len(payload) // 2}    {spaced(payload)}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def candump(path: Path, start: float, stop: float, *, absolute: bool = True, lose: int = 0) -> Path:
    """absolute: seconds since 1970, else the date and time of `candump -t A`. lose: how many frames at the front."""
    lines = []
    for t, key, payload in frames(start, stop, 0)[lose:]:
        moment = BEGAN + timedelta(microseconds=round(t * 1e6))
        if absolute:
            lines.append(f"({1_700_000_000 + t:.6f}) can0 {key:03X}#{payload}")
        else:
            lines.append(
                f" ({moment.isoformat(' ', 'microseconds')})  can0  {key:03X}   [{len(payload) // 2}]  {spaced(payload)}"
            )
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def table(path: Path, start: float, stop: float, zero: float) -> Path:
    t = np.arange(round(start * 50), round(stop * 50)) / 50
    speed, yaw, _ = counts(t)
    data = {"time_s": np.round(t - zero, 3), "speed_mps": speed / 360, "yaw_rate_radps": yaw / 1e4}
    pl.DataFrame(data).write_csv(path)
    return path


@pytest.fixture
def convert(tmp_path: Path):
    """Convert in memory and through the disk, require the same of both: the tables' signals, and the record."""

    def run(*logs: Path) -> tuple[dict[str, tuple[np.ndarray, np.ndarray]], dict[str, object]]:
        base = tmp_path / "v.dbc"
        base.write_text(DBC, encoding="utf-8")
        options = LoadOptions(dbc=(base,), dbc_given=False)
        drive = load_drive(logs, options)
        write_drive(drive, tmp_path / "whole")
        convert_logs(logs, options, tmp_path / "long", Budget(tmp_path / "long", **SMALL))
        records = [
            json.loads((tmp_path / name / RECORD_FILE).read_text(encoding="utf-8"))
            for name in ("whole", "long")
        ]
        assert records[0] == records[1]
        for file in (tmp_path / "whole").glob("*.parquet"):
            assert pl.read_parquet(tmp_path / "long" / file.name).equals(pl.read_parquet(file))
        found = {name: (s.time_ns, s.values) for name, s in drive.signals.items()}
        return found, records[0]

    return run


def is_whole(found: dict[str, tuple[np.ndarray, np.ndarray]], seconds: float) -> bool:
    """Whether speed and yaw rate are those of the drive, from its beginning and with every sample once."""
    zero = found["speed"][0][0]
    t = np.arange(round(seconds * 50)) / 50
    speed, yaw, _ = counts(t)
    return all(
        len(found[name][0]) == len(t)
        and np.abs((found[name][0] - zero) / NS - t).max() < 2e-5
        and np.abs(found[name][1] - expected).max() < 1e-9
        for name, expected in (("speed", speed / 360), ("yaw_rate", yaw / 1e4))
    )


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("write", [asc, trc])
def test_pieces_that_begin_at_zero_are_laid_by_the_dates_in_their_headers(write, order, convert, tmp_path):
    logs = [write(tmp_path / f"{k}.log", 20 * k, 20 * k + 20, 20 * k, 20 * k) for k in range(3)]
    found, record = convert(*logs[::order])
    assert is_whole(found, 60)
    assert record["duration_s"] == pytest.approx(59.981, abs=1e-4)
    assert all(entry["used"] for entry in record["mapped"])
    (note,) = [note for note in record["notes"] if "relative" in note]
    assert "by the dates in their headers" in note
    assert "(1.log 20 s, 2.log 40 s after 0.log), which are whole seconds" in note


def test_pieces_with_a_date_before_each_frame_are_laid_by_it(convert, tmp_path):
    logs = [candump(tmp_path / f"{k}.log", 20 * k, 20 * k + 20, absolute=False) for k in range(2)]
    found, record = convert(*logs)
    assert is_whole(found, 40)
    assert any("by the dates in their headers" in note for note in record["notes"])


@pytest.mark.parametrize("dated", [(0.0, 0.0), (0.0, 20.0), (None, None)])
def test_stamps_that_run_on_are_left_as_they_are_whatever_the_dates_mean(dated, convert, tmp_path):
    logs = [asc(tmp_path / f"{k}.asc", 20 * k, 20 * k + 20, 0, dated[k]) for k in range(2)]
    found, record = convert(*logs)
    assert is_whole(found, 40)
    assert any("their zeros are taken as one moment" in note for note in record["notes"])


def test_what_damage_took_moves_with_its_log(convert, tmp_path):
    logs = [asc(tmp_path / f"{k}.asc", 20 * k, 20 * k + 20, 20 * k, 20 * k) for k in range(2)]
    lines = logs[1].read_text(encoding="utf-8").split("\n")
    logs[1].write_text("\n".join([*lines[:500], *["~" * 40] * 9, *lines[700:]]), encoding="utf-8")
    gaps = [(gap["start_s"], gap["end_s"]) for gap in convert(*logs)[1]["gaps"]]
    assert all(24.5 < start < 25.5 and 26.5 < end < 27.5 for start, end in gaps)
    assert gaps


@pytest.mark.parametrize("dated", [0.0, None])
def test_pieces_that_begin_at_zero_without_a_date_are_refused(dated, convert, tmp_path):
    logs = [asc(tmp_path / f"{k}.asc", 20 * k, 20 * k + 20 - k, 20 * k, dated) for k in range(2)]
    with pytest.raises(LogError, match=r"1\.asc: its stamps begin anew, as those of 0\.asc do.*speed"):
        convert(*logs)


def test_table_pieces_that_begin_at_zero_are_refused_in_memory_and_on_disk(tmp_path):
    logs = [table(tmp_path / f"{k}.csv", 20 * k, 20 * k + 20, 20 * k) for k in range(2)]
    with pytest.raises(LogError, match="begin anew"):
        load_drive(logs)
    with pytest.raises(LogError, match="begin anew"):
        convert_logs(logs, LoadOptions(), tmp_path / "out", Budget(tmp_path / "out", **SMALL))


def test_one_of_the_logs_says_nothing_of_its_start(convert, tmp_path):
    logs = [asc(tmp_path / f"{k}.asc", 20 * k, 20 * k + 20, 20 * k, (0.0, 20.0, None)[k]) for k in range(3)]
    with pytest.raises(LogError, match=r"2\.asc: its stamps count from its own start and it does not say"):
        convert(*logs)


def test_recorders_side_by_side_stay_side_by_side(convert, tmp_path):
    first = table(tmp_path / "one.csv", 0, 40, 0)
    second = table(tmp_path / "two.csv", 0, 36, 0)
    frame = pl.read_csv(second)
    # the same drive by sensors of their own, whose clock is a little late
    noise = np.random.default_rng(1).normal(0, 0.02, frame.height)
    frame.with_columns(pl.col("speed_mps") + noise, pl.col("time_s") + 0.013).write_csv(second)
    found, record = convert(first, second)
    assert is_whole(found, 40)
    assert sum(entry["used"] for entry in record["mapped"]) == 2
    assert any("speed is in several logs over the same time" in note for note in record["notes"])


@pytest.mark.parametrize("order", [1, -1])
def test_pieces_that_overlap_with_the_same_samples_are_joined(order, convert, tmp_path):
    spans = ((0, 20), (15, 45), (40, 55))
    logs = [candump(tmp_path / f"{a}.log", a, b) for a, b in spans]
    found, record = convert(*logs[::order])
    assert is_whole(found, 55)
    assert all(entry["used"] for entry in record["mapped"])
    notes = [note for note in record["notes"] if "hold the same samples there, which count once" in note]
    assert len(notes) == 2
    assert all("overlap by 5.0 s" in note and "speed" in note for note in notes)


def test_a_copy_within_another_log_is_left_out(convert, tmp_path):
    found, record = convert(candump(tmp_path / "a.log", 0, 40), candump(tmp_path / "b.log", 10, 30))
    assert is_whole(found, 40)
    assert any("speed is in several logs over the same time" in note for note in record["notes"])


@pytest.mark.parametrize("apart", [1000, -1_700_000_000])
def test_buses_whose_clocks_have_nothing_in_common_are_said(apart, convert, tmp_path):
    log = candump(tmp_path / "a.log", 0, 40)
    lines = log.read_text(encoding="utf-8").split("\n")
    for k, line in enumerate(lines):
        if " 101#" in line:
            stamp = float(line[1 : line.index(")")]) + apart
            lines[k] = f"({stamp:017.6f}) can1 {line.split()[2]}"
    log.write_text("\n".join(lines), encoding="utf-8")
    (note,) = [note for note in convert(log)[1]["notes"] if "share no time" in note]
    earlier, later = ("speed, yaw_rate", "steering_wheel_angle")[:: 1 if apart > 0 else -1]
    between = abs(apart) - 40 + 0.02
    assert f"{earlier} end at 40.0 s; {later} begin at {abs(apart):.1f} s, {between:.1f} s after that" in note


def test_signals_that_hang_together_by_others_are_not_apart():
    spans = {"speed": (0, 50), "roll": (60, 90), "yaw_rate": (40, 60)}
    assert apart_notes(spans) == []
    (note,) = apart_notes(spans | {"pitch": (91 * NS, 95 * NS), "heave": (200 * NS, 201 * NS)})
    assert "pitch begin at 91.0 s" in note
    assert "heave begin at 200.0 s, 105.0 s after that" in note


def test_signals_that_are_there_for_a_part_of_the_drive_are_named():
    spans = {"speed": (0, 150 * NS), "roll": (2 * NS, 149 * NS)}
    assert apart_notes(spans) == []
    half = {f"suspension_deflection_{wheel}": (0, 75 * NS) for wheel in ("fl", "fr")}
    (note,) = apart_notes(spans | half | {"pitch": (40 * NS, 150 * NS)})
    assert (
        "for a part of the 150 s only: pitch begin at 40 s; suspension_deflection_fl, suspension_deflection_fr end at 75 s"
        in note
    )
