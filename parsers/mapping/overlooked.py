"""Channels that no profile and no name knows, and that look like signals which the log lacks otherwise: said, never guessed."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

from parsers.channels import ChannelInfo
from parsers.mapping.bindings import Binding
from parsers.mapping.contexts import blocking_words
from parsers.mapping.profiles import tags_of, unusable_reason
from parsers.mapping.words import known_words, load_names, words_of
from parsers.signals import WHEELS
from parsers.units import quantities_of

_FORCE = re.compile(r"force|load|strut|kraft|last(?![a-z])|^f[xyz]?_", re.IGNORECASE)
"""In a name whose unit may be knots or kilonewtons: what says that it is no speed."""
SAID = "not mapped, but they look like signals that the log lacks otherwise"
MOST_NAMED = 4


@dataclass(frozen=True)
class _Kind:
    """What a channel looks like. signals: any of them in the log, and it is not missed; quantities: of its unit; words: one of these in its
    name (any name where there are none), or a wheel's where `wheels` is set. body: it is the whole vehicle's, and a wheel's name rules it out. bare: sets of words; a name
    that holds all of one is enough without a unit, where it is made of known words alone. never: words that rule a name out."""

    title: str
    signals: tuple[str, ...]
    quantities: frozenset[str]
    words: frozenset[str]
    wheels: bool = False
    body: bool = False
    bare: tuple[frozenset[str], ...] = ()
    never: frozenset[str] = frozenset()


def _each(name: str) -> tuple[str, ...]:
    return tuple(f"{name}_{wheel}" for wheel in WHEELS)


def _sets(*rows: str) -> tuple[frozenset[str], ...]:
    return tuple(frozenset(row.split()) for row in rows)


# accelerations by satellites hold no gravity
_NO_ACCEL = frozenset({"gps"})
_NO_RATE = frozenset({"wheel", "steer"})
_TURNS = frozenset({"roll", "pitch", "yaw", "gyro", "angle", "rate", "x", "y", "z"})


def _accel(title: str, axis: str, words: str) -> _Kind:
    spelt = frozenset(words.split())
    bare = tuple(frozenset({"accel", word}) for word in sorted(spelt))
    return _Kind(
        title, (f"accel_{axis}",), frozenset({"acceleration"}), spelt, body=True, bare=bare, never=_NO_ACCEL
    )


def _rate(name: str, axis: str) -> _Kind:
    bare = _sets(f"{name} rate", f"{name} velocity", f"gyro {axis}")
    words = frozenset({name, axis})
    return _Kind(
        f"{name} rate",
        (f"{name}_rate",),
        frozenset({"angular_rate"}),
        words,
        body=True,
        bare=bare,
        never=_NO_RATE,
    )


KINDS = (
    _Kind("wheel speeds", _each("wheel_speed"), frozenset({"speed", "angular_rate"}), frozenset(), wheels=True),
    _Kind("speed", ("speed", "gps_speed_2d", "gps_speed_3d"), frozenset({"speed"}), frozenset({"speed", "velocity", "v"}), body=True, bare=_sets("speed", "velocity"), never=_TURNS | _NO_RATE),
    _accel("longitudinal acceleration", "x", "x ax long"),
    _accel("lateral acceleration", "y", "y ay lateral"),
    _accel("vertical acceleration", "z", "z az vertical"),
    _Kind("acceleration of some axis", ("accel_x", "accel_y", "accel_z"), frozenset({"acceleration"}), frozenset(), body=True, never=_NO_ACCEL),
    _rate("yaw", "z"),
    _rate("roll", "x"),
    _rate("pitch", "y"),
    _Kind("roll angle", ("roll",), frozenset({"angle"}), frozenset({"roll", "bank"}), body=True, bare=_sets("roll angle")),
    _Kind("pitch angle", ("pitch",), frozenset({"angle"}), frozenset({"pitch"}), body=True, bare=_sets("pitch angle")),
    _Kind("suspension deflections", _each("suspension_deflection"), frozenset({"length"}), frozenset(), wheels=True),
    _Kind("suspension or tyre forces", (*_each("suspension_force"), *_each("tire_normal_force")), frozenset({"force"}), frozenset(), wheels=True),
    _Kind("brake pressure", ("brake_pressure",), frozenset({"pressure"}), frozenset({"brake", "cylinder", "master"}), bare=_sets("brake pressure", "cylinder pressure")),
    _Kind("steering wheel angle", ("steering_wheel_angle",), frozenset({"angle"}), frozenset({"steer", "lenkwinkel"}), bare=_sets("steer angle", "lenkwinkel")),
    _Kind("axle loads", ("axle_load_front", "axle_load_rear"), frozenset({"force"}), frozenset({"axle"})),
    _Kind("brake or drive torque", ("brake_torque", "drive_torque", *_each("brake_torque"), *_each("drive_torque")), frozenset({"torque"}), frozenset({"wheel", "brake", "drive", "axle"})),
)  # fmt: skip


def overlooked(
    channels: Sequence[ChannelInfo], proposals: Mapping[str, tuple[Binding, ...]], known: Collection[str]
) -> tuple[tuple[str, ...], frozenset[str]]:
    """One sentence on the channels that may be what the log lacks, none where there are none, and their names.

    known: signals that the user's mapping file speaks of.
    """
    have = {*proposals, *known}
    bound = {name for found in proposals.values() for each in found for name in each.needed}
    table = load_names()
    free = [
        (channel, frozenset(words_of(_last(channel), table)))
        for channel in channels
        if channel.kind == "number" and channel.name not in bound
    ]
    parts: list[str] = []
    told: set[str] = set()
    for kind in KINDS:
        if have & {*kind.signals}:
            continue
        found = [
            channel
            for channel, words in free
            if channel.name not in told and _looks_like(kind, channel, words) and not _ruled_out(channel)
        ]
        told |= {channel.name for channel in found}
        if found:
            names = ", ".join(f"{c.name} [{c.unit}]" if c.unit else c.name for c in found[:MOST_NAMED])
            more = "" if len(found) <= MOST_NAMED else f" and {len(found) - MOST_NAMED} more"
            parts.append(f"{kind.title} ({names}{more})")
    if not parts:
        return (), frozenset()
    sentence = f"{SAID}: {'; '.join(parts)}; `cogest inspect --write-map` begins a mapping file"
    return (sentence,), frozenset(told)


def _looks_like(kind: _Kind, channel: ChannelInfo, words: frozenset[str]) -> bool:
    """Whether a channel, by its unit and the words of its name, may be what a kind tells of."""
    wheels = words & {*WHEELS}
    if (kind.body and wheels) or words & kind.never - kind.words:
        return False
    if not channel.unit:
        # without a unit a name must say all of it, and nothing else: "BrakePressureSwitch" is none
        return any(each <= words for each in kind.bare) and all(
            word in kind.words or word in _vocabulary() or word.isdigit() for word in words
        )
    marked = bool(wheels) if kind.wheels else not kind.words or bool(known_words(words, kind.words))
    return marked and bool(kind.quantities & _quantities(channel))


def _quantities(channel: ChannelInfo) -> frozenset[str]:
    """The quantities that a channel's unit may be of: "kn" is knots, or kilonewtons where the name says so."""
    found = quantities_of(channel.unit)
    return found - {"speed"} if "force" in found and _FORCE.search(channel.name) else found


@cache
def _vocabulary() -> frozenset[str]:
    """All words that the table of names knows."""
    table = load_names()
    return table.noise | table.worse | {*table.words.values(), *WHEELS, "x", "y", "z"}


def _last(channel: ChannelInfo) -> str:
    return (channel.tags.get("signal") or channel.tags.get("field") or channel.name).rpartition(".")[2]


def _ruled_out(channel: ChannelInfo) -> bool:
    """Whether its name says that it is no measurement of this vehicle, or its values cannot be used."""
    return (
        bool(blocking_words(channel, _last(channel)))
        or unusable_reason(channel, tags_of(channel)) is not None
    )
