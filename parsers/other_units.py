"""Another inertial unit of the same log, taken where the checks leave the first one out: two are in many logs, and one of them is mounted otherwise."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Generic, Protocol, TypeVar

from parsers.checks.upright import UNIT
from parsers.drive import Decision, MappedChannel
from parsers.mapping import Binding

_FORCES = ("accel_x", "accel_y", "accel_z")


class Grouped(Protocol):
    """What knows the rows that it is from."""

    @property
    def group(self) -> str:
        """The rows' name."""
        ...


P = TypeVar("P", bound=Grouped)


@dataclass(frozen=True)
class Spare(Generic[P]):
    """The next candidate for a signal, of other rows than the first. piece: its samples; mapped, stated, taken: as a log has them of what it took."""

    piece: P
    mapped: MappedChannel
    stated: bool
    taken: float


def spare_of(
    name: str, chosen: Binding, proposed: Iterable[Binding], group: Mapping[str, str]
) -> Binding | None:
    """The candidate behind the chosen one that is of other rows; none for a signal that is no inertial unit's, or that the user maps.

    group: channel -> the rows that it is in.
    """
    if name not in UNIT or chosen.rank < 0:
        return None
    own = group[chosen.channels[0]]
    behind = list(proposed)
    behind = behind[behind.index(chosen) + 1 :]
    return next((each for each in behind if group[each.channels[0]] != own), None)


def to_swap(
    held: Mapping[str, Grouped], left_out: Collection[str], spares: Collection[str]
) -> frozenset[str]:
    """The signals to try of another unit: all that have one, of the units of which an acceleration was left out. held: before the checks."""
    odd = {held[name].group for name in _FORCES if name in held and name in left_out}
    names = {name for name in UNIT if name in held and name in spares and held[name].group in odd}
    return frozenset(names) if names & set(left_out) else frozenset()


def better(left_out: Collection[str], then: Collection[str], swapped: Collection[str]) -> bool:
    """Whether the checks leave less out with the other unit, and nothing of it. then: what they leave out with it."""
    return not set(then) & set(swapped) and set(then) < set(left_out)


def choice(
    decisions: Iterable[Decision],
    left_out: Collection[str],
    mapped: Iterable[MappedChannel],
    other: Mapping[str, Spare[P]],
) -> Decision:
    """That another unit is taken, and why. decisions: of the first unit; mapped: its channels; other: what is taken instead."""
    found = [each for each in decisions if each.applied and each.signal in left_out]
    channels = {each.signal: each.channel for each in mapped}
    names = [name for name in UNIT if name in other and name in left_out]
    reasons = "; ".join(dict.fromkeys(each.found for each in found))
    groups = dict.fromkeys(other[name].piece.group for name in names)
    return Decision(
        names[0], "choice",
        f"{channels[names[0]]} and what is of its unit ({', '.join(names)}) would be left out: {reasons}",
        f"the log's other channels are taken, which the checks bear out: {', '.join(name for name in UNIT if name in other)} "
        f"of {', '.join(groups)}",
        "; ".join(dict.fromkeys(each.evidence for each in found)), applied=True,
    )  # fmt: skip


def with_other(
    stated: Mapping[str, bool], taken: Mapping[str, float], other: Mapping[str, Spare[P]]
) -> tuple[dict[str, bool], dict[str, float]]:
    """What is known of the units of a log's signals, with another unit's."""
    return (
        {**stated, **{name: spare.stated for name, spare in other.items()}},
        {**taken, **{name: spare.taken for name, spare in other.items()}},
    )


def swapped_entries(
    mapped: Iterable[MappedChannel], other: Mapping[str, Spare[P]]
) -> tuple[MappedChannel, ...]:
    """The record's channels, with the other unit's; the first one's stand beside them."""
    return tuple(
        replace(
            new,
            alternatives=tuple(
                dict.fromkeys((old.channel, *(a for a in new.alternatives if a != new.channel)))
            ),
        )
        if (new := other[old.signal].mapped if old.signal in other else None) is not None
        else old
        for old in mapped
    )
