"""One look at every frame of a log: how often each identifier comes, and the frames that a database may know, kept.

What is kept of a frame is its stamp, the number of its identifier and the words of eight bytes in which the database
has signals; in order of the log, batch by batch.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from parsers.allocator import Slab
from parsers.can.frames import CanFrames
from parsers.can.slots import (
    BEYOND,
    DONE,
    EXTENDED_MET,
    FILLED,
    FIRST_EXTENDED,
    FULL,
    GROW,
    SLOTS,
    STATE_SIZE,
    USED,
    LengthArray,
    SlotArray,
    WordArray,
    fill_table,
    take_frames,
)
from parsers.channels import ByteArray, IntArray

ROWS = 1 << 19
"""Most frames of a batch."""
WORDS = 1 << 20
"""Most payload words of a batch."""
PICKS = 1 << 14
"""Frames that are looked at before those of use are kept."""
MOST_IDS = 1 << 20
"""Different identifiers that are told apart; no bus has more than a few thousand."""
MOST_WORDS = 224
"""Of a payload of 1785 bytes, the most that J1939 sends in packets; frames have 64."""


@dataclass(frozen=True)
class KnownIds:
    """What databases know, sorted: identifiers, and parameter groups as GROUP + number, and the words of their signals.

    codes: (n,) int64. words: (n,) int64.
    """

    codes: IntArray
    words: IntArray

    @classmethod
    def of(cls, words: Mapping[int, int]) -> KnownIds:
        """words: number of words by code."""
        codes = sorted(words)
        return cls(np.array(codes, np.int64), np.array([words[code] for code in codes], np.int64))


@dataclass(frozen=True)
class Kept:
    """n frames. time_ns (n,) int64, slot (n,) int32, length (n,) uint16 payload bytes; words (m,) uint64: the payloads'
    first bytes in words of eight, first byte lowest, as many words a frame as its slot has (`Keeper.words`)."""

    time_ns: IntArray
    slot: SlotArray
    length: LengthArray
    words: WordArray

    @property
    def size(self) -> int:
        """Bytes in memory."""
        return self.time_ns.nbytes + self.slot.nbytes + self.length.nbytes + self.words.nbytes


class Keeper:
    """Frames in, batches of kept ones out. `words` and `seen` tell of the slots once all frames were taken."""

    def __init__(self, known: KnownIds, with_extended: Callable[[], KnownIds] | None = None) -> None:
        """with_extended: called when the first 29-bit identifier is met, gives what is known from then on."""
        self._known = known
        self._with_extended = with_extended
        self._state = np.zeros(STATE_SIZE, np.int64)
        self._state[BEYOND] = -1
        self._table: SlotArray = np.full(1 << 9, -1, np.int32)
        self._keys, self._counts, self._words = (np.zeros(1 << 8, np.int64) for _ in range(3))
        self._picks: tuple[SlotArray, SlotArray] = (np.empty(PICKS, np.int32), np.empty(PICKS, np.int32))
        self._room = _room()
        self._lent, self._keeping = False, True

    @property
    def words(self) -> IntArray:
        """(slots,) payload words that are kept of each slot's frames, 0 where the frames are not kept."""
        return self._words[: int(self._state[SLOTS])]

    @property
    def keys(self) -> IntArray:
        """(slots,) bus * 2**32 + id of each slot."""
        return self._keys[: int(self._state[SLOTS])]

    @property
    def beyond(self) -> int:
        """Frames that were not counted because there are too many different identifiers."""
        return max(int(self._state[BEYOND]), 0)

    def seen(self) -> dict[int, int]:
        """The number of frames by bus * 2**32 + id."""
        counts = self._counts[: int(self._state[SLOTS])]
        return dict(zip(self.keys.tolist(), counts.tolist(), strict=True))

    def keep_nothing(self) -> None:
        """From now on only count."""
        self.keep_only(np.zeros(0, np.int64))

    def keep_only(self, words: IntArray) -> None:
        """From now on keep the slots' frames with these numbers of words, and nothing of identifiers not met yet.

        Batches are then good only until the next one is asked for.
        """
        self._words[: words.size] = words
        self._words[words.size :] = 0
        self._known, self._keeping = KnownIds.of({}), False
        self._state[FILLED] = self._state[USED] = 0
        self._lent = True

    def take(self, frames: CanFrames) -> Iterator[Kept]:
        """Count frames and keep what is known; yields a batch whenever one is full."""
        can_id, bus = (
            np.ascontiguousarray(frames.can_id, np.uint32),
            np.ascontiguousarray(frames.bus, np.int16),
        )
        # of frames a byte, of J1939 messages in packets two
        size: ByteArray | LengthArray = (
            frames.length if frames.length.flags.c_contiguous else frames.length.copy()
        )
        payloads = (
            np.ascontiguousarray(frames.time_ns, np.int64),
            size,
            np.ascontiguousarray(frames.offset, np.int64),
            np.ascontiguousarray(frames.data, np.uint8),
        )
        begin, why = 0, FULL
        while why != DONE:
            table = (self._table, self._keys, self._counts, self._words)
            known, picks = self._known, self._picks
            time_ns, slot, length, words = self._room
            begin, why = take_frames(
                can_id, bus, *payloads, begin, *table, known.codes, known.words, *picks, time_ns, slot, length, words,
                self._state,
            )  # fmt: skip
            if why == FULL:
                yield from self.rest()
            elif why == GROW:
                self._grow()
            elif why == FIRST_EXTENDED:
                self._state[EXTENDED_MET] = 1
                more = self._with_extended() if self._with_extended is not None else None
                if more is not None and self._keeping:
                    self._known = more

    def rest(self) -> Iterator[Kept]:
        """The last batch, if there is anything in it."""
        filled, used = int(self._state[FILLED]), int(self._state[USED])
        if filled:
            time_ns, slot, length, words = self._room
            # what was not filled was never touched, and takes no memory
            yield Kept(time_ns[:filled], slot[:filled], length[:filled], words[:used])
            if not self._lent:
                self._room = _room()
            self._state[FILLED] = self._state[USED] = 0

    def _grow(self) -> None:
        """Room for twice as many identifiers, or an end to telling them apart."""
        slots = int(self._state[SLOTS])
        if slots >= MOST_IDS:
            self._state[BEYOND] = 0
            return
        for name in ("_keys", "_counts", "_words"):
            setattr(self, name, np.concatenate([getattr(self, name), np.zeros(slots, np.int64)]))
        self._table = np.empty(4 * slots, np.int32)
        fill_table(self._table, self._keys, slots)


def _room() -> tuple[IntArray, SlotArray, LengthArray, WordArray]:
    slab = Slab(14 * ROWS + 8 * WORDS)
    return (
        slab.empty(ROWS, np.int64),
        slab.empty(ROWS, np.int32),
        slab.empty(ROWS, np.uint16),
        slab.empty(WORDS, np.uint64),
    )
