"""MF4 files built block by block: compressed blocks, lists, records, virtual channels, any damage."""

from __future__ import annotations

import contextlib
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
from mf4_files import TIMES, Builder, bus_builder, opened, unsorted, values_of

from parsers.errors import LogError
from parsers.importer import ImportLog, ReadOptions, no_progress
from parsers.mf4.reader import open_mf4
from parsers.mf4_log import Mf4Importer


def simple(data_link: str, *, cycles: int = 100) -> Builder:
    """Time u64 in ms and a u16 "v": records of 10 bytes."""
    b = Builder()
    b.header("dg")
    b.data_group("dg", "cg", data_link)
    b.group("cg", "t", 10, cycles=cycles)
    b.channel("t", 0, 64, kind=2, rule=b.rule("ms", 1, [0.0, 0.001]), after="v")
    b.channel("v", 8, 16)
    return b


RECORDS = b"".join(struct.pack("<QH", k * 10, k) for k in range(100))


@pytest.mark.parametrize(("method", "columns"), [(0, 0), (1, 10), (1, 7), (2, 0), (3, 10), (4, 0), (5, 10)])
def test_compressed_blocks(tmp_path: Path, method: int, columns: int) -> None:
    b = simple("hl")
    b.add("hl", "HL", ["dl"], b"\0" * 8)
    parts = [RECORDS[:333], RECORDS[333:805], RECORDS[805:]]
    b.data_list("dl", ["dz0", "dz1"], after="dl2")
    b.data_list("dl2", ["dz2"])
    for k, part in enumerate(parts):
        b.packed(f"dz{k}", part, method=method, columns=columns)
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert values_of(reader)["v"] == (TIMES, list(range(100)))
    assert log.status == "complete"


def test_a_damaged_block_costs_its_records_only(tmp_path: Path) -> None:
    b = simple("dl")
    b.data_list("dl", ["dz0", "dz1", "dz2"])
    for k in range(3):
        b.packed(f"dz{k}", RECORDS[(0, 333, 666)[k] : (333, 666, 1000)[k]])
    whole = bytearray(b.build())
    second = whole.index(b"##DZ", whole.index(b"##DZ") + 4)
    whole[second + 60 : second + 90] = b"\xff" * 30
    reader, log = opened(tmp_path / "a.mf4", bytes(whole))
    assert values_of(reader)["v"][1] == [*range(33), *range(67, 100)]
    assert log.status == "malformed"
    assert log.rejected["damaged data block in the MF4 file"] == 1


def test_a_claimed_size_that_cannot_be_is_refused(tmp_path: Path) -> None:
    b = simple("dz")
    data = struct.pack("<2sBxIQQ", b"DT", 0, 0, 1 << 45, 40) + zlib.compress(RECORDS)[:40]
    b.add("dz", "DZ", [], data)
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert values_of(reader) == {}
    assert log.status == "malformed"


def test_a_file_cut_in_its_data(tmp_path: Path) -> None:
    b = simple("dt")
    b.add("dt", "DT", [], RECORDS)
    whole = b.build()
    reader, log = opened(tmp_path / "a.mf4", whole[: len(whole) - 505])
    assert values_of(reader)["v"][1] == list(range(49))
    assert log.status == "truncated"
    assert any("49 of the 100" in note for note in log.notes)


@pytest.mark.parametrize("length", [0, 24, 24 + 1000])
def test_an_unfinished_file_is_read_to_its_end(tmp_path: Path, length: int) -> None:
    b = simple("dt", cycles=0)
    b.mark, b.flags = b"UnFinMF ", 0x05
    b.add("dt", "DT", [], RECORDS)
    whole = bytearray(b.build())
    at = whole.index(b"##DT")
    whole[at + 8 : at + 16] = struct.pack("<Q", length)
    reader, log = opened(tmp_path / "a.mf4", bytes(whole[: at + 24 + 955]))
    assert values_of(reader)["v"][1] == list(range(95))
    assert log.status == "complete"
    assert any("did not finish" in note for note in log.notes)


def test_an_unfinished_list_finds_the_blocks_behind_it(tmp_path: Path) -> None:
    b = simple("dl", cycles=0)
    b.mark, b.flags = b"UnFinMF ", 0x11
    b.data_list("dl", ["dt0", "", ""])
    b.add("dt0", "DT", [], RECORDS[:400])
    b.add("dt1", "DT", [], RECORDS[400:800])
    b.add("dt2", "DT", [], RECORDS[800:])
    reader, _ = opened(tmp_path / "a.mf4", b.build())
    assert values_of(reader)["v"][1] == list(range(100))


def test_bits_and_byte_orders(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    raw = rng.integers(0, 256, (50, 24), dtype=np.uint8)
    raw[:, :8] = np.arange(50, dtype="<u8").view(np.uint8).reshape(50, 8)
    cases = [
        (8, 0, 12, 0),
        (9, 3, 10, 2),
        (10, 5, 64, 0),
        (8, 7, 58, 2),
        (12, 0, 24, 1),
        (12, 4, 20, 3),
        (20, 1, 1, 0),
    ]
    b = Builder()
    b.header("dg")
    b.data_group("dg", "cg", "dt")
    b.group("cg", "t", 24, cycles=50)
    b.channel("t", 0, 64, kind=2, rule=b.rule("s", 1, [0.0, 1.0]), after="c0")
    for k, (byte, bit, bits, data_type) in enumerate(cases):
        after = f"c{k + 1}" if k + 1 < len(cases) else ""
        b.channel(f"c{k}", byte, bits, bit=bit, data_type=data_type, after=after)
    b.add("dt", "DT", [], raw.tobytes())
    reader, _ = opened(tmp_path / "a.mf4", b.build())
    got = values_of(reader)
    for k, (byte, bit, bits, data_type) in enumerate(cases):
        size = (bit + bits + 7) // 8
        order = "big" if data_type in (1, 3) else "little"
        expected = []
        for row in raw:
            value = (int.from_bytes(row[byte : byte + size].tobytes(), order) >> bit) & ((1 << bits) - 1)
            if data_type in (2, 3) and value >> (bits - 1):
                value -= 1 << bits
            expected.append(float(value))
        assert got[f"c{k}"][1] == expected


def test_a_channel_outside_its_record_is_left_out(tmp_path: Path) -> None:
    b = simple("dt")
    b.channel("v", 8, 16, after="far")
    b.channel("far", 9, 16, after="odd")
    b.channel("odd", 0, 48, data_type=4)
    b.add("dt", "DT", [], RECORDS)
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert [c.name for c in reader.channels] == ["v"]
    assert any("'far'" in note for note in log.notes)
    assert any("'odd'" in note for note in log.notes)


def test_an_array_is_left_out_and_said(tmp_path: Path) -> None:
    b = simple("dt")
    b.channel("v", 8, 16, parts="ca", after="w")
    b.channel("w", 8, 8)
    b.add("ca", "CA", [], struct.pack("<BBHIiIQ", 0, 0, 1, 0, 2, 0, 1))
    b.add("dt", "DT", [], RECORDS)
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert [c.name for c in reader.channels] == ["w"]
    assert "channel 'v' was left out: an array or a structure" in log.notes


def test_a_database_inside_the_file_is_named(tmp_path: Path) -> None:
    b = simple("dt")
    b.add("dt", "DT", [], RECORDS)
    b.add("at", "AT", ["", b.text("net.dbc"), "", ""], b"\0" * 40)
    kind, links, data = b.blocks["HD"]
    b.blocks["HD"] = (kind, [*links[:3], "at", *links[4:]], data)
    _, log = opened(tmp_path / "a.mf4", b.build())
    assert any("net.dbc" in note and "--dbc" in note for note in log.notes)


def test_virtual_time_and_values(tmp_path: Path) -> None:
    b = Builder()
    b.header("dg")
    b.data_group("dg", "cg", "dt")
    b.group("cg", "t", 1, cycles=4)
    b.channel("t", 0, 0, kind=3, rule=b.rule("step", 1, [0.5, 0.02]), after="x")
    b.channel("x", 0, 8, after="n")
    b.channel("n", 0, 0, kind=6)
    b.add("dt", "DT", [], bytes([9, 8, 7, 6]))
    reader, _ = opened(tmp_path / "a.mf4", b.build())
    got = values_of(reader)
    assert got["x"] == ([500_000_000, 520_000_000, 540_000_000, 560_000_000], [9, 8, 7, 6])
    assert got["n"][1] == [0, 1, 2, 3]


def test_lists_that_run_in_a_circle_end(tmp_path: Path) -> None:
    b = simple("dl")
    b.channel("v", 8, 16, after="t")
    b.data_list("dl", ["dt"], after="dl")
    b.add("dt", "DT", [], RECORDS)
    b.blocks["dg"] = ("DG", ["dg", "cg", "dl", ""], b"\0" * 8)
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert values_of(reader)["v"][1] == list(range(100))
    assert log.status == "malformed"
    assert any("circle" in note for note in log.notes)


def test_local_start_time_is_said(tmp_path: Path) -> None:
    b = simple("dt")
    b.add("dt", "DT", [], RECORDS)
    b.header("dg", time_flags=1)
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert reader.absolute
    values_of(reader)
    assert any("local time" in note for note in log.notes)
    b.header("dg", start=0)
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert not reader.absolute


def test_other_versions_and_stumps(tmp_path: Path) -> None:
    b = simple("")
    b.version = 330
    path = tmp_path / "a.mdf"
    with pytest.raises(LogError, match=r"MDF version 3\.30 found.*convert the file to MDF 4"):
        opened(path, b.build())
    b.version = 54000
    with pytest.raises(
        LogError, match=r"version 4\.10, and its version number is 54000: its beginning is damaged"
    ):
        opened(path, b.build())
    for size in (8, 63, 64, 80, 130):
        with pytest.raises(LogError) as error:
            opened(path, simple("").build()[:size])
        assert "\n" not in str(error.value)
    # the descriptions of the data stand behind the cut
    far = simple("")
    with pytest.raises(LogError, match="breaks off at byte 200, before the end of a data group at byte 192"):
        opened(path, far.build()[:200])
    empty = Builder()
    empty.header("")
    with pytest.raises(LogError, match="no data groups"):
        opened(path, empty.build())


@pytest.mark.parametrize("kind", ["plain", "unsorted", "group", "blocks"])
def test_random_damage_never_hangs_or_crashes(tmp_path: Path, kind: str) -> None:
    if kind == "plain":
        b = simple("dl")
        b.data_list("dl", ["dz0", "dz1"])
        b.packed("dz0", RECORDS[:500], method=1, columns=10)
        b.packed("dz1", RECORDS[500:])
    else:
        b = unsorted(1) if kind == "unsorted" else bus_builder(kind)
    whole = b.build()
    rng = np.random.default_rng(7)
    path = tmp_path / "a.mf4"
    for _ in range(150):
        broken = bytearray(whole)
        for at in rng.integers(64, len(whole), 6):
            broken[at] = rng.integers(256)
        path.write_bytes(bytes(broken[: rng.integers(64, len(whole) + 1)]))
        log = ImportLog()
        # a LogError or what is whole; anything else fails the test
        with contextlib.suppress(LogError):
            reader = Mf4Importer().open(path, ReadOptions(), log)
            rows = sum(
                chunk.time_ns.size for chunk in reader.read(frozenset(c.name for c in reader.channels))
            )
            assert rows < 1_000_000


def test_progress_is_told(tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    b = simple("dt")
    b.add("dt", "DT", [], RECORDS)
    path = tmp_path / "a.mf4"
    path.write_bytes(b.build())
    reader = open_mf4(path, ReadOptions(progress=lambda done, total: told.append((done, total))), ImportLog())
    list(reader.read(frozenset({"v"})))
    assert told[-1] == (path.stat().st_size, path.stat().st_size)
    assert no_progress(*told[0]) is None
