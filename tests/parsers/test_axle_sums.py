"""Loads that come axle by axle: the rear axles' sum, in memory and from the disk, and what is refused or said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import polars as pl
import pytest

from parsers.axle_rows import MAX_AGE_NS, AxleSum, AxleSurvey
from parsers.convert import convert_logs
from parsers.drive import Drive
from parsers.errors import MappingError
from parsers.intake import Budget
from parsers.load import LoadOptions, load_drive
from parsers.mapping import read_map
from parsers.timebase import NS

G = 9.80665
FRONT, SECOND, THIRD = 0x00, 0x10, 0x20


def frame(at_s: float, place: int, kg: float) -> str:
    payload = bytes([place]) + round(kg / 0.5).to_bytes(2, "little") + b"\xff" * 5
    return f"({at_s:.6f}) can0 18FEEA2F#{payload.hex().upper()}"


def truck(
    folder: Path, seconds: int = 60, without: tuple[int, int] = (0, 0), twin: int | None = None
) -> Path:
    """Three axles, 0.2 ms apart, once a second; the third is silent in a span. twin: a second place of the third."""
    lines = []
    for k in range(seconds):
        lines += [frame(k, FRONT, 6000 + k), frame(k + 0.0002, SECOND, 9000 + 2 * k)]
        if not without[0] <= k < without[1]:
            lines.append(frame(k + 0.0004, THIRD, 8000 + 4 * k))
        if twin is not None:
            lines.append(frame(k + 0.0006, twin, 100))
        lines += [f"({k + n / 50:.6f}) can0 18FEF100#FF{5000 + k:04X}FFFFFFFFFF" for n in range(1, 50)]
    path = folder / "truck.log"
    path.write_text("\n".join(lines) + "\n")
    return path


def loads(drive: Drive, signal: str) -> tuple[np.ndarray, np.ndarray]:
    found = drive.signals[signal]
    return found.time_ns / NS, found.values / G


def test_the_rear_axles_are_summed_and_said(tmp_path: Path) -> None:
    drive = load_drive([truck(tmp_path)])
    seconds, kg = loads(drive, "axle_load_rear")
    assert seconds == pytest.approx(np.arange(60) + 0.0004)
    assert kg == pytest.approx(17000 + 6 * np.arange(60))
    assert loads(drive, "axle_load_front")[1] == pytest.approx(6000 + np.arange(60))
    (note,) = (note for note in drive.record.notes if "sum of axles" in note)
    assert note.startswith(
        "axle_load_rear is the sum of axles 2 + 3 (VW.AxleWeight, VW.AxleLocation 0x10, 0x20)"
    )
    assert "steers as well" in note
    rules = {entry.signal: entry.rule for entry in drive.record.mapped}
    assert rules["axle_load_rear"].endswith("sum of axles 2 + 3")


def test_no_sum_without_one_of_the_axles(tmp_path: Path) -> None:
    seconds, kg = loads(load_drive([truck(tmp_path, without=(20, 40))]), "axle_load_rear")
    there = np.array([*range(20), *range(40, 60)])
    assert seconds == pytest.approx(there + 0.0004)
    assert kg == pytest.approx(17000 + 6 * there)


def test_one_rear_axle_is_taken_as_it_is(tmp_path: Path) -> None:
    drive = load_drive([truck(tmp_path, without=(0, 60))])
    assert loads(drive, "axle_load_rear")[1] == pytest.approx(9000 + 2 * np.arange(60))
    assert not any("sum of axles" in note for note in drive.record.notes)


def test_a_damaged_frame_makes_no_axle(tmp_path: Path) -> None:
    path = truck(tmp_path, seconds=200)
    path.write_text(path.read_text() + frame(199.5, 0x71, 1.0) + "\n")
    drive = load_drive([path])
    assert loads(drive, "axle_load_rear")[1] == pytest.approx(17000 + 6 * np.arange(200))
    assert any("0x71" in note and "too seldom" in note for note in drive.record.notes)


def test_several_loads_of_one_axle_are_refused(tmp_path: Path) -> None:
    drive = load_drive([truck(tmp_path, twin=0x21)])
    assert "axle_load_rear" not in drive.signals
    assert "axle_load_front" in drive.signals
    (note,) = (note for note in drive.record.notes if "several places" in note)
    assert "axle 3 has loads at several places (0x20, 0x21)" in note
    assert not any("fewer than two" in note and "axle_load_rear" in note for note in drive.record.notes)


@pytest.mark.parametrize("long", [False, True])
def test_frames_that_share_a_stamp_are_refused(tmp_path: Path, long: bool) -> None:
    path = truck(tmp_path)
    path.write_text(path.read_text().replace(".000200)", ".000400)"))
    budget = Budget(tmp_path / "out", rows=5_000, pending=2_000, window=3_000) if long else None
    record = convert_logs([path], LoadOptions(), tmp_path / "out", budget).record
    assert not any(entry.signal.startswith("axle_load") for entry in record.mapped)
    assert any("axle_load_rear: 60 of its rows share a stamp" in note for note in record.notes)


def test_several_loads_of_the_front_axle_are_refused_too(tmp_path: Path) -> None:
    drive = load_drive([truck(tmp_path, twin=0x01)])
    assert "axle_load_front" not in drive.signals
    assert "axle_load_rear" in drive.signals
    assert any("axle 1 has loads at several places (0x00, 0x01)" in note for note in drive.record.notes)


def test_twin_steer_by_a_mapping_file(tmp_path: Path) -> None:
    path = tmp_path / "map.toml"
    text = '[signals.axle_load_{}]\nchannel = "VW.AxleWeight"\nwhere = ["VW.AxleLocation", {}]\nsum_axles = true\n'
    path.write_text(text.format("front", "0, 31") + text.format("rear", "32, 239"))
    drive = load_drive([truck(tmp_path)], LoadOptions(map=read_map(path)))
    assert loads(drive, "axle_load_front")[1] == pytest.approx(15000 + 3 * np.arange(60))
    assert loads(drive, "axle_load_rear")[1] == pytest.approx(8000 + 4 * np.arange(60))


@pytest.mark.parametrize(
    "rest", ["", 'where = ["B", 0, 31]\nadd = ["C"]', 'where = ["B", 0, 31]\nsign_channel = "C"']
)
def test_a_sum_needs_what_tells_the_axle(tmp_path: Path, rest: str) -> None:
    path = tmp_path / "map.toml"
    path.write_text(f'[signals.axle_load_rear]\nchannel = "A"\nsum_axles = true\n{rest}\n')
    with pytest.raises(MappingError, match="sum_axles needs where"):
        read_map(path)


def test_a_long_drive_gives_the_same_sums(tmp_path: Path) -> None:
    path = truck(tmp_path, seconds=900, without=(300, 400))
    expected = load_drive([path]).signals["axle_load_rear"]
    budget = Budget(tmp_path / "long", rows=20_000, pending=6_000, window=3_000)
    record = convert_logs([path], LoadOptions(), tmp_path / "long", budget).record
    (file,) = (tmp_path / "long").glob("*axle_load_rear*.parquet")
    table = pl.read_parquet(file)
    assert table["time_ns"].to_numpy() == pytest.approx(expected.time_ns)
    assert table["axle_load_rear_n"].to_numpy() == pytest.approx(expected.values)
    assert any("sum of axles 2 + 3" in note for note in record.notes)


def test_pieces_give_what_the_whole_gives() -> None:
    rng = np.random.default_rng(3)
    n = 4000
    time_ns = np.cumsum(rng.integers(1, NS // 3, n))
    place = rng.choice([0.0, 16.0, 32.0, 48.0, np.nan], n)
    load = np.where(rng.random(n) < 0.1, np.nan, rng.random(n))
    whole = AxleSurvey(16, 239)
    whole.add(time_ns, place, load)
    plan = whole.plan()
    assert plan.axles == (1, 2, 3)
    parts = AxleSurvey(16, 239)
    cuts = [slice(a, a + 37) for a in range(0, n, 37)]
    for cut in cuts:
        parts.add(time_ns[cut], place[cut], load[cut])
    assert parts.plan().axles == plan.axles
    stamps, sums = AxleSum(plan, 16, 239).add(time_ns, place, load)
    total = AxleSum(plan, 16, 239)
    pieces = [total.add(time_ns[cut], place[cut], load[cut]) for cut in cuts]
    assert np.concatenate([piece[0] for piece in pieces]) == pytest.approx(stamps)
    assert np.concatenate([piece[1] for piece in pieces]) == pytest.approx(sums)
    # by hand: each axle's latest load at the reference's rows
    at = int(np.searchsorted(time_ns, stamps[100]))
    good = np.isfinite(load)
    latest = [np.flatnonzero((place == 16.0 * axle) & good)[:] for axle in plan.axles]
    rows = [each[each <= at][-1] for each in latest]
    assert sums[100] == pytest.approx(load[rows].sum())
    assert all(time_ns[at] - time_ns[row] <= MAX_AGE_NS for row in rows)


def test_the_sum_is_made_at_the_end_of_a_round_and_at_the_slowest_axle_s_rows() -> None:
    quick = np.arange(0, 60 * NS, NS // 10)
    slow = np.arange(0, 60 * NS, NS) + 1000
    time_ns = np.concatenate([quick, slow])
    order = np.argsort(time_ns)
    place = np.concatenate([np.full(len(quick), 16.0), np.full(len(slow), 32.0)])[order]
    survey = AxleSurvey(16, 239)
    survey.add(time_ns[order], place, np.ones(len(place)))
    plan = survey.plan()
    assert plan.reference == 2
    stamps, sums = AxleSum(plan, 16, 239).add(time_ns[order], place, np.ones(len(place)))
    assert stamps.tolist() == slow.tolist()
    assert set(sums.tolist()) == {2.0}
