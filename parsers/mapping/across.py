"""What stands beside a speed along x and tells which axes it counts along: the velocity along y, and a yaw rate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from parsers.channels import ChannelInfo
from parsers.mapping.bindings import Binding
from parsers.units import find_unit

_ACROSS = {"x": "y", "X": "Y"}


def with_across(
    proposals: Mapping[str, tuple[Binding, ...]], channels: Sequence[ChannelInfo]
) -> dict[str, tuple[Binding, ...]]:
    """The proposals, in which speeds of cogest's own definitions know their velocity along y and a yaw rate of the same rows."""
    if "speed" not in proposals:
        return dict(proposals)
    known = {channel.name: channel for channel in channels if channel.kind == "number"}
    rates = {
        known[each.channels[0]].group: (each.channels[0], each.unit.scale)
        for each in reversed(proposals.get("yaw_rate", ()))
        if len(each.channels) == 1 and each.channels[0] in known
    }

    def beside(binding: Binding) -> Binding:
        main = known.get(binding.channels[0])
        plain = binding.kind == "scale" and len(binding.channels) == 1 and binding.sign_channel is None
        if main is None or not plain or binding.rank < 0:
            return binding
        across = _across(main, known)
        return binding if across is None else replace(binding, across=across, turning=rates.get(main.group))

    return {**proposals, "speed": tuple(map(beside, proposals["speed"]))}


def _across(main: ChannelInfo, known: Mapping[str, ChannelInfo]) -> str | None:
    """The channel of the same rows and unit that is called as one along x, but for its letter."""
    name = main.name
    for at, letter in enumerate(name):
        other = known.get(f"{name[:at]}{_ACROSS[letter]}{name[at + 1 :]}") if letter in _ACROSS else None
        if other is not None and other.group == main.group and _scale(other) == _scale(main):
            return other.name
    return None


def _scale(channel: ChannelInfo) -> float | None:
    unit = find_unit(channel.unit, "speed")
    return None if unit is None else unit.scale
