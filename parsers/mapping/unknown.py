"""Channels that are numbers and that neither a profile, nor a name, nor a mapping file knows: said, so that nothing is left out in silence."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from parsers.channels import ChannelInfo
from parsers.mapping.contexts import blocking_words
from parsers.mapping.profiles import tags_of, unusable_reason
from parsers.mapping.words import load_names, words_of
from parsers.unit_words import is_unit, says_unit
from parsers.units import quantities_of

SAID = "not recognised: "
MOST_NAMED, MOST_LISTED = 5, 30
"""Names in the sentence, and so many columns of a table at most of which any are named: of hundreds, and of messages' fields, only the count says
anything."""
LONGEST = 40
"""Characters of a name."""
_TABLES = frozenset({"table", "vbo", "mdf"})
_NO_SIGNALS = frozenset({"time", "ratio", "count", "mass"})
"""Quantities of units that none of the signals with a unit of their own has."""
_NEVER_WORDS = """
    true truth gt reference time timestamp utc date epoch index idx id frame sample row lap count cnt seq sequence status state
    flag mode switch heading course track azimuth cog pdop vdop tdop gdop fix hacc vacc temperature temp voltage
"""
_NEVER = frozenset(_NEVER_WORDS.split())
"""Words of what no signal is, known by its name: a simulation's truth, counters, clocks, a receiver's other figures."""


def say_unknown(
    channels: Sequence[ChannelInfo], known: Collection[str], refused: Collection[str]
) -> tuple[str, ...]:
    """One sentence on the channels that nobody knows; none where there are none.

    known: names of channels that are used or have a reason of their own. refused: of channels whose unit is not the signal's that the log
    lacks: these count as well.
    """
    unknown = [
        channel
        for channel in channels
        if channel.name in refused or (channel.name not in known and _may_be_one(channel))
    ]
    if not unknown:
        return ()
    table = all(channel.family in _TABLES for channel in channels)
    count = f"{len(unknown)} of {len(channels)} {'columns' if table else 'channels'}"
    how = "`cogest inspect LOG --write-map map.toml`"
    if not table or len(unknown) > MOST_LISTED:
        return (f"{SAID}{count}; {how} lists them",)
    named = ", ".join(_shown(channel) for channel in unknown[:MOST_NAMED])
    more = f" and {len(unknown) - MOST_NAMED} more" if len(unknown) > MOST_NAMED else ""
    return (f"{SAID}{named}{more} ({count}; {how} begins a mapping file for them)",)


def _shown(channel: ChannelInfo) -> str:
    name = channel.name if len(channel.name) <= LONGEST else f"{channel.name[: LONGEST - 1]}…"
    return f"{name} [{channel.unit[:LONGEST]}]" if channel.unit else name


def _may_be_one(channel: ChannelInfo) -> bool:
    """Whether a channel is a number that may be a signal: by its unit, and by no word that says what else it is."""
    if channel.kind != "number" or channel.name.startswith("_"):
        return False
    unit = channel.unit or ""
    if says_unit(unit) and is_unit(unit) and not quantities_of(unit) - _NO_SIGNALS - {"slope"}:
        return False
    words = {word.rstrip("0123456789") for word in words_of(channel.name, load_names())}
    return (
        not words & _NEVER
        and not blocking_words(channel, channel.name)
        and unusable_reason(channel, tags_of(channel)) is None
    )
