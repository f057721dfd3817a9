"""Compiled walks over SQLite's table b-trees: interior pages to children, leaf pages to rows.

The bytes come from an untrusted file: every read is checked against the end of its page, and a page that breaks a rule
of the format is given up as a whole (its place among the keys stays known, so that something else can look there).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel, load_u32, load_u64

BoolArray = NDArray[np.bool_]

LEAF, INTERIOR = 13, 5
SLACK = 16
"""A buffer goes on for so many bytes behind its last page: reading a number first, and then looking whether it was
still on its page, is cheaper than looking first."""
TOPIC, TIME, PLACE, LENGTH, NEXT, HERE, PAGE, MARK = range(8)
"""Rows of the table that `leaf_rows` fills: which of the wanted numbers; the time; the blob's place in the buffer and its
length; its first overflow page (0: it is whole) and how much of it is before that; which page of the batch it is on; and
the blob's first four bytes as a little-endian number (0 where fewer are here), which are at hand when the rest is found."""
FIELDS = 8
MOST = 1 << 40
"""No length and no serial type is larger."""
_8, _16, _32 = np.uint64(8), np.uint64(16), np.uint64(32)
_ODD_8, _ODD_16 = np.uint64(0x00FF00FF00FF00FF), np.uint64(0x0000FFFF0000FFFF)


@kernel
def u8(data: ByteArray, at: int) -> int:
    """A byte as a number that can be reckoned with."""
    return int(np.int64(data[at]))


@kernel
def u16(data: ByteArray, at: int) -> int:
    """Two bytes, big-endian; the caller has checked that they are there, as for all readers of numbers here."""
    return (u8(data, at) << 8) | u8(data, at + 1)


@kernel
def u32(data: ByteArray, at: int) -> int:
    """Four bytes, big-endian."""
    return (u16(data, at) << 16) | u16(data, at + 2)


@kernel
def varint_size(data: ByteArray, at: int) -> int:
    """How many bytes SQLite's number of one to nine bytes takes. The caller looks whether they are still inside."""
    size = 1
    while size < 9 and data[at + size - 1] >= 128:
        size += 1
    return size


@kernel
def varint(data: ByteArray, at: int, size: int) -> int:
    """SQLite's number of `size` bytes."""
    value = 0
    for k in range(min(size, 8)):
        value = (value << 7) | (u8(data, at + k) & 127)
    return (value << 8) | u8(data, at + 8) if size == 9 else value


@kernel
def u64_reversed(data: ByteArray, at: int) -> np.uint64:
    """Eight bytes, big-endian."""
    x = np.uint64(load_u64(data, at))
    x = ((x >> _8) & _ODD_8) | ((x & _ODD_8) << _8)
    x = ((x >> _16) & _ODD_16) | ((x & _ODD_16) << _16)
    return (x >> _32) | (x << _32)


@kernel
def stored_size(kind: int) -> int:
    """How many bytes a value of a serial type takes."""
    if kind >= 12:
        return (kind - 12) >> 1
    if kind <= 4:
        return kind
    if kind == 5:
        return 6
    return 8 if kind <= 7 else 0


@kernel
def integer(data: ByteArray, at: int, kind: int, width: int) -> int:
    """The value: big-endian with a sign, or the constants 0 and 1 (serial types 8 and 9)."""
    return int(np.int64(u64_reversed(data, at))) >> (64 - 8 * width) if width > 0 else kind - 8


@kernel
def integer_state(kind: int, here: bool) -> int:
    """1 for the serial type of an integer (7 is a float, 0 is NULL, 8 and 9 take no bytes), -1 if it is not here; else 0."""
    return (1 if here else -1) if 1 <= kind <= 6 or kind == 8 or kind == 9 else 0


@kernel
def local_size(total: int, usable: int) -> int:
    """How many bytes of a record are on its leaf page; the rest is on overflow pages."""
    if total <= usable - 35:
        return total
    least = ((usable - 12) * 32) // 255 - 23
    kept = least + (total - least) % (usable - 4)
    return kept if kept <= usable - 35 else least


@kernel
def leaf_cells(
    data: ByteArray, base: int, usable: int, low: int, high: int, limit: int, cells: IntArray, found: int
) -> int:
    """The records of a leaf page: place, length and how much of it is here, into `cells` from `found` on.

    How many are in it then; -1 where the page is damaged: cells outside of it, keys that do not rise; more than there is
    room for where it needs more room.
    """
    count = u16(data, base + 3)
    if data[base] != LEAF or 8 + 2 * count > usable:
        return -1
    if found + count > cells.shape[1]:
        return found + count
    least, end = base + 8 + 2 * count, base + usable
    before = low
    good = True
    for k in range(count):
        at = base + u16(data, base + 8 + 2 * k)
        if at < least or at > end - 4:
            good = False
            break
        # both numbers are read here and not by `varint`: calls cost more than what they do
        byte = u8(data, at)
        total = byte & 127
        at += 1
        while byte >= 128 and total <= limit and at < end:
            byte = u8(data, at)
            total = (total << 7) | (byte & 127)
            at += 1
        byte = u8(data, at)
        key = byte & 127
        size = 1
        while byte >= 128 and size < 9:
            byte = u8(data, at + size)
            key = (key << 8) | byte if size == 8 else (key << 7) | (byte & 127)
            size += 1
        at += size
        local = local_size(total, usable)
        if total > limit or key <= before or key > high or end - at < local + (4 if local < total else 0):
            good = False
            break
        before = key
        cells[PLACE, found], cells[LENGTH, found], cells[HERE, found] = at, total, local
        found += 1
    return found if good else -1


@kernel
def wanted_records(
    data: ByteArray, first: IntArray, columns: IntArray, ids: IntArray, rows: IntArray, bad: BoolArray
) -> int:
    """Replace the cells in `rows` (those of page i are first[i] to first[i + 1]) by what is wanted of them; how many.

    One pass in one function, as this is where the time goes. See `leaf_rows`.
    """
    row = 0
    for page in range(first.shape[0] - 1):
        begin = row
        for cell in range(first[page], first[page + 1]):
            body, total, local = rows[PLACE, cell], rows[LENGTH, cell], rows[HERE, cell]
            offset = u8(data, body)
            at, stop = body + 1, body + offset
            place, time_ns, kind, width = 0, 0, -1, 0
            state = 1 if 1 <= offset <= min(local, 127) else -1
            for column in range(columns[2] + 1 if state == 1 else 0):
                offset += width
                if at >= stop:  # a shorter record: this value and the rest of them are NULL
                    state = 0 if offset == total else -1
                    break
                byte = u8(data, at)
                kind = byte & 127
                at += 1
                while byte >= 128 and at < stop and kind < MOST:
                    byte = u8(data, at)
                    kind = (kind << 7) | (byte & 127)
                    at += 1
                width = stored_size(kind)
                if byte >= 128 or width > total - offset or (at == stop and width != total - offset):
                    state = -1
                    break
                if column == columns[0] or column == columns[1]:
                    state = integer_state(kind, offset + width <= local)
                    if state != 1:
                        break
                    value = integer(data, body + offset, kind, width)
                    if column == columns[1]:
                        time_ns = value
                    else:
                        place = int(np.searchsorted(ids, value))
                        if place == ids.shape[0] or ids[place] != value:
                            state = 0
                            break
            if state == 1 and (kind < 12 or kind & 1):
                state = 0
            if state < 0 or (state == 1 and offset > local):
                bad[page] = True
                row = begin
                break
            if state == 1:
                here = min(width, local - offset)
                rows[TOPIC, row], rows[TIME, row], rows[PAGE, row] = place, time_ns, page
                rows[NEXT, row] = max(u32(data, body + local), 1) if here < width else 0
                rows[PLACE, row], rows[LENGTH, row], rows[HERE, row] = body + offset, width, here
                rows[MARK, row] = load_u32(data, body + offset) if here >= 4 else 0
                row += 1
    return row


@kernel
def leaf_rows(
    data: ByteArray,
    place: IntArray,
    usable: int,
    low: IntArray,
    high: IntArray,
    limit: int,
    columns: IntArray,
    ids: IntArray,
    out: IntArray,
    bad: BoolArray,
) -> int:
    """The wanted rows of some leaf pages, in the order of their keys; how many there are.

    place: where in `data` each page is (all of it, checked by the caller), -1 where it is not. low, high: its keys are
    above `low` and not above `high`. limit: no record is longer. columns: which of a record's values are the number that
    must be one of the sorted `ids`, the time and the blob; the blob is the last of them. A row whose time is no integer
    or whose blob is no blob is not wanted. out: (FIELDS, room); -1 where that
    is not enough room for all cells of the pages. bad: set for damaged pages, of which no row is given.
    """
    first = np.zeros(place.shape[0] + 1, np.int64)
    for page in range(place.shape[0]):
        stop = -1
        if place[page] >= 0:
            stop = leaf_cells(data, place[page], usable, low[page], high[page], limit, out, first[page])
            if stop > out.shape[1]:
                return -1
        bad[page] = stop < 0
        first[page + 1] = max(stop, first[page])
    return wanted_records(data, first, columns, ids, out, bad)


@kernel
def interior_fits(data: ByteArray, base: int, usable: int, low: int, high: int) -> bool:
    """Whether an interior page follows the rules: cells inside it, keys rising between `low` and `high`."""
    count = u16(data, base + 3)
    if data[base] != INTERIOR or 12 + 2 * count > usable:
        return False
    end = base + usable
    for k in range(count):
        at = base + u16(data, base + 12 + 2 * k)
        if at < base + 12 + 2 * count or at + 5 > end:
            return False
        size = varint_size(data, at + 4)
        key = varint(data, at + 4, size)
        if at + 4 + size > end or key < low or key > high or (k > 0 and key == low):
            return False
        low = key
    return True


@kernel
def children(
    data: ByteArray,
    place: IntArray,
    usable: int,
    low: IntArray,
    high: IntArray,
    seen: BoolArray,
    out: IntArray,
) -> int:
    """The children of some interior pages in the order of their keys: (page, low, high) each; how many there are.

    A damaged page stands in for its children with page 0, as does a child that does not exist or was there before;
    neighbours of which that is true are one.
    place, low, high: as for `leaf_rows`. seen: by page number, which were met; its length is 1 + pages of the file.
    out: (3, room), with room for all (see `most_children`).
    """
    found = 0
    for page in range(place.shape[0]):
        base = place[page]
        count = 0
        fits = base >= 0 and interior_fits(data, base, usable, low[page], high[page])
        if fits:
            count = u16(data, base + 3)
        before = low[page]
        for k in range(count + 1):
            child, key = 0, high[page]
            if fits and k < count:
                at = base + u16(data, base + 12 + 2 * k)
                child = u32(data, at)
                key = varint(data, at + 4, varint_size(data, at + 4))
            elif fits:
                child = u32(data, base + 8)
            if child < 2 or child >= seen.shape[0] or seen[child]:
                child = 0
            else:
                seen[child] = True
            if child > 0 or found == 0 or out[0, found - 1] > 0:
                out[0, found], out[1, found] = child, before
                found += 1
            out[2, found - 1] = key
            before = key
    return found


@kernel
def most_children(data: ByteArray, place: IntArray, usable: int) -> int:
    """How many children `children` may give for these pages."""
    most = 0
    for page in range(place.shape[0]):
        most += 1
        if place[page] >= 0:
            most += min(u16(data, place[page] + 3), usable // 2)
    return most
