"""Channels that no profile and no name knows, and that look like signals which the log lacks otherwise: said, never guessed."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from parsers.channels import ChannelInfo
from parsers.mapping.bindings import Binding
from parsers.mapping.contexts import blocking_words
from parsers.mapping.profiles import tags_of, unusable_reason
from parsers.mapping.words import load_names, words_of
from parsers.signals import WHEELS
from parsers.units import quantities_of

SAID = "not mapped, but they look like signals that the log lacks otherwise"
MOST_NAMED = 4


@dataclass(frozen=True)
class _Kind:
    """What a channel looks like. signals: any of them in the log, and it is not missed; quantities: of its unit; words: one of these in its
    name, or a wheel's where `wheels` is set."""

    title: str
    signals: tuple[str, ...]
    quantities: frozenset[str]
    words: frozenset[str]
    wheels: bool = False


def _each(name: str) -> tuple[str, ...]:
    return tuple(f"{name}_{wheel}" for wheel in WHEELS)


KINDS = (
    _Kind("wheel speeds", _each("wheel_speed"), frozenset({"speed", "angular_rate"}), frozenset(), wheels=True),
    _Kind("speed", ("speed", "gps_speed_2d", "gps_speed_3d"), frozenset({"speed"}), frozenset({"speed", "velocity", "v"})),
    _Kind("suspension deflections", _each("suspension_deflection"), frozenset({"length"}), frozenset(), wheels=True),
    _Kind("suspension or tyre forces", (*_each("suspension_force"), *_each("tire_normal_force")), frozenset({"force"}), frozenset(), wheels=True),
    _Kind("brake pressure", ("brake_pressure",), frozenset({"pressure"}), frozenset({"brake", "cylinder", "master"})),
    _Kind("steering wheel angle", ("steering_wheel_angle",), frozenset({"angle"}), frozenset({"steer"})),
    _Kind("axle loads", ("axle_load_front", "axle_load_rear"), frozenset({"force"}), frozenset({"axle"})),
    _Kind("brake or drive torque", ("brake_torque", "drive_torque", *_each("brake_torque"), *_each("drive_torque")), frozenset({"torque"}), frozenset({"wheel", "brake", "drive", "axle"})),
)  # fmt: skip


def overlooked(
    channels: Sequence[ChannelInfo], proposals: Mapping[str, tuple[Binding, ...]], known: Collection[str]
) -> tuple[str, ...]:
    """One sentence on the channels that may be what the log lacks; none where there are none.

    known: signals that the user's mapping file speaks of.
    """
    have = {*proposals, *known}
    bound = {name for found in proposals.values() for each in found for name in each.needed}
    table = load_names()
    parts = []
    for kind in KINDS:
        if have & {*kind.signals}:
            continue
        found = []
        for channel in channels:
            if channel.kind != "number" or not channel.unit or channel.name in bound:
                continue
            words = {*words_of(_last(channel), table)}
            marked = words & {*WHEELS} if kind.wheels else words & kind.words
            if marked and kind.quantities & {*quantities_of(channel.unit)} and not _ruled_out(channel):
                found.append(channel)
        if found:
            names = ", ".join(f"{c.name} [{c.unit}]" for c in found[:MOST_NAMED])
            more = "" if len(found) <= MOST_NAMED else f" and {len(found) - MOST_NAMED} more"
            parts.append(f"{kind.title} ({names}{more})")
    if not parts:
        return ()
    return (f"{SAID}: {'; '.join(parts)}; `cogest inspect --write-map` begins a mapping file",)


def _last(channel: ChannelInfo) -> str:
    return (channel.tags.get("signal") or channel.tags.get("field") or channel.name).rpartition(".")[2]


def _ruled_out(channel: ChannelInfo) -> bool:
    """Whether its name says that it is no measurement of this vehicle, or its values cannot be used."""
    return (
        bool(blocking_words(channel, _last(channel)))
        or unusable_reason(channel, tags_of(channel)) is not None
    )
