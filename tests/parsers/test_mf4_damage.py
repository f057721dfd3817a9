"""Unfinished MF4 files with zeros behind their records or among them, as power cuts leave them: what is whole is kept."""

from __future__ import annotations

import re
import struct
from pathlib import Path

import numpy as np
import pytest
from mf4_files import START, Builder, bus_builder, frames_of, long_bus, opened, values_of

from parsers.mf4 import streams

COUNT = 400


def blanked(b: Builder, begin: int, end: int, fill: bytes = b"\0") -> bytes:
    """The file with some bytes of its records written over."""
    kind, links, data = b.blocks["dt"]
    b.blocks["dt"] = (kind, links, data[:begin] + (fill * (end - begin))[: end - begin] + data[end:])
    return b.build()


@pytest.mark.parametrize("double", [False, True])
@pytest.mark.parametrize("order", ["before", "behind", "mixed"])
@pytest.mark.parametrize("flags", [0x05, 0x45])
def test_zeros_behind_the_records_end_them(tmp_path: Path, double: bool, order: str, flags: int) -> None:
    b, frames, ends = long_bus(COUNT, double=double, order=order, flags=flags)
    reader, log = opened(tmp_path / "a.mf4", b.build() + bytes(70_000))
    assert frames_of(reader) == frames
    assert log.status == "truncated"
    assert not log.rejected
    assert not log.lost_spans_ns
    (said,) = [note for note in log.notes if "zeros" in note]
    data_at = b.build().index(b"##DT") + 24
    place = re.search(r"byte (\d+), 0.399 s after the start", said)
    assert place is not None
    assert int(place.group(1)) == data_at + ends[-1]


def test_a_few_zeros_that_fill_up_the_block_mean_nothing(tmp_path: Path) -> None:
    b, frames, _ = long_bus(COUNT)
    reader, log = opened(tmp_path / "a.mf4", b.build() + bytes(2))
    assert frames_of(reader) == frames
    assert log.status == "complete"


@pytest.mark.parametrize("double", [False, True])
@pytest.mark.parametrize("order", ["before", "behind"])
def test_zeros_that_could_be_records(tmp_path: Path, double: bool, order: str) -> None:
    # the frames have record id 0
    b, frames, _ = long_bus(3000, double=double, order=order, first_id=0)
    reader, log = opened(tmp_path / "a.mf4", b.build() + bytes(5000))
    assert frames_of(reader) == frames
    assert log.status == "truncated"


def test_an_unknown_record_id_ends_the_records(tmp_path: Path) -> None:
    b, frames, _ = long_bus(COUNT)
    reader, log = opened(tmp_path / "a.mf4", b.build() + b"\xee" * 3000)
    assert frames_of(reader) == frames
    assert log.status == "malformed"
    assert log.rejected == {"damaged place in the MF4 file's records": 1}
    assert any("no records were found any more behind byte" in note for note in log.notes)
    assert any("0.399 s after the start" in note for note in log.notes)


@pytest.mark.parametrize("double", [False, True])
@pytest.mark.parametrize("order", ["before", "behind"])
@pytest.mark.parametrize("flags", [0x05, 0x45])
@pytest.mark.parametrize("fill", [b"\0", b"\xff"])
@pytest.mark.parametrize("chunk", [4 << 20, 3000])
def test_damage_inside_costs_itself_only(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    double: bool,
    order: str,
    flags: int,
    fill: bytes,
    chunk: int,
) -> None:
    monkeypatch.setattr(streams, "CHUNK", chunk)
    b, frames, ends = long_bus(COUNT, double=double, order=order, flags=flags)
    reader, log = opened(tmp_path / "a.mf4", blanked(b, ends[199], ends[199] + 100, fill))
    got = frames_of(reader)
    assert got[:200] == frames[:200]
    assert set(got) <= set(frames)
    # 100 bytes are three frames; a small chunk gives up the rest of its own, where it is too short to be sure
    assert COUNT - len(got) <= (6 if chunk > 3000 else 30)
    assert log.status == "malformed"
    assert log.rejected["damaged place in the MF4 file's records"] == 1
    before, after = log.lost_spans_ns[0]
    assert before == START + frames[199][0]
    assert START + frames[202][0] <= after <= START + frames[205][0]


def test_what_is_before_damage_is_kept_where_nothing_is_certain_behind_it(tmp_path: Path) -> None:
    b, frames, ends = long_bus(COUNT, order="mixed")
    reader, log = opened(tmp_path / "a.mf4", blanked(b, ends[199], ends[199] + 100))
    assert frames_of(reader) == frames[:200]
    lost = log.rejected["CAN frame without its payload"]
    assert COUNT - 206 <= lost <= COUNT - 202
    assert any("not certain which payloads" in note for note in log.notes)
    spans = sorted(log.lost_spans_ns)
    assert spans[0][0] == START + frames[199][0]
    assert spans[-1][1] == START + frames[-1][0]
    assert sum(end - begin for begin, end in spans) == frames[-1][0] - frames[199][0]


def test_damage_before_anything_was_learnt(tmp_path: Path) -> None:
    b, frames, ends = long_bus(COUNT)
    reader, log = opened(tmp_path / "a.mf4", blanked(b, ends[4], ends[4] + 100))
    assert frames_of(reader) == frames[:5]
    assert log.rejected["CAN frame without its payload"] > 380


def test_a_record_in_which_the_zeros_begin_is_not_taken(tmp_path: Path) -> None:
    b, frames, ends = long_bus(COUNT, order="behind")
    # the last frame's record loses the place of its payload: it would be the first frame's
    begin = ends[-2] + 1 + 14
    reader, log = opened(tmp_path / "a.mf4", blanked(b, begin, ends[-1]) + bytes(500))
    assert frames_of(reader) == frames[:-1]
    assert log.status == "truncated"
    assert log.rejected == {"record in which damage begins": 1}


def test_any_damage_makes_no_frames_up(tmp_path: Path) -> None:
    rng = np.random.default_rng(11)
    kept = 0
    for _ in range(60):
        b, frames, ends = long_bus(COUNT, double=bool(rng.integers(2)))
        begin = int(rng.integers(ends[30], ends[-1] - 200))
        fill = b"\0" if rng.integers(2) else rng.bytes(200)
        reader, _ = opened(tmp_path / "a.mf4", blanked(b, begin, begin + int(rng.integers(1, 200)), fill))
        got = frames_of(reader)
        # bytes that are damaged within a whole record cannot be told from others
        assert len(set(got) - set(frames)) <= 2
        kept += len(got)
    assert kept > 60 * COUNT * 0.97


@pytest.mark.parametrize("zeros", [10, 57, 40_000])
def test_zeros_behind_records_of_one_group(tmp_path: Path, zeros: int) -> None:
    b = Builder(mark=b"UnFinMF ", flags=0x05)
    b.header("dg")
    b.data_group("dg", "cg", "dt")
    b.group("cg", "t", 10)
    b.channel("t", 0, 64, kind=2, rule=b.rule("ms", 1, [0.0, 0.001]), after="v")
    b.channel("v", 8, 16)
    b.add("dt", "DT", [], b"".join(struct.pack("<QH", k * 10, 7 * (k % 2)) for k in range(100)))
    whole = b.build()
    reader, log = opened(tmp_path / "a.mf4", whole + bytes(zeros))
    assert values_of(reader)["v"] == ([k * 10_000_000 for k in range(100)], [7 * (k % 2) for k in range(100)])
    assert log.status == "truncated"
    assert any("record 100" in note and "zeros" in note for note in log.notes)


def test_a_reserved_place_without_any_record(tmp_path: Path) -> None:
    b = bus_builder("fixed", flags=0x05)
    b.add("dt", "DT", [], bytes(8192))
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert frames_of(reader) == []
    assert log.status == "truncated"


def test_frames_behind_a_block_that_cannot_be_inflated(tmp_path: Path) -> None:
    b, frames, ends = long_bus(4 * COUNT, flags=0)
    data = b.blocks["dt"][2]
    cuts = [0, ends[COUNT] + 5, ends[2 * COUNT] + 9, ends[3 * COUNT] + 1, len(data)]
    b.data_list("dt", [f"dz{k}" for k in range(4)])
    for k in range(4):
        b.packed(f"dz{k}", data[cuts[k] : cuts[k + 1]])
    whole = bytearray(b.build())
    at = -1
    for _ in range(3):
        at = whole.index(b"##DZ", at + 1)
    whole[at + 80 : at + 140] = b"\xff" * 60
    reader, log = opened(tmp_path / "a.mf4", bytes(whole))
    got = frames_of(reader)
    assert set(got) <= set(frames)
    assert got[: 2 * COUNT] == frames[: 2 * COUNT]
    # the third block's frames, and those that straddle its ends
    assert COUNT <= len(frames) - len(got) <= COUNT + 4
    assert log.rejected["damaged data block in the MF4 file"] == 1
    assert log.lost_spans_ns[0][0] == START + frames[2 * COUNT][0]
