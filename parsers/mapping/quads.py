"""Names that are too short to be trusted alone and mean a signal where all four wheels stand side by side."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Sequence

from parsers.channels import ChannelInfo
from parsers.mapping.contexts import path_of
from parsers.mapping.words import load_names
from parsers.signals import WHEELS
from parsers.table_names import split_unit

_NAME = re.compile(r"(defl|deflection|omega|tb|td)[ _]?([a-z]{2})")
"""Suspension deflections, turn rates, brake and drive torques: what the name says, and of which wheel."""


def quads(channels: Sequence[ChannelInfo]) -> frozenset[str]:
    """The columns defl_fl, omega_fl, Tb_fl, Td_fl … of a table that has them of all four wheels."""
    words = load_names().words
    beside: dict[tuple[str, str, str], dict[str, str]] = defaultdict(dict)
    for channel in channels:
        if channel.family not in ("table", "mdf"):
            continue
        path = split_unit(path_of(channel))[0].strip()
        cut = max(path.rfind(mark) for mark in "./\\:") + 1
        found = _NAME.fullmatch(path[cut:].lower())
        if found is not None:
            wheel = words.get(found[2], found[2])
            beside[(channel.group, path[:cut], found[1])].setdefault(wheel, channel.name)
    return frozenset(
        names[wheel] for names in beside.values() if names.keys() >= {*WHEELS} for wheel in WHEELS
    )
