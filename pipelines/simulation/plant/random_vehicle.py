"""A road vehicle that nobody built but somebody might have: a random, physically consistent vehicle of the full plant.

Size, mass and CG height are those of a measured vehicle (`pipelines.vehicles`) with a little of its neighbours in it; all
else follows from how vehicles are designed: springs from ride frequencies, anti-roll bars from the roll gradient, dampers from
damping ratios, tyres from their squash, brakes from what they must hold, and the side view of the links from swing arms.
Ranges are those of textbooks and data sheets (Milliken & Milliken; Gillespie; Dixon), none from an estimator's prior.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from pipelines.simulation.plant.body import PlantVehicle
from pipelines.simulation.plant.linear import roll_gradient_degpg
from pipelines.simulation.records import GRAVITY
from pipelines.vehicles.measured import measured_vehicles
from pipelines.vehicles.priors import measured_product

Range = tuple[float, float]


@dataclass(frozen=True)
class Kind:
    """What a body style's vehicles have in common. Ranges are of even chance, (mean, std) of normal spread.

    front_drive, all_drive: chances; the rest is rear-wheel drive. leaves: chance of a driven rigid rear axle on leaf
    springs. wheelbase: (mean, std) in m at `at_kg`, growing by `longer` m a tonne. radius: of the free wheel, m.
    ride_hz: of the front on its springs, empty; behind: rear over front. gradient_degpg: roll a g.
    """

    front_drive: float
    all_drive: float
    leaves: float
    wheelbase: Range
    at_kg: float
    longer: float
    radius: Range
    ride_hz: Range
    behind: Range
    gradient_degpg: Range
    drag_area: Range
    rear_cornering: Range


KINDS: Mapping[str, Kind] = {
    "Sedan": Kind(0.65, 0.15, 0.0, (2.73, 0.05), 1560, 0.28, (0.305, 0.335), (1.05, 1.45), (1.02, 1.22),
                  (3.8, 6.3), (0.57, 0.72), (12.0, 17.0)),
    "Hatchback": Kind(0.9, 0.05, 0.0, (2.53, 0.05), 1280, 0.32, (0.285, 0.325), (1.10, 1.55), (1.05, 1.25),
                      (4.0, 6.8), (0.60, 0.75), (12.0, 17.0)),
    "Wagon": Kind(0.7, 0.2, 0.0, (2.68, 0.05), 1550, 0.28, (0.30, 0.335), (1.05, 1.45), (1.05, 1.25),
                  (3.8, 6.3), (0.62, 0.76), (12.0, 17.0)),
    "SUV": Kind(0.4, 0.5, 0.05, (2.76, 0.07), 1900, 0.30, (0.335, 0.385), (1.10, 1.55), (1.02, 1.25),
                (4.5, 7.2), (0.75, 1.02), (11.0, 15.5)),
    "Minivan": Kind(0.9, 0.1, 0.0, (2.96, 0.07), 1910, 0.30, (0.32, 0.345), (1.05, 1.40), (1.05, 1.30),
                    (4.8, 7.2), (0.85, 1.05), (11.0, 15.0)),
    "Van": Kind(0.2, 0.1, 0.6, (3.40, 0.15), 2780, 0.30, (0.335, 0.375), (1.15, 1.50), (1.15, 1.50),
                (4.5, 7.5), (1.20, 1.70), (9.5, 13.0)),
    "Pickup": Kind(0.0, 0.5, 1.0, (3.15, 0.15), 2010, 0.45, (0.345, 0.405), (1.15, 1.55), (1.20, 1.55),
                   (4.3, 7.0), (0.95, 1.30), (9.5, 13.5)),
}  # fmt: skip
"""By body style, as the measured vehicles name it."""

FRONT_LOAD = {"front": (0.605, 0.020), "rear": (0.530, 0.020), "all": (0.565, 0.022)}
"""Share of the weight on the front axle by driven wheels."""
RIGID_FRONT_LOAD = (0.570, 0.020)
"""The same with a rigid rear axle: pickups and vans are light behind while empty."""
DESIGN_LOAD_KG = 350.0
"""What may ride over the rear axle without the body resting on its stops."""
RIGID_ROLL_CENTER = (0.14, 0.24)
"""m above ground. Leaf springs have 0.3 to 0.4 m, but the plant's two guides jack the body in bends, the more the higher the
roll centre, which a rigid axle, whose wheels move sideways together, does not."""
LEAST_BAR, MOST_BAR = 0.06, 1.6
"""Least and greatest stiffness of the anti-roll bars together, over the springs' roll stiffness."""


def _even(rng: np.random.Generator, span: Range) -> float:
    return float(rng.uniform(*span))


def _near(rng: np.random.Generator, mean: float, std: float, most: float = 2.5) -> float:
    """Normal, never farther from the mean than `most` std."""
    return mean + std * float(np.clip(rng.standard_normal(), -most, most))


@dataclass(frozen=True)
class _Frame:
    """Size and masses: whole vehicle, in SI. wheels: front and rear unsprung mass, a wheel."""

    body: str
    kind: Kind
    drive: str
    rigid: bool
    mass: float
    height: float
    tracks: Range
    wheelbase: float
    behind: float
    left: float
    wheels: Range
    radius: float
    tires: Range
    hubs: Range

    @property
    def sprung(self) -> float:
        """Sprung mass."""
        return self.mass - 2 * sum(self.wheels)

    def corner(self, rear: bool) -> float:
        """Sprung mass over one wheel of an axle."""
        share = self.sprung_behind / self.wheelbase
        return 0.5 * self.sprung * (share if rear else 1 - share)

    @property
    def sprung_behind(self) -> float:
        """Sprung CG behind the front axle."""
        return (self.mass * self.behind - 2 * self.wheels[1] * self.wheelbase) / self.sprung

    @property
    def sprung_height(self) -> float:
        """Sprung CG above ground."""
        low = 2 * sum(w * h for w, h in zip(self.wheels, self.hubs, strict=True))
        return (self.mass * self.height - low) / self.sprung


def _frame(rng: np.random.Generator, body: str) -> _Frame:
    kind = KINDS[body]
    measured = measured_vehicles()
    rows = np.flatnonzero(
        np.array([b == body for b in measured.body]) & np.isfinite(measured.track) & (measured.mass > 900)
    )
    row = int(rng.choice(rows))
    mass = float(measured.mass[row]) * _near(rng, 1.0, 0.03)
    track = float(measured.track[row]) * _near(rng, 1.0, 0.006)
    height = float(measured.height[row]) * _near(rng, 1.0, 0.012)
    apart = _near(rng, 0.0, 0.006)
    wheelbase = _near(rng, *kind.wheelbase) + kind.longer * (mass - kind.at_kg) / 1000
    dice = rng.random()
    drive = (
        "front" if dice < kind.front_drive else "all" if dice < kind.front_drive + kind.all_drive else "rear"
    )
    rigid = drive != "front" and bool(rng.random() < kind.leaves)
    front_load = _near(rng, *(RIGID_FRONT_LOAD if rigid else FRONT_LOAD[drive]))
    behind = (1 - front_load) * wheelbase
    unsprung = (0.026 * mass * _near(rng, 1, 0.08), (0.038 if rigid else 0.024) * mass * _near(rng, 1, 0.1))
    larger = float(np.clip((mass - 0.75 * kind.at_kg) / (0.6 * kind.at_kg), 0, 1))
    radius = kind.radius[0] + (kind.radius[1] - kind.radius[0]) * (0.6 * larger + 0.4 * rng.random())
    tire = mass * GRAVITY / 4 / _even(rng, (0.0150, 0.0205))
    tires = (tire, tire * _near(rng, 1.0, 0.03))
    weights = (front_load * mass * GRAVITY / 2, (1 - front_load) * mass * GRAVITY / 2)
    hubs = (radius - weights[0] / tires[0], radius - weights[1] / tires[1])
    return _Frame(
        body, kind, drive, rigid, mass, height, (track * (1 + apart), track * (1 - apart)), wheelbase, behind,
        # driver's side: steering gear, battery, tank; either side of the road
        _near(rng, 0.0, 0.007), unsprung, radius, tires, hubs,
    )  # fmt: skip


def _inertias(rng: np.random.Generator, f: _Frame) -> dict[str, float]:
    """Of the sprung mass, from radii of gyration of the whole vehicle: 0.413 +- 0.023 of the track in roll (measured),
    k² near a b in pitch."""
    track = sum(f.tracks) / 2
    roll = f.mass * (track * _near(rng, 0.413, 0.02)) ** 2
    pitch = f.mass * f.behind * (f.wheelbase - f.behind) * _near(rng, 0.98, 0.06)
    yaw = pitch * _near(rng, 1.03, 0.035)
    up = f.sprung_height - f.height
    roll -= f.sprung * up**2
    along = f.sprung_behind - f.behind
    pitch -= f.sprung * (up**2 + along**2)
    yaw -= f.sprung * along**2
    for wheel, hub, half, ahead in zip(
        f.wheels, f.hubs, (f.tracks[0] / 2, f.tracks[1] / 2), (f.behind, f.wheelbase - f.behind), strict=True
    ):
        drop = (f.height - hub) ** 2
        roll -= 2 * wheel * (half**2 + drop)
        pitch -= 2 * wheel * (ahead**2 + drop)
        yaw -= 2 * wheel * (ahead**2 + half**2)
    return {
        "sprung_roll_inertia_kgm2": roll,
        "sprung_pitch_inertia_kgm2": pitch,
        "sprung_yaw_inertia_kgm2": yaw,
        "sprung_product_xz_kgm2": yaw * _near(rng, *measured_product(f.body), 1.7),
    }


def _springs(rng: np.random.Generator, f: _Frame) -> dict[str, float]:
    """Springs, dampers, friction, stops: all but the bars. A rigid axle's are as they act at its wheels."""
    front_hz = _even(rng, f.kind.ride_hz)
    hertz = (front_hz, front_hz * _even(rng, f.kind.behind))
    found: dict[str, float] = {}
    ratio = _even(rng, (0.28, 0.44))
    uneven = _even(rng, (1.4, 2.5))
    rates = []
    for axle, rear in (("front", False), ("rear", True)):
        corner = f.corner(rear)
        rate = corner * (2 * math.pi * hertz[rear]) ** 2
        mean = ratio * _near(rng, 1.0, 0.08) * 2 * math.sqrt(rate * corner)
        found[f"spring_rate_{axle}_npm"] = rate
        found[f"damper_compression_{axle}_nspm"] = 2 * mean / (1 + uneven)
        found[f"damper_extension_{axle}_nspm"] = 2 * mean * uneven / (1 + uneven)
        rates.append(rate)
    sag = DESIGN_LOAD_KG * GRAVITY / (2 * rates[1])
    weight = f.sprung * GRAVITY / 4
    dry = weight * _even(rng, (0.018, 0.035) if f.rigid else (0.007, 0.020))
    return found | {
        "spring_stiffening_pm2": _even(rng, (0.0, 14.0)),
        "bump_clearance_m": max(_even(rng, (0.065, 0.100)), sag + 0.03),
        "rebound_clearance_m": _even(rng, (0.075, 0.120)),
        "bump_rate_npm": sum(rates) / 2 * _even(rng, (3.0, 6.0)),
        "damper_knee_mps": _even(rng, (0.15, 0.35)),
        "damper_blow_off": _even(rng, (0.35, 0.75)),
        "friction_n": dry * _even(rng, (1.0, 1.4)),
        "friction_travel_m": _even(rng, (0.001, 0.003)),
    }


def _links(rng: np.random.Generator, f: _Frame) -> dict[str, float]:
    """Roll centres, side view, camber. A rigid driven axle takes its shaft's torque on its links as it does the brake's."""
    front = _even(rng, (0.01, 0.12))
    rear = -_even(rng, (0.08, 0.25) if f.rigid else (0.08, 0.38))
    arm = _even(rng, (0.05, 0.22))
    drive_rear = rear if f.rigid else rear * _even(rng, (0.05, 0.5))
    return {
        "roll_center_height_front_m": _even(rng, (0.02, 0.12)),
        "roll_center_height_rear_m": _even(rng, RIGID_ROLL_CENTER if f.rigid else (0.06, 0.20)),
        "side_slope_front": front,
        "side_slope_rear": rear,
        "side_slope_drive_front": front - f.radius * arm,
        "side_slope_drive_rear": drive_rear,
        "camber_compensation_front": _even(rng, (0.35, 0.70)),
        "camber_compensation_rear": 1.0 if f.rigid else _even(rng, (0.50, 0.85)),
    }


def _give(rng: np.random.Generator, f: _Frame) -> dict[str, float]:
    """What simple models leave out: roll centres of independent axles come down with the body (struts 1 to 1.8, wishbones and
    multi-link axles 0.5 to 1), those of rigid ones hardly; a tyre's load goes along with its patch by a tenth to two thirds; side-view poles stay in the body, more or less."""
    return {
        "roll_center_drop_front": _even(rng, (0.5, 1.6)),
        "roll_center_drop_rear": 0.0 if f.rigid else _even(rng, (0.4, 1.2)),
        "patch_give": _even(rng, (0.1, 0.7)),
        "pole_follow": _even(rng, (0.6, 1.2)),
    }


def _tyres(rng: np.random.Generator, f: _Frame) -> dict[str, float]:
    rear = _even(rng, f.kind.rear_cornering)
    understeer = math.radians(_even(rng, (1.2, 3.2)))
    heavy = (9.0 + 0.0075 * f.mass) * _near(rng, 1.0, 0.1)
    inertia = 0.62 * heavy * f.radius**2
    return {
        "tire_vertical_rate_front_npm": f.tires[0],
        "tire_vertical_rate_rear_npm": f.tires[1],
        "tire_damping_nspm": f.tires[0] * _even(rng, (0.0005, 0.001)),
        "wheel_radius_front_m": f.radius,
        "wheel_radius_rear_m": f.radius,
        "wheel_inertia_front_kgm2": inertia,
        "wheel_inertia_rear_kgm2": inertia * _near(rng, 0.97, 0.03),
        "longitudinal_stiffness_prad": _even(rng, (15.0, 28.0)),
        "cornering_stiffness_front_prad": 1 / (1 / rear + understeer),
        "cornering_stiffness_rear_prad": rear,
        "camber_stiffness_prad": _even(rng, (0.3, 1.0)),
        "stiffness_load_sensitivity": _even(rng, (0.15, 0.30)),
        "friction_load_sensitivity": _even(rng, (0.05, 0.14)),
        "friction_scale": _even(rng, (0.95, 1.10)),
        "sliding_loss": _even(rng, (0.10, 0.25)),
        "relaxation_longitudinal_m": _even(rng, (0.18, 0.38)),
        "relaxation_lateral_m": _even(rng, (0.38, 0.70)),
        "rolling_resistance": _even(rng, (0.008, 0.0135)),
    }


def _driving(rng: np.random.Generator, f: _Frame) -> dict[str, float]:
    heavy = f.mass > 1_800
    share = {"front": 1.0, "rear": 0.0, "all": _even(rng, (0.3, 0.65))}[f.drive]
    return {
        "steering_ratio": _even(rng, (15.5, 20.0) if heavy else (13.5, 17.5)),
        "steering_lag_s": _even(rng, (0.02, 0.05)),
        # 10 MPa holds 0.9 to 1.3 g
        "brake_gain_nmppa": f.mass * f.radius * _even(rng, (9.0, 13.0)) / 1e7,
        "brake_front_share": _even(rng, (0.60, 0.76)),
        "drive_front_share": share,
        "power_w": f.mass * _even(rng, (48.0, 95.0)),
        "drag_area_m2": _even(rng, f.kind.drag_area),
    }


def _with_bars(vehicle: PlantVehicle, gradient_degpg: float, front_share: float) -> PlantVehicle:
    """Anti-roll bars that give this roll gradient on springs and tyres together; a weak front one where none is needed."""
    springs = 0.5 * (
        vehicle.spring_rate_front_npm * vehicle.track_front_m**2
        + vehicle.spring_rate_rear_npm * vehicle.track_rear_m**2
    )

    def barred(total: float) -> PlantVehicle:
        return replace(
            vehicle,
            anti_roll_stiffness_front_nmprad=total * front_share,
            anti_roll_stiffness_rear_nmprad=total * (1 - front_share),
        )

    low, high = LEAST_BAR * springs, MOST_BAR * springs
    if roll_gradient_degpg(barred(low)) <= gradient_degpg:
        return barred(low)
    # where even the stiffest bars leave more lean than that, it leans so much
    for _ in range(14):
        middle = 0.5 * (low + high)
        if roll_gradient_degpg(barred(middle)) > gradient_degpg:
            low = middle
        else:
            high = middle
    return barred(0.5 * (low + high))


def random_vehicle(rng: np.random.Generator, body: str | None = None) -> PlantVehicle:
    """A random road vehicle, empty. body: one of KINDS; None = any of them with the same chance.

    Raises ValueError for another body. The CG of the empty vehicle lies up to 17 mm off the middle, and its springs are
    warped by up to 1 % of its mass.
    """
    if body is not None and body not in KINDS:
        raise ValueError(f"there is no random {body!r}: expected one of {', '.join(KINDS)}")
    style = body or str(rng.choice(list(KINDS)))
    f = _frame(rng, style)
    # from a stream of its own: all else of a seed's vehicle stays as it was before these were drawn
    give = _give(rng.spawn(1)[0], f)
    figures = _inertias(rng, f) | _springs(rng, f) | _links(rng, f) | _tyres(rng, f) | _driving(rng, f) | give
    bare = PlantVehicle(
        name=f"random_{style.lower()}",
        body=style,
        sprung_mass_kg=f.sprung,
        sprung_cg_behind_front_axle_m=f.sprung_behind,
        sprung_cg_left_m=f.left * f.mass / f.sprung,
        sprung_cg_height_m=f.sprung_height,
        unsprung_mass_front_kg=f.wheels[0],
        unsprung_mass_rear_kg=f.wheels[1],
        wheelbase_m=f.wheelbase,
        track_front_m=f.tracks[0],
        track_rear_m=f.tracks[1],
        anti_roll_stiffness_front_nmprad=0.0,
        anti_roll_stiffness_rear_nmprad=0.0,
        cross_weight_kg=_near(rng, 0.0, 0.004 * f.mass),
        **figures,  # type: ignore[arg-type]
    )
    gradient = _even(rng, f.kind.gradient_degpg)
    front_share = 1.0 if rng.random() < (0.6 if f.rigid else 0.1) else _even(rng, (0.55, 0.85))
    return _with_bars(bare, gradient, front_share)
