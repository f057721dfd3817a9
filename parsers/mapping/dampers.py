"""What is measured at a damper or a spring: its travel is not the wheel's, a damper's force not the suspension's."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from parsers.channels import ChannelInfo
from parsers.mapping.match import Refusal

_TRAVEL, _FORCE = "suspension_deflection_", "suspension_force_"
_AT = {_TRAVEL: ("damper", "spring"), _FORCE: ("damper",)}
"""The parts at which a signal would be measured short. A spring's force, but for the damper's, is what holds the body."""
_OF_FORCE = "a damper's force alone, without the spring's"


def at_which(signal: str, key: Collection[str]) -> str | None:
    """The part ("damper") of which alone a channel tells that is named like a signal; None where it is all of it. key: the name's words."""
    parts = next((parts for begin, parts in _AT.items() if signal.startswith(begin)), ())
    return next((part for part in parts if part in key), None)


def reason_at(signal: str, part: str) -> str:
    """Why a channel of a part is not the signal."""
    if signal.startswith(_FORCE):
        return _OF_FORCE
    return f"travel at the {part}, not at the wheel: a mapping file takes it with the installation's ratio as scale"


def say_dampers(refused: Mapping[str, Refusal], channels: Sequence[ChannelInfo]) -> tuple[str, ...]:
    """A sentence on the travels of each part and one on forces that were not taken. refused: signal -> the part's channel."""
    travels = {signal: each for signal, each in refused.items() if signal.startswith(_TRAVEL)}
    forces = [each.channel for signal, each in refused.items() if signal.startswith(_FORCE)]
    said = []
    for part in _AT[_TRAVEL]:
        of = {signal: each.channel for signal, each in travels.items() if each.at == part}
        if of:
            said.append(_say_travels(of, part, channels))
    if forces:
        said.append(
            f"{', '.join(forces)}: {_OF_FORCE}, so not taken for suspension_force, which is all that holds the body"
        )
    return tuple(said)


def _say_travels(of: Mapping[str, str], part: str, channels: Sequence[ChannelInfo]) -> str:
    """of: signal -> channel."""
    signal, channel = next(iter(of.items()))
    silent = any(each.name == channel and not each.unit for each in channels)
    unit = ', unit = "mm" (or what it is)' if silent else ""
    return (
        f"{', '.join(of.values())}: measured at the {part}, so not taken for suspension_deflection, which is the "
        f"wheel's and usually larger. With the installation's ratio (wheel travel over {part} travel; 1 only where "
        f'the log is scaled to the wheel) a mapping file takes it: [signals.{signal}] channel = "{channel}"{unit}, '
        "scale = the ratio, and so on; cogest inspect --write-map writes these lines"
    )
