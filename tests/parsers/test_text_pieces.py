"""Text logs in pieces: by one thread or several, whatever the size of piece and block, and what damage takes."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
import text_log_fuzz as fuzz

from parsers.asc_log import AscImporter
from parsers.can import pieces as pieces_module
from parsers.can.pieces import Buffers, Piece, pieces, read_piece
from parsers.can.textlines import TextSource
from parsers.candump_log import CandumpImporter
from parsers.channels import ByteArray
from parsers.errors import LogError
from parsers.importer import ImportLog, ReadOptions
from parsers.trc_log import TrcImporter

IMPORTERS = {".log": CandumpImporter, ".asc": AscImporter, ".trc": TrcImporter}
LOGS = {
    "file.log": (b"(1436509052.249713) can0 123#11\n", [fuzz.candump_file]),
    "delta.log": (
        b" (000.0) can0 123 [1] 11\n (000.5) can0 123 [1] 11\n (000.1) can0 123 [1] 11\n",
        [fuzz.candump_delta],
    ),
    "dated.log": (b" (2015-07-10 23:00:00.000001)  can0  123   [1]  11\n", [fuzz.candump_dated]),
    "classic.asc": (b"base hex timestamps absolute\n", [fuzz.asc_classic, fuzz.asc_events]),
    "relative.asc": (b"base hex timestamps relative\n", [fuzz.asc_classic, fuzz.asc_events]),
    "decimal.asc": (b"base dec timestamps absolute\n", [fuzz.asc_classic]),
    "fd.asc": (b"base hex timestamps absolute\n", [fuzz.asc_fd]),
    **{
        f"{version}.trc": (f";$FILEVERSION={version}\n".encode(), [fuzz.trc(version)])
        for version in ("1.0", "1.1", "1.2", "1.3", "2.0", "2.1")
    },
}


def source_of(path: Path, log: ImportLog) -> TextSource:
    source = IMPORTERS[path.suffix]().open(path, ReadOptions(), log)._source
    assert isinstance(source, TextSource)
    return source


def everything(path: Path, workers: int) -> tuple[list[tuple[int, int, int, bytes]], ImportLog]:
    """All frames of a log and what is written down of it."""
    source = source_of(path, ImportLog())
    source._log = log = ImportLog()
    frames = []
    for batch in source.frames(counting=True, workers=workers):
        for i in range(batch.time_ns.size):
            at = int(batch.offset[i])
            payload = batch.data[at : at + int(batch.length[i])].tobytes()
            frames.append((int(batch.time_ns[i]), int(batch.can_id[i]), int(batch.bus[i]), payload))
    return frames, log


def set_sizes(monkeypatch: pytest.MonkeyPatch, piece: int, block: int) -> None:
    monkeypatch.setattr(pieces_module, "PIECE_BYTES", piece)
    monkeypatch.setattr(pieces_module, "BLOCK_BYTES", block)


@pytest.mark.parametrize("name", LOGS)
def test_pieces_blocks_and_threads_change_nothing(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    head, kinds = LOGS[name]
    path = tmp_path / name
    for seed in range(3):
        path.write_bytes(head + fuzz.random_log(kinds, seed, 250, share=0.1))
        whole, log = everything(path, workers=1)
        assert len(whole) > (2 if name == "decimal.asc" else 10)
        assert log.messages == len(whole)
        for piece, block, workers in ((700, 400, 1), (700, 400, 3), (333, 5000, 2), (4000, 450, 2)):
            set_sizes(monkeypatch, piece, block)
            assert everything(path, workers) == (whole, log)
        monkeypatch.undo()


@pytest.mark.parametrize("name", ["file.log", "relative.asc", "2.1.trc"])
def test_a_log_cut_anywhere(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    head, kinds = LOGS[name]
    path = tmp_path / name
    text = head + fuzz.random_log(kinds, 1, 8, share=0.0)
    last: list[tuple[int, int, int, bytes]] = []
    for size in range(len(head), len(text)):
        path.write_bytes(text[:size])
        set_sizes(monkeypatch, 100, 400)
        got, log = everything(path, workers=2)
        assert got[: len(last)] == last or len(got) == len(last)
        assert log.status in ("complete", "truncated")
        assert not any("malformed line" in reason for reason in log.rejected)
        if text[:size].endswith(b"\n"):
            last = got


def test_pieces_hold_whole_lines(tmp_path: Path) -> None:
    rng = random.Random(3)
    text = b"".join(b"x" * rng.choice([0, 1, 5, 40, 6000]) + b"\n" for _ in range(300)) + b"rest"
    path = tmp_path / "a.txt"
    for form in (text, b"\xef\xbb\xbf" + text, b"\xef\xbb\xbf", b"", b"\n", b"no feed"):
        path.write_bytes(form)
        for size in (1, 7, 1000, 1 << 20):
            found = list(pieces(path, size))
            skipped = 3 if form.startswith(b"\xef") else 0
            assert b"".join(form[piece.begin : piece.end] for piece in found) == form[skipped:]
            assert all(form[piece.end - 1] == 10 for piece in found[:-1])
            assert [piece.last for piece in found] == [False] * (len(found) - 1) + [True] * bool(found)


def lines_read(path: Path, piece: Piece, block: int) -> tuple[list[bytes], bool]:
    lines: list[bytes] = []

    def parse(text: ByteArray, begin: int, stop: int, ended: bool) -> None:
        part = text[begin:stop].tobytes()
        assert ended or not part.endswith(b"\n")
        assert not ended or part.endswith(b"\n") or len(part) > block
        lines.extend(part.removesuffix(b"\n").split(b"\n"))

    return lines, read_piece(path, piece, Buffers(block), parse)


def test_a_line_longer_than_a_block_is_one_line(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    for length in (90, 101, 250, 1000, 5003):
        for before in (0, 10, 99):
            for after in (b"\nlast\n", b"\n", b""):
                text = b"a" * before + b"\n" + b"L" * length + after
                path.write_bytes(text)
                lines, ended = lines_read(path, Piece(0, len(text), True), 100)
                want = text.removesuffix(b"\n").split(b"\n")
                assert [line[:100] for line in lines] == [line[:100] for line in want]
                assert ended == text.endswith(b"\n")


def test_a_giant_line_is_counted_once_and_the_lines_around_it_are_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    set_sizes(monkeypatch, 5000, 200)
    path = tmp_path / "a.log"
    good = b"(1436509052.1) can0 123#1122\n"
    for length in (150, 399, 3000, 40_000):
        path.write_bytes(good * 40 + b"\0" * length + b"\n" + good.replace(b"52.1", b"52.9") * 40)
        frames, log = everything(path, workers=2)
        assert len(frames) == 80
        assert log.rejected == {"malformed line: a damaged block, which may have held several lines": 1}
        assert any(
            "1 of 81 lines are malformed and were left out; the first is line 41" in n for n in log.notes
        )
        assert log.lost_spans_ns == [(1436509052_100_000_000, 1436509052_900_000_000)]


def test_a_file_that_shrinks_while_it_is_read(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_bytes(b"one\ntwo\nthr")
    assert lines_read(path, Piece(0, 500, True), 100) == ([b"one", b"two", b"thr"], False)
    with pytest.raises(LogError, match="cannot be read"):
        lines_read(tmp_path / "gone.txt", Piece(0, 1, True), 100)
    with pytest.raises(LogError, match="cannot be read"):
        list(pieces(tmp_path / "gone.txt"))


SPANS = {
    # (stamp in ms, or None for a malformed line): what is lost
    "in a piece": ([0, 10, None, None, 300, 310], [(10, 300)]),
    "too short to tell": ([0, 10, None, 250, 260], []),
    "clock jumps back": ([1000, 1010, None, 20, 30], []),
    "no stamp before": ([None, 1000, 1010], []),
    "no stamp after": ([0, 10, None, None], []),
    "several": ([0, None, 500, 510, None, None, 900, 1000, 1400], [(0, 500), (510, 900)]),
    "a long run": ([0, 10, *[None] * 60, 990], [(10, 990)]),
}


@pytest.mark.parametrize("kind", SPANS)
@pytest.mark.parametrize("dialect", ["file.log", "dated.log", "classic.asc", "relative.asc", "2.1.trc"])
def test_the_time_that_malformed_lines_took_is_said(
    kind: str, dialect: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    stamps, lost = SPANS[kind]
    forms = {
        "file.log": ("", "(14365090{:09.6f}) can0 123#11\n"),
        "dated.log": ("", " (2015-07-10 09:00:{:09.6f})  can0  123   [1]  11\n"),
        "classic.asc": ("base hex timestamps absolute\n", "{:11.6f} 1  123             Rx   d 1 11\n"),
        "relative.asc": ("base hex timestamps relative\n", "{:11.6f} 1  123             Rx   d 1 11\n"),
        "2.1.trc": (";$FILEVERSION=2.1\n", "      1 {:13.3f} DT 1      0300 Rx -  1    11\n"),
    }
    head, form = forms[dialect]
    if dialect == "relative.asc" and kind == "clock jumps back":
        lost = []
    before = 0
    lines = []
    for stamp in stamps:
        if stamp is None:
            lines.append("#### \n")
            continue
        seconds = (stamp - before if dialect == "relative.asc" else stamp) / 1000
        before = stamp
        lines.append(form.format(stamp if dialect == "2.1.trc" else seconds))
    path = tmp_path / dialect
    path.write_text(head + "".join(lines))
    zero = 1436509000_000_000_000 if dialect == "file.log" else 0
    if dialect == "dated.log":
        zero = -1_000_000 * next(stamp for stamp in stamps if stamp is not None)
    for piece in (1 << 20, 200, 50):
        set_sizes(monkeypatch, piece, 400)
        _, log = everything(path, workers=2)
        assert log.lost_spans_ns == [(zero + a * 1_000_000, zero + b * 1_000_000) for a, b in lost]
        assert sum(log.rejected.values()) == stamps.count(None)


def test_more_damaged_spans_than_are_kept_still_cover_all(tmp_path: Path) -> None:
    path = tmp_path / "a.log"
    path.write_text(
        "".join(f"({1_500_000_000 + t}.0) can0 1#11\n?\n" for t in range(1500)) + "(1500009999.0) can0 1#\n"
    )
    _, log = everything(path, workers=1)
    assert len(log.lost_spans_ns) == 1024
    assert log.lost_spans_ns[0] == (1_500_000_000 * 10**9, 1_500_000_001 * 10**9)
    assert log.lost_spans_ns[-1] == (1_500_001_023 * 10**9, 1_500_009_999 * 10**9)


def test_interfaces_keep_their_numbers_through_pieces(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "a.log"
    for count in (5, 63, 64, 65, 90):
        rng = random.Random(count)
        names = [f"can{k}" for k in range(count)]
        lines = [f"(1436509052.{k:06d}) {rng.choice(names)} 123#11\n" for k in range(600)]
        lines += [f"(1436509053.{k:06d}) {name} 123#22\n" for k, name in enumerate(names)]
        path.write_text("".join(lines))
        whole, log = everything(path, workers=1)
        met = list(dict.fromkeys(line.split()[1] for line in lines))[:64]
        assert [frame[2] for frame in whole] == [
            met.index(n) + 1 for n in (x.split()[1] for x in lines) if n in met
        ]
        assert log.rejected["malformed line: no bus that can be read"] == len(lines) - len(whole)
        assert log.notes[-1] == ", ".join(f"bus {k} is {name}" for k, name in enumerate(met, start=1))
        for piece in (2500, 9000):
            set_sizes(monkeypatch, piece, 400)
            assert everything(path, workers=2) == (whole, log)
        monkeypatch.undo()


@pytest.mark.parametrize("name", ["file.log", "classic.asc", "2.1.trc"])
def test_a_byte_order_mark_is_no_damage(name: str, tmp_path: Path) -> None:
    head, kinds = LOGS[name]
    path = tmp_path / name
    text = head + fuzz.random_log(kinds, 2, 40, share=0.0)
    path.write_bytes(text)
    plain = everything(path, workers=1)
    path.write_bytes(b"\xef\xbb\xbf" + text)
    assert everything(path, workers=1) == plain


def test_progress_ends_at_the_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    set_sizes(monkeypatch, 500, 400)
    path = tmp_path / "a.log"
    path.write_bytes(b"(1436509052.1) can0 123#1122\n" * 100)
    seen: list[tuple[int, int]] = []
    source = source_of(path, ImportLog())
    source._progress = lambda done, total: seen.append((done, total))
    assert sum(batch.time_ns.size for batch in source.frames(counting=True)) == 100
    assert seen == sorted(seen)
    assert len(seen) > 3
    assert seen[-1] == (2900, 2900)


def test_a_first_look_counts_nothing(tmp_path: Path) -> None:
    path = tmp_path / "a.log"
    path.write_bytes(b"(1436509052.1) can0 123#1122\njunk\n")
    source = source_of(path, ImportLog())
    source._log = log = ImportLog()
    assert [batch.time_ns.tolist() for batch in source.frames(counting=False)] == [[1436509052100000000]]
    assert log == ImportLog()


def test_a_batch_is_good_until_the_next_is_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    set_sizes(monkeypatch, 500, 400)
    path = tmp_path / "a.log"
    path.write_bytes(b"".join(b"(1436509052.%06d) can0 123#%04X\n" % (k, k) for k in range(200)))
    stamps, payloads, rooms = [], [], set()
    for batch in source_of(path, ImportLog()).frames(counting=True):
        stamps += batch.time_ns.tolist()
        payloads += [batch.data[int(at) : int(at) + 2].tobytes() for at in batch.offset]
        rooms.add(batch.time_ns.ctypes.data)
    assert stamps == [1436509052 * 10**9 + k * 1000 for k in range(200)]
    assert payloads == [k.to_bytes(2, "big") for k in range(200)]
    # rows are used again
    assert 0 < len(rooms) < 10
