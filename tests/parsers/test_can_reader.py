"""The shared CAN reader: which channels a log has, their names and groups, and what `read` gives."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import can
import cantools
import numpy as np
import pytest

from parsers.can.frames import EXTENDED, CanFrames
from parsers.can.reader import CanReader
from parsers.importer import ImportLog, ReadOptions
from parsers.registry import find_importer

REAL = Path(__file__).resolve().parents[3] / "shared" / "real_logs"

CAR = """VERSION ""

BU_: A

BO_ 291 Motion: 8 A
 SG_ YawRate : 0|16@1- (0.01,0) [0|0] "deg/s" A
 SG_ Speed : 23|16@0+ (0.01,0) [0|0] "km/h" A

BO_ 512 Muxed: 8 A
 SG_ Page M : 0|8@1+ (1,0) [0|0] "" A
 SG_ Always : 8|8@1+ (1,0) [0|0] "" A
 SG_ Left m0 : 16|8@1+ (1,0) [0|0] "" A
 SG_ LeftToo m0 : 24|8@1- (1,0) [0|0] "" A
 SG_ Right m1 : 16|8@1+ (1,0) [0|0] "bar" A

BO_ 768 Absent: 8 A
 SG_ Nothing : 0|8@1+ (1,0) [0|0] "" A
"""

NESTED = """VERSION ""

BU_: A

BO_ 100 Nest: 8 A
 SG_ S0 M : 0|4@1+ (1,0) [0|0] "" A
 SG_ S1 m0M : 4|4@1+ (1,0) [0|0] "" A
 SG_ Deep m1 : 8|8@1+ (1,0) [0|0] "" A
 SG_ Range m3 : 16|8@1+ (1,0) [0|0] "" A

SG_MUL_VAL_ 100 S1 S0 0-0;
SG_MUL_VAL_ 100 Deep S1 1-2, 5-5;
SG_MUL_VAL_ 100 Range S0 3-4;
"""


class Listed:
    """A FrameSource over rows (time_ns, can_id, bus, payload), `batch` rows at a time."""

    clock = "test clock"
    absolute = False
    start_utc_ns = None

    def __init__(self, rows: list[tuple[int, int, int, bytes]], log: ImportLog, batch: int = 3) -> None:
        self.rows, self.log, self.batch = rows, log, batch

    def frames(self, *, counting: bool) -> Iterator[CanFrames]:
        for begin in range(0, len(self.rows), self.batch):
            rows = self.rows[begin : begin + self.batch]
            sizes = np.array([len(row[3]) for row in rows], dtype=np.int64)
            if counting:
                self.log.messages += len(rows)
            yield CanFrames(
                np.array([row[0] for row in rows], dtype=np.int64),
                np.array([row[1] for row in rows], dtype=np.uint32),
                np.array([row[2] for row in rows], dtype=np.int16),
                sizes.astype(np.uint8),
                np.cumsum(sizes) - sizes,
                np.frombuffer(b"".join(row[3] for row in rows), dtype=np.uint8),
            )


def open_rows(
    tmp_path: Path, rows: list[tuple[int, int, int, bytes]], *dbcs: str
) -> tuple[CanReader, ImportLog]:
    paths = []
    for index, text in enumerate(dbcs):
        path = tmp_path / f"db{index}.dbc"
        path.write_text(text, encoding="cp1252")
        paths.append(path)
    log = ImportLog()
    return CanReader(Listed(rows, log), ReadOptions(dbc=tuple(paths)), log, tmp_path / "log"), log


def read_all(reader: CanReader, wanted: set[str] | None = None) -> dict[str, tuple[list[int], list[float]]]:
    """Channel -> (times, values), chunks joined."""
    names = frozenset(wanted if wanted is not None else (c.name for c in reader.channels))
    result: dict[str, tuple[list[int], list[float]]] = {}
    for chunk in reader.read(names):
        for name, values in chunk.columns.items():
            times, column = result.setdefault(name, ([], []))
            times += chunk.time_ns.tolist()
            column += values.tolist()
    return result


def test_channels_of_present_messages_only_and_their_tags(tmp_path: Path) -> None:
    rows = [(i * 10, 291, 1, bytes([i, 0, 0, 100, 0, 0, 0, 0])) for i in range(7)]
    reader, log = open_rows(tmp_path, rows, CAR)
    assert [c.name for c in reader.channels] == ["Motion.YawRate", "Motion.Speed"]
    yaw = reader.channels[0]
    assert (yaw.group, yaw.unit, yaw.family, yaw.kind, yaw.count) == ("Motion", "deg/s", "can", "number", 7)
    assert dict(yaw.tags) == {"message": "Motion", "signal": "YawRate", "id": "291", "bus": "1"}
    assert log.messages == 7
    got = read_all(reader)
    assert got["Motion.YawRate"] == ([i * 10 for i in range(7)], [i * 0.01 for i in range(7)])
    assert got["Motion.Speed"][1] == [1.0] * 7
    assert log.messages == 7


def test_only_wanted_signals_are_decoded(tmp_path: Path) -> None:
    reader, log = open_rows(tmp_path, [(0, 291, 1, b"\x01\x00")], CAR)
    assert read_all(reader, {"Motion.YawRate", "No.Such"}) == {"Motion.YawRate": ([0], [0.01])}
    assert not log.rejected


def test_short_frames_are_counted_once_a_frame(tmp_path: Path) -> None:
    rows = [(0, 291, 1, bytes(8)), (1, 291, 1, b"\x01"), (2, 291, 1, b"")]
    reader, log = open_rows(tmp_path, rows, CAR)
    got = read_all(reader)
    assert np.isnan(got["Motion.YawRate"][1]).tolist() == [False, True, True]
    assert dict(log.rejected) == {"Motion: frame shorter than the DBC says": 2}


def test_multiplexed_signals_have_their_own_groups_and_times(tmp_path: Path) -> None:
    rows = [(i, 512, 1, bytes([i % 3, i, 10 + i, 250, 0, 0, 0, 0])) for i in range(6)]
    reader, _ = open_rows(tmp_path, rows, CAR)
    groups = {c.name: c.group for c in reader.channels}
    assert groups == {
        "Muxed.Page": "Muxed",
        "Muxed.Always": "Muxed",
        "Muxed.Left": "Muxed/Page=0",
        "Muxed.LeftToo": "Muxed/Page=0",
        "Muxed.Right": "Muxed/Page=1",
    }
    got = read_all(reader)
    assert got["Muxed.Always"] == ([0, 1, 2, 3, 4, 5], [0, 1, 2, 3, 4, 5])
    assert got["Muxed.Left"] == ([0, 3], [10, 13])
    assert got["Muxed.LeftToo"] == ([0, 3], [-6, -6])
    assert got["Muxed.Right"] == ([1, 4], [11, 14])


def test_extended_multiplexing_equals_cantools(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    rows = [
        (i, 100, 1, bytes([int(rng.integers(0, 6)) | int(rng.integers(0, 7)) << 4, *rng.bytes(7)]))
        for i in range(300)
    ]
    peer = cantools.database.load_string(NESTED, "dbc", strict=False)
    expected: dict[str, tuple[list[int], list[float]]] = {}
    for time_ns, can_id, _, payload in rows:
        first, second = payload[0] & 15, payload[0] >> 4
        if first in (0, 3, 4) and (first != 0 or second in (1, 2, 5)):
            for name, value in peer.decode_message(can_id, payload).items():
                times, values = expected.setdefault(f"Nest.{name}", ([], []))
                times.append(time_ns)
                values.append(value)
    reader, _ = open_rows(tmp_path, rows, NESTED)
    assert {c.group for c in reader.channels} == {"Nest", "Nest/S0=0", "Nest/S0=0/S1=1-2,5", "Nest/S0=3-4"}
    got = read_all(reader)
    assert got["Nest.Deep"] == expected["Nest.Deep"]
    assert got["Nest.Range"] == expected["Nest.Range"]
    assert got["Nest.S0"][1] == [row[3][0] & 15 for row in rows]


def test_one_message_on_two_buses(tmp_path: Path) -> None:
    rows = [(0, 291, 2, bytes(8)), (1, 291, 1, bytes(8)), (2, 291, 2, bytes(8))]
    reader, log = open_rows(tmp_path, rows, CAR)
    assert [(c.name, c.group, c.tags["bus"]) for c in reader.channels][::2] == [
        ("Motion.YawRate", "Motion", "1"),
        ("Motion.YawRate@bus2", "Motion@bus2", "2"),
    ]
    assert any("@bus2" in note for note in log.notes)
    assert read_all(reader)["Motion.Speed@bus2"][0] == [0, 2]


def j1939_rows(can_id: int, values: list[int], start: int = 0) -> list[tuple[int, int, int, bytes]]:
    """CCVS1-like frames: 16 bits in bytes 2-3."""
    return [
        (start + i, can_id | EXTENDED, 1, b"\xff" + v.to_bytes(2, "little") + b"\xff" * 5)
        for i, v in enumerate(values)
    ]


def test_j1939_by_group_number_whatever_priority_and_sender(tmp_path: Path) -> None:
    dbc = (REAL / "truck_j1939.dbc") if (REAL / "truck_j1939.dbc").exists() else None
    if dbc is None:
        pytest.skip("shared/real_logs is not beside the repository")
    rows = j1939_rows(0x0CFEF100, [256, 512]) + j1939_rows(0x18FEF121, [256 * 9, 0xFFFF, 0xFE12, 0], 10)
    log = ImportLog()
    reader = CanReader(Listed(rows, log), ReadOptions(dbc=(dbc,)), log, tmp_path)
    plain, other = reader.channels
    assert (plain.name, plain.tags["source_address"], plain.count) == (
        "CCVS1.WheelBasedVehicleSpeed",
        "33",
        4,
    )
    assert (other.name, other.tags["source_address"]) == ("CCVS1.WheelBasedVehicleSpeed@sa0", "0")
    assert {key: plain.tags[key] for key in ("pgn", "spn", "extended", "id")} == {
        "pgn": "65265", "spn": "84", "extended": "1", "id": str(0x18FEF121),
    }  # fmt: skip
    got = read_all(reader)
    assert got["CCVS1.WheelBasedVehicleSpeed@sa0"] == ([0, 1], [1.0, 2.0])
    assert np.array_equal(got["CCVS1.WheelBasedVehicleSpeed"][1], [9.0, np.nan, np.nan, 0.0], equal_nan=True)
    assert dict(log.rejected) == {
        "CCVS1.WheelBasedVehicleSpeed: not available": 1,
        "CCVS1.WheelBasedVehicleSpeed: error indicator": 1,
    }
    assert any("source address 33 (4 frames)" in note for note in log.notes)


def test_builtin_j1939_without_a_database(tmp_path: Path) -> None:
    payload = (32125).to_bytes(2, "little") + b"\x20" + (32113).to_bytes(2, "little")
    payload += (32127).to_bytes(2, "little") + b"\x7d"
    reader, log = open_rows(tmp_path, [(5, 0x18F0090B | EXTENDED, 1, payload)])
    got = {name: values[1][0] for name, values in read_all(reader).items()}
    assert got["VDC2.SteeringWheelAngle"] == pytest.approx(32125 / 1024 - 31.374, abs=1e-12)
    assert got["VDC2.YawRate"] == pytest.approx(32113 / 8192 - 3.92, abs=1e-12)
    assert got["VDC2.LateralAcceleration"] == pytest.approx(32127 / 2048 - 15.687, abs=1e-12)
    assert got["VDC2.LongitudinalAcceleration"] == pytest.approx(0.0, abs=1e-12)
    assert any("own J1939 definitions" in note and "VDC2" in note for note in log.notes)


def test_pdu1_ignores_the_destination(tmp_path: Path) -> None:
    dbc = f'VERSION ""\n\nBU_:\n\nBO_ {0x8C0000FE} TSC1: 8 X\n SG_ S : 8|8@1+ (1,0) [0|0] "" X\n'
    rows = [(0, 0x0C000003 | EXTENDED, 1, bytes([0, 7])), (1, 0x0C00FF03 | EXTENDED, 1, bytes([0, 8]))]
    reader, _ = open_rows(tmp_path, rows, dbc)
    assert read_all(reader) == {"TSC1.S": ([0, 1], [7, 8])}
    assert reader.channels[0].tags["pgn"] == "0"


def test_plain_29_bit_ids_are_not_taken_for_j1939(tmp_path: Path) -> None:
    dbc = f'VERSION ""\n\nBU_:\n\nBO_ {0x92DD54D2} Own: 8 X\n SG_ S : 0|8@1+ (1,0) [0|0] "" X\n'
    rows = [(0, 0x12DD54D2 | EXTENDED, 1, b"\xff"), (1, 0x12DD54D3 | EXTENDED, 1, b"\x01")]
    reader, log = open_rows(tmp_path, rows, dbc)
    assert read_all(reader) == {"Own.S": ([0], [255])}
    assert "pgn" not in reader.channels[0].tags
    assert any("1 of 2 CAN identifiers" in note for note in log.notes)


def test_no_database_and_no_match_are_explained(tmp_path: Path) -> None:
    rows = [(0, 1, 1, b"\x01"), (1, 2, 1, b"\x01"), (2, 2, 1, b"\x01")]
    reader, log = open_rows(tmp_path, rows)
    assert reader.channels == ()
    assert any("2 CAN identifiers (3 frames)" in note and "--dbc" in note for note in log.notes)
    assert list(reader.read(frozenset({"x"}))) == []
    assert log.messages == 3
    _, log = open_rows(tmp_path, rows, CAR)
    assert any("0x001" in note and "0x123" in note for note in log.notes)
    _, log = open_rows(tmp_path, [], CAR)
    assert any("no CAN data frames" in note for note in log.notes)


def test_first_database_wins_and_the_clash_is_said(tmp_path: Path) -> None:
    other = CAR.replace('(0.01,0) [0|0] "deg/s"', '(5,0) [0|0] "deg/s"')
    reader, log = open_rows(tmp_path, [(0, 291, 1, b"\x01\0\0\0")], CAR, other)
    assert read_all(reader)["Motion.YawRate"][1] == [0.01]
    assert any("db1.dbc defines 0x123" in note for note in log.notes)


def test_messages_of_one_name_keep_apart(tmp_path: Path) -> None:
    other = CAR.replace("BO_ 291 Motion", "BO_ 292 Motion")
    reader, _ = open_rows(tmp_path, [(0, 291, 1, bytes(8)), (0, 292, 1, bytes(8))], CAR, other)
    names = [c.name for c in reader.channels]
    assert names == ["Motion.YawRate", "Motion.Speed", "Motion.YawRate@id292", "Motion.Speed@id292"]


def many_rows(count: int) -> list[tuple[int, int, int, bytes]]:
    """Frames of two buses, known, unknown, multiplexed, of any length, and 29-bit ones of two senders in turn."""
    rng = np.random.default_rng(7)
    ids = (291, 512, 999, 0x18F0090B | EXTENDED, 0x0CF0090B | EXTENDED, 0x18F00921 | EXTENDED)
    rows = []
    for k in range(count):
        data = bytes([k % 2]) + rng.bytes(int(rng.integers(0, 12)))
        rows.append((k, ids[int(rng.integers(len(ids)))], 1 + k % 2, data))
    return rows


def result(reader: CanReader, log: ImportLog) -> tuple[object, ...]:
    """All that a reader gives, NaN made comparable."""
    got = read_all(reader)
    values = {name: (times, [None if v != v else v for v in column]) for name, (times, column) in got.items()}
    return values, log.messages, dict(log.rejected), log.notes


@pytest.mark.parametrize(
    "limits",
    [
        {"keep.ROWS": 7},
        {"keep.WORDS": 9},
        {"keep.PICKS": 5},
        {"reader.VALUES": 1},
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


def test_all_64_bits_come_through(tmp_path: Path) -> None:
    dbc = 'VERSION ""\n\nBU_: A\n\nBO_ 5 W: 9 A\n SG_ Low : 0|16@1+ (1,0) [0|0] "" A\n SG_ D : 8|64@1- (1,0) [0|0] "" A\n\n'
    dbc += "SIG_VALTYPE_ 5 D : 2;\n"
    value = 1.2345678901234567
    rows = [(0, 5, 1, b"\x07" + np.float64(value).tobytes()), (1, 5, 1, b"\xff" * 8)]
    reader, _ = open_rows(tmp_path, rows, dbc)
    got = read_all(reader)
    assert got["W.D"][1][0] == value
    assert np.isnan(got["W.D"][1][1])
    assert got["W.Low"][1][1] == 0xFFFF


def test_a_payload_outside_its_buffer_is_short_not_a_crash(tmp_path: Path) -> None:
    class Wild(Listed):
        def frames(self, *, counting: bool) -> Iterator[CanFrames]:
            for frames in super().frames(counting=counting):
                yield replace(frames, offset=np.array([0, 1, -1, 2**63 - 1, 8], np.int64))

    dbc = tmp_path / "car.dbc"
    dbc.write_text(CAR)
    log = ImportLog()
    source = Wild([(k, 291, 1, b"\x05\x00" if k else bytes(2)) for k in range(5)], log, batch=5)
    reader = CanReader(source, ReadOptions(dbc=(dbc,)), log, tmp_path)
    (chunk,) = reader.read(frozenset({"Motion.YawRate"}))
    # the buffer: two zeros, then 5, 0 four times
    np.testing.assert_array_equal(chunk.columns["Motion.YawRate"], [0.0, 12.8, np.nan, np.nan, 0.05])
    assert dict(log.rejected) == {"Motion: frame shorter than the DBC says": 2}


def test_known_group_in_a_database_without_attributes_is_j1939(tmp_path: Path) -> None:
    dbc = f'VERSION ""\n\nBU_:\n\nBO_ {0x98FEF100} C: 8 X\n SG_ V : 8|16@1+ (1,0) [0|0] "" X\n'
    reader, _ = open_rows(tmp_path, j1939_rows(0x18FEF100, [5, 0xFFFF]), dbc)
    assert np.array_equal(read_all(reader)["C.V"][1], [5, np.nan], equal_nan=True)
    assert reader.channels[0].tags["pgn"] == "65265"
    # the same group from another sender than the database's
    reader, log = open_rows(tmp_path, j1939_rows(0x18FEF121, [5, 0xFFFF]), dbc)
    assert reader.channels[0].tags["source_address"] == "33"
    assert any("matched by J1939 parameter group" in note for note in log.notes)


def test_text_formats_give_the_same_signals(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    messages = [
        can.Message(
            timestamp=1_700_000_000 + index / 64,
            arbitration_id=(291, 512, 999)[index % 3],
            is_extended_id=False,
            data=bytes([index % 2]) + rng.bytes(7),
            channel=0,
        )
        for index in range(300)
    ]
    dbc = tmp_path / "car.dbc"
    dbc.write_text(CAR)
    results = []
    for suffix in ("log", "asc", "trc"):
        path = tmp_path / f"drive.{suffix}"
        with can.Logger(path) as logger:
            for message in messages:
                logger.on_message_received(message)
        log = ImportLog()
        steps: list[tuple[int, int]] = []
        options = ReadOptions(
            dbc=(dbc,), progress=lambda done, total, steps=steps: steps.append((done, total))
        )
        importer = find_importer(path)
        assert importer.suffixes[0] == f".{suffix}"
        reader = importer.open(path, options, log)
        chunks = list(reader.read(frozenset(channel.name for channel in reader.channels)))
        start = min(int(chunk.time_ns[0]) for chunk in chunks)
        results.append(
            {
                name: (((chunk.time_ns - start) // 1000).tolist(), values.tolist())
                for chunk in chunks
                for name, values in chunk.columns.items()
            }
        )
        assert (log.messages, log.status) == (300, "complete")
        assert steps[-1][0] == steps[-1][1]
    assert results[0] == results[1] == results[2]
    assert len(results[0]) == 7
