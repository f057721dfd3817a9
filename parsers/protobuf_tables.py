"""The tables that tell the kernels what to do with each field of a protobuf type; parsers.protobuf_decode makes them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from parsers.channels import FloatArray, IntArray

# columns of the entry table; CELL: the column of a plain number, -1 where it is not wanted
(
    NUMBER,
    KIND,
    WIRE,
    FIRST_ELEMENT,
    ELEMENTS,
    LIST,
    ONEOF,
    COLUMN_FIRST,
    COLUMN_END,
    NODE_FIRST,
    NODE_END,
    LIST_FIRST,
    LIST_END,
    ACTION,
    CELL,
    TAG_SIZE,
) = range(16)
LOOK_UP, TAKE, TAKE_DOUBLE, STEP_OVER = range(4)
"""What to do with an expected field: a number of its own, a double of its own, of no interest, or anything else."""


class Tables(NamedTuple):
    """What the kernels know of a type.

    entries: a row a field. tags, masks: the field's tag as it stands in the message, and which of 8 bytes it covers.
    nodes: first and end entry, first and end default of each message. oneofs: what they clear. elements: column (or
    node) and stamp slot of each element. defaults: (column, value). template: shape (columns,), what an empty
    message gives. lists: number of element counters.
    """

    entries: IntArray
    tags: NDArray[np.uint64]
    masks: NDArray[np.uint64]
    nodes: IntArray
    oneofs: IntArray
    elements: IntArray
    defaults: FloatArray
    template: FloatArray
    lists: int


class Output(NamedTuple):
    """Where the numbers go. columns: shape (columns, n); bits: the same memory as uint64; stamps: (n, 2), seconds and
    nanoseconds."""

    columns: FloatArray
    bits: NDArray[np.uint64]
    stamps: IntArray
