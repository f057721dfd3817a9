"""Kernels of J1939's transport protocols: the packets of many senders at once into the messages that they are of.

SAE J1939-21: TP.CM (PGN 60416) announces a message of up to 1785 bytes, to all (BAM) or to one (RTS, which CTS and EndOfMsgACK
answer), TP.DT (PGN 60160) carries a packet number and seven bytes. Between two addresses one message is under way at a time.

SAE J1939-22, on CAN FD: FD.TP.CM (PGN 19712) and FD.TP.DT (PGN 19968) do the same with 60 bytes a packet, and each begins with the number of its
session, of which up to 16 are under way between two addresses.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from parsers.can.j1939_kernel import GROUP
from parsers.can.slots import BusArray, IdArray, LengthArray
from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel, lean_kernel

MOST_SESSIONS = 256
"""Messages under way at once; of more the one that waits longest is given up."""
MOST_BYTES = 1785
"""J1939-22 sends up to 16 MB in packets: files and programs; what is longer than J1939-21's is counted."""
PER_PACKET, PER_FD_PACKET = 7, 60
FD_BYTES = 64
TIMEOUT_NS = 1_250_000_000
"""J1939-21's T2 and T3, the longest that either side waits for the other."""

# places in a session's row: who sends to whom, what is announced, how many packets are there, the last packet's number, and stamp; the
# session's number and the bytes of its packets
BUS, SENDER, RECEIVER, PGN, SIZE, PACKETS, GOT, LAST, LAST_NS, SESSION, PER, ROW = range(12)
# places in the state vector: sessions under way, messages and bytes written, messages given up, those without an announcement
OPEN, MESSAGES, USED, GIVEN_UP, UNANNOUNCED, STATE_SIZE = range(6)
# why a message was given up
MISSING, ABORTED, CUT, CROWDED, LONG = range(5)

TO_ALL = 255
RTS, CTS, SENT, END_OF_MESSAGE, BAM, ABORT = 16, 17, 18, 19, 32, 255
"""As J1939-21 numbers them. SENT is J1939-22's alone: the sender has sent it all."""
CLASSIC = -1
"""The number of J1939-21's only session."""
PRIORITY = 6 << 26
"""What a message in packets would have had as one frame is not told; J1939's default."""
PACKETS_21 = 0x80EC0000, 0x80EB0000
"""GROUP bits of J1939-21's TP.CM and TP.DT."""
PACKETS_22 = 0x804D0000, 0x804E0000
"""Of J1939-22's FD.TP.CM and FD.TP.DT."""


class Sessions(NamedTuple):
    """Messages under way. rows: (MOST_SESSIONS, ROW). marks: (MOST_SESSIONS, 256) packets that are there. data: (MOST_SESSIONS,
    MOST_BYTES). state: (STATE_SIZE,)."""

    rows: IntArray
    marks: ByteArray
    data: ByteArray
    state: IntArray


class Messages(NamedTuple):
    """Room for what a batch of frames completes, as `CanFrames` has it, and for what is given up: (k, 3) bus, identifier, why."""

    time_ns: IntArray
    can_id: IdArray
    bus: BusArray
    length: LengthArray
    offset: IntArray
    data: ByteArray
    given_up: IntArray


@lean_kernel
def _identifier(row: IntArray) -> int:
    """The identifier that a message in one frame would have had."""
    pgn = int(row[PGN])
    target = int(row[RECEIVER]) << 8 if (pgn >> 8) & 0xFF < 240 else 0
    return 0x8000_0000 | PRIORITY | (pgn << 8) | target | int(row[SENDER])


@lean_kernel
def _close(at: int, held: Sessions) -> None:
    """End a session; the last one takes its place."""
    last = int(held.state[OPEN]) - 1
    if at != last:
        for k in range(ROW):
            held.rows[at, k] = held.rows[last, k]
        for k in range(held.rows[at, PACKETS] + 1):
            held.marks[at, k] = held.marks[last, k]
        for k in range(held.rows[at, SIZE]):
            held.data[at, k] = held.data[last, k]
    held.state[OPEN] = last


@lean_kernel
def _give_up(at: int, why: int, held: Sessions, out: Messages) -> None:
    """End a session whose message is not whole."""
    n = int(held.state[GIVEN_UP])
    row = held.rows[at]
    out.given_up[n, 0], out.given_up[n, 1], out.given_up[n, 2] = row[BUS], _identifier(row), why
    held.state[GIVEN_UP] = n + 1
    _close(at, held)


@kernel
def give_up_all(held: Sessions, out: Messages) -> None:
    """The log's end: no session will be whole any more."""
    held.state[MESSAGES] = held.state[USED] = held.state[GIVEN_UP] = 0
    while held.state[OPEN] > 0:
        _give_up(int(held.state[OPEN]) - 1, CUT, held, out)


@lean_kernel
def _find(bus: int, sender: int, receiver: int, session: int, held: Sessions) -> int:
    """The session of this number between two addresses, -1 where there is none."""
    for k in range(int(held.state[OPEN])):
        row = held.rows[k]
        if (
            row[SENDER] == sender
            and row[RECEIVER] == receiver
            and row[BUS] == bus
            and row[SESSION] == session
        ):
            return k
    return -1


@lean_kernel
def _announce(
    bus: int, sender: int, receiver: int, session: int, now: int, pgn: int, frame: ByteArray, held: Sessions, out: Messages
) -> None:  # fmt: skip
    """BAM or RTS: a message begins, and one that was under way ends."""
    size, packets = int(frame[1]) | int(frame[2]) << 8, int(frame[3])
    per = PER_PACKET
    if session != CLASSIC:
        size |= int(frame[3]) << 16
        packets = int(frame[4]) | int(frame[5]) << 8 | int(frame[6]) << 16
        per = PER_FD_PACKET
    whole = size > 0 and packets == (size + per - 1) // per
    # what is no such number is some other protocol's frame; groups with a destination have none in their number
    if not whole or pgn > 0x1FFFF or ((pgn >> 8) & 0xFF < 240 and pgn & 0xFF):
        return
    at = _find(bus, sender, receiver, session, held)
    if at >= 0:
        row = held.rows[at]
        if row[GOT] == 0 and row[PGN] == pgn and row[SIZE] == size:
            row[LAST_NS] = now
            return
        _give_up(at, MISSING, held, out)
    if size > MOST_BYTES:
        n = int(held.state[GIVEN_UP])
        target = receiver << 8 if (pgn >> 8) & 0xFF < 240 else 0
        out.given_up[n, 0], out.given_up[n, 1] = bus, 0x8000_0000 | PRIORITY | (pgn << 8) | target | sender
        out.given_up[n, 2] = LONG
        held.state[GIVEN_UP] = n + 1
        return
    if held.state[OPEN] == MOST_SESSIONS:
        oldest = 0
        for k in range(MOST_SESSIONS):
            oldest = k if held.rows[k, LAST_NS] < held.rows[oldest, LAST_NS] else oldest
        _give_up(oldest, CROWDED, held, out)
    at = int(held.state[OPEN])
    row = held.rows[at]
    row[BUS], row[SENDER], row[RECEIVER], row[PGN] = bus, sender, receiver, pgn
    row[SIZE], row[PACKETS], row[GOT], row[LAST], row[LAST_NS] = size, packets, 0, 0, now
    row[SESSION], row[PER] = session, per
    for k in range(packets + 1):
        held.marks[at, k] = 0
    held.state[OPEN] = at + 1


@lean_kernel
def _control(
    bus: int, sender: int, receiver: int, session: int, what: int, now: int, frame: ByteArray, held: Sessions, out: Messages
) -> None:  # fmt: skip
    """A frame of connection management. what: as J1939-21 numbers it."""
    first = 5 if session == CLASSIC else 9
    pgn = int(frame[first]) | int(frame[first + 1]) << 8 | int(frame[first + 2]) << 16
    if (what == BAM and receiver == TO_ALL) or (what == RTS and receiver != TO_ALL):
        _announce(bus, sender, receiver, session, now, pgn, frame, held, out)
        return
    answered = _find(bus, receiver, sender, session, held)
    if answered >= 0 and held.rows[answered, PGN] == pgn:
        if what == CTS:
            # also one that asks to wait keeps the connection
            held.rows[answered, LAST_NS] = now
        elif what == END_OF_MESSAGE:
            # the receiver has it all, the log has not
            _give_up(answered, MISSING, held, out)
        elif what == ABORT:
            _give_up(answered, ABORTED, held, out)
    if what in (ABORT, SENT):
        own = _find(bus, sender, receiver, session, held)
        if own >= 0 and held.rows[own, PGN] == pgn:
            if what == ABORT:
                _give_up(own, ABORTED, held, out)
            elif receiver == TO_ALL:
                # one receiver asks for what it lacks; all do not
                _give_up(own, MISSING, held, out)
            else:
                held.rows[own, LAST_NS] = now


@lean_kernel
def _as_classic(what: int) -> int:
    """The number that J1939-21 has for a frame of J1939-22's connection management, -1 for one that it does not know."""
    if what == 0:
        return RTS
    if what == 1:
        return CTS
    if what == 2:
        return SENT
    if what == 3:
        return END_OF_MESSAGE
    if what == 4:
        return BAM
    return ABORT if what == 15 else -1


@lean_kernel
def _repeats(at: int, begin: int, count: int, head: int, frame: ByteArray, held: Sessions) -> bool:
    """Whether a packet says what is there already. head: bytes before its data."""
    same = True
    for k in range(count):
        same = same and held.data[at, begin + k] == frame[head + k]
    return same


@lean_kernel
def _write(at: int, now: int, held: Sessions, out: Messages) -> None:
    """A whole message, with the stamp of its last packet; its session ends."""
    row, state = held.rows[at], held.state
    n, used, size = int(state[MESSAGES]), int(state[USED]), int(row[SIZE])
    out.time_ns[n], out.can_id[n], out.bus[n] = now, _identifier(row), row[BUS]
    out.length[n], out.offset[n] = size, used
    for k in range(size):
        out.data[used + k] = held.data[at, k]
    state[MESSAGES], state[USED] = n + 1, used + size
    _close(at, held)


@lean_kernel
def _packet(
    bus: int, sender: int, receiver: int, session: int, now: int, frame: ByteArray, length: int, held: Sessions, out: Messages
) -> None:  # fmt: skip
    """A frame of data transfer.

    To all, packets come once and in order: after one that lacks, the message cannot become whole. To one, the receiver asks for what
    it lacks. A packet that says otherwise than the same one before is of another message, whose announcement is not in the log.
    """
    head, number = 1, int(frame[0])
    if session != CLASSIC:
        head, number = 4, int(frame[1]) | int(frame[2]) << 8 | int(frame[3]) << 16
    at = _find(bus, sender, receiver, session, held)
    if at >= 0 and now - held.rows[at, LAST_NS] > TIMEOUT_NS:
        _give_up(at, MISSING, held, out)
        at = -1
    if at < 0:
        # shorter ones on such an identifier may be another protocol's
        held.state[UNANNOUNCED] += 1 if number == 1 and (session == CLASSIC or length > 8) else 0
        return
    row = held.rows[at]
    begin = int(row[PER]) * (number - 1)
    count = min(int(row[PER]), int(row[SIZE]) - begin)
    if number < 1 or number > row[PACKETS] or length < head + count:
        _give_up(at, MISSING, held, out)
        return
    if held.marks[at, number]:
        if _repeats(at, begin, count, head, frame, held):
            row[LAST_NS] = now
        else:
            _give_up(at, MISSING, held, out)
            held.state[UNANNOUNCED] += 1 if number == 1 else 0
        return
    if receiver == TO_ALL and number != row[LAST] + 1:
        _give_up(at, MISSING, held, out)
        return
    for k in range(count):
        held.data[at, begin + k] = frame[head + k]
    held.marks[at, number] = 1
    row[GOT], row[LAST], row[LAST_NS] = row[GOT] + 1, number, now
    if row[GOT] == row[PACKETS]:
        _write(at, now, held, out)


@kernel
def take_packets(
    time_ns: IntArray,
    can_id: IdArray,
    bus: BusArray,
    length: ByteArray,
    offset: IntArray,
    data: ByteArray,
    held: Sessions,
    out: Messages,
) -> None:
    """Go through a batch of frames; whole messages and those given up are written to `out`, which has room for one a frame."""
    held.state[MESSAGES] = held.state[USED] = held.state[GIVEN_UP] = 0
    frame = np.zeros(FD_BYTES, np.uint8)
    for i in range(can_id.size):
        kind = (np.int64(can_id[i]) & GROUP) >> 16
        if kind not in (0x80EB, 0x80EC, 0x804D, 0x804E):
            continue
        fd = kind in (0x804D, 0x804E)
        room = FD_BYTES if fd else 8
        first, size = int(offset[i]), min(int(length[i]), room)
        if size < 2 or first < 0 or first > data.size - size:
            continue
        for k in range(room):
            frame[k] = data[first + k] if k < size else 0
        sender, receiver = int(can_id[i]) & 0xFF, (int(can_id[i]) >> 8) & 0xFF
        now, on = int(time_ns[i]), int(bus[i])
        if kind == 0x80EB:
            _packet(on, sender, receiver, CLASSIC, now, frame, size, held, out)
        elif kind == 0x804E and size > 4 and frame[0] & 0xF == 0:
            _packet(on, sender, receiver, int(frame[0]) >> 4, now, frame, size, held, out)
        elif kind == 0x80EC and size == 8:
            _control(on, sender, receiver, CLASSIC, int(frame[0]), now, frame, held, out)
        elif kind == 0x804D and size >= 12:
            what = _as_classic(int(frame[0]) & 0xF)
            _control(on, sender, receiver, int(frame[0]) >> 4, what, now, frame, held, out)
