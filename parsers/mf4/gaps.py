"""Which time a damaged data block took with it: between the stamps of the records before and behind it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from parsers.channels import IntArray
from parsers.importer import ImportLog
from parsers.mf4.clock import NO_TIME


@dataclass
class Gaps:
    """Watches the numbers of the records as they come, group by group; writes gaps into `log.lost_spans_ns`."""

    log: ImportLog
    _ends: dict[int, tuple[int, int]] = field(default_factory=dict)

    def see(self, group: int, first: int, time_ns: IntArray) -> None:
        """Records of a group from number `first` on; NO_TIME stamps are passed over."""
        expected, before = self._ends.get(group, (first, NO_TIME))
        ends = [int(time_ns[0]), int(time_ns[-1])] if time_ns.size else []
        if NO_TIME in ends:
            known = time_ns[time_ns != NO_TIME]
            ends = [int(known[0]), int(known[-1])] if known.size else []
        if ends and first > expected and before != NO_TIME and ends[0] > before:
            self.log.lost_spans_ns.append((before, ends[0]))
        self._ends[group] = first + int(np.size(time_ns)), ends[1] if ends else before
