"""Profiles meet channels: every rule that fits becomes a binding, or a reason why it cannot."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from parsers.channels import ChannelInfo
from parsers.mapping.bindings import Binding
from parsers.mapping.contexts import foreign_words
from parsers.mapping.profiles import Expression, Pattern, Profile, Rule, Sibling, fits, tags_of
from parsers.mapping.wheel_radius import TURN_RATE, turn_rate
from parsers.signals import SIGNALS
from parsers.unit_words import is_unit, plain_unit, says_unit
from parsers.units import SI_TEXT, Unit, find_unit, quantities_of

_WORSE = 4


@dataclass(frozen=True)
class Refusal:
    """A rule that fits a channel, and why the channel still cannot be the signal. unit: whether for its unit.
    at: where it is measured, if that is why ("damper", "spring"). alone: whether for want of a channel beside it that would tell what it is.
    told: whether it is said where the log lacks the signal."""

    channel: str
    signal: str
    reason: str
    unit: bool = False
    at: str | None = None
    alone: bool = False
    told: bool = False


@dataclass(frozen=True)
class Judged:
    """What is made of channels that tell something only side by side. names: of those that are judged so, and nowhere else."""

    found: tuple[Binding | Refusal, ...]
    names: frozenset[str]


@dataclass(frozen=True)
class ChannelIndex:
    """Channels by tag and value, so that a rule need not look at each channel."""

    channels: tuple[ChannelInfo, ...]
    tags: tuple[Mapping[str, str], ...]
    by_tag: Mapping[str, Mapping[str, tuple[int, ...]]]
    by_group: Mapping[str, tuple[int, ...]]
    found: dict[tuple[str, str], frozenset[int]] = field(default_factory=dict)

    def matching(self, pattern: Pattern) -> list[int]:
        """Indexes of the channels that fit a pattern, in the log's order."""
        sets = [self._one(tag, expression) for tag, expression in pattern]
        return sorted(frozenset.intersection(*sets)) if sets else []

    def sibling(self, main: int, pattern: Pattern) -> ChannelInfo | None:
        """The channel of the same group that fits."""
        for index in self.by_group[self.channels[main].group]:
            if index != main and fits(pattern, self.tags[index]):
                return self.channels[index]
        return None

    def _one(self, tag: str, expression: Expression) -> frozenset[int]:
        key = (tag, expression.pattern)
        if key not in self.found:
            values = self.by_tag.get(tag, {})
            hits = [
                index for value, where in values.items() if expression.fullmatch(value) for index in where
            ]
            self.found[key] = frozenset(hits)
        return self.found[key]


def index_channels(channels: Sequence[ChannelInfo]) -> ChannelIndex:
    """Index the number channels of a log."""
    numbers = tuple(channel for channel in channels if channel.kind == "number")
    tags = tuple(tags_of(channel) for channel in numbers)
    by_tag: dict[str, dict[str, list[int]]] = defaultdict(lambda: defaultdict(list))
    by_group: dict[str, list[int]] = defaultdict(list)
    for index, (channel, own) in enumerate(zip(numbers, tags, strict=True)):
        by_group[channel.group].append(index)
        for tag, value in own.items():
            by_tag[tag][value].append(index)
    frozen = {tag: {value: tuple(at) for value, at in values.items()} for tag, values in by_tag.items()}
    return ChannelIndex(numbers, tags, frozen, {group: tuple(at) for group, at in by_group.items()})


def choose_unit(
    channel: ChannelInfo, signal: str, fallback: str | None, fallback_from: str, *, required: bool = False
) -> tuple[Unit, str] | str:
    """The unit of a channel and where it is from, or the reason why it cannot be the signal.

    The log's own unit wins; a unit of another quantity, known to cogest or not, rules the channel out. What is no unit
    that cogest knows ("Unit_DegreOfArc") does so, too, where no fallback says what it is. A silent log leaves it to the
    fallback, and without one SI is assumed (and said, for the checks to judge).
    """
    quantity = SIGNALS[signal].quantity
    stated = find_unit(channel.unit, quantity) or turn_rate(channel.unit, signal)
    if stated is not None:
        return stated, "log"
    text = plain_unit(channel.unit) if says_unit(channel.unit) else None
    if text is not None and is_unit(text):
        article = "an" if quantity[0] in "aeiou" else "a"
        hint = (
            " without the wheel's radius"
            if quantity == "speed" and quantities_of(text) == {TURN_RATE}
            else ""
        )
        return f"unit {text} is no unit of {article} {quantity.replace('_', ' ')}{hint}"
    if fallback is not None:
        guess = find_unit(fallback, quantity) or turn_rate(fallback, signal)
        if guess is not None:
            return guess, fallback_from
    if text is not None:
        return f"unit {text} is not known to cogest: say what it is in a mapping file"
    if required:
        return "its unit is not known, and the log does not say it"
    return Unit(SI_TEXT[quantity], quantity, 1.0), "assumed SI"


def profile_bindings(profile: Profile, index: ChannelIndex) -> Iterator[Binding | Refusal]:
    """Every binding that a profile finds, and every refusal."""
    for rule in profile.rules:
        for at in index.matching(rule.pattern):
            channel = index.channels[at]
            if channel.family not in profile.families:
                continue
            foreign = foreign_words(channel)
            if foreign:
                reason = f"{min(foreign)!r} in its name: not a measurement of this vehicle's {rule.signal}"
                yield Refusal(channel.name, rule.signal, reason)
            else:
                yield _bind_rule(profile, rule, index, at)


def _bind_rule(profile: Profile, rule: Rule, index: ChannelIndex, at: int) -> Binding | Refusal:
    main = index.channels[at]
    source = f"profile {profile.name}"

    def refuse(reason: str, *, unit: bool = False) -> Refusal:
        return Refusal(main.name, rule.signal, reason, unit)

    unit = choose_unit(main, rule.signal, rule.unit, source, required=rule.require_unit)
    if isinstance(unit, str):
        return refuse(unit, unit=True)
    channels = [main.name]
    for sibling in rule.add:
        other = index.sibling(at, sibling.pattern)
        if other is not None:
            channels.append(other.name)
        elif not sibling.optional:
            return refuse(f"needs {_say(sibling)} beside it")
    extra: list[ChannelInfo | None] = []
    for each in (rule.sign, rule.where):
        found = None if each is None else index.sibling(at, each.pattern)
        if each is not None and found is None and not each.optional:
            return replace(refuse(f"needs {_say(each)} beside it"), alone=True)
        extra.append(found)
    sign, where = extra
    worse = bool(rule.worse) and fits(rule.worse, index.tags[at])
    way = ", the vector's length" if rule.kind == "length" else ""
    return Binding(
        signal=rule.signal,
        channels=tuple(channels),
        unit=unit[0],
        unit_from=unit[1],
        rule=f"{source}: {_what(index.tags[at], main)}{way}",
        scale=rule.scale,
        offset=rule.offset,
        invert=rule.invert,
        sign_channel=None if sign is None else sign.name,
        valid_range=rule.valid_range,
        where=None if where is None or rule.where is None else (where.name, rule.where.low, rule.where.high),
        sum_axles=rule.sum_axles,
        rank=rule.rank + (_WORSE if worse else 0),
        kind=rule.kind,
    )


def _say(sibling: Sibling) -> str:
    return " and ".join(expression.pattern.replace("\\", "") for _, expression in sibling.pattern)


def _what(tags: Mapping[str, str], channel: ChannelInfo) -> str:
    """What was recognised, in the format's own words."""
    if "joint" in tags and "type" in tags:
        return f"{tags['type']} {tags.get('field', '')} of joint {tags['joint']}"
    if "type" in tags and "field" in tags:
        return f"{tags['type']} {tags['field']}"
    if "pgn" in tags and "spn" in tags:
        return f"PGN {tags['pgn']} SPN {tags['spn']} ({channel.name})"
    return channel.name
