"""Frames in blocks of whole records, which any thread reads by itself: the same as out of one plain block."""

from __future__ import annotations

from pathlib import Path

import pytest
from frame_rows import Frame
from mf4_files import START, Builder, bus_builder, frames_of, opened

import parsers.mf4.bus
import parsers.mf4.runs
from parsers.mf4.runs import runs_of

METHODS = [0, 1, 2, 3, 4, 5]
RECORD = 78
COUNT = 10


def in_blocks(method: int, cuts: list[int], *, damaged: int = -1) -> Builder:
    """The ten frames in blocks that begin at the records `cuts`. method: -1 for plain ones. damaged: number of a block."""
    b = bus_builder("fixed")
    data = b.blocks.pop("dt")[2]
    names = []
    for number, (begin, end) in enumerate(zip(cuts, [*cuts[1:], COUNT], strict=True)):
        part, name = data[begin * RECORD : end * RECORD], f"part {number}"
        if method < 0:
            b.add(name, "DT", [], part)
        else:
            b.packed(name, part, method=method, columns=RECORD)
        if number == damaged:
            kind, links, raw = b.blocks[name]
            b.add(name, kind, links, raw[:24] + bytes(len(raw) - 24))
        names.append(name)
    b.data_list("dt", names)
    return b


@pytest.fixture
def plain(tmp_path: Path) -> list[Frame]:
    return frames_of(opened(tmp_path / "plain.mf4", bus_builder("fixed").build())[0])


@pytest.mark.parametrize("method", [-1, *METHODS])
@pytest.mark.parametrize("cuts", [[0], [0, 5], [0, 1, 2, 9]])
@pytest.mark.parametrize("chunk", [1, 4 * RECORD, 1 << 20])
def test_the_same_frames(
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    plain: list[Frame],
    method: int,
    cuts: list[int],
    chunk: int,
) -> None:
    monkeypatch.setattr(parsers.mf4.runs, "CHUNK", chunk)
    monkeypatch.setattr(parsers.mf4.runs, "PLAIN_BYTES", chunk)
    made = []

    def listen(*given: object) -> object:
        made.append(runs_of(*given))  # type: ignore[arg-type]
        return made[-1]

    monkeypatch.setattr(parsers.mf4.bus, "runs_of", listen)
    assert frames_of(opened(tmp_path / "a.mf4", in_blocks(method, cuts).build())[0]) == plain
    assert all(runs is not None for runs in made)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("damaged", [0, 1, 2])
def test_a_damaged_block_costs_its_own_records_and_no_others_of_its_run(
    tmp_path: Path, plain: list[Frame], method: int, damaged: int
) -> None:
    cuts = [0, 3, 4]
    reader, log = opened(tmp_path / "a.mf4", in_blocks(method, cuts, damaged=damaged).build())
    begin, end = [*cuts, COUNT][damaged : damaged + 2]
    assert frames_of(reader) == plain[:begin] + plain[end:]
    assert log.status == "malformed"
    assert log.rejected["damaged data block in the MF4 file"] == 1
    inside = begin > 0 and end < COUNT
    assert log.lost_spans_ns == ([(START + plain[begin - 1][0], START + plain[end][0])] if inside else [])


def test_fewer_records_said_than_the_last_block_holds(tmp_path: Path, plain: list[Frame]) -> None:
    b = in_blocks(1, [0, 4])
    b.group("cg", "t", RECORD, cycles=7, ident=1, flags=2)
    assert frames_of(opened(tmp_path / "a.mf4", b.build())[0]) == plain[:7]


def test_blocks_that_cut_records_are_read_in_turn(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, plain: list[Frame]
) -> None:
    b = bus_builder("fixed")
    data = b.blocks.pop("dt")[2]
    b.packed("one", data[:100], method=0)
    b.packed("two", data[100:], method=0)
    b.data_list("dt", ["one", "two"])
    made = []

    def listen(*given: object) -> object:
        made.append(runs_of(*given))  # type: ignore[arg-type]
        return made[-1]

    monkeypatch.setattr(parsers.mf4.bus, "runs_of", listen)
    assert frames_of(opened(tmp_path / "a.mf4", b.build())[0]) == plain
    assert made
    assert not any(made)
