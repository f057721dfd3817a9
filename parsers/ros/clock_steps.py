"""Header stamps whose clock is set while the recorder goes on: a driver's computer that learns the time from the network."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from parsers.channels import IntArray
from parsers.jit import kernel
from parsers.timebase import JUMP_BACK_NS

LASTS = 16
"""So many messages in a row must be off by the step: a single wrong stamp, or a second sender with a delay of its own, is no
clock that was set."""
_WARM_UP = 32
_SLOW, _QUICK = 4096, 16
"""Over about so many messages the usual delay and the present one are taken; a stalled network moves the second only."""
_HEADER, _RECEIVE, _USUAL, _PRESENT, _SEEN, _RUN, _NEW, _FIRST_STEP, _SIZE = 0, 1, 2, 3, 4, 5, 6, 7, 8


@kernel
def find_steps(
    header_ns: IntArray, receive_ns: IntArray, limit: int, state: IntArray, instead: IntArray
) -> int:
    """Where header stamps jump away from their delay while receive times go on, and stay away: into `instead` the receive
    time less the delay before, else 0; all of shape (n,). How many there are.

    A header clock that is set jumps by itself. A queue that waits for its network lets receive times jump, and its headers are
    right; where it lost some of them, they jump back to the usual delay. state: carried from batch to batch.
    """
    found, begin = 0, 0
    for i in range(header_ns.shape[0]):
        instead[i] = 0
        stamp, receive = header_ns[i], receive_ns[i]
        if stamp <= 0 or receive < 0 or abs(receive - stamp) > limit:
            continue
        delay = receive - stamp
        usual, present, seen = state[_USUAL], state[_PRESENT], state[_SEEN]
        away = min(abs(delay - usual), abs(delay - present))
        if seen < _WARM_UP or away <= JUMP_BACK_NS:
            state[_RUN] = 0
        elif state[_RUN] >= LASTS or (state[_RUN] > 0 and abs(delay - state[_NEW]) <= JUMP_BACK_NS):
            state[_RUN] += 1
        else:
            state[_RUN] = 0
            before = state[_RECEIVE] - state[_HEADER]
            jump, went_on = abs(stamp - state[_HEADER]), abs(receive - state[_RECEIVE])
            if jump > JUMP_BACK_NS and went_on < jump // 2 and abs(delay - usual) > abs(before - usual):
                state[_RUN], state[_NEW] = 1, delay
                begin = i
        if state[_RUN] >= LASTS:
            if state[_FIRST_STEP] == 0:
                state[_FIRST_STEP] = present - delay
            for k in range(begin if state[_RUN] == LASTS else i, i + 1):
                if header_ns[k] > 0 and receive_ns[k] >= 0 and abs(receive_ns[k] - header_ns[k]) <= limit:
                    instead[k] = receive_ns[k] - present
                    found += 1
        elif state[_RUN] == 0:
            state[_USUAL] += (delay - usual) // min(seen + 1, _SLOW)
            state[_PRESENT] += (delay - present) // min(seen + 1, _QUICK)
            state[_SEEN] = seen + 1
        state[_HEADER], state[_RECEIVE] = stamp, receive
    return found


@dataclass
class ClockSteps:
    """Follows one topic's header stamps batch by batch. count: messages that were given their time by the receive time."""

    count: int = 0
    state: IntArray = field(default_factory=lambda: np.zeros(_SIZE, dtype=np.int64))

    def follow(self, header_ns: IntArray, receive_ns: IntArray, limit: int) -> IntArray | None:
        """Of each message the time that it has instead of its header's, 0 where that is good, (n,); None for all."""
        instead = np.empty(len(header_ns), dtype=np.int64)
        found = find_steps(header_ns, receive_ns, limit, self.state, instead)
        self.count += found
        return instead if found else None

    def note(self, topic: str) -> str | None:
        """What is to be said, if anything."""
        if not self.count:
            return None
        step = int(self.state[_FIRST_STEP]) / 1e9
        return (
            f"{topic}: the clock of the header stamps was set by {step:+.1f} s while messages went on; {self.count} messages "
            "behind it have the receive time, less the usual delay"
        )
