"""Compiled walks over unsorted records: which group each is of, where it is, and where records begin again behind damage."""

from __future__ import annotations

import numpy as np

from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel, load_u32, load_u64
from parsers.mf4.transpose import put_u64

MAX_PAYLOAD = 16 << 20
"""Bytes of one record of variable length; more is damage."""
CHAIN = 32
"""Records that must follow each other before the walk goes on behind damage."""
SHORT = 68
"""Bytes of a payload of CAN with its length: nothing longer is believed to be the first record behind damage."""
SECOND = 3600
"""A leap is so many seconds."""
POS, COUNT, BAD, LAST = range(4)


@kernel
def look(data: ByteArray, pos: int, id_size: int, ids: IntArray, sizes: IntArray, found: IntArray) -> int:
    """Look at the record at a place: 1 whole, 0 not all there, -1 no record. found: slot, first byte, bytes."""
    end = data.shape[0]
    if pos + id_size > end:
        return 0
    key = 0
    for k in range(id_size):
        key |= int(np.int64(data[pos + k]) << (8 * k))
    # small ids stand in a table: ids[0] is its length, then the slot of each id
    slot = -1
    if ids[0] > 0:
        if 0 <= key < ids[0]:
            slot = int(ids[1 + key])
    else:
        near = int(np.searchsorted(ids[1:], key))
        if near + 1 < ids.shape[0] and ids[1 + near] == key:
            slot = near
    if slot < 0:
        return -1
    at, size = pos + id_size, int(sizes[slot])
    if size < 0:
        if at + 4 > end:
            return 0
        size = 4
        for k in range(4):
            size += int(np.int64(data[at + k]) << (8 * k))
        if size > MAX_PAYLOAD:
            return -1
    found[0], found[1], found[2] = slot, at, size
    return 1 if at + size <= end else 0


@kernel
def _stamp(data: ByteArray, at: int, stamps: IntArray, slot: int) -> int:
    """The raw stamp of a record, -1 where its group has none of the simple kind. stamps: (groups, 2) place and bytes."""
    if stamps[slot, 1] == 0:
        return -1
    begin, size = at + stamps[slot, 0], stamps[slot, 1]
    if begin + 8 <= data.shape[0]:
        mask = np.uint64(0xFFFFFFFFFFFFFFFF) >> np.uint64(64 - 8 * size)
        return int(np.int64(load_u64(data, begin) & mask))
    value = 0
    for k in range(size):
        value |= int(np.int64(data[begin + k]) << (8 * k))
    return value


@kernel
def _blank(data: ByteArray, at: int, size: int) -> bool:
    """Whether a record holds nothing but zeros."""
    return not data[at : at + size].any()


@kernel
def _walk_plain(
    data: ByteArray,
    id_size: int,
    ids: IntArray,
    sizes: IntArray,
    stamps: IntArray,
    leap: int,
    slot: IntArray,
    place: IntArray,
    length: IntArray,
    state: IntArray,
) -> None:
    """As far as `walk_records` comes with two or three loads a record; stops at all that needs a second look.

    That are ids beyond the table, the data's last bytes, what is no record, and leaps of time.
    """
    end, known = data.shape[0], np.uint64(ids[0])
    key_mask = np.uint64(0xFFFFFFFFFFFFFFFF) >> np.uint64(64 - 8 * id_size)
    pos, count, last = state[POS], state[COUNT], state[LAST]
    while known > 0 and count < slot.shape[0] and pos + id_size + 8 <= end:
        key = load_u64(data, pos) & key_mask
        number = ids[1 + np.int64(key)] if key < known else -1
        if number < 0:
            break
        at, size = pos + id_size, sizes[number]
        if size < 0:
            size = 4 + load_u32(data, at)
        if size > MAX_PAYLOAD or at + size > end:
            break
        width = stamps[number, 1]
        if leap > 0 and width > 0:
            begin = at + stamps[number, 0]
            if begin + 8 > end:
                break
            stamp = np.int64(
                load_u64(data, begin) & (np.uint64(0xFFFFFFFFFFFFFFFF) >> np.uint64(64 - 8 * width))
            )
            if last >= 0 and abs(stamp - last) > leap:
                break
            if stamp == 0 and number == 0 and last > leap // SECOND and _blank(data, pos, id_size + size):
                break
            last = stamp
        slot[count], place[count], length[count] = number, at, size
        count += 1
        pos = at + size
    state[POS], state[COUNT], state[LAST] = pos, count, last


@kernel
def walk_records(
    data: ByteArray,
    begin: int,
    id_size: int,
    ids: IntArray,
    sizes: IntArray,
    stamps: IntArray,
    leap: int,
    slot: IntArray,
    place: IntArray,
    length: IntArray,
    state: IntArray,
) -> None:
    """Walk records: for each, which group (slot) it is of, and where its bytes begin and how many they are.

    ids: see `_id_table`. sizes: bytes of a record, -1 for variable length. leap: see LEAP_NS, in raw stamps, 0 to look at none.
    state: POS the first byte not used, COUNT records so far (the columns are filled from there), BAD 1 where no
    record begins at POS, LAST the last raw stamp or -1.
    """
    found = np.zeros(3, np.int64)
    state[POS], state[BAD] = begin, 0
    while True:
        _walk_plain(data, id_size, ids, sizes, stamps, leap, slot, place, length, state)
        count = int(state[COUNT])
        if count >= slot.shape[0]:
            break
        what = look(data, int(state[POS]), id_size, ids, sizes, found)
        if what < 0:
            state[BAD] = 1
        if what <= 0:
            break
        if leap > 0:
            stamp = _stamp(data, found[1], stamps, found[0])
            if stamp >= 0:
                if state[LAST] >= 0 and abs(stamp - state[LAST]) > leap:
                    state[BAD] = 1
                    break
                # id 0 stands in the first slot: bytes that were never written look like its records
                size = id_size + found[2]
                if (
                    stamp == 0
                    and found[0] == 0
                    and state[LAST] > leap // SECOND
                    and _blank(data, state[POS], size)
                ):
                    state[BAD] = 1
                    break
                state[LAST] = stamp
        slot[count], place[count], length[count] = found[0], found[1], found[2]
        state[COUNT] = count + 1
        state[POS] = found[1] + found[2]


@kernel
def find_records(
    data: ByteArray, begin: int, id_size: int, ids: IntArray, sizes: IntArray, stamps: IntArray, leap: int
) -> int:
    """The first place from which CHAIN records follow each other with rising stamps (at the end: at least 4), or -1.

    The first stamp is above 0: zeros are no records.
    """
    found = np.zeros(3, np.int64)
    for start in range(begin, data.shape[0]):
        pos, count, last = start, 0, -1
        while count < CHAIN:
            what = look(data, pos, id_size, ids, sizes, found)
            if what <= 0:
                if what == 0 and count >= 4 and last >= 0:
                    count = CHAIN
                break
            stamp = _stamp(data, found[1], stamps, found[0])
            if stamp >= 0:
                if last >= 0 and (stamp < last or stamp - last > leap):
                    break
                if last < 0 and stamp == 0:
                    break
                last = stamp
            elif found[2] > (4096 if count > 0 else SHORT):
                break
            pos = found[1] + found[2]
            count += 1
        if count >= CHAIN and last >= 0:
            return start
    return -1


@kernel
def gather(
    data: ByteArray, chosen: int, slot: IntArray, place: IntArray, length: IntArray, out: ByteArray
) -> None:
    """Put the records of one slot one behind the other; the caller made `out` as long as all of them."""
    used = 0
    for i in range(place.shape[0]):
        if slot[i] != chosen:
            continue
        at, size = place[i], length[i]
        if size < 8:
            for k in range(size):
                out[used + k] = data[at + k]
        else:
            for k in range(0, size - 8, 8):
                put_u64(out, used + k, load_u64(data, at + k))
            put_u64(out, used + size - 8, load_u64(data, at + size - 8))
        used += size
