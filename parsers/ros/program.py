"""What the compiled decoder is given: the programs of some topics, and memory for shapes and rows."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.ros.fields import Encoding
from parsers.ros.kernels import (
    CELL,
    COLUMNS,
    HEAD,
    ROOM,
    SIZE_OF,
    STAMP_ROW,
    WAYS,
    Program,
    Rows,
    Shapes,
)
from parsers.ros.layout import JUMP, SLOT, Layout, specialise


def make_program(
    topics: Sequence[tuple[Layout, Sequence[str]]], encoding: Encoding, wide: int = 4
) -> Program:
    """The programs for the wanted field paths of some types, as one. wide: bytes of a wide character in CDR."""
    ops: list[IntArray] = []
    tables: list[IntArray] = []
    spec = np.zeros((len(topics), 4), dtype=np.int64)
    first = slot = shelf = 0
    for i, (layout, wanted) in enumerate(topics):
        own, table = specialise(layout, wanted, encoding)
        own[own[:, SLOT] >= 0, SLOT] += slot
        own[own[:, JUMP] >= 0, JUMP] += first
        spec[i] = first, first + len(own), len(wanted), shelf
        first, slot, shelf = first + len(own), slot + len(table), shelf + len(wanted)
        ops.append(own)
        tables.append(table)
    return Program(spec, np.concatenate(ops), np.concatenate(tables), encoding == "cdr", wide)


def make_shapes(program: Program, depth: int) -> Shapes:
    """An empty memory for the shapes of a program's messages; one for each thread. depth: how deep its loops nest."""
    rows = len(program.spec) * WAYS
    cells = int(program.spec[:, COLUMNS].sum()) * WAYS
    heads = np.zeros((rows, HEAD), dtype=np.int64)
    heads[:, SIZE_OF] = -1
    return Shapes(heads, np.empty((cells, 2), dtype=np.int64), np.empty((depth + 1, 4), dtype=np.int64))


def make_rows(program: Program, room: IntArray, cells: Callable[[int], FloatArray] = np.empty) -> Rows:
    """Room for so many rows of each topic. All of it is written before it is read. cells: gives memory for numbers."""
    place = np.zeros((len(room), 4), dtype=np.int64)
    sizes = room * program.spec[:, COLUMNS]
    place[:, ROOM] = room
    place[:, CELL] = np.cumsum(sizes) - sizes
    place[:, STAMP_ROW] = np.cumsum(room) - room
    memory = cells(int(sizes.sum()))
    return Rows(memory, memory.view(np.uint64), np.empty(int(room.sum()), dtype=np.int64), place)
