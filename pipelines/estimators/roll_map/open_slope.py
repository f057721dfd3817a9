"""What leaves the steady slope of a roll motion open, in words: noise, dry friction, or roads that lean into their bends."""

from __future__ import annotations

import math
from collections.abc import Mapping

FRICTION, ROAD = "friction", "road"
"""Parts of the slope's relative spread that the likelihood does not know of."""
BY_NOISE = "little lateral acceleration in relation to the noise"
BY_FRICTION = "little lateral acceleration in relation to dry friction"
BY_ROAD = (
    "in bends that last, a road's bank and the body's lean look alike: quicker steering, level ground (say a circle of more "
    "than a turn), or suspension deflections would tell them apart"
)
BY_RATE = (
    "a roll rate shows little of a lean that lasts: a roll angle or suspension deflections would tell it"
)


def why_open(noise: float, doubts: Mapping[str, float], bank: float, level: float, *, angle: bool) -> str:
    """What leaves a slope open, the largest part of its spread.

    noise: relative spread by the likelihood. doubts: the parts beyond it, by FRICTION and ROAD. bank, level: of the angle, what it
    wanders by without lateral acceleration and its noise, rad: where it wanders farther, the likelihood's spread is the road's.
    angle: whether one was measured, and not its rate alone.
    """
    if not angle:
        return BY_RATE
    road = doubts.get(ROAD, 0.0)
    if bank > level:
        noise, road = 0.0, math.hypot(noise, road)
    parts = {BY_NOISE: noise, BY_FRICTION: doubts.get(FRICTION, 0.0), BY_ROAD: road}
    return max(parts, key=parts.__getitem__)
