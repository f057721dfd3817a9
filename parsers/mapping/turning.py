"""Wheels' turn rates (rad/s, rpm) as wheel speeds: the radius that the wheels roll on makes them that.

It is told by the mapping file's [wheels] or, where a vehicle file is at hand, by its wheel_radius_m; without either a turn rate is no wheel
speed.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from parsers.mapping.bindings import Binding
from parsers.mapping.match import Refusal
from parsers.mapping.wheel_radius import HOW, TURN_RATE, WheelRadius
from parsers.signals import WHEEL_SPEEDS
from parsers.units import Unit

_RANK_WORSE = 4
"""A speed that the log states itself comes first."""


def with_radius(
    candidates: Iterable[Binding | Refusal], radius: WheelRadius | None
) -> Iterator[Binding | Refusal]:
    """The candidates, with turn rates made speeds, or refused without a radius.

    What a profile knows to be a turn rate is no speed by its name either ("WheelSpd_FL" without a unit).
    """
    turning: set[tuple[str, str]] = set()
    for each in candidates:
        if not isinstance(each, Binding) or each.signal not in WHEEL_SPEEDS:
            yield each
            continue
        wheel = (each.channels[0], each.signal)
        if each.unit.quantity != TURN_RATE:
            if wheel not in turning:
                yield each
            continue
        turning.add(wheel)
        if radius is None:
            reason = f"unit {each.unit.text} is no unit of a speed without the wheel's radius: {HOW}"
            yield Refusal(each.channels[0], each.signal, reason, unit=True)
        else:
            yield replace(as_speed(each, radius), rank=each.rank + _RANK_WORSE)


def as_speed(binding: Binding, radius: WheelRadius) -> Binding:
    """A turn rate's binding, as the wheel's speed."""
    metres = radius.of(binding.signal)
    unit = Unit(binding.unit.text, "speed", binding.unit.scale * metres)
    return replace(binding, unit=unit, rule=f"{binding.rule}, times the wheel's radius of {metres:g} m")


def say_turning(proposals: Mapping[str, Sequence[Binding]], radius: WheelRadius | None) -> tuple[str, ...]:
    """A sentence on the wheel speeds that were made of turn rates."""
    taken = [
        signal
        for signal in WHEEL_SPEEDS
        if proposals.get(signal) and "times the wheel's radius" in proposals[signal][0].rule
    ]
    if not taken or radius is None:
        return ()
    radii = f"{radius.front_m:g} m"
    if radius.rear_m != radius.front_m:
        radii += f" in front and {radius.rear_m:g} m behind"
    return (
        f"{', '.join(taken)}: turn rates of the wheels, times their radius of {radii} as {radius.source} has it; "
        "a radius that is off by 1 % puts them off by as much",
    )
