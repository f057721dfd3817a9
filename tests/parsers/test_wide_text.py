"""Text logs of frames that were saved as UTF-16, as PowerShell's ">" does: read as the same log with one byte a letter."""

from __future__ import annotations

import random
from pathlib import Path

import numpy as np
import pytest
from can_rows import CAR
from frame_rows import text_frames
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from test_text_zeros import FORMATS

from parsers.can.database import load_database
from parsers.importer import ImportLog
from parsers.table_text import Encoding
from parsers.wide_text import WideText, narrow_text

CODECS = ["utf-16-le", "utf-16-be"]


def logs(tmp_path: Path, text: str, codec: str, mark: str = "\ufeff") -> tuple[Path, Path]:
    """The same log with one byte a letter, and with two."""
    plain, wide = tmp_path / "plain.log", tmp_path / "wide.log"
    plain.write_bytes(text.encode("latin-1", "replace"))
    wide.write_bytes((mark + text).encode(codec))
    return plain, wide


@pytest.mark.parametrize("mark", ["\ufeff", ""])
@pytest.mark.parametrize("codec", CODECS)
@pytest.mark.parametrize(("importer", "head", "line"), FORMATS)
def test_the_same_frames_and_the_same_book(
    tmp_path: Path, importer: object, head: str, line: object, codec: str, mark: str
) -> None:
    assert callable(line)
    text = head + "".join(line(k) + "\r\n" for k in range(2000))
    plain, wide = logs(tmp_path, text, codec, mark)
    expected, log = ImportLog(), ImportLog()
    frames = text_frames(importer, plain, expected)
    assert len(frames) == 2000
    assert text_frames(importer, wide, log) == frames
    assert (log.messages, log.status, log.local_start_ns) == (
        expected.messages, expected.status, expected.local_start_ns,
    )  # fmt: skip
    assert [note for note in log.notes if "UTF-16" not in note] == expected.notes
    assert any("UTF-16" in note for note in log.notes)


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize(("importer", "head", "line"), FORMATS)
def test_damage_costs_what_it_costs_with_one_byte_a_letter(
    tmp_path: Path, importer: object, head: str, line: object, seed: int
) -> None:
    """Zeros over some letters, remarks in other scripts, a cut between the two bytes of a letter."""
    assert callable(line)
    rng = random.Random(seed)
    lines = [line(k) for k in range(400)]
    lines.insert(rng.randrange(400), "комментарий 速度")
    text = head + "".join(each + "\n" for each in lines)
    place, count = rng.randrange(len(text) // 2, len(text) - 900), rng.randrange(1, 800)
    text = text[:place] + "\0" * count + text[place + count :]
    text = text[: len(text) - rng.randrange(60)]
    plain, wide = logs(tmp_path, text, rng.choice(CODECS))
    with wide.open("ab") as file:
        file.write(b"7"[: seed % 2])
    expected, log = ImportLog(), ImportLog()
    frames = text_frames(importer, plain, expected)
    assert text_frames(importer, wide, log) == frames
    assert (log.status, log.rejected, log.lost_spans_ns) == (
        expected.status, expected.rejected, expected.lost_spans_ns,
    )  # fmt: skip


def test_pieces_that_end_anywhere_change_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    importer, head, line = FORMATS[1]
    _, wide = logs(tmp_path, head + "".join(line(k) + "\n" for k in range(300)), "utf-16-le")
    expected = text_frames(importer, wide)
    monkeypatch.setattr("parsers.can.pieces.PIECE_BYTES", 777)
    monkeypatch.setattr("parsers.can.pieces.BLOCK_BYTES", 100)
    assert text_frames(importer, wide) == expected


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    text=st.text(st.characters(codec="utf-16"), max_size=300),
    steps=st.lists(st.tuples(st.integers(0, 320), st.integers(0, 90)), max_size=6),
    big=st.booleans(),
    extra=st.booleans(),
)
def test_any_place_of_a_file_reads_as_its_letters(
    tmp_path: Path, text: str, steps: list[tuple[int, int]], big: bool, extra: bool
) -> None:
    path = tmp_path / "any"
    codec = CODECS[big]
    path.write_bytes(b"\xff\xfe" + text.encode(codec) + b"x" * extra)
    units = np.frombuffer(text.encode(codec), ">u2" if big else "<u2")
    expected = bytes(int(unit) if unit < 256 else ord("?") for unit in units)
    wide = WideText(path, Encoding(codec, 2))
    assert wide.stat().st_size == len(expected)
    for buffering in (-1, 0):
        with wide.open("rb", buffering=buffering) as file:
            assert file.read() == expected
            for at, size in steps:
                file.seek(at)
                assert file.read(size) == expected[at : at + size]


def test_a_file_of_one_byte_a_letter_stays_itself(tmp_path: Path) -> None:
    path = tmp_path / "log"
    for data in (b"(1.0) can0 123#00\n", b"\xff\xfe", b"\0" * 40, b""):
        path.write_bytes(data)
        assert narrow_text(path) is path


@pytest.mark.parametrize("codec", CODECS)
def test_a_database_of_two_bytes_a_letter(tmp_path: Path, codec: str) -> None:
    plain, wide = tmp_path / "car.dbc", tmp_path / codec / "car.dbc"
    wide.parent.mkdir()
    text = CAR.replace("deg/s", "°/s")
    plain.write_text(text, encoding="cp1252")
    wide.write_bytes(("\ufeff" + text).encode(codec))
    assert load_database(wide, ImportLog()) == load_database(plain, ImportLog())
