"""The reader that all CAN formats share: frames and databases in, channels and decoded chunks out."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path

import numpy as np

from parsers.allocator import keep_freed_memory
from parsers.can.contained import CARRIER, Contained
from parsers.can.database import builtin_j1939, load_databases
from parsers.can.decode import Place
from parsers.can.definitions import MessageDef, pgn_of
from parsers.can.frames import FrameSource
from parsers.can.groups import channel_of, groups_of
from parsers.can.keep import MOST_WORDS, Keeper, Kept, KnownIds
from parsers.can.matching import explain_no_match, match_streams, note_unknown
from parsers.can.piece_decode import Cut, PieceDecoder
from parsers.can.plain import PlainGroups
from parsers.can.slots import GROUP
from parsers.can.spread import Piece, pieces
from parsers.can.transport import Transport, without_carriers
from parsers.can.whole import Places, whole_columns
from parsers.channels import ChannelInfo, Chunk, IntArray
from parsers.importer import ImportLog, ReadOptions
from parsers.parallel import in_order

KEPT_BYTES = 96 << 20
"""Most memory that the frames of one pass may take; of a log with more, `read` makes a second pass."""

PIECE = 1 << 17
"""Frames of a batch that is kept which a core decodes at a time: what lies between frames and columns stays small."""


class CanReader:
    """A `LogReader` over the frames of any CAN format.

    On opening it loads the databases and goes through the log once: counts the identifiers and keeps the frames of those that
    a database may know, from which `read` decodes. Raises DatabaseError where a database cannot be used, LogError
    where the log cannot be read; where no channel can be made of the frames, `channels` is empty and the log book
    says why.
    """

    def __init__(self, source: FrameSource, options: ReadOptions, log: ImportLog, path: Path) -> None:
        keep_freed_memory()
        self._source = source
        self._options = options
        self._log = log
        self._path = path
        log.can_frames = True
        given = load_databases(options.dbc, log, given=options.dbc_given)
        builtin: tuple[MessageDef, ...] = ()

        def with_extended() -> KnownIds:
            # the second database is needed only where 29-bit ids are about
            nonlocal builtin
            builtin = builtin_j1939(log)
            return _known((*given, *builtin))

        self._keeper = Keeper(_known(given), with_extended)
        transport, contained = Transport(), Contained()
        self._kept = self._first_pass(transport, contained)
        seen = self._keeper.seen()
        streams = match_streams(seen, given, builtin, log, options.buses)
        log.databases = tuple(
            dict.fromkeys(s.message.origin for s in streams if s.message.origin and not s.builtin)
        )
        transport.say((*given, *builtin), streams, log)
        contained.say(streams, log)
        _say_unknown(options, log)
        if streams:
            note_unknown(_without_containers(without_carriers(seen, transport), contained), streams, log)
        else:
            explain_no_match(seen, given, log)
        self._groups = tuple(group for stream in streams for group in groups_of(stream))
        self._channels = tuple(
            channel_of(group, name, signal)
            for group in self._groups
            for name, signal in group.signals.items()
        )

    @property
    def channels(self) -> tuple[ChannelInfo, ...]:
        """Signals of all messages that are in the log, in the order of the databases."""
        return self._channels

    @property
    def clock(self) -> str:
        """As the format has it."""
        return self._source.clock

    @property
    def absolute(self) -> bool:
        """As the format has it."""
        return self._source.absolute

    @property
    def start_utc_ns(self) -> int | None:
        """As the format has it."""
        return self._source.start_utc_ns

    def read(self, wanted: frozenset[str]) -> Iterator[Chunk]:
        """Yield decoded chunks. What was kept of the log is given up on the way; reading again takes another pass."""
        groups = [group for group in self._groups if not wanted.isdisjoint(group.signals)]
        kept, self._kept = self._kept, None
        if not groups:
            return
        streams = list({id(group.stream): group.stream for group in groups}.values())
        width = [_words(stream.message) for stream in streams]
        number = {id(stream): part for part, stream in enumerate(streams)}
        parts = [number[id(group.stream)] for group in groups]
        part_of_key = {key: part for part, stream in enumerate(streams) for key in stream.keys}
        part_of = np.array([part_of_key.get(key, -1) for key in self._keeper.keys.tolist()], np.int64)
        plain: PlainGroups | None = None
        if kept is None:
            words = np.where(part_of >= 0, np.array(width, np.int64)[part_of], 0)
            work: Iterator[tuple[Piece, Places]] = (
                (piece, Places.loose(groups))
                for batch in self._next_pass(words)
                for piece in pieces(batch, words, part_of, len(streams), batch.slot.size)
            )
        else:
            words = self._keeper.words
            cut = partial(pieces, slot_words=words, part_of=part_of, parts=len(streams), step=PIECE)
            taken = deque(piece for found in in_order(cut, kept) for piece in found)
            kept.clear()
            whole = whole_columns(taken, groups, parts, wanted)
            if whole is not None:
                plain, work = PlainGroups(groups, whole), whole.places(taken)
            else:
                work = ((taken.popleft(), Places.loose(groups)) for _ in range(len(taken)))

        decode = PieceDecoder(groups, parts, wanted, Cut(words, part_of, width), plain)
        # the batches of another pass share their memory: one at a time
        workers = 1 if kept is None else None
        for outcomes in in_order(decode, work, workers=workers):
            for chunk, rejected in outcomes:
                for reason, count in rejected:
                    self._log.reject(reason, count)
                if chunk is not None:
                    yield chunk

    def _first_pass(self, transport: Transport, contained: Contained) -> deque[Kept] | None:
        """Count all frames and keep the known ones; None where they are too many."""
        keeper = self._keeper
        kept: deque[Kept] = deque()
        size, fits = 0, True
        for batch in _batches(self._source, keeper, transport, contained, counting=True):
            size += batch.size
            fits = fits and size <= KEPT_BYTES
            if fits:
                kept.append(batch)
            else:
                kept.clear()
                keeper.keep_nothing()
        self._log.reject("frame of one identifier too many to tell apart", keeper.beyond)
        return kept if fits else None

    def _next_pass(self, words: IntArray) -> Iterator[Kept]:
        """The frames of the slots that have words."""
        self._keeper.keep_only(words)
        yield from _batches(self._source, self._keeper, Transport(), Contained(), counting=False)
        self._options.progress(1, 1)


def _say_unknown(options: ReadOptions, log: ImportLog) -> None:
    """Databases whose buses the mapping file tells, and that are not there."""
    unknown = sorted(options.buses.keys() - {path.name for path in options.dbc})
    if unknown:
        log.note(f"[buses] of the mapping file names databases that were not read: {', '.join(unknown)}")


def _without_containers(seen: dict[int, int], contained: Contained) -> dict[int, int]:
    """The frames of each key but for those that hold others, which count as messages themselves."""
    if not contained.groups:
        return seen
    return {key: count for key, count in seen.items() if pgn_of(key & 0xFFFF_FFFF) != CARRIER}


def _batches(
    source: FrameSource, keeper: Keeper, transport: Transport, contained: Contained, *, counting: bool
) -> Iterator[Kept]:
    """What is kept of one pass through a log: of its frames, and of the messages that these hold, or carry in packets."""
    for frames in source.frames(counting=counting):
        yield from keeper.take(frames)
        for messages in (contained.take(frames), transport.take(frames)):
            if messages is not None:
                yield from keeper.take(messages)
    transport.end()
    yield from keeper.rest()


def _words(message: MessageDef) -> int:
    """How many words of eight bytes of a message's payload its signals reach into."""
    fields = [signal.field for signal in message.signals]
    fields += [gate.field for signal in message.signals for gate in signal.gates]
    last = max((Place.of(field).last for field in fields), default=-1)
    return min(last // 8 + 1, MOST_WORDS)


def _known(messages: Iterable[MessageDef]) -> KnownIds:
    """Which identifiers and parameter groups any of the messages may be matched to, however that is decided in the end."""
    known: dict[int, int] = {}
    for message in messages:
        pgn = pgn_of(message.can_id)
        for code in (message.can_id,) if pgn is None else (message.can_id, GROUP + pgn):
            known[code] = max(known.get(code, 0), _words(message))
    return KnownIds.of(known)
