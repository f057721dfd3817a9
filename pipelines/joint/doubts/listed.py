"""All doubts of a drive, with what its log makes of each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pipelines.joint.doubts.carried import bellows, channel_doubts, levelling
from pipelines.joint.doubts.simple_models import BETWEEN, physics_doubts
from pipelines.joint.doubts.stated_figures import file_doubts, unlike_measured
from pipelines.joint.doubts.weighed import NOTHING, Doubt, Place, Weighed, elsewhere, weigh
from pipelines.joint.vehicle.unknowns import Known
from pipelines.vehicles.vehicle import Vehicle

NAMED = 0.7
"""Weight from which on a doubt is named."""


SOURCES = (file_doubts, unlike_measured, channel_doubts, levelling, bellows, physics_doubts)
"""What may be otherwise, each for a posterior and its vehicle file: a new kind of doubt is a function and a place here."""


def doubts_of(joint: Place, vehicle: Vehicle, opened: str = "") -> tuple[Weighed, ...]:
    """All doubts with what the log makes of them. At most one is true: their weights and that of none sum to 1.

    Each is there as often as there are places for the load, and none of them too: what stays for the posterior as it is is nothing then.
    opened: a group of stated figures (`stated_unknowns`) that the posterior does not take from the file, or a channel whose scale it does not take
    for known: of that there is none.
    """
    doubts = [
        d for source in SOURCES for d in source(joint, vehicle) if not opened or not d.text.startswith(opened)
    ]
    none = max(1 - sum(d.chance for d in doubts), 0.05)
    where = load_places(joint.known)
    if where:
        doubts.append(replace(NOTHING, chance=none))
    found = [weigh(joint, d, place) for d in doubts for place in where or [NOTHING]]
    logs = np.array([odds + math.log(w.doubt.chance) for odds, w in found])
    left = -math.inf if where else math.log(none)
    top = max(left, float(logs.max(initial=left)))
    shares = np.exp(logs - top)
    shares /= shares.sum() + math.exp(left - top)
    return tuple(replace(w, weight=float(s)) for s, (_, w) in zip(shares, found, strict=True))


def said(doubts: Sequence[Weighed]) -> tuple[str, ...]:
    """The doubts that the log speaks for, in words."""
    together: dict[str, float] = {}
    for d in doubts:
        for piece in d.doubt.text.split(BETWEEN) if d.doubt.text else ():
            together[piece] = together.get(piece, 0.0) + d.weight
    return tuple(
        f"{text} (odds {weight:.0%} among the causes weighed)"
        for text, weight in together.items()
        if weight > NAMED
    )


def load_places(known: Known) -> list[Doubt]:
    """Where the load may lie; nothing where that is one place."""
    return [elsewhere("", known, place.figures, place.chance) for place in known.places]
