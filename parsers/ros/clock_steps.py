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
_SLOW_BITS, _QUICK_BITS = 12, 4
_SLOW, _QUICK = 1 << _SLOW_BITS, 1 << _QUICK_BITS
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
    usual, present, seen, run = state[_USUAL], state[_PRESENT], state[_SEEN], state[_RUN]
    last_stamp, last_receive = state[_HEADER], state[_RECEIVE]
    for i in range(header_ns.shape[0]):
        instead[i] = 0
        stamp, receive = header_ns[i], receive_ns[i]
        if stamp <= 0 or receive < 0 or abs(receive - stamp) > limit:
            continue
        delay = receive - stamp
        away = min(abs(delay - usual), abs(delay - present))
        if seen < _WARM_UP or away <= JUMP_BACK_NS:
            run = 0
        elif run >= LASTS or (run > 0 and abs(delay - state[_NEW]) <= JUMP_BACK_NS):
            run += 1
        else:
            run = 0
            before = last_receive - last_stamp
            jump, went_on = abs(stamp - last_stamp), abs(receive - last_receive)
            if jump > JUMP_BACK_NS and went_on < jump // 2 and abs(delay - usual) > abs(before - usual):
                run, state[_NEW] = 1, delay
                begin = i
        if run >= LASTS:
            if state[_FIRST_STEP] == 0:
                state[_FIRST_STEP] = present - delay
            for k in range(begin if run == LASTS else i, i + 1):
                if header_ns[k] > 0 and receive_ns[k] >= 0 and abs(receive_ns[k] - header_ns[k]) <= limit:
                    instead[k] = receive_ns[k] - present
                    found += 1
        elif run == 0:
            # a division takes longer than all else here: where it is by a power of two, it is a shift
            slow, quick = delay - usual, delay - present
            usual += slow >> _SLOW_BITS if seen + 1 >= _SLOW else slow // (seen + 1)
            present += quick >> _QUICK_BITS if seen + 1 >= _QUICK else quick // (seen + 1)
            seen += 1
        last_stamp, last_receive = stamp, receive
    state[_USUAL], state[_PRESENT], state[_SEEN], state[_RUN] = usual, present, seen, run
    state[_HEADER], state[_RECEIVE] = last_stamp, last_receive
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
