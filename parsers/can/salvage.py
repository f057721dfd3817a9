"""What can still be had from a DBC that does not follow the grammar: its messages and signals, line by line."""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from parsers.can.definitions import MAX_BITS, BitField, MessageDef, SignalDef
from parsers.can.frames import EXTENDED
from parsers.can.salvage_mux import Above, gates_of, multiplexers_of, read_above

NO_MESSAGE = 0xC000_0000
"""The id under which databases keep signals that belong to no message."""

LONGEST_LINE = 4096
"""Longer lines hold no message or signal."""

_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_MESSAGE = re.compile(r"^\s*BO_\s+(\d{1,10})\s+([^\s:]+)\s*:\s*(\d{1,5})")
_SIGNAL = re.compile(
    rf"^\s*SG_\s+(\S+)\s*(M|m\d{{1,9}}M?)?\s*:\s*(\d{{1,5}})\s*\|\s*(\d{{1,4}})\s*@\s*([01])\s*([+-])"
    rf"\s*(?:\(\s*({_NUMBER})\s*[,;]\s*({_NUMBER})\s*\))?\s*(?:\[[^\]]*\])?\s*(?:\"([^\"]*)\")?"
)
_VALUE_TYPE = re.compile(r"^\s*SIG_VALTYPE_\s+(\d+)\s+(\w+)\s*:?\s*([0-3])\s*;?\s*$")
"""Some writers leave the colon away."""
_VALUES = re.compile(r"^\s*VAL_\s+(\d+)\s+(\S+)\s+(.*)$")
_VALUE = re.compile(r'(-?\d{1,20})\s+"([^"]*)"')
_SPN = re.compile(r"^\s*BA_\s+\"SPN\"\s+SG_\s+(\d+)\s+(\S+)\s+(\d+)")
_J1939 = re.compile(
    r"^\s*BA_\s+\"ProtocolType\"\s+\"J1939\"|^\s*BA_DEF_DEF_\s+\"VFrameFormat\"\s+\"J1939PG\""
)


InvalidCodes = Callable[[Mapping[int, object], int], tuple[int, ...]]


@dataclass(frozen=True)
class Salvaged:
    """What was read of a file: messages, the 1-based numbers of BO_ and SG_ lines that could not be read, and the
    multiplexed signals ("Message.Signal") of which the file does not say in which frames they are."""

    messages: tuple[MessageDef, ...]
    skipped: tuple[int, ...]
    ungated: tuple[str, ...]


def salvage_messages(text: str, origin: str, invalid_codes: InvalidCodes) -> Salvaged:
    """Read BO_ and SG_ lines that can be read, and what later lines say of their signals.

    Comments are not looked at. origin: the file's name, for the records. invalid_codes: which raw values of a value
    table and a length in bits stand for no value.
    """
    choices: dict[tuple[int, str], dict[int, object]] = {}
    names: dict[int, str] = {}
    signals: dict[int, list[tuple[str | None, SignalDef]]] = defaultdict(list)
    floats: dict[tuple[int, str], str] = {}
    numbers: dict[tuple[int, str], int] = {}
    skipped: list[int] = []
    current: int | None = None
    lines = [line if len(line) <= LONGEST_LINE else "" for line in text.splitlines()]
    for line_number, line in enumerate(lines, start=1):
        word = line.split(maxsplit=1)[:1]
        if word == ["BO_"]:
            current = _begin(line, names)
            if current is None:
                skipped.append(line_number)
        elif word == ["SG_"] and current is not None:
            signal = _signal(line)
            if signal is None:
                skipped.append(line_number)
            else:
                signals[current].append(signal)
        elif word == ["SIG_VALTYPE_"]:
            # floats read as integers are no numbers at all: what cannot be read is said
            if found := _VALUE_TYPE.match(line):
                floats[int(found[1]), found[2]] = found[3]
            else:
                skipped.append(line_number)
        elif found := _VALUES.match(line):
            choices[int(found[1]), found[2]] = {int(raw): label for raw, label in _VALUE.findall(found[3])}
        elif found := _SPN.match(line):
            numbers[int(found[1]), found[2]] = int(found[3])
    whole_j1939 = any(_J1939.match(line) for line in lines)
    messages, ungated = [], list[str]()
    multiplexers = read_above(text)
    for dbc_id, name in names.items():
        gated, without = _gated(dbc_id, signals[dbc_id], multiplexers)
        ungated += [f"{name}.{each}" for each in without]
        finished = tuple(
            signal
            if signal.is_float
            else replace(
                signal, invalid=invalid_codes(choices.get((dbc_id, signal.name), {}), signal.field.length)
            )
            for signal in _finish(dbc_id, gated, floats, numbers)
        )
        j1939 = bool(dbc_id & EXTENDED) and (whole_j1939 or dbc_id & 0xFF == 0xFE)
        messages.append(MessageDef(name, dbc_id, finished, j1939=j1939, origin=origin))
    return Salvaged(tuple(messages), tuple(skipped), tuple(ungated))


def _begin(line: str, names: dict[int, str]) -> int | None:
    found = _MESSAGE.match(line)
    if found is None:
        return None
    dbc_id = int(found[1])
    limit = 0x1FFF_FFFF if dbc_id & EXTENDED else 0x7FF
    if dbc_id == NO_MESSAGE or dbc_id & 0x7FFF_FFFF > limit or dbc_id in names:
        return None
    names[dbc_id] = found[2]
    return dbc_id


def _signal(line: str) -> tuple[str | None, SignalDef] | None:
    """A signal and its multiplexing mark ("M", "m3", "m3M")."""
    found = _SIGNAL.match(line)
    if found is None or not 1 <= int(found[4]) <= MAX_BITS:
        return None
    if found[7] is None or found[8] is None:
        # "(0,05,0)", "(1/20,0)" or nothing: what the numbers mean is not known
        return None
    scale, offset = float(found[7]), float(found[8])
    if not (math.isfinite(scale) and math.isfinite(offset)):
        return None
    field = BitField(int(found[3]), int(found[4]), found[5] == "1")
    signal = SignalDef(found[1], field, found[6] == "-", False, scale, offset, found[9] or None)
    return found[2], signal


def _gated(
    dbc_id: int, marked: list[tuple[str | None, SignalDef]], above: Above
) -> tuple[list[SignalDef], list[str]]:
    """A message's signals with their gates, and the names of those whose gates are not told."""
    gated, without = [], []
    multiplexers = multiplexers_of(marked)
    for mark, signal in marked:
        gates = gates_of(mark, signal.name, dbc_id, multiplexers, above)
        if gates is None:
            without.append(signal.name)
        else:
            gated.append(replace(signal, gates=gates))
    return gated, without


def _finish(
    dbc_id: int,
    gated: list[SignalDef],
    floats: dict[tuple[int, str], str],
    numbers: dict[tuple[int, str], int],
) -> tuple[SignalDef, ...]:
    """Add what later lines say; the first of several signals with one name stays."""
    finished: dict[str, SignalDef] = {}
    for signal in gated:
        is_float = floats.get((dbc_id, signal.name)) in ("1", "2")
        if is_float and signal.field.length not in (16, 32, 64):
            continue
        spn = numbers.get((dbc_id, signal.name))
        finished.setdefault(signal.name, replace(signal, is_float=is_float, spn=spn))
    return tuple(finished.values())
