"""One deflection for a whole axle, as sensors of headlamps' levelling and of air suspensions give it: no wheel's, and told."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from parsers.channels import ChannelInfo
from parsers.mapping.contexts import blocking_words
from parsers.mapping.profiles import tags_of, unusable_reason
from parsers.mapping.words import load_names, words_of
from parsers.unit_words import is_unit, says_unit
from parsers.units import quantities_of

_ENDS = {
    "front": "front", "frontaxle": "front", "va": "front", "rear": "rear", "rearaxle": "rear", "ha": "rear",
    "f": "front", "r": "rear",
}  # fmt: skip
_MEANT = tuple(
    frozenset(each.split())
    for each in (
        "suspension", "spring", "damper", "level", "axle travel", "frontaxle travel", "rearaxle travel", "wheel travel", "travel va",
        "travel ha", "ride height", "axle height", "height va", "height ha",
    )
)  # fmt: skip
"""Words one set of which says that a name with an axle is of its suspension; all of a name's words must be known."""
_BESIDE = frozenset(
    {"axle", "travel", "wheel", "mean", "average", "mm", "cm", "m", "height", "ride", "headlamp", "headlight"}
)
_MEAN = frozenset({"mean"})
"""A word that says elsewhere that a channel is no measurement, and here what it is."""
REASON = "one deflection for an axle, and no wheel's"
_WHEELS = {"front": "fl and fr", "rear": "rl and rr"}


def axle_means(channels: Sequence[ChannelInfo], wanted: Collection[str]) -> dict[str, str]:
    """Channel -> axle ("front") of those that by name and unit are an axle's deflection. wanted: signals that the log lacks."""
    lacking = {
        axle
        for axle, end in (("front", "f"), ("rear", "r"))
        if all(f"suspension_deflection_{end}{side}" in wanted for side in "lr")
    }
    found = {channel.name: axle_of(channel) for channel in channels if channel.kind == "number"}
    return {name: axle for name, axle in found.items() if axle is not None and axle in lacking}


def say_axle_means(found: dict[str, str]) -> tuple[str, ...]:
    """One sentence on them, none where there are none."""
    if not found:
        return ()
    ends = list(dict.fromkeys(found.values()))
    signals = " or ".join(_WHEELS[axle] for axle in ends)
    return (
        f"{', '.join(found)}: one deflection for an axle, so not taken for suspension_deflection, which is a wheel's ({signals}): the mean "
        "of two wheels says nothing of roll, and mapped to both it would be one sensor counted as two. cogest needs a sensor at each wheel "
        "of an axle; without, axle loads (axle_load_front, axle_load_rear) tell mass and place of the load, and a pitch rate beside "
        "torques and spring rates the height",
    )


def axle_of(channel: ChannelInfo) -> str | None:
    """The axle whose deflection a channel is by its name, None where it is not one's."""
    unit = channel.unit or ""
    if says_unit(unit) and not (is_unit(unit) and "length" in quantities_of(unit)):
        return None
    table = load_names()
    name = (channel.tags.get("signal") or channel.tags.get("field") or channel.name).rpartition(".")[2]
    words = frozenset(words_of(name, table)) - table.noise - table.worse
    ends = {_ENDS[word] for word in words if word in _ENDS}
    meant = [each for each in _MEANT if each <= words]
    if len(ends) != 1 or not meant:
        return None
    if words - _ENDS.keys() - _BESIDE - frozenset().union(*meant):
        return None
    blocked = (
        bool(blocking_words(channel, name) - _MEAN) or unusable_reason(channel, tags_of(channel)) is not None
    )
    return None if blocked else ends.pop()
