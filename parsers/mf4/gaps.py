"""Which time a damaged data block took with it: between the stamps of the records before and behind it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from parsers.channels import IntArray
from parsers.importer import ImportLog
from parsers.mf4.clock import NO_TIME

RUN, MOST = 2, 100
"""Records without a stamp from which on, next to each other, they are a gap that is named; so many gaps of a piece of the file at most."""

PADDING = 8
"""Zero bytes behind the records that mean nothing."""


def say_zeros(log: ImportLog, end: str, count: int) -> None:
    """Say that the records end before zeros. end: where, in words. count: of the zero bytes."""
    if count >= PADDING:
        log.worsen(
            "truncated",
            f"the records of the MF4 file end at {end}: the {count} bytes behind them are zeros, as a recorder "
            "leaves them where it did not come to an end; all records before them were used",
        )


@dataclass
class Gaps:
    """Watches the numbers of the records as they come, group by group; writes gaps into `log.lost_spans_ns`."""

    log: ImportLog
    _bare: tuple[int, int] | None = None
    _ends: dict[int, tuple[int, int]] = field(default_factory=dict)

    def see(self, group: int, first: int, time_ns: IntArray, *, holes: bool = False) -> None:
        """Records of a group from number `first` on; NO_TIME stamps (holes: there are some) are passed over, a run of them is a gap."""
        expected, before = self._ends.get(group, (first, NO_TIME))
        ends = [int(time_ns[0]), int(time_ns[-1])] if time_ns.size else []
        if NO_TIME in ends:
            known = time_ns[time_ns != NO_TIME]
            ends = [int(known[0]), int(known[-1])] if known.size else []
        if ends and first > expected and before != NO_TIME and ends[0] > before:
            self.log.lost_spans_ns.append((before, ends[0]))
        if holes:
            self._inside(time_ns)
        self._ends[group] = first + int(np.size(time_ns)), ends[1] if ends else before

    def _inside(self, time_ns: IntArray) -> None:
        """Runs of records without a stamp between others, the first of them where there are very many."""
        bad = time_ns == NO_TIME
        edges = np.diff(bad.astype(np.int8), prepend=0, append=0)
        begins, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
        inner = (ends - begins >= RUN) & (begins > 0) & (ends < time_ns.size)
        before, behind = time_ns[begins[inner] - 1], time_ns[np.minimum(ends[inner], time_ns.size - 1)]
        spans = zip(before.tolist(), behind.tolist(), strict=True)
        self.log.lost_spans_ns += [(a, b) for a, b in spans if b > a][:MOST]

    def without_payload(self, time_ns: IntArray) -> None:
        """Frames whose payloads damage made uncertain; those of one batch after another are one gap."""
        known = time_ns[time_ns != NO_TIME]
        if not known.size:
            return
        begin, end = int(known.min()), int(known.max())
        spans = self.log.lost_spans_ns
        if self._bare is not None and spans and spans[-1] == self._bare and begin >= self._bare[0]:
            begin = spans.pop()[0]
        if end > begin:
            self._bare = begin, max(end, begin)
            spans.append(self._bare)
