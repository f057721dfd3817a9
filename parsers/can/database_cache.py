"""Databases that were read before, kept as plain records: a large DBC takes its reader seconds, its records milliseconds.

One file a database (a digest, then JSON) in the user's cache folder, named after the hash of all that it hangs on: the database's bytes and
name, this package's reader and the library behind it. What cannot be used is read anew; nothing here ever raises.
"""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from parsers.can.definitions import BitField, Gate, MessageDef, SignalDef
from parsers.user_cache import drop_oldest, user_cache

FOLDER_VARIABLE = "COGEST_CACHE_DIR"
"""Names the folder; set to nothing, nothing is kept."""

MOST_FILES = 64
_READER = ("database.py", "salvage.py", "salvage_mux.py", "labels.py", "definitions.py", "database_cache.py")


@dataclass(frozen=True)
class KeptDatabase:
    """The messages of a database, and the notes that reading it gave."""

    messages: tuple[MessageDef, ...]
    notes: tuple[str, ...]


def cache_folder() -> Path | None:
    """Where databases are kept, or None where nothing is to be kept."""
    named = os.environ.get(FOLDER_VARIABLE)
    if named is not None:
        return Path(named) if named else None
    base = user_cache()
    return base / "databases" if base else None


def cache_file(name: str, raw: bytes) -> Path | None:
    """Where the records of a database of this name and these bytes lie, or would lie."""
    folder = cache_folder()
    if folder is None:
        return None
    digest = hashlib.sha256(name.encode("utf-8", "surrogateescape") + b"\0" + raw)
    try:
        for part in _READER:
            digest.update((Path(__file__).parent / part).read_bytes())
        library = find_spec("cantools")
        if library is not None and library.origin is not None:
            digest.update(str(os.stat(library.origin).st_mtime_ns).encode())
    except OSError:
        return None
    return folder / f"{digest.hexdigest()}.json"


def recall(file: Path | None) -> KeptDatabase | None:
    """What lies in a file of the cache, or None where it is of no use."""
    if file is None:
        return None
    try:
        digest, _, text = file.read_bytes().partition(b"\n")
        if digest.decode("ascii") != hashlib.sha256(text).hexdigest():
            return None
        kept = json.loads(text)
        return KeptDatabase(
            tuple(_message(each) for each in kept["messages"]), tuple(str(note) for note in kept["notes"])
        )
    except (OSError, ValueError, TypeError, LookupError, RecursionError):
        return None


def keep(file: Path | None, database: KeptDatabase) -> None:
    """Write a database's records, whole or not at all, and drop the oldest of too many."""
    if file is None:
        return
    records = {"messages": [_plain(message) for message in database.messages], "notes": database.notes}
    text = json.dumps(records, separators=(",", ":")).encode("ascii")
    part = file.with_suffix(f".{os.getpid()}.part")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        try:
            part.write_bytes(hashlib.sha256(text).hexdigest().encode("ascii") + b"\n" + text)
            part.replace(file)
        finally:
            part.unlink(missing_ok=True)
    except OSError:
        return
    drop_oldest(file.parent, "*.json", MOST_FILES)


def _plain(message: MessageDef) -> list[Any]:
    signals = [_plain_signal(signal) for signal in message.signals]
    return [message.name, message.can_id, message.j1939, message.by_exact_id, message.origin, signals]


def _plain_signal(signal: SignalDef) -> list[Any]:
    field, gates = signal.field, [_plain_gate(gate) for gate in signal.gates]
    head = [signal.name, field.start, field.length, field.little, signal.signed, signal.is_float]
    return [
        *head,
        signal.scale,
        signal.offset,
        signal.unit,
        signal.comment,
        signal.spn,
        gates,
        signal.invalid,
    ]


def _plain_gate(gate: Gate) -> list[Any]:
    return [gate.multiplexer, gate.field.start, gate.field.length, gate.field.little, gate.values]


def _message(plain: list[Any]) -> MessageDef:
    name, can_id, j1939, by_exact_id, origin, signals = plain
    return MessageDef(
        str(name),
        int(can_id),
        tuple(_signal(each) for each in signals),
        bool(j1939),
        bool(by_exact_id),
        str(origin),
    )


def _signal(plain: list[Any]) -> SignalDef:
    name, start, length, little, signed, is_float, scale, offset, unit, comment, spn, gates, invalid = plain
    return SignalDef(
        name=str(name),
        field=BitField(int(start), int(length), bool(little)),
        signed=bool(signed),
        is_float=bool(is_float),
        scale=float(scale),
        offset=float(offset),
        unit=None if unit is None else str(unit),
        comment=str(comment),
        spn=None if spn is None else int(spn),
        gates=tuple(
            Gate(str(m), BitField(int(a), int(n), bool(le)), tuple(map(int, v))) for m, a, n, le, v in gates
        ),
        invalid=tuple(map(int, invalid)),
    )
