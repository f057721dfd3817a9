"""Kept frames of all messages, parted into the payloads of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from parsers.allocator import Slab
from parsers.can.decode import LONGEST, Payloads
from parsers.can.keep import Kept
from parsers.can.slots import LengthArray, SlotArray, WordArray
from parsers.channels import IntArray
from parsers.jit import kernel


@dataclass(frozen=True)
class Piece:
    """Some frames of a batch, and how many of them belong to each part: (parts,)."""

    frames: Kept
    counts: IntArray


@kernel
def _count(
    slot: SlotArray,
    slot_words: IntArray,
    part_of: IntArray,
    step: int,
    counts: IntArray,
    first_word: IntArray,
) -> None:
    """The frames of each part in every piece of `step` frames, and each piece's first word; at last where the words end."""
    at = 0
    for k in range(len(counts)):
        first_word[k] = at
        row = counts[k]
        for i in range(k * step, min((k + 1) * step, slot.size)):
            which = slot[i]
            if part_of[which] >= 0:
                row[part_of[which]] += 1
            at += slot_words[which]
    first_word[first_word.size - 1] = at


def pieces(kept: Kept, slot_words: IntArray, part_of: IntArray, parts: int, step: int) -> list[Piece]:
    """A batch in pieces of at most `step` frames, for `spread`."""
    frames = kept.slot.size
    counts = np.zeros((-(-frames // step), parts), np.int64)
    word = np.zeros(len(counts) + 1, np.int64)
    _count(kept.slot, slot_words, part_of, step, counts, word)
    found: list[Piece] = []
    for number, each in enumerate(counts):
        rows = slice(number * step, (number + 1) * step)
        words = kept.words[word[number] : word[number + 1]]
        found.append(Piece(Kept(kept.time_ns[rows], kept.slot[rows], kept.length[rows], words), each))
    return found


@kernel
def _spread(
    time_ns: IntArray,
    slot: SlotArray,
    length: LengthArray,
    words: WordArray,
    slot_words: IntArray,
    part_of: IntArray,
    width: IntArray,
    time_at: IntArray,
    row_at: IntArray,
    word_at: IntArray,
    out_time: IntArray,
    out_length: LengthArray,
    out_words: WordArray,
) -> None:
    """Put every frame behind the last one of its part. time_at, row_at, word_at: where each part's next stamp, row and word
    go."""
    at = 0
    for i in range(slot.size):
        which = slot[i]
        part = part_of[which]
        if part >= 0:
            row, word = row_at[part], word_at[part]
            out_time[time_at[part]], out_length[row] = time_ns[i], length[i]
            # most have one word: a loop whose end nobody can foretell costs more than all else
            out_words[word] = words[at]
            for k in range(1, width[part]):
                out_words[word + k] = words[at + k]
            time_at[part] += 1
            row_at[part], word_at[part] = row + 1, word + width[part]
        at += slot_words[which]


def spread(
    piece: Piece,
    slot_words: IntArray,
    part_of: IntArray,
    width: Sequence[int],
    stamps: IntArray | None = None,
    stamps_at: IntArray | None = None,
) -> list[Payloads]:
    """The payloads of each part, in the log's order.

    slot_words: (slots,) words of each slot's frames. part_of: (slots,) the part of each slot, -1 for none. width: words of each
    part's payloads, one at least and at most those of any slot in it. stamps, stamps_at: where the stamps are written to,
    and where each part's begin in it, (parts,); without, they get memory of their own. Raises ValueError where a width is
    not as said.
    """
    kept, counts = piece.frames, piece.counts
    parts = len(width)
    widths = np.array(width, np.int64)
    taken = part_of >= 0
    if (widths[part_of[taken]] > slot_words[taken]).any() or min(width, default=1) < 1:
        raise ValueError(f"payloads of {width} words out of frames that have fewer, or none")
    rows, words = np.cumsum(counts), np.cumsum(counts * widths)
    total, total_words = (int(rows[-1]), int(words[-1])) if parts else (0, 0)
    first_row, first_word = rows - counts, words - counts * widths
    slab = Slab(10 * total + 8 * total_words + 128)
    length, out = slab.empty(total, np.uint16), slab.empty(total_words, np.uint64)
    if stamps is None or stamps_at is None:
        stamps, stamps_at = slab.empty(total, np.int64), first_row
    _spread(
        kept.time_ns, kept.slot, kept.length, kept.words, slot_words, part_of, widths, stamps_at.copy(), first_row.copy(),
        first_word.copy(), stamps, length, out,
    )  # fmt: skip
    return [
        Payloads(
            stamps[stamps_at[k] : stamps_at[k] + counts[k]],
            length[first_row[k] : rows[k]],
            out[first_word[k] : words[k]].reshape(-1, width[k]),
            int(length[first_row[k] : rows[k]].min(initial=LONGEST)),
            out,
            int(first_word[k]),
        )
        for k in range(parts)
    ]
