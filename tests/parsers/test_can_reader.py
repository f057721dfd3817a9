"""The shared CAN reader: which channels a log has, their names and groups, and what `read` gives."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import can
import cantools
import numpy as np
import pytest
from can_rows import CAR, Listed, open_rows, read_all

from parsers.adjacent import joined
from parsers.can.frames import CanFrames
from parsers.can.reader import CanReader
from parsers.importer import ImportLog, ReadOptions
from parsers.registry import find_importer

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
    assert any("0x123: taken as db0.dbc has it; db0.dbc and db1.dbc" in note for note in log.notes)


AIR = 'VERSION ""\n\nBU_: A\n\nBO_ 291 Air: 8 A\n SG_ Level : 0|16@1+ (0.1,0) [0|0] "mm" A\n'
MORE = '\nBO_ {} {}: 8 A\n SG_ Extra : 0|8@1+ (1,0) [0|0] "" A\n'
ON_BOTH = [(0, 291, 1, b"\x01" + bytes(7)), (1, 291, 2, b"\x05" + bytes(7))]


def _levels(reader: CanReader) -> dict[str, list[float]]:
    return {
        name: values
        for name, (_, values) in read_all(reader).items()
        if name.startswith(("Air.Level", "Motion.Yaw"))
    }


@pytest.mark.parametrize("first", ["car", "air"])
@pytest.mark.parametrize("whose", ["car", "air"])
def test_each_bus_has_the_database_whose_other_messages_it_carries(
    tmp_path: Path, first: str, whose: str
) -> None:
    """One more message, of either database, tells both buses: it speaks for its own, and against it on the other."""
    more = MORE.format(77, "Other")
    texts = [CAR + more, AIR] if whose == "car" else [CAR, AIR + more]
    rows = [*ON_BOTH, (2, 77, 1 if whose == "car" else 2, bytes(8))]
    reader, log = open_rows(tmp_path, rows, *(texts if first == "car" else texts[::-1]))
    assert _levels(reader) == {"Motion.YawRate": [0.01], "Air.Level": [0.5]}
    assert sum("define it differently" in note for note in log.notes) == 2


def test_what_both_databases_define_alike_speaks_for_neither_and_is_read_on_the_bus_of_either(
    tmp_path: Path,
) -> None:
    both = MORE.format(77, "Other")
    rows = [*ON_BOTH, (2, 77, 2, b"\x07" + bytes(7))]
    reader, log = open_rows(tmp_path, rows, CAR + both, AIR + both)
    assert _levels(reader) == {}
    assert any("0x123 on buses 1 and 2" in note for note in log.notes)
    reader, _ = open_rows(tmp_path, rows, CAR + both, AIR + both, buses={"db0.dbc": (1,), "db1.dbc": (2,)})
    assert read_all(reader)["Other.Extra"][1] == [7.0]


def test_what_nothing_tells_is_left_undecoded_and_the_mapping_file_tells_it(tmp_path: Path) -> None:
    reader, log = open_rows(tmp_path, ON_BOTH, CAR, AIR)
    assert _levels(reader) == {}
    assert any("0x123 on buses 1 and 2" in note and "[buses]" in note for note in log.notes)
    for bound, expected in (
        ({"db0.dbc": (2,), "db1.dbc": (1,)}, {"Motion.YawRate": [0.05], "Air.Level": [0.1]}),
        ({"db0.dbc": (2,)}, {"Motion.YawRate": [0.05], "Air.Level": [0.1]}),
        ({"db1.dbc": (2,)}, {"Motion.YawRate": [0.01], "Air.Level": [0.5]}),
        ({"db1.dbc": (2,), "db0.dbc": (7,)}, {"Air.Level": [0.5]}),
    ):
        reader, log = open_rows(tmp_path, ON_BOTH, CAR, AIR, buses=bound)
        assert _levels(reader) == expected
    _, log = open_rows(tmp_path, ON_BOTH, CAR, AIR, buses={"air.dbc": (2,)})
    assert any("not read: air.dbc" in note for note in log.notes)


def test_messages_of_one_name_keep_apart(tmp_path: Path) -> None:
    other = CAR.replace("BO_ 291 Motion", "BO_ 292 Motion")
    reader, _ = open_rows(tmp_path, [(0, 291, 1, bytes(8)), (0, 292, 1, bytes(8))], CAR, other)
    names = [c.name for c in reader.channels]
    assert names == ["Motion.YawRate", "Motion.Speed", "Motion.YawRate@id292", "Motion.Speed@id292"]


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


@pytest.mark.parametrize(
    ("whole", "page"), [(0, 1 << 21), (0, 1 << 6), (1 << 20, 1 << 21), (1 << 20, 1 << 6)]
)
@pytest.mark.parametrize("size", [1, 3, 7, 1000])
def test_pieces_of_any_size_give_the_same_columns(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, size: int, whole: int, page: int
) -> None:
    """page: with small ones, the columns of so short a log lie in a slab as those of a long one do."""
    rng = np.random.default_rng(5)
    rows = []
    for stamp in range(60):
        can_id = int(rng.choice([100, 291, 999]))
        data = rng.integers(0, 256, 8, np.uint8)
        # the multiplexer at nought half of the time; some frames are too short
        data[0] &= 0xF0 if stamp % 2 else 0xFF
        rows.append((stamp, can_id, 1, data.tobytes()[: 8 if stamp % 5 else 2]))
    both = CAR + NESTED[NESTED.index("BO_ ") :]
    expected, log = open_rows(tmp_path, rows, both)
    columns = read_all(expected)
    monkeypatch.setattr("parsers.can.reader.PIECE", size)
    monkeypatch.setattr("parsers.can.whole.WHOLE_BYTES", whole)
    monkeypatch.setattr("parsers.allocator.LARGE_PAGE", page)
    reader, cut = open_rows(tmp_path, rows, both)
    assert str(read_all(reader)) == str(columns)
    assert cut.rejected == log.rejected
    assert {"Motion.YawRate", "Nest.S0", "Nest.S1"} <= columns.keys()


def test_the_columns_of_a_message_lie_in_one_piece(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("parsers.can.reader.PIECE", 4)
    rows = [(i, 291, 1, bytes([i, 0, 0, 100, 0, 0, 0, 0])) for i in range(10)]
    reader, _ = open_rows(tmp_path, rows, CAR)
    chunks = list(reader.read(frozenset(["Motion.YawRate", "Motion.Speed"])))
    assert len(chunks) == 3
    assert all(chunk.own for chunk in chunks)
    for pieces in ([c.time_ns for c in chunks], *([c.columns[n] for c in chunks] for n in chunks[0].columns)):
        assert np.shares_memory(joined(pieces), pieces[0])
