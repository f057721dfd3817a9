"""Samples that an MF4 file itself calls invalid, or texts: left out, and counted once."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest
from asammdf import MDF, Signal
from asammdf.blocks.conversion_utils import from_dict
from mf4_files import Builder, opened, values_of
from mf4_logs import opened as opened_log
from mf4_logs import read_all

COUNT = 300
INVALID = "v: invalid by the log's own invalidation bit"


def is_bad(k: int) -> bool:
    return k % 3 == 0


def apart(*, packed: bool = False, blocks: int = 3, links: str = "all", flags: int = 1 << 31) -> Builder:
    """Columns (LD list of DV blocks) of a time and an int16 "v" with an invalidation bit in DI blocks; "w" has none.

    links: which of the three DI blocks are linked.
    """
    step = COUNT // blocks
    rows = [struct.pack("<Qhh", k * 10, k, -k) for k in range(COUNT)]
    b = Builder(version=420)
    b.header("dg")
    b.data_group("dg", "cg", "ld")
    b.group("cg", "t", 12, cycles=COUNT, invalid=1)
    b.channel("t", 0, 64, kind=2, rule=b.rule("ms", 1, [0.0, 0.001]), after="v")
    b.channel("v", 8, 16, data_type=2, flags=2, invalid=5, after="w")
    b.channel("w", 10, 16, data_type=2)
    names, marks = [], []
    for number in range(blocks):
        some = range(number * step, (number + 1) * step)
        names.append(b.add(f"dv{number}", "DV", [], b"".join(rows[k] for k in some)))
        bits = bytes(is_bad(k) << 5 for k in some)
        if packed:
            marks.append(b.packed(f"di{number}", bits, kind=b"DI"))
        else:
            marks.append(b.add(f"di{number}", "DI", [], bits))
    if links == "first":
        marks = [marks[0], *[""] * (blocks - 1)]
    elif links == "broken":
        marks[1] = "cg"
    data = struct.pack("<IIQ", 1 | flags, blocks, step)
    b.add("ld", "LD", ["", *names, *(marks if flags else [])], data)
    return b


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize("blocks", [1, 3, 50])
def test_invalidation_bits_stored_apart(tmp_path: Path, packed: bool, blocks: int) -> None:
    reader, log = opened(tmp_path / "a.mf4", apart(packed=packed, blocks=blocks).build())
    got = values_of(reader)
    assert got["w"][1] == [-k for k in range(COUNT)]
    np.testing.assert_array_equal(got["v"][1], [np.nan if is_bad(k) else k for k in range(COUNT)])
    assert log.rejected == {INVALID: 100}
    assert log.status == "complete"


def test_blocks_without_invalidation_bits_are_valid(tmp_path: Path) -> None:
    reader, log = opened(tmp_path / "a.mf4", apart(links="first").build())
    expected = [np.nan if is_bad(k) and k < 100 else k for k in range(COUNT)]
    np.testing.assert_array_equal(values_of(reader)["v"][1], expected)
    assert log.rejected == {INVALID: 34}


def test_bits_that_cannot_be_read_leave_their_samples_out(tmp_path: Path) -> None:
    reader, log = opened(tmp_path / "a.mf4", apart(links="broken").build())
    got = values_of(reader)
    expected = [np.nan if is_bad(k) or 100 <= k < 200 else k for k in range(COUNT)]
    np.testing.assert_array_equal(got["v"][1], expected)
    # a channel without such a bit is as good as ever
    assert got["w"][1] == [-k for k in range(COUNT)]
    assert log.status == "malformed"
    assert any("invalidation bits" in note for note in log.notes)


def test_bits_that_are_not_in_the_file_are_said(tmp_path: Path) -> None:
    reader, log = opened(tmp_path / "a.mf4", apart(flags=0).build())
    assert values_of(reader)["v"][1] == list(range(COUNT))
    assert any("taken as valid" in note for note in log.notes)
    only, log = opened(tmp_path / "a.mf4", apart(flags=0).build())
    values_of(only, "w")
    assert not any("taken as valid" in note for note in log.notes)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("compression", [0, 2])
def test_invalid_samples_and_texts_are_counted_once(tmp_path: Path, compression: int) -> None:
    path = tmp_path / "a.mf4"
    t = np.arange(2000) * 0.01
    table = from_dict(
        {
            "val_0": 254,
            "text_0": "error",
            "val_1": 255,
            "text_1": "n/a",
            "default_addr": {"a": 0.5, "b": -2.0},
        }
    )
    raw = np.full(2000, 10, np.uint8)
    raw[[3, 10]], raw[11] = 255, 254
    bad = np.arange(2000) % 7 == 3
    with MDF(version="4.10") as mdf:
        mdf.append(
            [
                Signal(raw, t, name="v", conversion=table, invalidation_bits=bad),
                Signal(t, t, name="y"),
            ],
            common_timebase=True,
        )
        mdf.save(path, compression=compression)
    reader, log = opened_log(path)
    got = read_all(reader)
    # the samples 3 and 10 are both: invalid ones count as such
    lost = int(bad.sum())
    assert np.count_nonzero(np.isnan(got["v"][1])) == lost + 1
    assert log.rejected == {INVALID: lost, "v: a text of the channel's value table": 1}
    read_all(reader)
    assert log.rejected[INVALID] == lost


def test_a_conversion_that_gives_no_number_is_counted(tmp_path: Path) -> None:
    b = Builder()
    b.header("dg")
    b.data_group("dg", "cg", "dt")
    b.group("cg", "t", 10, cycles=100)
    b.channel("t", 0, 64, kind=2, rule=b.rule("ms", 1, [0.0, 0.001]), after="v")
    # (x - 50) / (x - 50)
    b.channel("v", 8, 16, rule=b.rule("rational", 2, [0.0, 1.0, -50.0, 0.0, 1.0, -50.0]))
    b.add("dt", "DT", [], b"".join(struct.pack("<QH", k * 10, k) for k in range(100)))
    reader, log = opened(tmp_path / "a.mf4", b.build())
    assert np.count_nonzero(np.isnan(values_of(reader)["v"][1])) == 1
    assert log.rejected == {"v: no number by the channel's conversion": 1}
