"""The radius that wheels roll on, with which a turn rate is a wheel's speed."""

from __future__ import annotations

from dataclasses import dataclass

from parsers.signals import WHEEL_SPEEDS
from parsers.units import Unit, find_unit

TURN_RATE = "angular_rate"
"""The quantity of a wheel speed's unit (rad/s, rpm) that needs the radius."""
RADII_M = (0.02, 2.0)
"""Of wheels on anything from a model to a mining truck."""
HOW = "the vehicle file's wheel_radius_m or a mapping file's [wheels] radius_m tells it"


@dataclass(frozen=True)
class WheelRadius:
    """The radii that the wheels of the front and rear axle roll on, and which file tells them."""

    front_m: float
    rear_m: float
    source: str

    def of(self, signal: str) -> float:
        """The radius of a wheel's signal ("wheel_speed_fl")."""
        return self.front_m if signal[-2] == "f" else self.rear_m


def turn_rate(text: str | None, signal: str) -> Unit | None:
    """The unit of a turn rate that a text means where a wheel's speed is wanted; None where it is none, or another signal's."""
    return find_unit(text, TURN_RATE) if signal in WHEEL_SPEEDS else None
