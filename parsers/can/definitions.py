"""What a CAN database says of a message, in plain records: all that matching and decoding need."""

from __future__ import annotations

from dataclasses import dataclass

from parsers.can.frames import EXTENDED

MAX_BITS = 64
"""Longest signal that is decoded; longer ones are text or keys, not measurements."""


@dataclass(frozen=True)
class BitField:
    """Where a raw value lies in a payload.

    start: as in a DBC file: the least significant bit for little endian (Intel), the most significant bit for
    big endian (Motorola), counted byte * 8 + bit with bit 0 the lowest of its byte. length: bits, 1-64.
    """

    start: int
    length: int
    little: bool


@dataclass(frozen=True)
class Gate:
    """A multiplexed signal is present where the multiplexer's raw value is one of `values`."""

    multiplexer: str
    field: BitField
    values: tuple[int, ...]


@dataclass(frozen=True)
class SignalDef:
    """One signal: physical value = raw * scale + offset.

    gates: all must hold (nested multiplexing gives several). invalid: raw values, modulo 2**length, that the
    database's value table calls invalid, not available or faulty. spn: J1939 parameter number or None.
    """

    name: str
    field: BitField
    signed: bool = False
    is_float: bool = False
    scale: float = 1.0
    offset: float = 0.0
    unit: str | None = None
    comment: str = ""
    spn: int | None = None
    gates: tuple[Gate, ...] = ()
    invalid: tuple[int, ...] = ()


@dataclass(frozen=True)
class MessageDef:
    """One message. can_id: with the EXTENDED bit for 29-bit ids. j1939: to be matched by PGN.

    by_exact_id: the database says in so many words that it is a plain extended frame, so that a frame with the same
    PGN and another sender is another message. With `j1939` as well (an id that ends in FE, which nobody sends from) that holds
    for a log in which just this id is. origin: the database's file name, for notes.
    """

    name: str
    can_id: int
    signals: tuple[SignalDef, ...]
    j1939: bool = False
    by_exact_id: bool = False
    origin: str = ""

    @property
    def extended(self) -> bool:
        """Whether the id has 29 bits."""
        return bool(self.can_id & EXTENDED)


def pgn_of(can_id: int) -> int | None:
    """The J1939 parameter group number of a 29-bit id, None where it cannot be one.

    PDU1 (PF below 240) carries a destination in the PS byte, which is no part of the number; PDU2 carries the group
    extension there. Standard ids and ids with the extended data page (ISO 15765-3) are no J1939.
    """
    if not can_id & EXTENDED or can_id & 0x0200_0000:
        return None
    pgn = (can_id >> 8) & 0x1FFFF
    return pgn if (pgn >> 8) & 0xFF >= 240 else pgn & 0x1FF00


def sender_of(can_id: int) -> int:
    """The J1939 source address of a 29-bit id."""
    return can_id & 0xFF


def is_proprietary(pgn: int) -> bool:
    """Whether J1939 leaves a PGN's content to the maker (proprietary A, A2 and B)."""
    return pgn & 0xFFFF == 0xEF00 or (pgn & 0xFF00) == 0xFF00


def id_text(can_id: int) -> str:
    """An id as engineers write it: 0x1F0, 0x18FEF1FEx with an x for 29 bits."""
    return f"0x{can_id & 0x1FFF_FFFF:08X}x" if can_id & EXTENDED else f"0x{can_id:03X}"
