"""The quick way through text logs reads every line as the format's own kernel does, damaged ones too."""

from __future__ import annotations

import random
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import text_log_fuzz as fuzz

from parsers.asc_log import AscHeader
from parsers.asc_log import _Parser as AscParser
from parsers.can.candump_kernel import DATED, DELTA, PLAIN
from parsers.can.layouts import MOST_LAYOUTS, known_lines, no_layouts
from parsers.can.linebook import (
    BUSES,
    CLOCK,
    FRAMES,
    LAYOUTS,
    LINE,
    SPANS,
    USED,
    filled,
    new_book,
    rows_for,
    with_more_room,
)
from parsers.can.textlines import MOST_BUSES, NAME_BYTES, LineParser, Work
from parsers.can.words import (
    BEHIND,
    FRONT,
    NO_PAIR,
    decimal,
    find_feed,
    hex_pairs,
    hexadecimal,
    not_decimal,
    not_hexadecimal,
)
from parsers.candump_log import _Parser as CandumpParser
from parsers.trc_log import COLUMNS_OF_VERSION
from parsers.trc_log import _Parser as TrcParser

PAIRS = hex_pairs()
HEXADECIMAL = AscHeader(16, False, None, ())


def parsed(parser: LineParser, text: bytes, layouts: int, clock: int = 0) -> tuple[dict[str, Any], Work]:
    """All that a kernel makes of a text, and the work."""
    buffer = bytearray(FRONT + len(text) + BEHIND)
    buffer[FRONT : FRONT + len(text)] = text
    whole = np.frombuffer(buffer, dtype=np.uint8)
    book = new_book(clock)
    names = np.zeros(MOST_BUSES * NAME_BYTES, dtype=np.uint8)
    work = Work(book, rows_for(0), no_layouts(PAIRS, layouts), names, np.zeros(MOST_BUSES, dtype=np.int64))
    work.rows = rows_for(len(text))
    begin, stop = FRONT, FRONT + len(text)
    while (begin := parser.parse(whole, begin, stop, text.endswith(b"\n"), work)) < stop:
        work.rows = with_more_room(work.rows)
    frames = filled(work.rows, book)
    columns = {
        name: getattr(frames, name).tolist()
        for name in ("time_ns", "can_id", "bus", "length", "offset", "data")
    }
    rest = {
        "state": book.state[:LAYOUTS].tolist(),
        "counts": book.counts.tolist(),
        "first": book.first.tolist(),
        "spans": book.spans[: book.state[SPANS]].tolist(),
        "names": work.buses(),
    }
    return columns | rest, work


KINDS: dict[str, tuple[LineParser, list[Callable[[random.Random, float], str]]]] = {
    "candump file": (CandumpParser(PLAIN), [fuzz.candump_file]),
    "candump console": (CandumpParser(PLAIN), [fuzz.candump_console]),
    "candump both": (CandumpParser(PLAIN), [fuzz.candump_console, fuzz.candump_file]),
    "candump delta": (CandumpParser(DELTA), [fuzz.candump_delta]),
    "candump dated": (CandumpParser(DATED), [fuzz.candump_dated]),
    "asc": (AscParser(HEXADECIMAL), [fuzz.asc_classic]),
    "asc events": (AscParser(HEXADECIMAL), [fuzz.asc_classic, fuzz.asc_events]),
    "asc fd": (AscParser(HEXADECIMAL), [fuzz.asc_fd, fuzz.asc_classic]),
    "asc relative": (AscParser(AscHeader(16, True, None, ())), [fuzz.asc_classic, fuzz.asc_events]),
    "asc decimal": (AscParser(AscHeader(10, False, None, ())), [fuzz.asc_classic]),
    **{
        f"trc {version}": (TrcParser(columns), [fuzz.trc(version)])
        for version, columns in COLUMNS_OF_VERSION.items()
    },
}


@pytest.mark.parametrize("name", KINDS)
def test_every_line_is_read_as_the_long_way_reads_it(name: str) -> None:
    parser, kinds = KINDS[name]
    for seed in range(30):
        text = fuzz.random_log(kinds, seed, 500, share=(0.0, 0.03, 0.3)[seed % 3])
        long_way, _ = parsed(parser, text, 0)
        quick, work = parsed(parser, text, MOST_LAYOUTS)
        assert quick == long_way
        few, _ = parsed(parser, text, 2)
        assert few == long_way
        assert len(long_way["time_ns"]) > (0 if name == "asc decimal" else 50)
        assert (work.book.state[LAYOUTS] > 0) == (name != "asc decimal")


@pytest.mark.parametrize("name", ["candump file", "candump console", "asc", "asc fd", "trc 1.1", "trc 2.1"])
def test_every_character_of_a_known_line_changed(name: str) -> None:
    parser, kinds = KINDS[name]
    rng = random.Random(4)
    line = kinds[0](rng, 12.5)
    while "RR" in line or "ST" in line or "TxRq" in line or len(line) < 50:
        line = kinds[0](rng, 12.5)
    for at in range(len(line)):
        changed = [line[:at] + character + line[at + 1 :] for character in map(chr, range(256))]
        text = "\n".join([line, line, *changed, line]).encode("latin-1") + b"\n"
        quick, _ = parsed(parser, text, MOST_LAYOUTS)
        assert quick == parsed(parser, text, 0)[0]


@pytest.mark.parametrize("name", [name for name in KINDS if name != "asc decimal"])
def test_the_quick_way_is_taken(name: str) -> None:
    """Should it fall out of use, no other test would tell."""
    parser, kinds = KINDS[name]
    rng = random.Random(9)
    taken = 0
    for _ in range(30):
        line = kinds[0](rng, 12.5) + "\n"
        text = (line * 20).encode("latin-1")
        found, work = parsed(parser, text, MOST_LAYOUTS)
        if not found["time_ns"] or not found["length"][0]:
            continue
        taken += 1
        assert work.book.state[LAYOUTS] == 1
        buffer = np.frombuffer(bytearray(FRONT) + text + bytearray(BEHIND), dtype=np.uint8).copy()
        room = rows_for(len(text))
        stop = FRONT + len(text)
        work.book.state[FRAMES] = work.book.state[USED] = 0
        assert known_lines(buffer, FRONT, stop, False, work.book, room, work.layouts) == stop
        assert room.can_id[:20].tolist() == found["can_id"]
        # without the margins that the unchecked loads need nothing is read at all
        assert known_lines(buffer, FRONT - 1, stop, False, work.book, room, work.layouts) == FRONT - 1
        assert known_lines(buffer[:-1].copy(), FRONT, stop, False, work.book, room, work.layouts) == FRONT
    assert taken > 5


def test_room_grows_with_short_lines() -> None:
    text = b"(1.0) a 1#\n" * 5000
    found, work = parsed(CandumpParser(PLAIN), text, MOST_LAYOUTS)
    assert (len(found["time_ns"]), found["length"][-1]) == (5000, 0)
    assert work.rows.time_ns.size >= 5000
    assert found == parsed(CandumpParser(PLAIN), text, 0)[0]


def word(text: str) -> np.uint64:
    return np.frombuffer(text.encode("latin-1"), dtype="<u8")[0]


def test_eight_digits_at_once_equal_one_by_one() -> None:
    rng = random.Random(2)
    zeros = word("00000000")
    for text in ["00000000", "99999999", "12345678", *(f"{rng.randrange(10**8):08d}" for _ in range(200))]:
        assert not not_decimal(word(text) ^ zeros)
        assert decimal(word(text) ^ zeros) == int(text)
    for text in ["00000000", "ffffffff", "FFFFFFFF", *(f"{rng.randrange(1 << 32):08x}" for _ in range(200))]:
        for form in (text, text.upper()):
            assert not not_hexadecimal(word(form))
            assert hexadecimal(word(form)) == int(text, 16)
    for at in range(8):
        for code in range(256):
            text = "1a2B3c4D"[:at] + chr(code) + "1a2B3c4D"[at + 1 :]
            assert bool(not_hexadecimal(word(text))) == (chr(code) not in "0123456789abcdefABCDEF")
            text = "12345678"[:at] + chr(code) + "12345678"[at + 1 :]
            assert bool(not_decimal(word(text) ^ zeros)) == (chr(code) not in "0123456789")


def test_pairs_of_digits_equal_pythons() -> None:
    for first in range(256):
        for second in range(0, 256, 1 if chr(first) in "09aAfF" else 37):
            text = chr(first) + chr(second)
            valid = all(character in "0123456789abcdefABCDEF" for character in text)
            assert PAIRS[first + 256 * second] == (int(text, 16) if valid else NO_PAIR)


def test_a_line_feed_is_found_at_any_place() -> None:
    text = np.full(64, 11, dtype=np.uint8)
    for at in range(40):
        text[:] = 11
        text[at] = 10
        text[min(at + 5, 63)] = 10
        assert find_feed(text, 0, 50) == at
        assert find_feed(text, 0, at) == at
    assert find_feed(np.full(64, 0x8A, dtype=np.uint8), 0, 50) == 50


def test_spans_and_lines_are_counted_in_the_same_way() -> None:
    parser = CandumpParser(PLAIN)
    text = b"(1.0) a 1#11\n(1.1) a 1#11\njunk\njunk\n(1.4) a 1#11\n(1.5) a 1#1\n(1.6) a 1#11\n"
    for layouts in (0, MOST_LAYOUTS):
        found, work = parsed(parser, text, layouts)
        assert found["spans"] == [[1_100_000_000, 1_400_000_000]]
        assert work.book.state[LINE] == 7
        assert work.book.state[FRAMES] == 4
        assert (work.book.state[BUSES], work.book.state[CLOCK]) == (1, 0)
