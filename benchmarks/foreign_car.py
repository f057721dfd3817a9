"""Vehicles for the foreign simulators: figures of the empty car, a load nobody tells of, and what follows from both.

Shares nothing with the plant of `pipelines/simulation` nor with the textbook car. ISO 8855 signs, SI, radians: x behind
the front axle, y left of the middle, heights above the road. `foreign_planes`, `foreign_ride` and `foreign_pillars` are
three ways to move such a car; `foreign_logs` writes what its sensors read; `foreign_study` asks the verdict.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
G = 9.81

CLASSES = {
    "Hatchback": (1180.0, 2.52, 0.40, 1.47, 0.53, 0.30, 21e3, 0.075, 0.06),
    "Sedan": (1520.0, 2.76, 0.45, 1.56, 0.55, 0.32, 25e3, 0.080, 0.06),
    "SUV": (1950.0, 2.72, 0.48, 1.61, 0.69, 0.36, 32e3, 0.095, 0.08),
    "Van": (2200.0, 3.30, 0.46, 1.70, 0.80, 0.34, 42e3, 0.100, 0.06),
    "Pickup": (2150.0, 3.22, 0.44, 1.63, 0.72, 0.38, 36e3, 0.140, 0.15),
}
"""Mass, wheelbase, share of it to the CG, track, CG height, wheel radius, spring at a wheel, unsprung share of the mass,
mean roll centre height."""


@dataclass(frozen=True)
class Car:
    """One car with or without its load. unsprung: an axle; spring, damper: a wheel; bar: an axle, N·m/rad.

    dive, squat: height about which the links let the body pitch in braking and driving, over the CG's height.
    """

    body: str
    mass: float
    wheelbase: float
    x: float
    y: float
    height: float
    track: tuple[float, float]
    unsprung: tuple[float, float]
    inertia: tuple[float, float, float]
    spring: tuple[float, float]
    bar: tuple[float, float]
    damper: tuple[float, float]
    centre: tuple[float, float]
    dive: float
    squat: float
    radius: float
    tyre_rate: float
    wheel_inertia: float
    drag_area: float
    rolling: float
    brake_front: float
    drive_front: float
    brake_gain: float
    steering: float
    friction: float

    @property
    def hubs(self) -> float:
        """Both axles' unsprung mass."""
        return sum(self.unsprung)

    @property
    def sprung(self) -> float:
        """Sprung mass."""
        return self.mass - self.hubs

    @property
    def sprung_x(self) -> float:
        """Sprung CG behind the front axle."""
        return (self.mass * self.x - self.unsprung[1] * self.wheelbase) / self.sprung

    @property
    def sprung_y(self) -> float:
        """Sprung CG left of the middle."""
        return self.mass * self.y / self.sprung

    @property
    def sprung_height(self) -> float:
        """Sprung CG above the road."""
        return (self.mass * self.height - self.hubs * self.radius) / self.sprung

    @property
    def axis(self) -> float:
        """Roll axis below the sprung CG, above the road."""
        return self.centre[0] + (self.centre[1] - self.centre[0]) * self.sprung_x / self.wheelbase

    @property
    def roll_stiffness(self) -> float:
        """Springs and bars, body against axles."""
        return sum(0.5 * k * t * t + b for k, t, b in zip(self.spring, self.track, self.bar, strict=True))

    @property
    def sprung_inertia(self) -> tuple[float, float]:
        """Roll and pitch of the sprung body about its own CG."""
        low = (
            self.hubs * (self.height - self.radius) ** 2
            + self.sprung * (self.sprung_height - self.height) ** 2
        )
        wide = sum(u * (t / 2) ** 2 for u, t in zip(self.unsprung, self.track, strict=True))
        ends = self.unsprung[0] * self.x**2 + self.unsprung[1] * (self.wheelbase - self.x) ** 2
        return (
            self.inertia[0] - low - wide,
            self.inertia[1] - low - ends - self.sprung * (self.sprung_x - self.x) ** 2,
        )

    @property
    def resting(self) -> Array:
        """(4,) what each spring carries at rest, N: fl, fr, rl, rr."""
        rear = self.sprung * G * self.sprung_x / self.wheelbase
        out = []
        for force, track in zip((self.sprung * G - rear, rear), self.track, strict=True):
            out += [force * (0.5 + self.sprung_y / track), force * (0.5 - self.sprung_y / track)]
        return np.array(out)

    def pair(self, axle: int) -> Array:
        """(2, 2) stiffness of an axle's springs and bar, left and right."""
        bar = self.bar[axle] / self.track[axle] ** 2
        return np.array([[self.spring[axle] + bar, -bar], [-bar, self.spring[axle] + bar]])


def draw_car(rng: np.random.Generator) -> Car:
    """A car of some class, every figure spread about what such cars have."""
    body = str(rng.choice(list(CLASSES)))
    mass, length, share, track, height, radius, spring, hubs, centre = CLASSES[body]

    def about(value: float, spread: float = 0.06) -> float:
        return float(value * np.exp(spread * np.clip(rng.standard_normal(), -2, 2)))

    mass, height, track = about(mass), about(height, 0.04), about(track, 0.02)
    width, length = about(1.08 * track, 0.03), about(length, 0.03)
    springs = (about(spring), about(spring * 1.08))
    corner = mass * (1 - hubs) / 4
    wanted = mass * (1 - hubs) * G * (height - centre) / np.radians(rng.uniform(2.8, 5.0))
    bars = max(wanted - sum(0.5 * k * track**2 for k in springs), 0.15 * wanted)
    front_bar = rng.uniform(0.5, 0.75)
    return Car(
        body, mass, length, length * float(np.clip(share + 0.02 * rng.standard_normal(), 0.36, 0.54)),
        0.004 * float(rng.standard_normal()), height, (track, about(track, 0.01)),
        (about(0.5 * hubs * mass), about(0.52 * hubs * mass)),
        (about(mass * (0.30 * width) ** 2 * 1.3), about(mass * 0.21 * length**2), about(mass * 0.23 * length**2)),
        springs, (front_bar * bars, (1 - front_bar) * bars),
        (about(0.56 * np.sqrt(springs[0] * corner), 0.1), about(0.6 * np.sqrt(springs[1] * corner), 0.1)),
        (max(about(centre, 0.3) - 0.03, 0.0), about(centre, 0.3) + 0.03),
        rng.uniform(0.0, 0.35), rng.uniform(0.0, 0.35), radius, about(125 * mass, 0.1), rng.uniform(0.7, 1.8),
        rng.uniform(0.6, 1.1), rng.uniform(0.008, 0.015), rng.uniform(0.58, 0.75),
        float(rng.choice([1.0, 0.0, 0.5])), rng.uniform(3e-4, 9e-4), rng.uniform(14, 18), rng.uniform(0, 100),
    )  # fmt: skip


@dataclass(frozen=True)
class Load:
    """A lump."""

    mass: float
    x: float
    y: float
    height: float


def draw_load(car: Car, rng: np.random.Generator) -> Load:
    """Nothing, a roof box, a full boot, or persons."""
    kind = str(rng.choice(["none", "roof", "boot", "persons"]))
    aside = rng.uniform(-0.15, 0.15)
    return {
        "none": Load(0.0, car.x, 0.0, car.height),
        "roof": Load(rng.uniform(60, 150), 0.5 * car.wheelbase, aside, 2.3 * car.height + 0.2),
        "boot": Load(rng.uniform(100, 200), 1.05 * car.wheelbase, aside, 0.75),
        "persons": Load(rng.uniform(75, 320), 0.52 * car.wheelbase, aside, 0.8),
    }[kind]


def squeezed(empty: Car, full: Car) -> Array:
    """(4,) m, how far the load presses each spring."""
    more = full.resting - empty.resting
    return np.concatenate([np.linalg.solve(full.pair(i), more[2 * i : 2 * i + 2]) for i in (0, 1)])


def with_load(car: Car, load: Load, *, sags: bool) -> Car:
    """The car as it drives. sags: the body stands lower by what springs and tyres give, or its author forgot that."""
    total = car.mass + load.mass
    part = load.mass / total
    x, y = car.x + part * (load.x - car.x), car.y + part * (load.y - car.y)
    height = car.height + part * (load.height - car.height)
    both = car.mass * part
    up, along, over = load.height - car.height, load.x - car.x, load.y - car.y
    roll, pitch, yaw = car.inertia
    inertia = (
        roll + both * (up**2 + over**2),
        pitch + both * (up**2 + along**2),
        yaw + both * (along**2 + over**2),
    )
    full = replace(car, mass=total, x=x, y=y, height=height, inertia=inertia)
    if not sags:
        return full
    springs = float(squeezed(car, full).mean())
    tyres = load.mass * G / (4 * car.tyre_rate)
    return replace(full, height=height - (springs + tyres) * full.sprung / total)
