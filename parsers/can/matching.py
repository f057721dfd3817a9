"""Which identifiers of a log are which messages of the databases, and what their channels are called."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from parsers.can.buses import BusDatabases
from parsers.can.definitions import MessageDef, id_text, is_proprietary, pgn_of, sender_of
from parsers.can.standard import standard_of
from parsers.importer import ImportLog


@dataclass(frozen=True)
class Stream:
    """One message as one sender puts it on one bus: what becomes channels.

    keys: bus * 2**32 + id of all identifiers that carry it (J1939: priorities and destinations may differ).
    pgn, sender: for messages matched as J1939, else None. suffix: "" or "@bus2", "@sa33", what follows the names
    of channels. frames: number in the log. special_codes: J1939 codes for "not available" and so on are in force.
    builtin: of cogest's own J1939 definitions, not of a database that was given. standard: cogest's own definition of
    the parameter group that a database's message is, whatever it is called there; None where it is none.
    """

    message: MessageDef
    bus: int
    keys: tuple[int, ...]
    frames: int
    pgn: int | None = None
    sender: int | None = None
    suffix: str = ""
    special_codes: bool = False
    builtin: bool = False
    standard: MessageDef | None = None

    @property
    def proprietary(self) -> bool:
        """Whether J1939 leaves the content to the maker."""
        return self.pgn is not None and is_proprietary(self.pgn)


@dataclass
class _Index:
    """The databases' messages by what identifies them."""

    ids: set[int] = field(default_factory=set)
    by_pgn_and_sender: dict[tuple[int, int], MessageDef] = field(default_factory=dict)
    by_pgn: dict[int, MessageDef] = field(default_factory=dict)
    loose: dict[int, MessageDef] = field(default_factory=dict)


def _index(messages: Iterable[MessageDef], known: set[int]) -> _Index:
    index = _Index()
    for message in messages:
        index.ids.add(message.can_id)
        pgn = pgn_of(message.can_id)
        exactly = message.by_exact_id and not message.j1939
        if pgn is None or (exactly and pgn not in known):
            continue
        if message.j1939:
            index.by_pgn_and_sender.setdefault((pgn, sender_of(message.can_id)), message)
            index.by_pgn.setdefault(pgn, message)
        else:
            index.loose.setdefault(pgn, message)
    return index


def match_streams(
    seen: Mapping[int, int],
    given: tuple[MessageDef, ...],
    builtin: tuple[MessageDef, ...],
    log: ImportLog,
    bound: Mapping[str, tuple[int, ...]] | None = None,
) -> tuple[Stream, ...]:
    """The streams of a log, in the order of the databases' messages, then by bus.

    seen: number of frames of each key (bus * 2**32 + id). given: messages of the user's databases; builtin: J1939
    messages for parameter groups that those do not define. bound: the buses of a database, by file name, where the user said so.
    """
    known = {pgn: message for message in builtin if (pgn := pgn_of(message.can_id)) is not None}
    ids = {key & 0xFFFF_FFFF for key in seen}
    given = tuple(
        replace(message, j1939=False) if message.by_exact_id and message.can_id in ids else message
        for message in given
    )
    index = _index(given, set(known))
    databases = BusDatabases(given, seen, bound or {})
    defined = {pgn for message in given if (pgn := pgn_of(message.can_id)) is not None}
    spare = {pgn: m for m in builtin if (pgn := pgn_of(m.can_id)) is not None and pgn not in defined}
    exact = ids & index.ids
    rank = {id(message): place for place, message in enumerate((*given, *builtin))}
    found: dict[tuple[int, int, int | None], list[int]] = defaultdict(list)
    loosely: set[str] = set()
    from_builtin: set[str] = set()
    for key in sorted(seen):
        bus, can_id = key >> 32, key & 0xFFFF_FFFF
        pgn = pgn_of(can_id)
        message, undecided = databases.pick(can_id, bus)
        if undecided:
            continue
        if message is None and pgn is not None:
            exactly = index.by_pgn_and_sender.get((pgn, sender_of(can_id)))
            message = databases.of(exactly, bus) or databases.of(index.by_pgn.get(pgn), bus)
            candidate = databases.of(index.loose.get(pgn), bus)
            if message is None and candidate is not None and candidate.can_id not in exact:
                message = candidate
                loosely.add(message.name)
            if message is None and pgn in spare:
                message = spare[pgn]
                from_builtin.add(message.name)
        if message is not None:
            by_pgn = pgn is not None and (message.j1939 or pgn in known or message.name in loosely)
            found[rank[id(message)], bus, sender_of(can_id) if by_pgn else None].append(key)
    databases.say(log)
    _say_how(given, loosely, from_builtin, log)
    everything = (*given, *builtin)
    streams = [
        _stream(everything[place], bus, sender, tuple(keys), seen, known, builtin=place >= len(given))
        for (place, bus, sender), keys in found.items()
    ]
    streams.sort(key=lambda s: (rank[id(s.message)], s.bus, -s.frames, s.sender or 0))
    return _named(streams, log)


def _stream(
    message: MessageDef,
    bus: int,
    sender: int | None,
    keys: tuple[int, ...],
    seen: Mapping[int, int],
    known: Mapping[int, MessageDef],
    *,
    builtin: bool,
) -> Stream:
    """sender: None where the message is no J1939. known: cogest's own J1939 messages by group."""
    frames, pgn = sum(seen[key] for key in keys), pgn_of(message.can_id)
    if sender is None:
        return Stream(message, bus, keys, frames, builtin=builtin)
    standard = standard_of(message, known.get(pgn or 0))
    return Stream(
        message,
        bus,
        keys,
        frames,
        pgn=pgn,
        sender=sender,
        special_codes=True,
        builtin=builtin,
        standard=standard,
    )


def _say_how(
    given: tuple[MessageDef, ...], loosely: set[str], from_builtin: set[str], log: ImportLog
) -> None:
    if loosely:
        log.note(
            f"matched by J1939 parameter group, since the database's 29-bit id is not in the log: {_list(loosely)}"
        )
    if from_builtin:
        why = "not in the databases given" if given else "no database (--dbc) was given"
        log.note(f"decoded with cogest's own J1939 definitions, {why}: {_list(from_builtin)}")


def _named(streams: list[Stream], log: ImportLog) -> tuple[Stream, ...]:
    """Give each stream the suffix that keeps channel names apart; the first of a message is plain."""
    first: dict[str, Stream] = {}
    named = []
    others: dict[str, list[str]] = defaultdict(list)
    for stream in streams:
        plain = first.setdefault(stream.message.name, stream)
        suffix = ""
        if stream.message is not plain.message:
            suffix += f"@id{stream.message.can_id & 0x1FFF_FFFF}"
        if stream.bus != plain.bus:
            suffix += f"@bus{stream.bus}"
        if stream.sender != plain.sender and stream.sender is not None:
            suffix += f"@sa{stream.sender}"
        if suffix:
            others[stream.message.name].append(suffix)
        named.append(replace(stream, suffix=suffix))
    for name, suffixes in others.items():
        plain = first[name]
        sender = "" if plain.sender is None else f", source address {plain.sender}"
        log.note(
            f"{name} comes from several senders, buses or ids: the plain name is bus {plain.bus}{sender} "
            f"({plain.frames} frames), the others end with {', '.join(suffixes[:6])}"
            + (f" and {len(suffixes) - 6} more" if len(suffixes) > 6 else "")
        )
    return tuple(named)


def explain_no_match(seen: Mapping[int, int], given: tuple[MessageDef, ...], log: ImportLog) -> None:
    """Say why a log has no usable channel: no database, or none that fits."""
    frames = sum(seen.values())
    ids = sorted({key & 0xFFFF_FFFF for key in seen})
    if not ids:
        log.note("the log holds no CAN data frames")
    elif not given:
        log.note(
            f"the log holds {len(ids)} CAN identifiers ({frames} frames) but no database to decode them: "
            "name one with --dbc FILE"
        )
    else:
        in_log = ", ".join(id_text(can_id) for can_id in ids[:4])
        in_dbc = ", ".join(id_text(message.can_id) for message in given[:4])
        log.note(
            f"none of the log's {len(ids)} CAN identifiers ({in_log}{', …' if len(ids) > 4 else ''}) is in the databases given "
            f"({len(given)} message{'s' if len(given) > 1 else ''}: {in_dbc}{', …' if len(given) > 4 else ''}): check that --dbc belongs to this vehicle and bus"
        )


def note_unknown(seen: Mapping[int, int], streams: tuple[Stream, ...], log: ImportLog) -> None:
    """Say how much of the log no database explains."""
    known = {key for stream in streams for key in stream.keys}
    unknown = [key for key in seen if key not in known]
    if unknown and streams:
        count = sum(seen[key] for key in unknown)
        log.note(
            f"{len(unknown)} of {len(seen)} CAN identifiers ({count} of {sum(seen.values())} frames) "
            "are in no database and were not decoded"
        )


def _list(names: set[str], most: int = 8) -> str:
    ordered = sorted(names)
    return ", ".join(ordered[:most]) + (f" and {len(ordered) - most} more" if len(ordered) > most else "")
