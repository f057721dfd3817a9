"""Names that are too short to be trusted alone and mean angular rates where all three axes stand side by side."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

from parsers.channels import ChannelInfo
from parsers.mapping.contexts import path_of
from parsers.table_names import split_unit

_TRIADS = (("p", "q", "r"), ("wx", "wy", "wz"), ("gx", "gy", "gz"))
_BESIDE = frozenset({"gx", "gy", "gz"})
"""These may be accelerations in g as well: only beside accelerations that are named so are they a gyro's."""
_ACCELERATIONS = (("ax", "ay"), ("accx", "accy"), ("accelx", "accely"))


def triads(channels: Sequence[ChannelInfo]) -> frozenset[str]:
    """The columns p, q, r (wx, wy, wz; gx, gy, gz) of a table that has all three of them: a body's angular rates.

    One alone may be a pressure, a radius or a wind; gx, gy, gz need accelerations of their own name beside them.
    """
    beside: dict[tuple[str, str], dict[str, str]] = defaultdict(dict)
    for channel in channels:
        if channel.family in ("table", "mdf"):
            # the unit first: it may have a slash
            path = split_unit(path_of(channel))[0].strip()
            cut = max(path.rfind(mark) for mark in "./\\:") + 1
            plain = path[cut:].lower().replace("_", "")
            beside[(channel.group, path[:cut])].setdefault(plain, channel.name)
    return frozenset(
        names[each]
        for names in beside.values()
        for triad in _TRIADS
        if all(each in names for each in triad)
        and (not _BESIDE & set(triad) or any(x in names and y in names for x, y in _ACCELERATIONS))
        for each in triad
    )
