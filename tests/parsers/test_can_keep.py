"""What the CAN reader keeps of a log's frames: how much changes nothing in what it gives."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from can_rows import CAR, Listed, open_rows, read_all, result

from parsers.can.frames import EXTENDED, CanFrames
from parsers.can.reader import CanReader
from parsers.importer import ImportLog, ReadOptions


def many_rows(count: int) -> list[tuple[int, int, int, bytes]]:
    """Frames of two buses, known, unknown, multiplexed, of any length, and 29-bit ones of two senders in turn."""
    rng = np.random.default_rng(7)
    ids = (291, 512, 999, 0x18F0090B | EXTENDED, 0x0CF0090B | EXTENDED, 0x18F00921 | EXTENDED)
    rows = []
    for k in range(count):
        data = bytes([k % 2]) + rng.bytes(int(rng.integers(0, 12)))
        rows.append((k, ids[int(rng.integers(len(ids)))], 1 + k % 2, data))
    return rows


@pytest.mark.parametrize(
    "limits",
    [
        {"keep.ROWS": 7},
        {"keep.WORDS": 9},
        {"keep.PICKS": 5},
        {"piece_decode.VALUES": 1},
        {"reader.KEPT_BYTES": 0},
        {"reader.KEPT_BYTES": 2000, "keep.ROWS": 40},
    ],
    ids=str,
)
def test_how_much_is_kept_at_a_time_changes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, limits: dict[str, int]
) -> None:
    rows = many_rows(900)
    expected = result(*open_rows(tmp_path, rows, CAR))
    assert expected[1] == 900
    for name, value in limits.items():
        monkeypatch.setattr(f"parsers.can.{name}", value)
    assert result(*open_rows(tmp_path, rows, CAR)) == expected


def test_a_log_too_large_to_keep_is_gone_through_twice_and_counted_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("parsers.can.reader.KEPT_BYTES", 0)
    dbc = tmp_path / "car.dbc"
    dbc.write_text(CAR)
    passes: list[bool] = []

    class Watched(Listed):
        def frames(self, *, counting: bool) -> Iterator[CanFrames]:
            passes.append(counting)
            return super().frames(counting=counting)

    log = ImportLog()
    steps: list[tuple[int, int]] = []
    options = ReadOptions(dbc=(dbc,), progress=lambda done, total: steps.append((done, total)))
    reader = CanReader(Watched(many_rows(50), log), options, log, tmp_path)
    assert passes == [True]
    assert read_all(reader)
    assert (passes, log.messages) == ([True, False], 50)
    assert steps[-1][0] == steps[-1][1]


def test_what_was_kept_is_given_up_and_reading_again_gives_the_same(tmp_path: Path) -> None:
    reader, log = open_rows(tmp_path, many_rows(200), CAR)
    first = read_all(reader)
    # a second reading counts what it rejects anew
    log.rejected.clear()
    again = read_all(reader)
    assert first.keys() == again.keys()
    for name, (times, values) in first.items():
        assert again[name][0] == times
        np.testing.assert_array_equal(again[name][1], values)


def test_ids_of_one_stream_stay_in_the_order_of_the_log(tmp_path: Path) -> None:
    # two priorities of one sender, in turn, with a stamp that goes back
    ids = (0x0CFEF100, 0x18FEF100)
    rows = [
        (t, ids[k % 2] | EXTENDED, 1, b"\xff" + bytes([0, k]) + b"\xff" * 5)
        for k, t in enumerate([5, 6, 3, 9])
    ]
    reader, _ = open_rows(tmp_path, rows)
    assert read_all(reader)["CCVS1.WheelBasedVehicleSpeed"] == ([5, 6, 3, 9], [0.0, 1.0, 2.0, 3.0])


@pytest.mark.parametrize("most", [1 << 20, 256])
def test_thousands_of_identifiers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, most: int) -> None:
    monkeypatch.setattr("parsers.can.keep.MOST_IDS", most)
    rows = [(0, 291, 1, b"\x01\x00")] + [(k, k | EXTENDED, 1 + k % 3, b"") for k in range(3000)]
    rows.append((9, 291, 1, b"\x02\x00"))
    reader, log = open_rows(tmp_path, rows, CAR)
    assert read_all(reader, {"Motion.YawRate"})["Motion.YawRate"] == ([0, 9], [0.01, 0.02])
    counted = min(most, 3001)
    assert sum(reader._keeper.seen().values()) == counted + 1
    assert log.rejected["frame of one identifier too many to tell apart"] == 3001 - counted
