"""Header stamps by a clock that stands off from the recorder's all along: TAI, satellites' time, a computer that nobody set."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from parsers.channels import IntArray
from parsers.quantiles import quantile

APART_NS = 5_000_000_000
"""No message is under way for longer than this each time. Less may be a slow network, and the header is right then."""
STEADY_NS = 250_000_000
_STEADY_SHARE = 0.9
_ENOUGH = 8
"""Stamps by which the offset is told; a single first one may have waited in a queue."""
_WHOLE_NS, _NEAR_NS = 1_000_000_000, 100_000_000


@dataclass
class ClockOffset:
    """Follows one topic's stamps batch by batch until its offset is known. shift_ns: what is added to its stamps, None until then.

    waiting: messages that came before, and were so far off that they got the receive time.
    """

    shift_ns: int | None = None
    waiting: int = 0
    _delays: list[IntArray] = field(default_factory=list)

    def take(self, header_ns: IntArray, receive_ns: IntArray) -> bool:
        """Look at a batch, (n,) each. False where its stamps are off, and too few are known to say by how much."""
        if self.shift_ns is not None:
            return True
        self._delays.append((receive_ns - header_ns)[header_ns > 0])
        delays = np.concatenate(self._delays)
        if len(delays) >= _ENOUGH:
            self.shift_ns, self._delays = _shift_ns(delays), []
            return True
        if len(delays) == 0 or abs(quantile(delays.astype(np.float64), 0.5)) <= APART_NS:
            return True
        self.waiting += len(receive_ns)
        return False

    def apply(self, header_ns: IntArray, *, in_place: bool) -> IntArray:
        """The stamps on the recorder's clock, (n,); 0 where there is none. in_place: the given ones may be written over."""
        if not self.shift_ns:
            return header_ns
        out = header_ns if in_place else header_ns.copy()
        np.add(out, self.shift_ns, out=out, where=out > 0)
        return out

    def notes(self, topic: str) -> list[str]:
        """What is to be said, if anything."""
        said = []
        if self.shift_ns:
            side = "before" if self.shift_ns > 0 else "after"
            said.append(
                f"{topic}: header stamps are {abs(self.shift_ns) / 1e9:g} s {side} the receive time all along, by a clock of "
                "their own (TAI, satellites' time, or never set): they are shifted by that"
            )
        if self.waiting:
            said.append(
                f"{topic}: {self.waiting} messages with header stamps more than {APART_NS // 1_000_000_000} s off, before that "
                "could be told from a delay, got the receive time"
            )
        return said


def _shift_ns(delay_ns: IntArray) -> int:
    """What is to be added: the median delay, in whole seconds where it is close to some, as the rest is the messages' way then.

    0 where stamps and receive times agree, or are now near and now far.
    """
    middle = quantile(delay_ns.astype(np.float64), 0.5)
    if abs(middle) <= APART_NS or np.mean(np.abs(delay_ns - middle) <= STEADY_NS) < _STEADY_SHARE:
        return 0
    whole = round(middle / _WHOLE_NS) * _WHOLE_NS
    return whole if abs(middle - whole) <= _NEAR_NS else round(middle)
