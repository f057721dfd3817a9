"""Why a channel is not mapped, in a few words for `inspect`."""

from __future__ import annotations

from collections.abc import Sequence

from parsers.channels import ChannelInfo
from parsers.mapping.axle_means import REASON, axle_of
from parsers.mapping.bindings import Binding
from parsers.mapping.compass import compass
from parsers.mapping.match import Refusal
from parsers.mapping.names import ambiguous_name
from parsers.mapping.profiles import tags_of, unusable_reason
from parsers.mapping.propose import candidates
from parsers.mapping.velocities import velocities
from parsers.mapping.wheel_lists import wheel_of_a_list


def unmapped_reason(channel: ChannelInfo) -> str:
    """Why `propose` leaves a channel alone ("text", "unit rpm is no unit of a speed", …).

    For a channel that could be a signal and was not chosen: that another one ranks above it.
    """
    if channel.kind != "number":
        return "text"
    tags = tags_of(channel)
    unusable = unusable_reason(channel, tags)
    if unusable is not None:
        return unusable
    found = list(candidates([channel]))
    bindings = [each for each in found if isinstance(each, Binding)]
    if bindings:
        return f"could be {bindings[0].signal}; another channel ranks above it"
    refusals = [each for each in found if isinstance(each, Refusal)]
    if refusals:
        return f"{refusals[0].signal}: {refusals[0].reason}"
    if axle_of(channel) is not None:
        return REASON
    return wheel_of_a_list(channel) or ambiguous_name(channel) or "no profile knows it"


def reasons_beside(channels: Sequence[ChannelInfo]) -> dict[str, str]:
    """Channel -> why it is not mapped, of those that mean something else alone than beside the log's others."""
    numbers = [channel for channel in channels if channel.kind == "number"]
    return {
        each.channel: f"{each.signal}: {each.reason}"
        for each in (*velocities(numbers).found, *compass(numbers).found)
        if isinstance(each, Refusal)
    }
