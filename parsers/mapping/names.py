"""Signals recognised by a column's name alone, by the table in `parsers/profiles/names.toml`."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache

from parsers.channels import ChannelInfo
from parsers.mapping.bindings import Binding
from parsers.mapping.contexts import blocking_words, without_device
from parsers.mapping.dampers import at_which, reason_at
from parsers.mapping.doubts import doubts
from parsers.mapping.elements import element_texts, wheel_of
from parsers.mapping.match import Refusal, choose_unit
from parsers.mapping.name_units import without_suffix
from parsers.mapping.wheel_radius import TURN_RATE, turn_rate
from parsers.mapping.words import NameTable, is_japanese, known_words, load_names, plain_letters, words_of
from parsers.signals import COLUMNS, SIGNALS, WHEEL_SPEEDS, WHEELS
from parsers.table_names import split_header, split_unit
from parsers.unit_words import is_remark, says_unit
from parsers.units import SI_TEXT, STANDARD_GRAVITY, Unit, find_unit

RANK_CANONICAL = 0
RANK_CANONICAL_NAME = 2
RANK_NAME = 60
_RANK_WORSE = 10
_RANK_WEAK = 8
_LEAST_HEIGHT_M = 0.1
"""Unit of a height from which on it can be one above the sea: feet are, inches, cm and mm are not."""
_OF_BODY = frozenset({"body", "chassis", "car", "vehicle", "veh", "cg", "cog"})
_LAST = 12
"""The place of a name that is less than all others of its signal."""


def vendor_prefixes(channels: Sequence[ChannelInfo]) -> frozenset[tuple[str, str]]:
    """(group, prefix) of what two channels of a group or more begin with and no word of the table is: ("ESC", "VehDyn").

    A prefix that means something ("GPS", "Target", "Wheel") is none.
    """
    table = load_names()
    seen = Counter((channel.group, prefix) for channel in channels if (prefix := _prefix(channel)))
    meaning = {word for key in table.sets for word in key} | table.worse
    telling = table.blocked | table.blocked_fields | table.references
    return frozenset(
        (group, prefix)
        for (group, prefix), count in seen.items()
        if count > 1
        and not prefix[0].isdigit()
        and not meaning & set(words := words_of(prefix, table))
        and not known_words(words, telling)
    )


def _prefix(channel: ChannelInfo) -> str:
    """What stands before the first underscore of a name's last part."""
    head, underscore, rest = _last_part(channel).partition("_")
    return head if underscore and rest else ""


def name_bindings(
    channel: ChannelInfo,
    prefixes: Collection[tuple[str, str]] = (),
    pitches: Collection[str] = (),
    rates: Collection[str] = (),
) -> Iterator[Binding | Refusal]:
    """What a channel could be by its name: at most one signal.

    prefixes: those of `vendor_prefixes`; pitches: those of `parsers.mapping.doubts.attitudes`; rates: those of
    `parsers.mapping.triads` and `parsers.mapping.quads`.
    """
    table = load_names()
    texts = _texts(channel)
    last = _last_part(channel)
    if last and (channel.group, prefix := _prefix(channel)) in prefixes:
        texts.append(last.removeprefix(f"{prefix}_"))
    found, bracket = None, None
    for text in texts:
        plain, bracket = split_unit(text)
        found = _directed(plain, channel.unit or bracket, table) or _find(
            plain, channel.unit or bracket, table
        )
        if found is not None:
            break
    canonical = _canonical(channel, split_unit(last)[0]) if last else None
    if found is None and canonical is None:
        return
    blocked = _blocked(channel, last, table)
    doubt = None if found is None else next(doubts(channel, found.signal, found.key, pitches), None)
    if blocked or doubt:
        canonical = None
    elif canonical is not None and not _is_column(channel):
        # a part of a path, or a message's field, says no more than any other name of the signal
        canonical = None if found is not None else replace(canonical, rank=RANK_NAME)
    if canonical is not None and (found is None or found.signal == canonical.signal):
        yield canonical
    elif found is not None and blocked:
        reason = f"{min(blocked)!r} in its name: not a measurement of this vehicle's {found.signal}"
        yield Refusal(channel.name, found.signal, reason)
    elif found is not None and doubt:
        yield Refusal(channel.name, found.signal, doubt)
    elif found is not None:
        named = _named(channel, found, bracket or found.suffix, table, sure=channel.name in rates)
        at = at_which(found.signal, found.key) if isinstance(named, Binding) else None
        yield named if at is None else Refusal(channel.name, found.signal, reason_at(found.signal, at), at=at)


def ambiguous_name(channel: ChannelInfo) -> str | None:
    """Why a name is too general to be mapped, or None."""
    table = load_names()
    for text in _texts(channel):
        words = [word for word in words_of(split_unit(text)[0], table) if word not in table.noise]
        reason = table.ambiguous.get(tuple(sorted(words)))
        if reason is not None:
            return reason
    return None


def _parts(channel: ChannelInfo) -> list[str]:
    """The parts of a channel's path; none where its name must not be looked at."""
    tags = channel.tags
    if (
        channel.family == "vbo"
    ):  # a dot is an abbreviation there ("Lat._Vel."), a leading underscore a raw value
        return [] if channel.name.startswith("_") else [channel.name]
    name = without_device(tags.get("field") or tags.get("signal") or tags.get("column") or channel.name)
    plain = split_header(name).name if channel.family in ("table", "mdf") else name
    if name.startswith(f"{plain}/"):
        # "a_x/g": what stands behind the slash is a unit, and no part of a path
        name = plain
    return re.split(r"[./\\:]+", name) if not re.search(r"\s", name) else [name]


def _is_column(channel: ChannelInfo) -> bool:
    """Whether a channel is a column at the top of a table."""
    return channel.family in ("table", "vbo", "mdf") and len(_parts(channel)) == 1


def _last_part(channel: ChannelInfo) -> str:
    return (_parts(channel) or [""])[-1]


def _blocked(channel: ChannelInfo, last: str, table: NameTable) -> frozenset[str]:
    """The words of a channel's name that say that it is not measured. last: the last part of its path."""
    found = blocking_words(channel, last)
    if any(ending in last.lower() for ending in table.blocked_endings):
        # the last word that is no unit: "ref" of "YawRateRef [deg/s]" and of "yaw_rate_ref_degps"
        *_, (text, _) = without_suffix(split_unit(last)[0])
        found |= table.blocked_endings & set(words_of(text, table)[-1:])
    return found


def _texts(channel: ChannelInfo) -> list[str]:
    """The texts to look at: all parts of a path but the first ones, then fewer, to the last part alone.

    What stands before a name tells more of it ("velocities.yaw", "fl.speed"); a topic does where its field says nothing
    ("/vehicle/speed" with "data").
    """
    parts = _parts(channel)
    wheel = wheel_of(channel)
    if wheel is not None:
        return element_texts(channel, wheel, parts)
    texts = [" ".join(parts[start:]) for start in (-3, -2, -1, 0)]
    topic = channel.tags.get("topic", "").rstrip("/").rpartition("/")[2]
    if topic and parts:
        texts.append(f"{topic} {parts[-1]}")
    return list(dict.fromkeys(text for text in texts if text))


@dataclass(frozen=True)
class _Found:
    signal: str
    key: tuple[str, ...]
    place: int
    worse: bool
    suffix: str | None


def _find(name: str, stated: str | None, table: NameTable) -> _Found | None:
    """Look a name up, with and without a unit glued to its end; a command as what it commands, so that it can be said.

    stated: the unit that the log or a bracket states.
    """
    for text, suffix in without_suffix(name):
        words = [word for word in words_of(text, table) if not known_words([word], table.commands)]
        kept = [word for word in words if word not in table.worse]
        if tuple(sorted(kept)) not in table.sets:
            # "body" is noise in a vehicle's own signals, and not in "Body acc FL"
            words = [word for word in words if word not in table.noise]
            kept = [word for word in words if word not in table.worse]
        hit = table.sets.get(tuple(sorted(kept)))
        if hit is not None and hit[0] in ("latitude", "longitude") and _spelt_out(text, table):
            continue
        if hit is not None and suffix is not None and _no_unit(suffix, stated, hit[0]):
            continue
        if hit is not None:
            return _Found(hit[0], tuple(sorted(kept)), hit[1], len(kept) < len(words), suffix)
    return None


def _no_unit(suffix: str, stated: str | None, signal: str) -> bool:
    """Whether a name's end is no unit after all: "N" behind a velocity is north, and no newton."""
    quantity = SIGNALS[signal].quantity
    if find_unit(suffix, quantity) is not None or turn_rate(suffix, signal) is not None:
        return False
    return len(suffix) == 1 or find_unit(stated, quantity) is not None


def _directed(name: str, unit: str | None, table: NameTable) -> _Found | None:
    """A direction alone, where the unit tells of what: "Lat [g]"."""
    quantities = {SIGNALS[signal].quantity for signal in table.directions.values()}
    if says_unit(unit) and not any(find_unit(unit, quantity) for quantity in quantities):
        return None
    for text, suffix in without_suffix(name):
        words = [word for word in words_of(text, table) if word not in table.noise]
        key = tuple(sorted(word for word in words if word not in table.worse))
        signal = table.directions.get(key)
        if signal is not None and find_unit(unit or suffix, SIGNALS[signal].quantity) is not None:
            return _Found(signal, key, _LAST, len(key) < len(words), suffix)
    return None


def _spelt_out(name: str, table: NameTable) -> bool:
    """Whether a name says "lateral" or "longitudinal" in full: a direction, and no coordinate."""
    if is_japanese(name):
        return True
    pieces = re.split(r"[^a-z]+", plain_letters(name).lower())
    return any(
        table.words.get(each) in ("lateral", "long") and each not in table.abbreviated for each in pieces
    )


def _canonical(channel: ChannelInfo, name: str) -> Binding | None:
    """A column of cogest's own store ("accel_y_mps2"), or a canonical name with the log's unit ("accel_y")."""
    spec = COLUMNS.get(name)
    if spec is not None and (spec.column != spec.name or spec.name not in SIGNALS):
        stated = find_unit(channel.unit, spec.quantity)
        if (stated is None and not says_unit(channel.unit)) or (stated is not None and stated.scale == 1.0):
            unit = Unit(channel.unit or SI_TEXT[spec.quantity], spec.quantity, 1.0)
            rule = f"canonical column {name!r}"
            return Binding(spec.name, (channel.name,), unit, "name", rule, rank=RANK_CANONICAL)
    if name not in SIGNALS:
        return None
    chosen = _unit(channel, name, split_unit(channel.name)[1])
    if isinstance(chosen, str):
        return None
    unit, unit_from = chosen
    rule = f"canonical name {name!r}"
    return Binding(name, (channel.name,), unit, unit_from, rule, rank=RANK_CANONICAL_NAME)


def _unit(channel: ChannelInfo, signal: str, text: str | None) -> tuple[Unit, str] | str:
    """The log's unit, else the one in the name, else SI; a reason where either is no unit of the quantity that is known.

    text: what stands in the name.
    """
    chosen = choose_unit(channel, signal, text, "name")
    if not isinstance(chosen, str) and chosen[1] == "assumed SI" and text and not _remark(channel, text):
        return choose_unit(replace(channel, unit=text), signal, None, "")
    return chosen


def _remark(channel: ChannelInfo, text: str) -> bool:
    """Whether what stands behind a name is words that are no unit: any in round brackets, known ones in square ones."""
    if not is_remark(text):
        return False
    square = channel.tags.get("column", channel.name).rstrip().endswith("]")
    return not square or set(words_of(text, load_names())) <= _vocabulary()


@cache
def _vocabulary() -> frozenset[str]:
    table = load_names()
    return table.noise | table.worse | table.commands | {*table.words.values(), *WHEELS, "x", "y", "z"}


def _low_height(channel: ChannelInfo, unit: Unit) -> str | None:
    """Why a height is the body's over the road or the axle, and no altitude; None where it may be one."""
    if unit.scale < _LEAST_HEIGHT_M:
        # a receiver's fields in mm are called so with more words, or altitude
        return f"a height in {unit.text} is the body's over the road or the axle, and no altitude"
    whose = _OF_BODY & set(words_of(channel.name, load_names()))
    return f"the height of the {max(whose, key=len)} is over the road, and no altitude" if whose else None


def _named(
    channel: ChannelInfo, found: _Found, text: str | None, table: NameTable, *, sure: bool
) -> Binding | Refusal:
    """The binding of a name that was found. sure: what stands beside a general name says what it is."""
    quantity = SIGNALS[found.signal].quantity
    chosen = _unit(channel, found.signal, text)
    if isinstance(chosen, str):
        return Refusal(channel.name, found.signal, chosen, unit=True)
    unit, unit_from = chosen
    if unit_from == "assumed SI" and "gyro" in found.key and found.signal in WHEEL_SPEEDS:
        unit = Unit(SI_TEXT[TURN_RATE], TURN_RATE, 1.0)
    if unit_from == "assumed SI" and "g" in found.key and quantity == "acceleration":
        unit, unit_from = Unit("g", quantity, STANDARD_GRAVITY), "name"
    low = _low_height(channel, unit) if found.key == ("height",) else None
    if low is not None:
        return Refusal(channel.name, found.signal, low, told=True)
    weak = found.key in table.weak
    guessed = unit_from == "assumed SI"
    if guessed and (channel.family == "can" or (weak and not sure and found.key not in table.unit_free)):
        reason = f"the name alone is too general for {found.signal}: say its unit, or map it"
        return Refusal(channel.name, found.signal, reason)
    rank = RANK_NAME + found.place + (_RANK_WORSE if found.worse else 0) + (_RANK_WEAK if weak else 0)
    return Binding(found.signal, (channel.name,), unit, unit_from, f"column name {channel.name!r}", rank=rank)
