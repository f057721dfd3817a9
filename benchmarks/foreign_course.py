"""What a foreign car is asked to do: speed, steering at the road wheels, and the road's slopes, every 10 ms."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from foreign_car import Array, Car

RATE_HZ = 100.0
DRIVES = ("mixed", "slalom", "dwell", "circles", "braking", "straight")


@dataclass(frozen=True)
class Course:
    """(n,) wanted speed, angle of the front wheels, grade (+ uphill), bank (+ left side high)."""

    speed: Array
    steer: Array
    grade: Array
    bank: Array


@dataclass
class _Plan:
    """Pieces put one after another."""

    car: Car
    v: float = 0.0
    speed: list[Array] = field(default_factory=list)
    steer: list[Array] = field(default_factory=list)

    def piece(self, speed: Array, steer: Array | None = None) -> None:
        """Append speeds and road wheel angles."""
        self.speed.append(speed)
        self.steer.append(np.zeros(len(speed)) if steer is None else steer)
        self.v = float(speed[-1])

    def hold(self, seconds: float) -> None:
        """Keep the speed, or stand."""
        self.piece(np.full(int(seconds * RATE_HZ), self.v))

    def change(self, speed: float, accel: float) -> None:
        """A ramp of speed with round corners."""
        count = max(int(abs(speed - self.v) / accel * RATE_HZ * 1.2), 30)
        u = np.linspace(0, 1, count)
        self.piece(self.v + (speed - self.v) * u * u * (3 - 2 * u) * 0.5 + (speed - self.v) * u * 0.5)

    def weave(self, shape: Array, lateral: float) -> None:
        """Steer by a shape between -1 and 1, for so much lateral acceleration at this speed."""
        angle = lateral * (self.car.wheelbase / self.v**2 + 0.0025)
        self.piece(np.full(len(shape), self.v), angle * shape)


def _seconds(seconds: float) -> Array:
    return np.arange(int(seconds * RATE_HZ)) / RATE_HZ


def _slalom(plan: _Plan, rng: np.random.Generator, hard: float) -> None:
    t = _seconds(rng.uniform(10, 18))
    edge = np.minimum(1, np.minimum(t, t[-1] - t))
    plan.weave(np.sin(2 * np.pi * rng.uniform(0.3, 0.7) * t) * edge, hard)


def _dwell(plan: _Plan, rng: np.random.Generator, hard: float) -> None:
    t = _seconds(5.0)
    hz = rng.uniform(0.5, 0.75)
    turn = np.sin(2 * np.pi * hz * t)
    held = np.where(t < 0.75 / hz, turn, np.where(t < 0.75 / hz + 0.5, -1.0, 0.0))
    late = np.clip(t - 0.75 / hz - 0.5, 0, 0.25 / hz)
    tail = np.where(t >= 0.75 / hz + 0.5, -np.cos(2 * np.pi * hz * late), held)
    plan.weave(np.where(late >= 0.25 / hz, 0.0, tail) * float(rng.choice([-1, 1])), hard)


def _circle(plan: _Plan, rng: np.random.Generator, hard: float) -> None:
    t = _seconds(rng.uniform(6, 14))
    edge = np.minimum(1, np.minimum(t / 1.5, (t[-1] - t) / 1.5))
    plan.weave(edge * float(rng.choice([-1, 1])), hard)


def _stop(plan: _Plan, rng: np.random.Generator, hard: float) -> None:
    plan.change(0.0, rng.uniform(0.3, 1.0) * hard)
    plan.hold(rng.uniform(2, 4))


def _piece(plan: _Plan, kind: str, rng: np.random.Generator) -> None:
    hard = float(rng.uniform(2.0, 6.0))
    if plan.v < 8 or rng.random() < 0.2:
        plan.change(rng.uniform(10, 25), rng.uniform(1.0, 2.8))
    if kind == "braking" or (kind == "mixed" and rng.random() < 0.35):
        _stop(plan, rng, hard)
        return
    turns = {"slalom": _slalom, "dwell": _dwell, "circles": _circle}
    which = turns.get(kind) or list(turns.values())[rng.integers(3)]
    which(plan, rng, hard)
    plan.hold(rng.uniform(1, 3))


def make_course(car: Car, kind: str, rng: np.random.Generator, *, hilly: bool) -> Course:
    """A drive of one of DRIVES: from standstill to standstill, one to four minutes."""
    plan = _Plan(car)
    plan.hold(5.0)
    length = rng.uniform(150, 240) if kind == "mixed" else rng.uniform(60, 120)
    if kind == "straight":
        plan = _Plan(car, v=18.0)
        plan.hold(length)
    while kind != "straight" and sum(map(len, plan.speed)) < length * RATE_HZ:
        _piece(plan, kind, rng)
    if kind != "straight":
        plan.change(0.0, 2.0)
        plan.hold(3.0)
    speed, steer = np.concatenate(plan.speed), np.concatenate(plan.steer)
    return Course(speed, _smooth(steer, 0.08), *(_slope(speed, rng, hilly) for _ in range(2)))


def _smooth(values: Array, seconds: float) -> Array:
    half = int(3 * seconds * RATE_HZ)
    weights = np.exp(-0.5 * (np.arange(-half, half + 1) / (seconds * RATE_HZ)) ** 2)
    padded = np.pad(values, half, mode="edge")
    return np.asarray(np.convolve(padded, weights / weights.sum(), mode="valid"))


def _slope(speed: Array, rng: np.random.Generator, hilly: bool) -> Array:
    """A slope that changes with the way driven: waves of 90 to 500 m."""
    way = np.cumsum(speed) / RATE_HZ
    size = 0.012 if hilly else 0.0
    waves = [np.sin(2 * np.pi * way / length + rng.uniform(0, 6.28)) for length in rng.uniform(90, 500, 4)]
    return np.asarray(size * np.sum(waves, axis=0) * rng.uniform(0.3, 1.0))
