"""Kept frames of all messages, parted into the payloads of each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from parsers.allocator import Slab
from parsers.can.decode import Payloads
from parsers.can.keep import Kept
from parsers.can.slots import SlotArray, WordArray
from parsers.channels import ByteArray, IntArray
from parsers.jit import kernel


@kernel
def _count(slot: SlotArray, part_of: IntArray, counts: IntArray) -> None:
    for i in range(slot.size):
        if part_of[slot[i]] >= 0:
            counts[part_of[slot[i]]] += 1


@kernel
def _spread(
    time_ns: IntArray,
    slot: SlotArray,
    length: ByteArray,
    words: WordArray,
    slot_words: IntArray,
    part_of: IntArray,
    width: IntArray,
    row_at: IntArray,
    word_at: IntArray,
    shortest: IntArray,
    out_time: IntArray,
    out_length: ByteArray,
    out_words: WordArray,
) -> None:
    """Put every frame behind the last one of its part. row_at, word_at: where each part's next row and word go."""
    at = 0
    for i in range(slot.size):
        which = slot[i]
        part = part_of[which]
        if part >= 0:
            row, word = row_at[part], word_at[part]
            out_time[row], out_length[row] = time_ns[i], length[i]
            shortest[part] = min(shortest[part], np.int64(length[i]))
            for k in range(width[part]):
                out_words[word + k] = words[at + k] if k < slot_words[which] else np.uint64(0)
            row_at[part], word_at[part] = row + 1, word + width[part]
        at += slot_words[which]


def spread(kept: Kept, slot_words: IntArray, part_of: IntArray, width: Sequence[int]) -> list[Payloads]:
    """The payloads of each part, in the log's order.

    slot_words: (slots,) words of each slot's frames in `kept`. part_of: (slots,) the part of each slot, -1 for none.
    width: words of each part's payloads, at most those of any slot in it.
    """
    parts = len(width)
    widths, counts = np.array(width, np.int64), np.zeros(parts, np.int64)
    _count(kept.slot, part_of, counts)
    rows, words = np.cumsum(counts), np.cumsum(counts * widths)
    total, total_words = (int(rows[-1]), int(words[-1])) if parts else (0, 0)
    slab = Slab(9 * total + 8 * total_words + 128)
    time_ns, length = slab.empty(total, np.int64), slab.empty(total, np.uint8)
    out, shortest = slab.empty(total_words, np.uint64), np.full(parts, 255, np.int64)
    first_row, first_word = rows - counts, words - counts * widths
    _spread(
        kept.time_ns, kept.slot, kept.length, kept.words, slot_words, part_of, widths, first_row.copy(), first_word.copy(),
        shortest, time_ns, length, out,
    )  # fmt: skip
    return [
        Payloads(
            time_ns[first_row[k] : rows[k]],
            length[first_row[k] : rows[k]],
            out[first_word[k] : words[k]].reshape(-1, width[k]),
            int(shortest[k]),
        )
        for k in range(parts)
    ]
