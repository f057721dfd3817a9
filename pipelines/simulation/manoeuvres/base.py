"""What a manoeuvre is given and what it gives: the vehicle's figures and options in, a demand and a road out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from pipelines.simulation.records import GRAVITY, Demand, Road

Direction = Literal["left", "right", "both"]
SURFACES = ("A", "B", "C", "D", "E", "F", "G", "H")
"""Roughness classes of ISO 8608, from a very good road to ground that is hardly passable."""

FULL_LOCK_RAD = 9.0
"""Steering-wheel angle that a driver can turn to: near full lock."""

SPEEDS_MPS = (0.5, 70.0)
"""What any manoeuvre can be asked for."""


@dataclass(frozen=True)
class Options:
    """What the user may choose. Every field has a meaning in every manoeuvre; None = the manoeuvre's own value.

    speed_mps: test speed; on road courses the driver's top speed. severity: factor on what makes the manoeuvre hard
    (steering amplitude, lateral acceleration, deceleration, roughness, slope). duration_s: of the whole run with its
    rests: repeats are added while they fit, the rest is standstill; one repeat is always run. friction: peak friction
    coefficient of the road. direction: first or only side of the manoeuvres that have one. surface: ISO 8608 class.
    """

    speed_mps: float | None = None
    severity: float = 1.0
    duration_s: float | None = None
    friction: float | None = None
    direction: Direction = "both"
    surface: str | None = None

    def __post_init__(self) -> None:
        """Raises ValueError naming the option that cannot be used."""
        ranges = {
            "speed_mps": (self.speed_mps, *SPEEDS_MPS),
            "severity": (self.severity, 0.05, 10.0),
            "duration_s": (self.duration_s, 5.0, 7200.0),
            "friction": (self.friction, 0.05, 1.5),
        }
        for name, (value, low, high) in ranges.items():
            if value is not None and not low <= value <= high:
                raise ValueError(f"{name} is {value:g}: expected {low:g} to {high:g}")
        if self.direction not in ("left", "right", "both"):
            raise ValueError(f"direction is {self.direction!r}: expected 'left', 'right' or 'both'")
        if self.surface is not None and self.surface not in SURFACES:
            raise ValueError(f"surface is {self.surface!r}: expected one of {', '.join(SURFACES)}")

    def signs(self) -> tuple[float, ...]:
        """The sides to run, +1 for left: both, or the one that was asked for."""
        return {"left": (1.0,), "right": (-1.0,), "both": (1.0, -1.0)}[self.direction]

    def grip(self, own: float) -> float:
        """The friction asked for, or the manoeuvre's own."""
        return own if self.friction is None else self.friction

    def speed(self, own_mps: float) -> float:
        """The speed asked for, or the manoeuvre's own."""
        return own_mps if self.speed_mps is None else self.speed_mps


@dataclass(frozen=True)
class VehicleFigures:
    """What a manoeuvre has to know of the vehicle that will run it, as loaded: SI.

    understeer_radps2pm: road-wheel angle beyond L/R per m/s² of lateral acceleration. brake_gain_nmppa: brake torque of
    all wheels per pressure. power_w: at the wheels. driven_load_share: of the weight, on driven wheels. The defaults are
    those of a mid-size SUV.
    """

    wheelbase_m: float = 2.78
    track_m: float = 1.60
    steering_ratio: float = 16.0
    mass_kg: float = 1850.0
    cg_height_m: float = 0.68
    wheel_radius_m: float = 0.34
    brake_gain_nmppa: float = 4.0e-4
    power_w: float = 110_000.0
    understeer_radps2pm: float = 0.0035
    drag_area_m2: float = 0.8
    rolling_resistance: float = 0.012
    driven_load_share: float = 1.0

    @property
    def width_m(self) -> float:
        """Width of the body, from the track: 1.84 m for a track of 1.60 m."""
        return 1.15 * self.track_m

    @property
    def tightest_m(self) -> float:
        """Least radius of a bend that it takes easily: a road wheel turned by about 24 degrees."""
        return 2.2 * self.wheelbase_m

    @property
    def static_stability_factor(self) -> float:
        """Track over twice the CG height: the lateral acceleration, in g, that tips a rigid vehicle."""
        return self.track_m / (2 * self.cg_height_m)

    def safe_lateral_mps2(self, wanted_mps2: float, friction: float, share: float = 0.6) -> float:
        """The lateral acceleration wanted, held to a share of what grip allows and half of what static stability does."""
        return min(wanted_mps2, share * GRAVITY * friction, 0.5 * GRAVITY * self.static_stability_factor)

    def steering_wheel_rad(self, lateral_mps2: float, speed_mps: float) -> float:
        """Steering-wheel angle for a steady lateral acceleration: ratio (L a_y / v² + K a_y), at most full lock.

        At a walking pace no lock is enough for much of it.
        """
        road_wheel = lateral_mps2 * (self.wheelbase_m / speed_mps**2 + self.understeer_radps2pm)
        return min(self.steering_ratio * road_wheel, FULL_LOCK_RAD)

    def brake_pressure_pa(self, decel_mps2: float) -> float:
        """Pressure for a deceleration, by m a R = gain p."""
        return self.mass_kg * decel_mps2 * self.wheel_radius_m / self.brake_gain_nmppa

    def resistance_mps2(self, speed_mps: float) -> float:
        """Deceleration with both feet off: rolling resistance and drag (air of 1.2 kg/m³)."""
        return GRAVITY * self.rolling_resistance + 0.6 * self.drag_area_m2 * speed_mps**2 / self.mass_kg

    def reachable_mps(self, wanted_mps: float) -> float:
        """The speed wanted, or the highest at which 70 % of the power still accelerates by 0.2 m/s²."""
        speeds = np.arange(2.0, 80.0, 0.5)
        able = [float(v) for v in speeds if self.acceleration_mps2(float(v), 0.9) >= 0.2]
        return min(wanted_mps, max(able, default=2.0))

    def traction_mps2(self, friction: float, share: float = 0.6) -> float:
        """What a share of the driven wheels' grip gives: beyond 60 % they slip too much for a steady drive."""
        return share * friction * GRAVITY * self.driven_load_share

    def acceleration_mps2(self, speed_mps: float, friction: float, share: float = 0.6) -> float:
        """What 70 % of the power gives at a speed, as far as that share of the grip allows; not below 0.05."""
        power = 0.7 * self.power_w / (self.mass_kg * max(speed_mps, 2.0))
        return max(min(power, self.traction_mps2(friction, share)) - self.resistance_mps2(speed_mps), 0.05)


class Drivable(Protocol):
    """What `figures_of` reads of a plant's vehicle. SI, as `VehicleFigures`."""

    @property
    def wheelbase_m(self) -> float:
        """Front to rear axle."""
        ...

    @property
    def track_front_m(self) -> float:
        """Left to right wheel."""
        ...

    @property
    def track_rear_m(self) -> float:
        """Left to right wheel."""
        ...

    @property
    def steering_ratio(self) -> float:
        """Steering-wheel angle over road-wheel angle."""
        ...

    @property
    def mass_kg(self) -> float:
        """As loaded."""
        ...

    @property
    def cg_to_front_axle_m(self) -> float:
        """Behind the front axle."""
        ...

    @property
    def drive_front_share(self) -> float:
        """Of the drive torque: 1 is front-wheel drive."""
        ...

    @property
    def cg_height_m(self) -> float:
        """Above ground."""
        ...

    @property
    def wheel_radius_m(self) -> float:
        """Rolling radius."""
        ...

    @property
    def brake_gain_nmppa(self) -> float:
        """Brake torque of all wheels per pressure."""
        ...

    @property
    def power_w(self) -> float:
        """At the wheels."""
        ...

    @property
    def understeer_radps2pm(self) -> float:
        """Road-wheel angle beyond L/R per m/s² of lateral acceleration."""
        ...

    @property
    def drag_area_m2(self) -> float:
        """Drag coefficient times frontal area."""
        ...

    @property
    def rolling_resistance(self) -> float:
        """Force over weight."""
        ...


def driven_load_share(drive_front_share: float, rear_load_share: float) -> float:
    """Share of the weight on driven wheels."""
    return (1 - rear_load_share) * (drive_front_share > 0) + rear_load_share * (drive_front_share < 1)


def figures_of(vehicle: Drivable) -> VehicleFigures:
    """The figures of a vehicle as it will be driven: give the loaded one."""
    driven = driven_load_share(vehicle.drive_front_share, vehicle.cg_to_front_axle_m / vehicle.wheelbase_m)
    return VehicleFigures(
        vehicle.wheelbase_m,
        0.5 * (vehicle.track_front_m + vehicle.track_rear_m),
        vehicle.steering_ratio,
        vehicle.mass_kg,
        vehicle.cg_height_m,
        vehicle.wheel_radius_m,
        vehicle.brake_gain_nmppa,
        vehicle.power_w,
        vehicle.understeer_radps2pm,
        vehicle.drag_area_m2,
        vehicle.rolling_resistance,
        driven,
    )


@dataclass(frozen=True)
class Scenario:
    """A manoeuvre ready to run. standard: where it comes from, or "" for one of our own; notes: what was chosen."""

    name: str
    title: str
    standard: str
    demand: Demand
    road: Road
    notes: tuple[str, ...] = ()


Builder = Callable[[VehicleFigures, Options, np.random.Generator], Scenario]
"""A manoeuvre: one function. The first line of its docstring is its title in lists."""
