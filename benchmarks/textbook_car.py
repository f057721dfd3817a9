"""A car from the textbook: fourteen degrees of freedom at small angles, to judge the verdict on foreign physics.

It shares no code and no derivation with the plant in `pipelines/simulation`. A sprung body heaves, rolls about an axis
through the roll centres, and pitches; four hubs move up and down between springs and tyres, four wheels spin, and the
car moves in the road's plane. Springs stiffen by a square law; dampers are softer in compression, and softer still
above a knee; struts carry anti-roll bars, dry friction and bump stops. Tyres saturate as the magic formula has it, with
combined slip, load sensitivity and a relaxation length. The road has grade, bank, and a profile under each side that
the rear wheels meet later.

Signs as in ISO 8855: x ahead, y left, z up; roll is positive with the right side down, pitch with the nose down, yaw and
steering to the left. A deflection is positive in compression. grade is positive uphill, bank with the left side high.
SI throughout, and radians.

Left out: camber and the couples of hubs that lean with the body, so that no hub weighs on the springs in roll; lift
of the body by air; compliance of the links; steering geometry and play; the road's own turning, so that gyroscopes
miss the rates of grade and bank and nothing is pressed by crests and dips; products of small angles and rates, beyond
the inertial unit's share of gravity and of the forces in the road's plane. `textbook_motion` moves it, `textbook_logs`
drives and logs it, `textbook_study` puts the verdict to it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from pipelines.results import FloatArray

G = 9.81


class Car(NamedTuple):
    """The vehicle as loaded. Behind: the front axle; left: of the middle. unsprung_*: both wheels of an axle; spring,
    damper: one wheel; bar: N·m per rad of roll. Damping is the mean of both directions. brake_gain: N·m (all wheels) per Pa."""

    mass: float
    wheelbase: float
    cg_behind: float
    track: float
    cg_height: float
    unsprung_front: float
    unsprung_rear: float
    roll_inertia: float
    pitch_inertia: float
    yaw_inertia: float
    spring_front: float
    spring_rear: float
    bar_front: float
    bar_rear: float
    damper_front: float
    damper_rear: float
    roll_centre_front: float
    roll_centre_rear: float
    radius: float
    tyre_rate: float
    pitch_centre_braking: float
    pitch_centre_driving: float
    drag_area: float
    rolling: float
    wheel_inertia: float
    brake_front: float
    brake_gain: float
    drive_front: float
    steering_ratio: float
    cg_left: float
    friction: float


@dataclass(frozen=True)
class Load:
    """One lump: where it lies behind the front axle, left of the middle, and above the ground."""

    kg: float
    behind: float
    left: float
    height: float


class Parts(NamedTuple):
    """What follows from a car: its sprung body about that body's own CG, and a value a wheel."""

    sprung_kg: float
    sprung_height: float
    sprung_behind: float
    sprung_left: float
    unsprung_kg: float
    roll_inertia: float
    pitch_inertia: float
    arm: float
    static: FloatArray
    hub_kg: FloatArray
    spring: FloatArray
    damper: FloatArray
    bar: FloatArray
    x: FloatArray
    y: FloatArray
    body_x: FloatArray
    body_y: FloatArray
    brake_share: FloatArray
    drive_share: FloatArray


KINDS: dict[str, tuple[float, ...]] = {
    "suv": (1850, 2.75, 1.32, 1.58, 0.68, 95, 98, 640, 2700, 3000, 29e3, 31e3, 24e3, 12e3, 2200, 2400, 0.09, 0.13, 0.35, 230e3),
    "sedan": (1450, 2.7, 1.18, 1.54, 0.54, 80, 80, 480, 2100, 2300, 24e3, 26e3, 20e3, 10e3, 1700, 1900, 0.06, 0.12, 0.31, 210e3),
    "van": (2100, 3.2, 1.45, 1.68, 0.78, 115, 125, 1000, 4400, 4500, 38e3, 45e3, 28e3, 8e3, 2900, 3100, 0.08, 0.16, 0.34, 260e3),
}  # fmt: skip
"""Typical figures, in the order of the first fields of `Car`."""


def draw_car(kind: str, rng: np.random.Generator) -> Car:
    """A car of its kind: every figure 5 % about the typical one, the rest within what cars have."""
    typical = KINDS[kind]
    drawn = [value * float(np.exp(0.05 * rng.standard_normal())) for value in typical]
    wheelbase, behind = Car._fields.index("wheelbase"), Car._fields.index("cg_behind")
    drawn[behind] = typical[behind] * drawn[wheelbase] / typical[wheelbase] + 0.03 * rng.standard_normal()
    pitch_centres = (rng.uniform(0.02, 0.15), rng.uniform(0.0, 0.12))
    losses = (rng.uniform(0.65, 1.0), rng.uniform(0.009, 0.014), rng.uniform(1.0, 1.7))
    torques = (rng.uniform(0.6, 0.72), rng.uniform(5e-4, 8e-4), float(rng.choice([0, 1.0, 0.4])))
    last = (rng.uniform(14, 18), 0.005 * rng.standard_normal(), rng.uniform(20, 120))
    return Car._make([*drawn, *pitch_centres, *losses, *torques, *last])


def loaded(car: Car, load: Load) -> Car:
    """The car with a load: masses, places and inertias about the new CG."""
    m = load.kg
    total = car.mass + m
    behind = (car.mass * car.cg_behind + m * load.behind) / total
    left = (car.mass * car.cg_left + m * load.left) / total
    height = (car.mass * car.cg_height + m * load.height) / total
    up, ahead, over = car.cg_height - height, car.cg_behind - behind, car.cg_left - left
    load_up, load_ahead, load_over = load.height - height, load.behind - behind, load.left - left
    return car._replace(
        mass=total,
        cg_behind=behind,
        cg_left=left,
        cg_height=height,
        roll_inertia=car.roll_inertia + car.mass * (up**2 + over**2) + m * (load_up**2 + load_over**2),
        pitch_inertia=car.pitch_inertia + car.mass * (up**2 + ahead**2) + m * (load_up**2 + load_ahead**2),
        yaw_inertia=car.yaw_inertia + car.mass * ahead**2 + m * (load_ahead**2 + load.left**2),
    )


def sprung(car: Car) -> tuple[float, float, float, float]:
    """The sprung mass, and its CG behind the front axle, left of the middle, above the ground."""
    hubs = car.unsprung_front + car.unsprung_rear
    kg = car.mass - hubs
    behind = (car.mass * car.cg_behind - car.unsprung_rear * car.wheelbase) / kg
    return kg, behind, car.mass * car.cg_left / kg, (car.mass * car.cg_height - hubs * car.radius) / kg


def roll_arm(car: Car) -> float:
    """From the roll axis up to the sprung CG."""
    _, behind, _, height = sprung(car)
    rise = (car.roll_centre_rear - car.roll_centre_front) * behind / car.wheelbase
    return height - (car.roll_centre_front + rise)


def static_forces(car: Car) -> FloatArray:
    """What the body weighs on each strut at rest on a level road, N; bars carry nothing then."""
    kg, behind, left, _ = sprung(car)
    front, rear = kg * G * (car.wheelbase - behind) / car.wheelbase, kg * G * behind / car.wheelbase
    side = np.array([0.5 + left / car.track, 0.5 - left / car.track])
    return np.concatenate([front * side, rear * side])


def parts_of(car: Car) -> Parts:
    """The car as the kernel needs it."""
    kg, behind, left, height = sprung(car)
    front, rear = car.unsprung_front, car.unsprung_rear
    hubs = front + rear
    ahead, rearward = car.cg_behind, car.wheelbase - car.cg_behind
    lower = hubs * (car.cg_height - car.radius) ** 2 + kg * (height - car.cg_height) ** 2
    roll = car.roll_inertia - lower - hubs * (car.track / 2) ** 2
    pitch = car.pitch_inertia - lower - front * ahead**2 - rear * rearward**2 - kg * (behind - ahead) ** 2
    half = car.track / 2
    axles = [behind, behind, behind - car.wheelbase, behind - car.wheelbase]

    def each(at_front: float, at_rear: float) -> FloatArray:
        return np.array([at_front, at_front, at_rear, at_rear])

    return Parts(
        *(kg, height, behind, left, hubs, roll, pitch, roll_arm(car), static_forces(car)),
        hub_kg=each(front / 2, rear / 2),
        spring=each(car.spring_front, car.spring_rear),
        damper=each(car.damper_front, car.damper_rear),
        bar=each(car.bar_front, car.bar_rear),
        x=each(ahead, -rearward),
        y=np.array([half, -half, half, -half]),
        body_x=np.array(axles),
        body_y=np.array([half - left, -half - left, half - left, -half - left]),
        brake_share=each(car.brake_front / 2, (1 - car.brake_front) / 2),
        drive_share=each(car.drive_front / 2, (1 - car.drive_front) / 2),
    )
