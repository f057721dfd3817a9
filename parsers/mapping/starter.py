"""A starter mapping file for `inspect --write-map`: what was mapped, and empty tables for the rest."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

from parsers.channels import ChannelInfo
from parsers.mapping.axle_means import axle_of
from parsers.mapping.bindings import Binding
from parsers.mapping.match import Refusal
from parsers.mapping.propose import candidates
from parsers.mapping.reasons import reasons_beside, unmapped_reason
from parsers.mapping.wheel_radius import turn_rate
from parsers.mapping.words import load_names, words_of
from parsers.signals import SIGNALS, WHEELS, SignalSpec
from parsers.units import SI_TEXT, find_unit, quantities_of

_MOST_SUGGESTIONS = 6
_MOST_LEFT = 1000
_OF_LENGTH = frozenset({"length", "laenge", "federlaenge", "federbeinlaenge"})


def starter_map(channels: Sequence[ChannelInfo], proposals: Mapping[str, tuple[Binding, ...]]) -> str:
    """TOML text that `read_map` reads: mapped signals as tables, unmapped ones as comments with suggestions."""
    lines = [
        "# Mapping file of cogest: which channel of the log is which signal.",
        "# Signals are SI inside, axes ISO 8855: x forward, y left, z up; a left turn has accel_y > 0, yaw_rate > 0",
        "# and roll > 0. Keys of a signal: channel, unit, scale, offset, invert, sign_channel, valid_range, add, where,",
        "# ignore = true (leave it out). A signal without a table here is mapped by the built-in profiles.",
        "",
        "# [time]            # CSV only",
        '# channel = "time"',
        '# unit = "s"        # s, min, ms, us, ns, iso8601 or hhmmss',
    ]
    lines += _wheels(proposals)
    for signal, found in proposals.items():
        lines += ["", *_mapped(found)] if found[0].kind == "scale" else ["", *_derived(signal, found[0])]
    lines += ["", "# Not found in this log. Remove the # and fill in a channel where it has one."]
    used = {name for found in proposals.values() for name in found[0].needed}
    free = [channel for channel in channels if channel.kind == "number" and channel.name not in used]
    # an axle's deflection is suggested for no wheel's
    free = [channel for channel in free if axle_of(channel) is None]
    dampers, lengths = _dampers(channels), _lengths(free)
    for signal, spec in SIGNALS.items():
        if signal in proposals:
            continue
        if signal in dampers:
            lines += ["", *_damper(spec, *dampers[signal])]
        elif signal in lengths:
            lines += ["", *_length(spec, lengths[signal])]
        else:
            lines += ["", *_open(spec, free)]
    lines += _left(channels, used)
    return "\n".join(lines) + "\n"


def _left(channels: Sequence[ChannelInfo], used: set[str]) -> list[str]:
    """Each channel of numbers that no signal takes, as it has to be written, its unit, and why."""
    left = [channel for channel in channels if channel.kind == "number" and channel.name not in used]
    if not left:
        return []
    reasons = reasons_beside(channels)
    lines = ["", "# Channels of numbers that no signal takes, as they are written here, and why:"]
    for channel in left[:_MOST_LEFT]:
        unit = f" [{_comment(channel.unit)}]" if channel.unit else ""
        reason = reasons.get(channel.name) or unmapped_reason(channel)
        lines += [f"# {_comment(quote(channel.name))}{unit}: {_comment(reason)}"]
    if len(left) > _MOST_LEFT:
        lines += [f"# and {len(left) - _MOST_LEFT} more, which `cogest inspect` lists"]
    return lines


def _wheels(proposals: Mapping[str, tuple[Binding, ...]]) -> list[str]:
    """The radii with which wheels' turn rates were made speeds: without them their unit would be an error."""
    radii: dict[str, float] = {}
    for signal, (best, *_) in proposals.items():
        turns = turn_rate(best.unit.text, signal)
        if turns is not None and best.unit.quantity == "speed":
            radii["front" if signal[-2] == "f" else "rear"] = best.unit.scale / turns.scale
    if not radii:
        return []
    one = next(iter(radii.values()))
    front, rear = radii.get("front", one), radii.get("rear", one)
    return ["", "[wheels]", f"radius_front_m = {front:.6g}", f"radius_rear_m = {rear:.6g}"]


def _mapped(found: tuple[Binding, ...]) -> list[str]:
    best = found[0]
    lines = [f"[signals.{best.signal}]  # {_comment(best.rule)}"]
    lines += [f"channel = {quote(best.channels[0])}"]
    unit = find_unit(best.unit.text, SIGNALS[best.signal].quantity) or turn_rate(best.unit.text, best.signal)
    if unit is not None:
        lines += [f"unit = {quote(best.unit.text)}  # from: {_comment(best.unit_from)}"]
    if len(best.channels) > 1:
        lines += [f"add = [{', '.join(quote(name) for name in best.channels[1:])}]"]
    if best.scale != 1.0:
        lines += [f"scale = {best.scale!r}"]
    if best.offset != 0.0:
        lines += [f"offset = {best.offset!r}"]
    if best.invert:
        lines += ["invert = true"]
    if best.sign_channel:
        lines += [f"sign_channel = {quote(best.sign_channel)}"]
    if best.valid_range:
        lines += [f"valid_range = [{best.valid_range[0]!r}, {best.valid_range[1]!r}]"]
    if best.where:
        name, low, high = best.where
        lines += [f"where = [{quote(name)}, {low!r}, {high!r}]"]
    if best.sum_axles:
        lines += ["sum_axles = true"]
    others = [_comment(other.channels[0]) for other in found[1 : 1 + _MOST_SUGGESTIONS]]
    return [*lines, *([f"# could be too: {', '.join(others)}"] if others else [])]


def _derived(signal: str, best: Binding) -> list[str]:
    what = "vector" if best.kind == "length" else "quaternion"
    return [
        f"# {signal}: computed from the {what} {_comment(', '.join(best.channels))};",
        f"# to leave it out: [signals.{signal}] with ignore = true",
    ]


def _open(spec: SignalSpec, free: Sequence[ChannelInfo]) -> list[str]:
    fitting = [channel.name for channel in free if spec.quantity in quantities_of(channel.unit)]
    lines = [f"# [signals.{spec.name}]  # {spec.description}"]
    if fitting and spec.quantity not in ("ratio", "count"):
        lines += [f"# by unit it could be: {_comment(', '.join(fitting[:_MOST_SUGGESTIONS]))}"]
    return [*lines, '# channel = ""', f"# unit = {quote(SI_TEXT[spec.quantity])}"]


def _dampers(channels: Sequence[ChannelInfo]) -> dict[str, tuple[ChannelInfo, str]]:
    """The channels of dampers' and springs' travel and of which it is, by the signal that they are with the installation's ratio."""
    by_name = {channel.name: channel for channel in channels}
    return {
        each.signal: (by_name[each.channel], each.at)
        for each in candidates(channels)
        if isinstance(each, Refusal) and each.at and SIGNALS[each.signal].quantity == "length"
    }


def _damper(spec: SignalSpec, channel: ChannelInfo, at: str) -> list[str]:
    # the scale is left empty, so that nobody takes its travel for the wheel's without having said so
    scale = f"# scale =         # to be filled in: wheel travel over {at} travel, by the installation"
    return _by_hand(spec, channel, f"travel at the {at}", scale)


def _lengths(free: Sequence[ChannelInfo]) -> dict[str, ChannelInfo]:
    """The channels of springs' or struts' lengths, by the deflection that they are with the length at rest."""
    table, found = load_names(), dict[str, ChannelInfo]()
    for channel in free:
        words = {*words_of(channel.name, table)}
        wheels = words & {*WHEELS}
        if len(wheels) == 1 and words & _OF_LENGTH and "length" in quantities_of(channel.unit):
            found.setdefault(f"suspension_deflection_{wheels.pop()}", channel)
    return found


def _length(spec: SignalSpec, channel: ChannelInfo) -> list[str]:
    # the offset is left empty: no log tells how long the spring of the empty vehicle is
    return _by_hand(
        spec, channel, "a length, which falls as the spring is compressed",
        "# scale = -1       # times wheel travel over the spring's, by the installation",
        "# offset =         # to be filled in: that length with the empty vehicle at rest, times the same",
    )  # fmt: skip


def _by_hand(spec: SignalSpec, channel: ChannelInfo, what: str, *lines: str) -> list[str]:
    """A channel that is the signal once somebody fills in what no log tells."""
    return [
        f"# [signals.{spec.name}]  # {spec.description}",
        f"# channel = {quote(channel.name)}  # {what}",
        f"# unit = {quote(channel.unit or 'mm')}",
        *lines,
    ]


def quote(text: str) -> str:
    """A TOML basic string (JSON's escapes are a subset of TOML's, but for DEL)."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _comment(text: str) -> str:
    """Text from a log, safe inside a comment: one line, no control characters."""
    return "".join(character if character.isprintable() else " " for character in text)
