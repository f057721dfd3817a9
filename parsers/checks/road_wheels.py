"""A steering angle that is the road wheels': two to nine metres of it over the path's curvature, where a steering wheel's makes 12 to 400.

It is off by the steering ratio, not by a unit. Taken for a steering wheel's in another unit it would have a right yaw rate divided by 57, or
itself multiplied by as much: both bring the ratio into the range.
"""

from __future__ import annotations

from parsers.drive import Decision

STEERING = "steering_wheel_angle"

FACTOR = 10.0
"""What makes a steering wheel's of any road wheels' angle, for the range that is asked for: 1.2 rad·m and more."""

COST = 0.5
"""Less than any unit's: simulators, robots and steer-by-wire log the angle of the wheels, under every name that the steering wheel's has."""


def road_wheels(words: str, *, sure: bool) -> Decision:
    """The decision. words: the finding in figures; sure: whether it is left out."""
    return Decision(
        STEERING,
        "range",
        f"{STEERING} {'is' if sure else 'may be'} the angle of the road wheels, not of the steering wheel",
        "left out; a mapping file gives it with the steering ratio as its scale"
        if sure
        else "left as it is: say so in a mapping file, with the steering ratio as its scale",
        f"{words}, a steering wheel's makes 12 to 400",
        applied=sure,
    )
