"""Which time a message has: its header's stamp where that can be believed, else when the recorder received it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from parsers.channels import FloatArray, IntArray
from parsers.importer import ImportLog
from parsers.jit import kernel
from parsers.quantiles import quantile
from parsers.ros.clock_offsets import ClockOffset
from parsers.ros.clock_steps import ClockSteps

SAME_CLOCK_NS = 60_000_000_000
"""Header and receive time further apart than this are on different clocks (simulated time, time since boot)."""
YEAR_2000_NS = 946_684_800_000_000_000
"""Receive times before this are not of a wall clock: simulated time, or a computer that never learnt the date."""
SAID_FROM_S = 0.1
ENOUGH = 32
"""Messages of a batch from which on it shows whether header stamps move with them."""
_KEPT = 256


def is_wall_clock(first_receive_ns: int | None, log: ImportLog) -> bool:
    """Whether a log's receive times count from 1970; a note where they do not. Unknown times are taken to."""
    if first_receive_ns is None or first_receive_ns >= YEAR_2000_NS:
        return True
    log.note(
        f"the log's clock is no wall clock (it begins at {first_receive_ns / 1e9:.1f} s: simulated time?)"
    )
    return False


@kernel
def choose_stamps(
    header_ns: IntArray, receive_ns: IntArray, limit: int, chosen: IntArray, delays: FloatArray
) -> tuple[int, int, int]:
    """Header stamps where they are within `limit` of the receive times, else these: into chosen, all of shape (n,).

    (how many have no header stamp, how many are further off, how many delays were kept): some, spread over all.
    """
    step = max(1, (header_ns.shape[0] + delays.shape[0] - 1) // max(1, delays.shape[0]))
    empty, far, kept, wait = 0, 0, 0, 0
    for i in range(header_ns.shape[0]):
        stamp, receive = header_ns[i], receive_ns[i]
        # neither is negative where both are looked at, so that their difference fits
        near = stamp > 0 and receive >= 0 and abs(receive - stamp) <= limit
        chosen[i] = stamp if near else receive
        if stamp <= 0:
            empty += 1
        elif not near:
            far += 1
        elif i >= wait:
            delays[kept] = receive - stamp
            kept, wait = kept + 1, i + step
    return empty, far, kept


@dataclass
class _Topic:
    """What is known of one topic. uses_header: None until the first message with a stamp. unread: messages that could not be
    decoded, which look as if their stamps were zero.

    step_s: of header stamps that stand still for several messages, infinite where they never move; 0 where each moves on;
    None until enough messages were seen.
    """

    has_header: bool
    uses_header: bool | None = None
    messages: int = 0
    unread: int = 0
    empty: int = 0
    far: int = 0
    delays_s: list[FloatArray] = field(default_factory=list)
    other_clock_s: float = 0.0
    step_s: float | None = None
    steps: ClockSteps = field(default_factory=ClockSteps)
    offset: ClockOffset = field(default_factory=ClockOffset)


@dataclass
class StampChooser:
    """Chooses the time of messages, topic by topic, and writes down what it chose.

    A topic's first messages decide: their header stamps are used where the median is within 60 s of the receive
    time, and stamps move on with the messages (some drivers fill in whole seconds, or the first one's for all). Single messages
    without a stamp, or with one further off than that, get the receive time; so do, less the usual delay, those behind a step of
    the headers' clock against the receive times. Stamps that are off by the same seconds all along are shifted by them. All
    topics so keep the one clock on which the recorder ran. Usage: `choose` for every batch, then `finish`.
    """

    topics: dict[str, _Topic] = field(default_factory=dict)

    def add(self, topic: str, *, has_header: bool) -> None:
        """Announce a topic, so that `clock` can speak of it before anything is read."""
        self.topics.setdefault(topic, _Topic(has_header))

    def choose(
        self,
        topic: str,
        header_ns: IntArray | None,
        receive_ns: IntArray,
        *,
        in_place: bool = False,
        unread: int = 0,
    ) -> IntArray:
        """The time of each message of a batch; both inputs and the output have shape (n,), int64 nanoseconds.

        in_place: the result may be written over header_ns. unread: how many messages could not be decoded.
        """
        state = self.topics.setdefault(topic, _Topic(header_ns is not None))
        state.messages += len(receive_ns)
        state.unread += unread
        if header_ns is None:
            return receive_ns
        if state.uses_header is None and (header_ns > 0).any():
            stamped = header_ns > 0
            middle = quantile(receive_ns[stamped].astype(np.float64) - header_ns[stamped], 0.5)
            state.uses_header = abs(middle) <= SAME_CLOCK_NS
            state.other_clock_s = middle / 1e9
        if state.uses_header and state.step_s is None and len(receive_ns) >= ENOUGH:
            state.step_s = _step_s(header_ns, receive_ns)
            state.uses_header = state.step_s == 0
        if not state.uses_header:
            state.empty += int(np.count_nonzero(header_ns <= 0))
            return receive_ns
        header_ns, receive_ns = np.ascontiguousarray(header_ns), np.ascontiguousarray(receive_ns)
        if not state.offset.take(header_ns, receive_ns):
            return receive_ns
        header_ns = state.offset.apply(header_ns, in_place=in_place)
        chosen = header_ns if in_place else np.empty(len(receive_ns), dtype=np.int64)
        delays = np.empty(min(_KEPT, len(receive_ns)), dtype=np.float64)
        instead = state.steps.follow(header_ns, receive_ns, SAME_CLOCK_NS)
        empty, far, kept = choose_stamps(header_ns, receive_ns, SAME_CLOCK_NS, chosen, delays)
        state.empty += empty
        state.far += far
        if instead is None:
            state.delays_s.append(delays[:kept] / 1e9)
        else:
            np.copyto(chosen, instead, where=instead != 0)
        return chosen

    @property
    def clock(self) -> str:
        """Which clock the stamps are from, in words: as expected before reading, as found after it."""
        read = {name: state for name, state in self.topics.items() if state.messages} or self.topics
        by_receive = [name for name, state in read.items() if not self._by_header(state)]
        if not by_receive:
            return "header stamp"
        if len(by_receive) == len(read):
            return "receive time"
        return f"header stamp (receive time for {_some(by_receive)})"

    @staticmethod
    def _by_header(state: _Topic) -> bool:
        if state.uses_header is None:
            return state.has_header and state.messages == 0
        return state.uses_header

    def finish(self, log: ImportLog) -> None:
        """Write down which of the topics that were read used which time, and by how much the two differ."""
        read = {name: state for name, state in self.topics.items() if state.messages}
        plain = [name for name, state in read.items() if not state.has_header]
        if plain and len(plain) < len(read):
            log.note(f"no header, so the receive time is used: {_some(plain)}")
        for name, state in read.items():
            if not state.has_header:
                continue
            if state.unread >= state.messages:
                continue
            if state.uses_header is None:
                log.note(f"{name}: header stamps are all zero, so the receive time is used")
            elif state.step_s:
                how = "stand still" if math.isinf(state.step_s) else f"come in steps of {state.step_s:g} s"
                log.note(f"{name}: header stamps {how} while messages go on, so the receive time is used")
            elif not state.uses_header:
                log.note(
                    f"{name}: header stamps are on another clock ({abs(state.other_clock_s):.0f} s "
                    f"{'before' if state.other_clock_s > 0 else 'after'} the receive time), "
                    "so the receive time is used"
                )
            else:
                self._differences(name, state, log)

    @staticmethod
    def _differences(name: str, state: _Topic, log: ImportLog) -> None:
        if (empty := state.empty - state.unread) > 0:
            log.note(f"{name}: {empty} messages have no header stamp; they got the receive time")
        for note in state.offset.notes(name):
            log.note(note)
        if state.far:
            log.note(f"{name}: {state.far} header stamps are more than 60 s off; they got the receive time")
        if (stepped := state.steps.note(name)) is not None:
            log.note(stepped)
        delays = np.concatenate(state.delays_s) if state.delays_s else np.zeros(0)
        middle = quantile(delays, 0.5) if len(delays) else 0.0
        if abs(middle) > SAID_FROM_S:
            side = "before" if middle > 0 else "after"
            log.note(f"{name}: header stamps are {abs(middle):.2f} s {side} the receive time (median)")


def _step_s(header_ns: IntArray, receive_ns: IntArray) -> float:
    """How far apart in s stamps are that most messages share with the one before, though they came at moments of their own; else 0."""
    moved = np.diff(header_ns)
    if np.mean(moved == 0) < 2 / 3 or np.mean(np.diff(receive_ns) == 0) > 1 / 3:
        return 0.0
    steps = moved[moved != 0]
    return quantile(np.abs(steps), 0.5) / 1e9 if len(steps) else math.inf


def _some(names: list[str]) -> str:
    """Names for a sentence, not more than a line of them."""
    shown = ", ".join(names[:6])
    return shown if len(names) <= 6 else f"{shown} and {len(names) - 6} more"
