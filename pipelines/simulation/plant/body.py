"""The vehicle of the full plant: everything that its equations need.

All quantities are those of the vehicle at rest on flat ground, empty, unless `pipelines.simulation.loads` put a load
into it. Axes ISO 8855.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from pipelines.simulation.records import GRAVITY

Corners = tuple[float, float, float, float]
"""One figure a wheel: fl, fr, rl, rr."""


@dataclass(frozen=True)
class PlantVehicle:
    """One vehicle of the plant, SI.

    Raises ValueError, naming the field, where a figure cannot be.
    """

    name: str
    body: str
    # the sprung mass: its CG behind the front axle, left of the middle, above ground at rest, and its inertias about it
    sprung_mass_kg: float
    sprung_cg_behind_front_axle_m: float
    sprung_cg_left_m: float
    sprung_cg_height_m: float
    sprung_roll_inertia_kgm2: float
    sprung_pitch_inertia_kgm2: float
    sprung_yaw_inertia_kgm2: float
    sprung_product_xz_kgm2: float
    # the unsprung masses, a wheel
    unsprung_mass_front_kg: float
    unsprung_mass_rear_kg: float
    # geometry
    wheelbase_m: float
    track_front_m: float
    track_rear_m: float
    roll_center_height_front_m: float
    roll_center_height_rear_m: float
    # side view: what the foot of a wheel moves forward a metre of jounce (the wheel held by its brake); + fights dive
    # in front, - fights lift behind
    side_slope_front: float
    side_slope_rear: float
    # the same with the torque of a drive shaft (the hub moves, the wheel rolls on)
    side_slope_drive_front: float
    side_slope_drive_rear: float
    # how much of the body's lean the suspension takes from the wheels: 0 they lean with it, 1 a rigid axle
    camber_compensation_front: float
    camber_compensation_rear: float
    # springs, a wheel, at the wheel; stiffening: growth of the rate with deflection² [1/m²]
    spring_rate_front_npm: float
    spring_rate_rear_npm: float
    spring_stiffening_pm2: float
    bump_clearance_m: float
    rebound_clearance_m: float
    bump_rate_npm: float
    anti_roll_stiffness_front_nmprad: float
    anti_roll_stiffness_rear_nmprad: float
    # dampers, a wheel, at the wheel: slopes up to the knee, and what is left of them beyond it
    damper_compression_front_nspm: float
    damper_extension_front_nspm: float
    damper_compression_rear_nspm: float
    damper_extension_rear_nspm: float
    damper_knee_mps: float
    damper_blow_off: float
    # dry friction, a wheel; it changes over within `friction_travel_m` after a turn of the motion (Dahl). As large either way:
    # one that differs is this one with another preload, and deflections count from where the empty vehicle stands
    friction_n: float
    friction_travel_m: float
    # tyres and wheels
    tire_vertical_rate_front_npm: float
    tire_vertical_rate_rear_npm: float
    tire_damping_nspm: float
    wheel_radius_front_m: float
    wheel_radius_rear_m: float
    wheel_inertia_front_kgm2: float
    wheel_inertia_rear_kgm2: float
    # force a unit slip and a newton of load; what load takes from it and from friction, a doubling of static load
    longitudinal_stiffness_prad: float
    cornering_stiffness_front_prad: float
    cornering_stiffness_rear_prad: float
    camber_stiffness_prad: float
    stiffness_load_sensitivity: float
    friction_load_sensitivity: float
    friction_scale: float
    sliding_loss: float
    relaxation_longitudinal_m: float
    relaxation_lateral_m: float
    rolling_resistance: float
    # driving
    steering_ratio: float
    steering_lag_s: float
    brake_gain_nmppa: float
    brake_front_share: float
    drive_front_share: float
    power_w: float
    drag_area_m2: float
    slip_limit: float = 0.12
    # mass that the springs' seats put on the diagonal fr-rl and take from fl-rr, in front; its CG stays where it is
    cross_weight_kg: float = 0.0
    # how far an axle's roll centre comes down for a metre that the body does: 0 the wheels' paths are straight in the body
    roll_center_drop_front: float = 0.0
    roll_center_drop_rear: float = 0.0
    # how far wheels' side-view paths turn with their travel, over what arms about poles that are fixed in the body do; 0 straight paths
    pole_follow: float = 0.0
    # share of a tyre's deflection across by which the middle of its load goes along with the patch; 0 it stays under the wheel
    patch_give: float = 0.0
    # force of each suspension where its deflection is 0; None: what carries this vehicle level
    spring_preload_n: Corners | None = None

    def __post_init__(self) -> None:
        """Refuse what cannot be."""
        for item in fields(self):
            value = getattr(self, item.name)
            if not isinstance(value, float | int):
                continue
            if not math.isfinite(value):
                raise ValueError(f"{item.name} is {value}, expected a finite number")
            if item.name in _POSITIVE and value <= 0:
                raise ValueError(f"{item.name} is {value:g}, expected more than 0")
            if item.name in _ZERO_OR_MORE and value < 0:
                raise ValueError(f"{item.name} is {value:g}, expected 0 or more")
            if item.name in _SHARES and not 0 <= value <= 1:
                raise ValueError(f"{item.name} is {value:g}, expected a share from 0 to 1")
        if not 0 < self.sprung_cg_behind_front_axle_m < self.wheelbase_m:
            raise ValueError("sprung_cg_behind_front_axle_m is not inside the wheelbase")
        if 2 * abs(self.sprung_cg_left_m) >= min(self.track_front_m, self.track_rear_m):
            raise ValueError("sprung_cg_left_m is not inside the track")
        if self.cross_weight_kg != 0 and min(self.preloads_n) <= 0:
            raise ValueError(f"cross_weight_kg is {self.cross_weight_kg:g}, which lifts a wheel")

    @property
    def unsprung_masses_kg(self) -> Corners:
        """Of the four wheels."""
        front, rear = self.unsprung_mass_front_kg, self.unsprung_mass_rear_kg
        return front, front, rear, rear

    @property
    def mass_kg(self) -> float:
        """Of the whole vehicle."""
        return self.sprung_mass_kg + sum(self.unsprung_masses_kg)

    @property
    def hub_heights_m(self) -> Corners:
        """Of the four wheels where the deflections are 0: the radius less the tyre's squash."""
        loads = [p + m * GRAVITY for p, m in zip(self.preloads_n, self.unsprung_masses_kg, strict=True)]
        rates, radii = self.tire_rates_npm, self.wheel_radii_m
        fl, fr, rl, rr = (r - load / k for r, load, k in zip(radii, loads, rates, strict=True))
        return fl, fr, rl, rr

    @property
    def tire_rates_npm(self) -> Corners:
        """Vertical rates of the four tyres."""
        front, rear = self.tire_vertical_rate_front_npm, self.tire_vertical_rate_rear_npm
        return front, front, rear, rear

    @property
    def wheel_radii_m(self) -> Corners:
        """Unloaded, of the four wheels."""
        front, rear = self.wheel_radius_front_m, self.wheel_radius_rear_m
        return front, front, rear, rear

    @property
    def cg_height_m(self) -> float:
        """CG height of the whole vehicle standing level (a load's sag is in `loads.truth`)."""
        wheels = sum(m * h for m, h in zip(self.unsprung_masses_kg, self.hub_heights_m, strict=True))
        return (self.sprung_mass_kg * self.sprung_cg_height_m + wheels) / self.mass_kg

    @property
    def cg_to_front_axle_m(self) -> float:
        """Of the whole vehicle."""
        rear = 2 * self.unsprung_mass_rear_kg * self.wheelbase_m
        return (self.sprung_mass_kg * self.sprung_cg_behind_front_axle_m + rear) / self.mass_kg

    @property
    def wheel_radius_m(self) -> float:
        """Mean of the unloaded wheels' radii."""
        return 0.5 * (self.wheel_radius_front_m + self.wheel_radius_rear_m)

    @property
    def roll_axis_height_m(self) -> float:
        """Height of the roll axis above ground at the sprung CG, where the deflections are 0."""
        share = self.sprung_cg_behind_front_axle_m / self.wheelbase_m
        return (1 - share) * self.roll_center_height_front_m + share * self.roll_center_height_rear_m

    @property
    def pitch_axis_height_m(self) -> float:
        """Height above ground of the axis about which braking pitches the body: the links carry what acts below it."""
        front = self.side_slope_front * self.sprung_cg_behind_front_axle_m
        rear = -self.side_slope_rear * (self.wheelbase_m - self.sprung_cg_behind_front_axle_m)
        return self.brake_front_share * front + (1 - self.brake_front_share) * rear

    @property
    def preloads_n(self) -> Corners:
        """Suspension force of each wheel where its deflection is 0: given, or what carries this vehicle level.

        A given one holds the cross weight already. The rear springs' share of it is that which leaves no roll moment.
        """
        if self.spring_preload_n is not None:
            return self.spring_preload_n
        weight = self.sprung_mass_kg * GRAVITY
        rear = weight * self.sprung_cg_behind_front_axle_m / self.wheelbase_m
        lean_front = self.sprung_cg_left_m / self.track_front_m
        lean_rear = self.sprung_cg_left_m / self.track_rear_m
        cross = self.cross_weight_kg * GRAVITY
        behind = cross * self.track_front_m / self.track_rear_m
        return (
            (weight - rear) * (0.5 + lean_front) - cross,
            (weight - rear) * (0.5 - lean_front) + cross,
            rear * (0.5 + lean_rear) + behind,
            rear * (0.5 - lean_rear) - behind,
        )

    @property
    def understeer_radps2pm(self) -> float:
        """Road-wheel angle beyond the geometric one, a m/s² of lateral acceleration, from the tyres' linear slopes."""
        return (1 / self.cornering_stiffness_front_prad - 1 / self.cornering_stiffness_rear_prad) / GRAVITY


_SIGNED = frozenset(
    {
        "sprung_cg_left_m",
        "cross_weight_kg",
        "sprung_product_xz_kgm2",
        "roll_center_height_front_m",
        "roll_center_height_rear_m",
        "side_slope_front",
        "side_slope_rear",
        "side_slope_drive_front",
        "side_slope_drive_rear",
        "roll_center_drop_front",
        "roll_center_drop_rear",
    }
)
_SHARES = frozenset(
    {"brake_front_share", "drive_front_share", "damper_blow_off", "sliding_loss", "patch_give"}
)
_ZERO_OR_MORE = frozenset(
    {
        "pole_follow",
        "camber_compensation_front",
        "camber_compensation_rear",
        "spring_stiffening_pm2",
        "bump_rate_npm",
        "anti_roll_stiffness_front_nmprad",
        "anti_roll_stiffness_rear_nmprad",
        "damper_compression_front_nspm",
        "damper_extension_front_nspm",
        "damper_compression_rear_nspm",
        "damper_extension_rear_nspm",
        "friction_n",
        "tire_damping_nspm",
        "camber_stiffness_prad",
        "stiffness_load_sensitivity",
        "friction_load_sensitivity",
        "rolling_resistance",
        "drag_area_m2",
        "slip_limit",
    }
)
_POSITIVE = (
    frozenset(item.name for item in fields(PlantVehicle) if item.type == "float")
    - _SIGNED
    - _SHARES
    - _ZERO_OR_MORE
)
