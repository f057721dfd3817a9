"""Databases kept as records: the same as read anew, and never in the way."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from parsers.can import database_cache
from parsers.can.database import builtin_j1939, load_database
from parsers.can.database_cache import FOLDER_VARIABLE, KeptDatabase, cache_file, keep, recall
from parsers.can.definitions import BitField, Gate, MessageDef, SignalDef
from parsers.importer import ImportLog

DBC = """VERSION ""

BU_: X

BO_ 256 Motion: 8 X
 SG_ Mode M : 0|4@1+ (1,0) [0|15] "" X
 SG_ Speed m1 : 8|16@1- (0.01,-5) [0|0] "km/h" X
 SG_ Yaw m2 : 15|16@0- (0.001,0) [0|0] "deg/s" X

VAL_ 256 Speed 65535 "not available" ;
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "cache"
    monkeypatch.setenv(FOLDER_VARIABLE, str(folder))
    return folder


def _database(tmp_path: Path, text: str = DBC) -> Path:
    path = tmp_path / "motion.dbc"
    path.write_text(text, encoding="utf-8")
    return path


def test_records_come_back_as_they_were(folder: Path) -> None:
    gate = Gate("Mode", BitField(0, 4, True), (1, 2, 2**40))
    signal = SignalDef(
        "Grüße", BitField(63, 64, False), True, True, 1 / 3, -1e300, None, "c", 84, (gate,), (5, 2**64 - 1)
    )
    database = KeptDatabase((MessageDef("A", 0x98FE_F1FE, (signal,), True, True, "a.dbc"),), ("a note",))
    file = cache_file("a.dbc", b"bytes")
    keep(file, database)
    assert recall(file) == database
    assert recall(cache_file("a.dbc", b"other bytes")) is None
    assert recall(cache_file("b.dbc", b"bytes")) is None


def test_the_second_reading_gives_the_same_without_the_reader(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = _database(tmp_path, DBC.replace("SG_ Yaw m2 : 15|16", "SG_ Yaw m2 : 15|9999999"))
    first = ImportLog()
    messages = load_database(path, first)
    assert len(list(folder.iterdir())) == 1
    monkeypatch.setattr("parsers.can.database._through_cantools", None)
    monkeypatch.setattr("parsers.can.database.salvage_messages", None)
    again = ImportLog()
    assert load_database(path, again) == messages
    assert again.notes == first.notes
    assert first.notes


def test_the_builtin_database_is_kept_too(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    messages = builtin_j1939(ImportLog())
    monkeypatch.setattr("parsers.can.database._through_cantools", None)
    assert builtin_j1939(ImportLog()) == messages


@pytest.mark.parametrize(
    "junk", [b"", b"{}", b"[1]", b"\xff\xfe", b'{"messages": [[1]], "notes": []}', b"[" * 100_000, b"0\n{}"]
)
def test_a_damaged_file_is_read_anew(folder: Path, tmp_path: Path, junk: bytes) -> None:
    path = _database(tmp_path)
    messages = load_database(path, ImportLog())
    file = next(folder.iterdir())
    file.write_bytes(junk)
    assert load_database(path, ImportLog()) == messages
    assert json.loads(file.read_bytes().partition(b"\n")[2])["messages"]


def test_nothing_is_kept_where_it_cannot_be(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = _database(tmp_path)
    monkeypatch.setenv(FOLDER_VARIABLE, "")
    assert len(load_database(path, ImportLog())) == 1
    (tmp_path / "file").write_text("", encoding="utf-8")
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "file"))
    assert len(load_database(path, ImportLog())) == 1
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "motion.dbc"]


def test_the_oldest_go(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(database_cache, "MOST_FILES", 3)
    for number in range(6):
        keep(cache_file("a.dbc", bytes([number])), KeptDatabase((), ()))
    assert len(list(folder.iterdir())) == 3
    assert recall(cache_file("a.dbc", bytes([5]))) is not None
