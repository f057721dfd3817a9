"""All that a log's channels could be: candidates for each signal, best first."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from parsers.channels import ChannelInfo
from parsers.errors import MappingError
from parsers.mapping.across import with_across
from parsers.mapping.axle_means import axle_means, say_axle_means
from parsers.mapping.bindings import Binding
from parsers.mapping.compass import compass
from parsers.mapping.corners import say_corners
from parsers.mapping.dampers import say_dampers
from parsers.mapping.doubts import attitudes
from parsers.mapping.elements import channel_of, of_elements, only_a_place
from parsers.mapping.joints import say_joints
from parsers.mapping.map_file import MapEntry, MapFile, nearest
from parsers.mapping.match import Refusal, choose_unit, index_channels, profile_bindings
from parsers.mapping.names import name_bindings, vendor_prefixes
from parsers.mapping.overlooked import overlooked
from parsers.mapping.profiles import load_profiles, may_be_named
from parsers.mapping.quads import quads
from parsers.mapping.sign_channels import with_signs
from parsers.mapping.triads import triads
from parsers.mapping.turning import as_speed, say_turning, with_radius
from parsers.mapping.unknown import say_unknown
from parsers.mapping.velocities import velocities
from parsers.mapping.wheel_lists import say_wheel_lists
from parsers.mapping.wheel_radius import HOW, TURN_RATE, WheelRadius
from parsers.signals import SIGNALS, WHEEL_SPEEDS

_OVER_GROUND = "gps_speed_2d"
"""What a speed along the world's axes becomes, unless the user says what that is."""

_BUILTIN = 100
"""What is added to the rank of cogest's own definitions beside a user's: more than any two ranks differ by."""


def propose(
    channels: Sequence[ChannelInfo], user: MapFile | None, radius: WheelRadius | None = None
) -> Mapping[str, tuple[Binding, ...]]:
    """The proposals of `propose_and_say`."""
    return propose_and_say(channels, user, radius)[0]


def propose_and_say(
    channels: Sequence[ChannelInfo], user: MapFile | None, radius: WheelRadius | None = None
) -> tuple[Mapping[str, tuple[Binding, ...]], tuple[str, ...]]:
    """Those of `propose_all`, without the channels that nobody knows."""
    found = propose_all(channels, user, radius)
    return found.bindings, found.said


@dataclass(frozen=True)
class Proposals:
    """bindings: candidates for each signal, best first. said, unknown: sentences, the latter on channels that nobody knows."""

    bindings: Mapping[str, tuple[Binding, ...]]
    said: tuple[str, ...]
    unknown: tuple[str, ...]


def propose_all(
    channels: Sequence[ChannelInfo], user: MapFile | None, radius: WheelRadius | None = None
) -> Proposals:
    """Candidates for each signal that the log can give, best first, in the order of the canonical table; and a sentence
    for each signal that it lacks because its channel's unit is none of the signal's, on those that it lacks because the channel tells of the
    damper alone, and on channels that look like what it lacks.

    radius: of the vehicle's wheels, where the mapping file tells none. An entry of the user's mapping file wins outright: it is then the only candidate. Raises MappingError where such
    an entry names a channel that the log lacks (unless the file is not strict), or channels of two groups.
    """
    if user is not None and user.radius is not None:
        radius = user.radius
    found: dict[str, list[Binding]] = defaultdict(list)
    refused: dict[str, Refusal] = {}
    dampers: dict[str, Refusal] = {}
    refusals: set[str] = set()
    for candidate in candidates(channels, radius):
        if isinstance(candidate, Binding):
            found[candidate.signal].append(candidate)
            continue
        if not candidate.alone:
            # a reason is known of it, and `inspect` gives it
            refusals.add(candidate.channel)
        if candidate.unit or candidate.told:
            refused.setdefault(candidate.signal, candidate)
        elif candidate.at:
            dampers.setdefault(candidate.signal, candidate)
    proposals = with_signs(_ranked(found, channels), channels)
    if user is not None:
        proposals = _with_user(proposals, channels, user, radius)
    proposals = _with_places(proposals, channels)
    if user is None or _OVER_GROUND not in user.signals:
        proposals = with_across(proposals, channels)
    wanted = set(SIGNALS) - proposals.keys() - (user.signals.keys() if user is not None else set())
    bound = {name for bindings in proposals.values() for each in bindings for name in each.channels}
    of_units = [refused[signal] for signal in SIGNALS if signal in refused and signal in wanted]
    left_out = [each for each in of_units if each.channel not in bound]
    said = [f"{each.channel} is not taken for {each.signal}: {each.reason}" for each in left_out]
    at_dampers = {signal: dampers[signal] for signal in SIGNALS if signal in dampers and signal in wanted}
    needed = {name for bindings in proposals.values() for each in bindings for name in each.needed}
    of_axles = axle_means([each for each in channels if each.name not in needed], wanted)
    spoken_of = user.signals.keys() if user is not None else ()
    listed, in_lists = say_wheel_lists(channels, proposals, spoken_of)
    known = refusals | in_lists | of_axles.keys()
    missed, told = overlooked([each for each in channels if each.name not in known], proposals, spoken_of)
    texts, joints = texts_of_signals(channels, wanted), say_joints(proposals, channels)
    turning = say_turning(proposals, radius)
    unknown = say_unknown(channels, known | needed | told, {each.channel for each in left_out if each.unit})
    sentences = (
        *said, *texts, *say_dampers(at_dampers, channels), *say_axle_means(of_axles), *say_corners(proposals), *joints, *turning, *missed, *listed,
    )  # fmt: skip
    return Proposals(proposals, sentences, unknown)


def _ranked(
    found: dict[str, list[Binding]], channels: Sequence[ChannelInfo]
) -> dict[str, tuple[Binding, ...]]:
    """The candidates of each signal, best first."""
    order = {channel.name: (-(channel.count or 0), place) for place, channel in enumerate(channels)}
    for one, other in (("latitude", "longitude"), ("longitude", "latitude")):
        if not found.get(other):
            # "lat" alone, without a unit, is hardly a coordinate
            found[one] = [each for each in found.get(one, ()) if each.unit_stated]
    own = {channel.name for channel in channels if "builtin" in channel.tags}
    given = {channel.name for channel in channels if channel.family == "can"} - own
    proposals: dict[str, tuple[Binding, ...]] = {}
    for signal in SIGNALS:
        bindings = found.get(signal, [])
        if any(each.channels[0] in given for each in bindings):
            # what the user's database says of this very bus comes before cogest's own J1939 definitions
            bindings = [
                replace(each, rank=each.rank + _BUILTIN) if each.channels[0] in own else each
                for each in bindings
            ]
        ranked = sorted(bindings, key=lambda each: (each.rank, order[each.channels[0]]))
        unique: dict[str, Binding] = {}
        for binding in ranked:
            unique.setdefault(binding.channels[0], binding)
        if unique:
            proposals[signal] = tuple(unique.values())
    return proposals


def candidates(
    channels: Sequence[ChannelInfo], radius: WheelRadius | None = None
) -> Iterator[Binding | Refusal]:
    """Every binding that a profile or a name gives, and every refusal with its reason."""
    return with_radius(_candidates(channels), radius)


def _candidates(channels: Sequence[ChannelInfo]) -> Iterator[Binding | Refusal]:
    index = index_channels(channels)
    by_name = {channel.name: channel for channel in index.channels}
    families = {channel.family for channel in index.channels}
    for profile in load_profiles():
        if families & profile.families:
            for each in profile_bindings(profile, index):
                yield from of_elements(by_name[channel_of(each)], (each,))
    prefixes = vendor_prefixes(index.channels)
    pitches, rates = attitudes(index.channels), triads(index.channels) | quads(index.channels)
    letters, north_east = velocities(index.channels), compass(index.channels)
    for each in (*letters.found, *north_east.found):
        yield from of_elements(by_name[channel_of(each)], (each,))
    judged = letters.names | north_east.names
    for channel, tags in zip(index.channels, index.tags, strict=True):
        if channel.name in judged or only_a_place(channel):
            continue
        if may_be_named(channel, tags):
            yield from of_elements(channel, name_bindings(channel, prefixes, pitches, rates))


def texts_of_signals(channels: Sequence[ChannelInfo], wanted: Collection[str]) -> tuple[str, ...]:
    """Sentences on columns of text, or without any value, that would be signals which the log lacks, if they held numbers."""
    texts = [
        replace(channel, kind="number")
        for channel in channels
        if channel.kind == "text" and channel.family in ("table", "mdf", "vbo")
    ]
    if not texts:
        return ()
    found = {
        each.signal: each.channels[0]
        for each in candidates(texts)
        if isinstance(each, Binding) and each.signal in wanted
    }
    holds = {each.name: each.tags.get("holds", "text and no numbers") for each in texts}
    of: dict[str, list[str]] = {}
    for signal, channel in found.items():
        of.setdefault(holds[channel], []).append(f"{channel} ({signal})")
    return tuple(f"left out, since the column holds {what}: {', '.join(names)}" for what, names in of.items())


def _with_places(
    proposals: dict[str, tuple[Binding, ...]], channels: Sequence[ChannelInfo]
) -> dict[str, tuple[Binding, ...]]:
    """Latitudes and longitudes that know each other, where they are of one group: a receiver without a fix writes 0° and 0°.

    The VBO reader leaves such rows out itself.
    """
    places: dict[str, tuple[Binding, ...]] = {
        name: proposals[name] for name in ("latitude", "longitude") if name in proposals
    }
    if len(places) < 2:
        return proposals
    bound = {each.channels[0] for bindings in places.values() for each in bindings}
    groups = {
        channel.name: channel.group
        for channel in channels
        if channel.name in bound and channel.family != "vbo"
    }

    def paired(binding: Binding, others: tuple[Binding, ...]) -> Binding:
        own = binding.channels[0]
        near = (each.channels[0] for each in others if each.channels[0] != own)
        at = groups.get(own)
        return replace(
            binding, beside=next((n for n in near if at is not None and groups.get(n) == at), None)
        )

    pairs = {
        name: tuple(paired(each, places[other]) for each in places[name])
        for name, other in (("latitude", "longitude"), ("longitude", "latitude"))
    }
    return proposals | pairs


def missing_channels(channels: Sequence[ChannelInfo], user: MapFile) -> tuple[str, ...]:
    """A sentence for every entry of a mapping file that names a channel which the log does not have."""
    known = {channel.name for channel in channels}
    whole = _whole_headers(channels)
    return tuple(
        f"{user.path.name} maps {entry.signal} to {name!r}, which is not in this log"
        for entry in (_resolved(entry, whole) for entry in user.signals.values())
        for name in entry.needed
        if name not in known
    )


def _whole_headers(channels: Sequence[ChannelInfo]) -> dict[str, str]:
    """A table's header as it stands in the file ("AY [g]") -> the channel's name ("AY"): users copy either."""
    names = {channel.name for channel in channels}
    return {
        header: channel.name
        for channel in channels
        if (header := channel.tags.get("column", channel.name)) not in names
    }


def _resolved(entry: MapEntry, whole: Mapping[str, str]) -> MapEntry:
    """An entry with its channels by name, where it gives whole headers."""
    return replace(
        entry,
        channel=whole.get(entry.channel, entry.channel),
        add=tuple(whole.get(name, name) for name in entry.add),
        sign_channel=whole.get(entry.sign_channel, entry.sign_channel) if entry.sign_channel else None,
        where=(whole.get(entry.where[0], entry.where[0]), *entry.where[1:]) if entry.where else None,
    )


def _with_user(
    proposals: dict[str, tuple[Binding, ...]],
    channels: Sequence[ChannelInfo],
    user: MapFile,
    radius: WheelRadius | None,
) -> dict[str, tuple[Binding, ...]]:
    known = {channel.name: channel for channel in channels}
    whole = _whole_headers(channels)
    result = dict(proposals)
    for signal, written in user.signals.items():
        entry = _resolved(written, whole)
        if entry.ignore:
            result.pop(signal, None)
            continue
        missing = [name for name in entry.needed if name not in known]
        if missing and user.strict:
            raise _missing(missing[0], entry, user, list(known))
        if not missing:
            binding = _from_entry(entry, known, user)
            result[signal] = (_rolling(binding, entry, user, radius),)
    return {signal: result[signal] for signal in SIGNALS if signal in result}


def _missing(name: str, entry: MapEntry, user: MapFile, known: list[str]) -> MappingError:
    contained = [each for each in known if name.casefold() in each.casefold()][:3]
    hint = nearest(name, known)
    if hint is None and contained:
        hint = f"did you mean {' or '.join(map(repr, contained))}?"
    hint = hint or "`cogest inspect` lists the channels of a log"
    place = f"[signals.{entry.signal}]"
    return MappingError(f"channel {name!r} is not in the log", path=user.path, place=place, hint=hint)


def _rolling(binding: Binding, entry: MapEntry, user: MapFile, radius: WheelRadius | None) -> Binding:
    """A binding of the mapping file, with a wheel's turn rate made its speed. Raises MappingError without a radius."""
    if binding.unit.quantity != TURN_RATE or entry.signal not in WHEEL_SPEEDS:
        return binding
    if radius is None:
        raise MappingError(
            f"{entry.channel!r}: unit {binding.unit.text} is no unit of a speed without the wheel's radius",
            path=user.path,
            place=f"[signals.{entry.signal}]",
            hint=HOW,
        )
    return as_speed(binding, radius)


def _from_entry(entry: MapEntry, known: Mapping[str, ChannelInfo], user: MapFile) -> Binding:
    place = f"[signals.{entry.signal}]"
    main = known[entry.channel]
    for name in entry.needed:
        if known[name].kind != "number":
            raise MappingError(f"channel {name!r} holds text, not numbers", path=user.path, place=place)
        if known[name].group != main.group:
            problem = f"channels {main.name!r} and {name!r} do not share one clock"
            hint = "only channels of one message, topic or table can be combined"
            raise MappingError(problem, path=user.path, place=place, hint=hint)
    if entry.unit is not None:
        unit, unit_from = entry.unit, "map file"
    else:
        chosen = choose_unit(main, entry.signal, None, "")
        if isinstance(chosen, str):
            hint = 'say the unit in the mapping file: unit = "…"'
            raise MappingError(f"{main.name!r}: {chosen}", path=user.path, place=place, hint=hint)
        unit, unit_from = chosen
    return Binding(
        signal=entry.signal,
        channels=(entry.channel, *entry.add),
        unit=unit,
        unit_from=unit_from,
        rule=user.path.name,
        scale=entry.scale,
        offset=entry.offset,
        invert=entry.invert,
        sign_channel=entry.sign_channel,
        valid_range=entry.valid_range,
        where=entry.where,
        sum_axles=entry.sum_axles,
        rank=-1,
    )
