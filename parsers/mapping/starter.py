"""A starter mapping file for `inspect --write-map`: what was mapped, and empty tables for the rest."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

from parsers.channels import ChannelInfo
from parsers.mapping.bindings import Binding
from parsers.signals import SIGNALS, SignalSpec
from parsers.units import SI_TEXT, find_unit, quantities_of

_MOST_SUGGESTIONS = 6


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
        '# unit = "s"        # s, ms, us, ns, iso8601 or hhmmss',
    ]
    for signal, found in proposals.items():
        lines += ["", *_mapped(found)] if found[0].kind == "scale" else ["", *_derived(signal, found[0])]
    lines += ["", "# Not found in this log. Remove the # and fill in a channel where it has one."]
    used = {name for found in proposals.values() for name in found[0].needed}
    free = [channel for channel in channels if channel.kind == "number" and channel.name not in used]
    for signal, spec in SIGNALS.items():
        if signal not in proposals:
            lines += ["", *_open(spec, free)]
    return "\n".join(lines) + "\n"


def _mapped(found: tuple[Binding, ...]) -> list[str]:
    best = found[0]
    lines = [f"[signals.{best.signal}]  # {_comment(best.rule)}"]
    lines += [f"channel = {quote(best.channels[0])}"]
    unit = find_unit(best.unit.text, SIGNALS[best.signal].quantity)
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


def quote(text: str) -> str:
    """A TOML basic string (JSON's escapes are a subset of TOML's, but for DEL)."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _comment(text: str) -> str:
    """Text from a log, safe inside a comment: one line, no control characters."""
    return "".join(character if character.isprintable() else " " for character in text)
