"""Vertical accelerations of a wheel's corner whose name does not say whether the sensor is on the body or on the hub."""

from __future__ import annotations

from collections.abc import Mapping

from parsers.mapping.bindings import Binding
from parsers.mapping.words import load_names, words_of
from parsers.signals import WHEELS

_PLACES = frozenset({"body", "chassis", "sprung"})
RULE = "column name"


def say_corners(proposals: Mapping[str, tuple[Binding, ...]]) -> tuple[str, ...]:
    """One sentence on those that are taken for the body's without a word of their names for it; none where hubs have channels of their own."""
    if any(f"accel_z_unsprung_{wheel}" in proposals for wheel in WHEELS):
        return ()
    table = load_names()
    best = [proposals[name][0] for wheel in WHEELS if (name := f"accel_z_sprung_{wheel}") in proposals]
    named = [
        each.channels[0]
        for each in best
        if each.rule.startswith(RULE) and not _PLACES & {*words_of(each.channels[0], table)}
    ]
    if not named:
        return ()
    return (
        f"{', '.join(named)}: taken for the body's vertical acceleration over the wheels, though the name does not say whether the sensor is on the "
        "body or on the hub; a hub's is accel_z_unsprung, in a mapping file",
    )
