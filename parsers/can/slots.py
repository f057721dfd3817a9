"""Kernels that give every identifier of a log a slot, and keep the frames of those slots that are of use."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel, load_u64, prefetch

SlotArray = NDArray[np.int32]
WordArray = NDArray[np.uint64]
IdArray = NDArray[np.uint32]
BusArray = NDArray[np.int16]
LengthArray = NDArray[np.uint16]
"""Payload bytes: 64 at most in a frame, 1785 in a J1939 message of several packets."""

# places in the state vector: slots given; frames and words kept; whether 29-bit ids were met; frames whose id has no room any
# more (-1 as long as there is some); frames picked, and how many of them were kept already
SLOTS, FILLED, USED, EXTENDED_MET, BEYOND, PICKED, KEPT = range(7)
STATE_SIZE = 7
# why taking frames stopped
DONE, GROW, FIRST_EXTENDED, FULL = range(4)
NEAR = 12
"""Frames ahead of which the payload is sent for."""
GROUP = 1 << 40
"""Added to the number of a parameter group, so that it is not taken for an identifier."""


@kernel
def _find(codes: IntArray, words: IntArray, code: int) -> int:
    """The words of a code, 0 where it is not known."""
    at = np.searchsorted(codes, code)
    return int(words[at]) if at < codes.size and codes[at] == code else 0


@kernel
def _known_words(can_id: int, codes: IntArray, words: IntArray) -> int:
    """How many words of an identifier's frames are worth keeping: 0 where no database can know it."""
    most = _find(codes, words, can_id)
    if can_id & 0x8000_0000 and not can_id & 0x0200_0000:
        group = (can_id >> 8) & 0x1FFFF
        if (group >> 8) & 0xFF < 240:
            group &= 0x1FF00
        most = max(most, _find(codes, words, GROUP + group))
    return most


@kernel
def _place(key: int, table: SlotArray, keys: IntArray) -> int:
    """Where a key is in the table, or the free place where it belongs."""
    mask = table.size - 1
    mixed = np.uint64(key) * np.uint64(0x9E3779B97F4A7C15)
    at = int(np.int64(mixed >> np.uint64(40))) & mask
    while table[at] >= 0 and keys[table[at]] != key:
        at = (at + 1) & mask
    return at


@kernel
def _new_slot(
    key: int,
    at: int,
    table: SlotArray,
    keys: IntArray,
    counts: IntArray,
    words: IntArray,
    codes: IntArray,
    code_words: IntArray,
    state: IntArray,
) -> int:
    """Give an identifier a slot; -1 where there is no room."""
    slot = int(state[SLOTS])
    if slot >= keys.size:
        return -1
    table[at], keys[slot], counts[slot] = slot, key, 0
    words[slot] = _known_words(key & 0xFFFF_FFFF, codes, code_words)
    state[SLOTS] = slot + 1
    return slot


@kernel
def fill_table(table: SlotArray, keys: IntArray, slots: int) -> None:
    """Put the first keys into a table, which then holds nothing else."""
    table[:] = -1
    for slot in range(slots):
        table[_place(keys[slot], table, keys)] = slot


@kernel
def _find_slots(
    can_id: IdArray,
    bus: BusArray,
    begin: int,
    table: SlotArray,
    keys: IntArray,
    counts: IntArray,
    words: IntArray,
    codes: IntArray,
    code_words: IntArray,
    picks: SlotArray,
    pick_slots: SlotArray,
    state: IntArray,
) -> tuple[int, int]:
    """Count the frames from `begin` on, as many as picks has room for. Returns the first frame not dealt with, and why.

    table: (2**k,) slots by hash of key, -1 where free. keys, counts, words: by slot. picks, pick_slots: numbers and slots
    of the frames whose slots have words; how many is in state[PICKED]. Identifiers come in no order that a processor
    could learn: there is no branch on whether one is of use.
    """
    picked = 0
    i = begin
    end = min(can_id.size, begin + picks.size)
    why = DONE
    while i < end:
        key = (int(bus[i]) << 32) | int(can_id[i])
        at = _place(key, table, keys)
        slot = int(table[at])
        if slot < 0:
            if not state[EXTENDED_MET] and key & 0x8000_0000:
                why = FIRST_EXTENDED
                break
            slot = _new_slot(key, at, table, keys, counts, words, codes, code_words, state)
            if slot < 0 and state[BEYOND] < 0:
                why = GROW
                break
            if slot < 0:
                state[BEYOND] += 1
                i += 1
                continue
        counts[slot] += 1
        picks[picked], pick_slots[picked] = i, slot
        picked += 1 if words[slot] > 0 else 0
        i += 1
    state[PICKED] = picked
    return i, why


@kernel
def _word(data: ByteArray, at: int) -> np.uint64:
    """Eight bytes of a buffer, zeros beyond its end."""
    if at + 8 <= data.size:
        return np.uint64(load_u64(data, at))
    value = np.uint64(0)
    for k in range(data.size - at):
        value |= np.uint64(data[at + k]) << np.uint64(8 * k)
    return value


@kernel
def _keep_rows(
    time_ns: IntArray,
    length: ByteArray | LengthArray,
    offset: IntArray,
    data: ByteArray,
    picks: SlotArray,
    pick_slots: SlotArray,
    begin: int,
    words: IntArray,
    kept_time: IntArray,
    kept_slot: SlotArray,
    kept_length: LengthArray,
    kept_words: WordArray,
    state: IntArray,
) -> int:
    """Keep the picked frames from number `begin` on; the first that there is no room for, or state[PICKED]."""
    filled, used = int(state[FILLED]), int(state[USED])
    picked = int(state[PICKED])
    n = begin
    while n < picked:
        # payloads lie here and there, and another core may have written them
        prefetch(data, offset[picks[min(n + NEAR, picked - 1)]])
        i, slot = picks[n], pick_slots[n]
        wide = int(words[slot])
        if wide > 0:
            if filled >= kept_time.size or used + wide > kept_words.size:
                break
            first, size = int(offset[i]), int(length[i])
            if first < 0 or first > data.size - size:
                # a payload outside its buffer is none
                first, size = 0, 0
            held = min(wide, (size + 7) >> 3)
            for k in range(held):
                kept_words[used + k] = _word(data, first + 8 * k)
            for k in range(held, wide):
                kept_words[used + k] = 0
            kept_time[filled], kept_slot[filled], kept_length[filled] = time_ns[i], slot, size
            used += wide
            filled += 1
        n += 1
    state[FILLED], state[USED] = filled, used
    return n


@kernel
def take_frames(
    can_id: IdArray,
    bus: BusArray,
    time_ns: IntArray,
    length: ByteArray | LengthArray,
    offset: IntArray,
    data: ByteArray,
    begin: int,
    table: SlotArray,
    keys: IntArray,
    counts: IntArray,
    words: IntArray,
    codes: IntArray,
    code_words: IntArray,
    picks: SlotArray,
    pick_slots: SlotArray,
    kept_time: IntArray,
    kept_slot: SlotArray,
    kept_length: LengthArray,
    kept_words: WordArray,
    state: IntArray,
) -> tuple[int, int]:
    """Count the frames from `begin` on and keep those of use. Returns the first frame not counted, and why.

    FULL: call again with the same frames once there is room to keep in. All in one call: threads that read ahead wait for
    the interpreter's lock less often.
    """
    why = DONE
    while True:
        state[KEPT] = _keep_rows(
            time_ns, length, offset, data, picks, pick_slots, int(state[KEPT]), words, kept_time, kept_slot, kept_length,
            kept_words, state,
        )  # fmt: skip
        if state[KEPT] < state[PICKED]:
            return begin, FULL
        if why != DONE or begin >= can_id.size:
            return begin, why
        begin, why = _find_slots(
            can_id, bus, begin, table, keys, counts, words, codes, code_words, picks, pick_slots, state
        )
        state[KEPT] = 0
