"""CAN databases (DBC): cantools reads the grammar, this file brings it into plain records and says what it dropped."""

from __future__ import annotations

import codecs
import logging
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from parsers.can.database_cache import KeptDatabase, cache_file, keep, recall
from parsers.can.definitions import MAX_BITS, BitField, Gate, MessageDef, SignalDef, id_text
from parsers.can.frames import EXTENDED
from parsers.can.labels import invalid_codes
from parsers.can.other_databases import refuse_other
from parsers.can.salvage import salvage_messages
from parsers.errors import DatabaseError
from parsers.importer import ImportLog

MAX_BYTES = 64 << 20
"""No known DBC is larger; a file beyond this is something else."""

WIDEST_RANGE = 4096
"""Multiplexer values of one SG_MUL_VAL_ range that are kept; a file may ask for 2**32."""

MOST_VALUES = 1 << 20
"""Multiplexer values of a whole file."""

_TOO_LARGE = re.compile(
    r"BO_\s{1,99}\d+\s{1,99}\S+?\s{0,99}:\s{0,99}\d{5,}|SG_\s[^:\n]*:\s{0,99}(?:\d{6,}|\d+\s{0,99}\|\s{0,99}\d{5,})"
)
_BIT_TIMING = re.compile(r"^BS_[ \t]*:[^;\n]*;?[ \t]*$", re.MULTILINE)
"""Bit timing is obsolete and told nothing of signals; cantools refuses the spelling that the format's text gives it."""
_SIGNAL_HEAD = re.compile(r"^[ \t]{0,99}SG_[ \t][^\n\"]{0,4096}", re.MULTILINE)
"""A signal's line up to its unit."""
_BARE_POINT = re.compile(r"(?<![\d.])\.(?=\d)")
_PLUS = re.compile(r"(?<![\deE.])\+(?=[\d.])")
_BUILTIN = Path(__file__).parent / "j1939.dbc"


def load_databases(paths: Iterable[Path], log: ImportLog, *, given: bool = True) -> tuple[MessageDef, ...]:
    """The messages of several DBC files, in their order; an identifier that several define is there several times.

    Raises DatabaseError where a file that the user gave cannot be read or holds no message at all. One that was found
    beside the log is left out with a note.
    """
    messages: list[MessageDef] = []
    for path in paths:
        try:
            messages += load_database(path, log)
        except DatabaseError as error:
            if given:
                raise
            log.note(f"the CAN database {path.name} beside the log is left out: {error.problem}")
    return tuple(messages)


def builtin_j1939(log: ImportLog) -> tuple[MessageDef, ...]:
    """The J1939 parameter groups that cogest knows without a database."""
    return load_database(_BUILTIN, log)


def load_database(path: Path, log: ImportLog) -> tuple[MessageDef, ...]:
    """The messages of one DBC file, in its order. Raises DatabaseError."""
    raw = _read_bytes(path)
    refuse_other(raw, path)
    file = cache_file(path.name, raw)
    kept = recall(file)
    if kept is None:
        own = ImportLog()
        kept = KeptDatabase(_parsed(_text_of(raw), path, own), tuple(own.notes))
        keep(file, kept)
    for note in kept.notes:
        log.note(note)
    return kept.messages


def _parsed(text: str, path: Path, log: ImportLog) -> tuple[MessageDef, ...]:
    try:
        messages = _through_cantools(_bounded(_regular(text), path, log), path, log)
    except Exception as error:  # cantools raises its own, textparser's and built-in errors alike
        salvaged = salvage_messages(text, path.name, invalid_codes)
        messages, skipped = salvaged.messages, salvaged.skipped
        if not messages:
            raise DatabaseError(
                f"not a CAN database that can be read ({_one_line(error)})",
                path=path,
                hint="name a DBC file with --dbc",
            ) from error
        log.note(
            f"{path.name} is not a correct DBC ({_one_line(error)}): {len(messages)} messages were read line by line"
            + (f", {len(skipped)} lines were left out (the first: line {skipped[0]})" if skipped else "")
        )
        if salvaged.ungated:
            log.note(
                f"{path.name}: multiplexed signals are left out, since it does not say in which frames they are: "
                f"{_some(list(salvaged.ungated))}"
            )
    if not messages:
        raise DatabaseError(
            "holds no messages (no BO_ line)", path=path, hint="check that this is the right DBC"
        )
    return _without_twins(messages, path, log)


def _read_bytes(path: Path) -> bytes:
    try:
        if path.stat().st_size > MAX_BYTES:
            raise DatabaseError(f"larger than {MAX_BYTES >> 20} MiB, which no DBC is", path=path)
        raw = path.read_bytes()
    except OSError as error:
        raise DatabaseError(
            f"cannot be read ({error.strerror})", path=path, hint="check the name given with --dbc"
        ) from error
    if raw[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
        raw = raw.decode("utf-16", errors="replace").encode()
    if b"\0" in raw:
        raise DatabaseError("a binary file, not a DBC", path=path, hint="name a DBC file with --dbc")
    return raw


def _text_of(raw: bytes) -> str:
    for encoding in ("utf-8-sig", "cp1252"):
        try:
            return raw.decode(encoding).replace("\r\n", "\n")
        except UnicodeDecodeError:
            continue
    return raw.decode("latin-1").replace("\r\n", "\n")


def _regular(text: str) -> str:
    """The text in the spelling that cantools takes: without bit timing, and numbers of signals as "0.5" for ".5", "+.5"."""

    def in_line(match: re.Match[str]) -> str:
        head, bracket, numbers = match[0].partition("(")
        return head + bracket + _BARE_POINT.sub("0.", _PLUS.sub("", numbers))

    return _SIGNAL_HEAD.sub(in_line, _BIT_TIMING.sub("BS_:", text))


def _bounded(text: str, path: Path, log: ImportLog) -> str:
    """The text with multiplexer ranges narrowed that would be expanded into billions of values.

    Raises ValueError for sizes and places that no frame has and that would take all memory to lay out.
    """
    if found := _TOO_LARGE.search(text):
        line = text.count("\n", 0, found.start()) + 1
        raise ValueError(f"line {line}: a size or place beyond any frame's, {found[0][-60:]!r}")
    expanded = 0

    def narrow(match: re.Match[str]) -> str:
        nonlocal expanded
        if max(len(match[1]), len(match[2])) > 12:
            raise ValueError("a multiplexer value with more than 12 digits")
        low, high = int(match[1]), int(match[2])
        expanded += min(max(high - low, 0), WIDEST_RANGE) + 1
        if expanded > MOST_VALUES:
            raise ValueError(f"more than {MOST_VALUES} multiplexer values")
        if high - low < WIDEST_RANGE:
            return match[0]
        log.note(f"{path.name}: of multiplexer values {low}-{high} only the first {WIDEST_RANGE} are used")
        return f"{low}-{low + WIDEST_RANGE - 1}"

    def narrow_entry(match: re.Match[str]) -> str:
        return re.sub(r"\b(\d+)\s*-\s*(\d+)\b", narrow, match[0])

    return re.sub(r"SG_MUL_VAL_\s[^;]*", narrow_entry, text)


def _through_cantools(text: str, path: Path, log: ImportLog) -> tuple[MessageDef, ...]:
    # cantools says things through `logging`, whose last resort prints; what matters is said in the log book
    logger = logging.getLogger("cantools")
    if not logger.handlers:
        logger.addHandler(logging.NullHandler())
    from cantools.database import Database

    database = Database(strict=False)
    database.add_dbc_string(text)
    attributes = getattr(database.dbc, "attributes", None) or {}
    protocol = getattr(attributes.get("ProtocolType"), "value", "")
    whole_j1939 = isinstance(protocol, str) and protocol.strip().upper() == "J1939"
    return tuple(_message(message, whole_j1939, path, log) for message in database.messages)


def _message(message: Any, whole_j1939: bool, path: Path, log: ImportLog) -> MessageDef:
    attributes = getattr(message.dbc, "attributes", None) or {}
    own = getattr(attributes.get("VFrameFormat"), "value", None)
    plain = own in (0, 1, "StandardCAN", "ExtendedCAN", 14, 15, "StandardCAN_FD", "ExtendedCAN_FD")
    extended = bool(message.is_extended_frame)
    # nobody sends from address 254: an id with it is a pattern for its parameter group
    j1939 = extended and (
        message.frame_id & 0xFF == 0xFE or (not plain and (whole_j1939 or message.protocol == "j1939"))
    )
    by_name = {signal.name: signal for signal in message.signals}
    signals = []
    for signal in message.signals:
        definition = _signal(signal, by_name)
        if definition is None:
            log.note(f"{path.name}: signal {message.name}.{signal.name} cannot be decoded and is left out")
        else:
            signals.append(definition)
    return MessageDef(
        name=message.name,
        can_id=int(message.frame_id) | (EXTENDED if extended else 0),
        signals=tuple(signals),
        j1939=j1939,
        by_exact_id=plain and extended,
        origin=path.name,
    )


def _signal(signal: Any, by_name: Mapping[str, Any]) -> SignalDef | None:
    scale, offset = float(signal.conversion.scale), float(signal.conversion.offset)
    is_float = bool(signal.conversion.is_float)
    gates = _gates(signal, by_name)
    if (
        gates is None
        or not 1 <= signal.length <= MAX_BITS
        or signal.start < 0
        or not (math.isfinite(scale) and math.isfinite(offset))
        or (is_float and signal.length not in (16, 32, 64))
    ):
        return None
    return SignalDef(
        name=signal.name,
        field=_field(signal),
        signed=bool(signal.is_signed),
        is_float=is_float,
        scale=scale,
        offset=offset,
        unit=signal.unit or None,
        comment=str(signal.comment or ""),
        spn=signal.spn or None,
        gates=gates,
        invalid=() if is_float else invalid_codes(signal.conversion.choices or {}, signal.length),
    )


def _field(signal: Any) -> BitField:
    return BitField(int(signal.start), int(signal.length), signal.byte_order == "little_endian")


def _gates(signal: Any, by_name: Mapping[str, Any]) -> tuple[Gate, ...] | None:
    """The multiplexers above a signal, nearest first; None where they are missing or go in a circle."""
    gates: list[Gate] = []
    current = signal
    while current.multiplexer_ids is not None:
        above = by_name.get(current.multiplexer_signal)
        if above is None or len(gates) > len(by_name) or not 1 <= above.length <= MAX_BITS:
            return None
        mask = (1 << above.length) - 1
        values = tuple(sorted({int(value) & mask for value in current.multiplexer_ids}))
        gates.append(Gate(above.name, _field(above), values))
        current = above
    return tuple(gates)


def _without_twins(messages: tuple[MessageDef, ...], path: Path, log: ImportLog) -> tuple[MessageDef, ...]:
    """Drop the second of two messages with one id, and of two signals with one name."""
    kept: dict[int, MessageDef] = {}
    for message in messages:
        signals = {signal.name: signal for signal in reversed(message.signals)}
        if len(signals) < len(message.signals):
            log.note(f"{path.name}: {message.name} has signals with one name: the first of each is used")
            message = replace(message, signals=tuple(reversed(signals.values())))
        first = kept.setdefault(message.can_id, message)
        if first is not message:
            log.note(
                f"{path.name} defines {id_text(message.can_id)} twice: {first.name} is used, not {message.name}"
            )
    return tuple(kept.values())


def _some(items: list[str], most: int = 3) -> str:
    more = f" and {len(items) - most} more" if len(items) > most else ""
    return ", ".join(items[:most]) + more


def _one_line(error: Exception) -> str:
    text = " ".join(str(error).split())
    return text[:160] + "…" if len(text) > 160 else text or type(error).__name__
