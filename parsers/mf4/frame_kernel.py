"""The fields of CAN frames out of records in one pass, each with one load."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from parsers.can.frames import EXTENDED
from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel, load_u64

# rows of `fields`, each with AT, SHIFT and MASK (0 for a field that is not there, or the same in all records)
ID, IDE, BUS, LENGTH, FD, FIELDS = range(6)
AT, SHIFT, MASK = range(3)
# rows of `tables`: what each value of a byte means. Lengths of FD frames have a table of their own.
FD_LENGTH, TABLES = FIELDS, FIELDS + 1
TABLE = 256


@kernel
def _bits(word: int, shift: int, mask: int) -> int:
    """Some bits of a word (uint64) as a whole number."""
    return int(np.int64((word >> np.uint64(shift)) & np.uint64(mask)))


@kernel
def read_fields(
    data: ByteArray,
    stride: int,
    begin: int,
    payload: int,
    fields: IntArray,
    tables: IntArray,
    can_id: NDArray[np.uint32],
    bus: NDArray[np.int16],
    length: NDArray[np.uint8],
    offset: IntArray,
) -> None:
    """Fill the columns. payload: its place in the record. fields, tables: see above.

    data: contiguous, one record every `stride` bytes from `begin` on, as many as the columns are long. No load is checked:
    each field's word lies within its record, and all but the id have at most 8 bits.
    """
    ids, ide, buses, sizes, fd = fields[ID], fields[IDE], fields[BUS], fields[LENGTH], fields[FD]
    id_at, id_shift, id_mask = ids[AT], ids[SHIFT], ids[MASK]
    ide_at, ide_shift, ide_mask = ide[AT], ide[SHIFT], ide[MASK]
    bus_at, bus_shift, bus_mask = buses[AT], buses[SHIFT], buses[MASK]
    size_at, size_shift, size_mask = sizes[AT], sizes[SHIFT], sizes[MASK]
    fd_at, fd_shift, fd_mask = fd[AT], fd[SHIFT], fd[MASK]
    for i in range(can_id.shape[0]):
        row = i * stride + begin
        raw = _bits(load_u64(data, row + id_at), id_shift, id_mask)
        ident = raw & 0x1FFFFFFF
        far = (ident > 0x7FF) | (raw & EXTENDED != 0)
        far |= tables[IDE, _bits(load_u64(data, row + ide_at), ide_shift, ide_mask)] != 0
        can_id[i] = np.uint32(ident | (EXTENDED if far else 0))
        bus[i] = np.int16(tables[BUS, _bits(load_u64(data, row + bus_at), bus_shift, bus_mask)])
        size = _bits(load_u64(data, row + size_at), size_shift, size_mask)
        long = tables[FD, _bits(load_u64(data, row + fd_at), fd_shift, fd_mask)] != 0
        length[i] = np.uint8(tables[FD_LENGTH if long else LENGTH, size])
        offset[i] = row + payload
