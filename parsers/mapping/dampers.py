"""What is measured at a damper: its travel is not the wheel's, its force not the suspension's."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from parsers.channels import ChannelInfo
from parsers.mapping.match import Refusal

_WORD = "damper"
_TRAVEL, _FORCE = "suspension_deflection_", "suspension_force_"
_REASONS = {
    _TRAVEL: "travel at the damper, not at the wheel: a mapping file takes it with the installation's ratio as scale",
    _FORCE: "a damper's force alone, without the spring's",
}


def damper_reason(signal: str, key: Collection[str]) -> str | None:
    """Why a channel that is named like a signal is only the damper's; None where it is not. key: the name's words."""
    if _WORD not in key:
        return None
    return next((reason for begin, reason in _REASONS.items() if signal.startswith(begin)), None)


def say_dampers(refused: Mapping[str, Refusal], channels: Sequence[ChannelInfo]) -> tuple[str, ...]:
    """A sentence on travels and one on forces that were not taken. refused: signal -> its damper's channel."""
    travels = {signal: each.channel for signal, each in refused.items() if signal.startswith(_TRAVEL)}
    forces = [each.channel for signal, each in refused.items() if signal.startswith(_FORCE)]
    said = []
    if travels:
        signal, channel = next(iter(travels.items()))
        silent = any(each.name == channel and not each.unit for each in channels)
        unit = ', unit = "mm" (or what it is)' if silent else ""
        said.append(
            f"{', '.join(travels.values())}: measured at the damper, so not taken for suspension_deflection, which is the "
            "wheel's and usually larger. With the installation's ratio (wheel travel over damper travel; 1 only where "
            f'the log is scaled to the wheel) a mapping file takes it: [signals.{signal}] channel = "{channel}"{unit}, '
            "scale = the ratio, and so on; cogest inspect --write-map writes these lines"
        )
    if forces:
        said.append(
            f"{', '.join(forces)}: {_REASONS[_FORCE]}, so not taken for suspension_force, which is all that holds the body"
        )
    return tuple(said)
