"""J1939 messages in packets, as frames of their senders."""

from __future__ import annotations

from parsers.can.frames import EXTENDED

Row = tuple[int, int, int, bytes]

EC1, MINE = 65251, 0xEF00
LONG = f"""VERSION ""

BU_: X

BO_ {0x98FEE3FE} EC1: 39 X
 SG_ EngSpeedAtIdle : 0|16@1+ (0.125,0) [0|8031] "rpm" X
 SG_ GovernorGain : 168|16@1+ (0.0007813,0) [0|50] "%" X
 SG_ EngRefTorque : 152|16@1+ (1,0) [0|64255] "Nm" X
 SG_ Last : 304|8@1+ (1,0) [0|250] "" X

BO_ {0x98EF00FE} Mine: 1785 X
 SG_ First : 0|32@1- (1,0) [0|0] "" X
 SG_ Far : 14272|8@1+ (1,0) [0|0] "" X
 SG_ Middle : 3007|16@0+ (1,0) [0|0] "" X

"""


def announce(size: int, pgn: int, kind: int, sender: int, to: int) -> tuple[int, bytes]:
    head = bytes([kind]) + size.to_bytes(2, "little") + bytes([-(-size // 7), 0xFF])
    return 0x1CEC0000 | to << 8 | sender | EXTENDED, head + pgn.to_bytes(3, "little")


def packets(payload: bytes, pgn: int = EC1, sender: int = 0, to: int = 255) -> list[tuple[int, bytes]]:
    """Announcement and packets of one message; to all (BAM), or to one (RTS, without its answers)."""
    rows = [announce(len(payload), pgn, 32 if to == 255 else 16, sender, to)]
    for k in range(-(-len(payload) // 7)):
        part = payload[7 * k : 7 * k + 7].ljust(7, b"\xff")
        rows.append((0x1CEB0000 | to << 8 | sender | EXTENDED, bytes([k + 1]) + part))
    return rows


def answer(kind: int, sender: int, to: int, *values: int, pgn: int = EC1) -> tuple[int, bytes]:
    """CTS, EndOfMsgACK or abort of `sender`, who is the receiver of the message."""
    head = bytes([kind, *values]).ljust(5, b"\xff")
    return 0x1CEC0000 | to << 8 | sender | EXTENDED, head + pgn.to_bytes(3, "little")


def timed(*parts: list[tuple[int, bytes]], step: int = 10_000_000, start: int = 0, bus: int = 1) -> list[Row]:
    frames = [frame for part in parts for frame in part]
    return [(start + k * step, can_id, bus, data) for k, (can_id, data) in enumerate(frames)]


def ec1(value: int) -> bytes:
    """A payload in which every byte tells of the value."""
    return bytes((value + 3 * k) % 251 for k in range(39))


def last_byte(value: int) -> float:
    return float(ec1(value)[38])


def lost(log: object) -> dict[str, int]:
    return {reason: count for reason, count in log.rejected.items() if "in packets" in reason}  # type: ignore[attr-defined]
