"""A body on four suspensions over rough ground, built apart from the product's plant: heave, pitch, roll, four hubs.

Any inertias, anti-roll bars, friction, damper curves with a knee, and moments on the body (braking, cornering).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from parsers.drive import Drive, ImportRecord, Signal
from parsers.jit import kernel
from parsers.signals import WHEELS
from pipelines.simulation.quarter_car import off_road_terrain
from pipelines.vehicles.vehicle import Quantity, Vehicle

Array = NDArray[np.float64]
G = 9.80665


@dataclass(frozen=True)
class RideCar:
    """sprung: mass kg; behind, left: its CG from the middle of the front axle, m. Springs, dampers a wheel."""

    sprung: float = 1650.0
    behind: float = 1.25
    left: float = 0.02
    roll_inertia: float = 600.0
    pitch_inertia: float = 2300.0
    wheelbase: float = 2.75
    track: float = 1.58
    spring_front: float = 32e3
    spring_rear: float = 36e3
    extension: float = 2600.0
    compression: float = 1300.0
    knee_mps: float = 0.4
    beyond_knee: float = 1.0
    bar_front: float = 18e3
    bar_rear: float = 8e3
    friction: float = 0.0
    unsprung_front: float = 90.0
    unsprung_rear: float = 84.0
    tyre: float = 230e3

    @property
    def mass(self) -> float:
        return self.sprung + self.unsprung_front + self.unsprung_rear

    @property
    def cg_to_front_axle(self) -> float:
        return (self.sprung * self.behind + self.unsprung_rear * self.wheelbase) / self.mass


@kernel
def _integrate(
    body: Array, wheels: Array, road: Array, moment: Array, step: float, inner: int, out: Array
) -> None:
    """body: mass, Ixx, Iyy, extension, compression, knee, beyond, friction. wheels (4, 6): place ahead of the CG, left of
    it, spring, bar (N/m of half difference), unsprung, tyre. road (n, 4), moment (n, 2): roll, pitch. out (n, 8)."""
    z = np.zeros(14)
    rate, mid, total = np.zeros(14), np.zeros(14), np.zeros(14)
    force = np.zeros(4)
    for k in range(out.shape[0] - 1):
        for sub in range(inner):
            for stage in range(4):
                share = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
                at = (sub + share) / inner
                for i in range(14):
                    mid[i] = z[i] + share * step / inner * rate[i]
                for w in range(4):
                    x = mid[0] + wheels[w, 1] * mid[1] - wheels[w, 0] * mid[2] - mid[3 + w]
                    v = mid[7] + wheels[w, 1] * mid[8] - wheels[w, 0] * mid[9] - mid[10 + w]
                    other = w + 1 if w % 2 == 0 else w - 1
                    xo = mid[0] + wheels[other, 1] * mid[1] - wheels[other, 0] * mid[2] - mid[3 + other]
                    slope = body[3] if v > 0 else body[4]
                    damper = slope * min(max(v, -body[5]), body[5])
                    damper += slope * body[6] * (v - min(max(v, -body[5]), body[5]))
                    force[w] = wheels[w, 2] * x + wheels[w, 3] * (x - xo) + damper
                    force[w] += body[7] * np.tanh(v / 0.003)
                heave = roll = pitch = 0.0
                for w in range(4):
                    heave -= force[w]
                    roll -= wheels[w, 1] * force[w]
                    pitch += wheels[w, 0] * force[w]
                    ground = (1 - at) * road[k, w] + at * road[k + 1, w]
                    rate[3 + w] = mid[10 + w]
                    rate[10 + w] = (force[w] + wheels[w, 5] * (ground - mid[3 + w])) / wheels[w, 4]
                rate[0], rate[1], rate[2] = mid[7], mid[8], mid[9]
                rate[7] = heave / body[0]
                rate[8] = (roll + moment[k, 0]) / body[1]
                rate[9] = (pitch + moment[k, 1]) / body[2]
                if stage == 0 and sub == 0:
                    for w in range(4):
                        out[k, w] = rate[7] + wheels[w, 1] * rate[8] - wheels[w, 0] * rate[9]
                        out[k, 4 + w] = rate[10 + w]
                weight = 1.0 if stage == 0 or stage == 3 else 2.0
                for i in range(14):
                    total[i] = (0.0 if stage == 0 else total[i]) + weight * rate[i]
            for i in range(14):
                z[i] += step / inner / 6.0 * total[i]


def simulate(
    car: RideCar,
    rng: np.random.Generator,
    *,
    seconds: float = 120.0,
    speed: float = 10.0,
    roughness_m: float = 0.02,
    rate_hz: float = 200.0,
    moments: tuple[float, float] = (0.0, 0.0),
) -> tuple[Array, Array]:
    """Body accelerations over the wheels and hub accelerations, (n, 4) each. roughness_m: RMS height of the ground.
    moments: RMS of slow roll and pitch moments on the body in N m."""
    n = round(seconds * rate_hz)
    way = np.arange(n) * speed / rate_hz
    road = np.zeros((n, 4))
    both = [off_road_terrain(way[-1] + car.wheelbase + 5, rng) for _ in range(2)]
    common = off_road_terrain(way[-1] + car.wheelbase + 5, rng)
    for w in range(4):
        side = both[w % 2]
        place = np.arange(len(side.height_m)) * side.step_m
        height = roughness_m * (0.7 * side.height_m + 0.7 * common.height_m)
        road[:, w] = np.interp(way - (car.wheelbase if w > 1 else 0.0), place, height)
    t = np.arange(n) / rate_hz
    slow = np.column_stack((
        moments[0] * 1.4 * np.sin(2 * np.pi * 0.31 * t) * np.sin(2 * np.pi * 0.013 * t),
        moments[1] * 1.4 * np.sin(2 * np.pi * 0.22 * t + 1) * np.sin(2 * np.pi * 0.017 * t),
    ))  # fmt: skip
    body = np.array([
        car.sprung, car.roll_inertia, car.pitch_inertia, car.extension, car.compression, car.knee_mps, car.beyond_knee,
        car.friction,
    ])  # fmt: skip
    wheels = np.zeros((4, 6))
    for w in range(4):
        front = w < 2
        wheels[w] = (
            car.behind if front else car.behind - car.wheelbase,
            (car.track / 2 if w % 2 == 0 else -car.track / 2) - car.left,
            car.spring_front if front else car.spring_rear,
            (car.bar_front if front else car.bar_rear) / car.track**2,
            (car.unsprung_front if front else car.unsprung_rear) / 2,
            car.tyre,
        )
    out = np.zeros((n, 8))
    _integrate(body, wheels, road, slow, 1 / rate_hz, 8, out)
    return out[:, :4], out[:, 4:]


def record(
    body: Array,
    hubs: Array,
    rng: np.random.Generator,
    *,
    rate_hz: float = 200.0,
    noise: float = 0.1,
    gains: float = 0.0,
    offset: float = 0.0,
    gravity: float = 0.0,
    wheels: tuple[str, ...] = WHEELS,
) -> Drive:
    """A drive with noisy accelerometers. gains: spread of each one's scale; offset: spread; gravity: added to all."""
    time_ns = (np.arange(len(body)) / rate_hz * 1e9).round().astype(np.int64)
    signals = {}
    for form, table in (("accel_z_sprung_{}", body), ("accel_z_unsprung_{}", hubs)):
        for i, w in enumerate(WHEELS):
            if w not in wheels:
                continue
            values = (1 + gains * rng.standard_normal()) * table[:, i] + gravity
            values = values + offset * rng.standard_normal() + noise * rng.standard_normal(len(table))
            signals[form.format(w)] = Signal(form.format(w), time_ns, values, "simulated")
    seconds = len(body) / rate_hz
    none = ImportRecord(
        "simulated", (Path("none"),), "", "complete", len(body), {}, (), "simulated", None, seconds, ()
    )
    return Drive(signals, none)


def vehicle_of(
    car: RideCar, spring_std: float = 0.02, rng: np.random.Generator | None = None, **extra: float
) -> Vehicle:
    """A vehicle file of the car; with `rng` its spring rates are wrong by their spread."""

    def known(value: float, std: float) -> Quantity:
        off = 0.0 if rng is None else std * value * rng.standard_normal()
        return Quantity(value + off, std * value, "test")

    quantities = {
        "spring_rate_front_npm": known(car.spring_front, spring_std),
        "spring_rate_rear_npm": known(car.spring_rear, spring_std),
        "unsprung_mass_front_kg": Quantity(car.unsprung_front, 4.0, "test"),
        "unsprung_mass_rear_kg": Quantity(car.unsprung_rear, 4.0, "test"),
        "wheelbase_m": Quantity(car.wheelbase, 0.005, "test"),
        "track_front_m": Quantity(car.track, 0.005, "test"),
        "track_rear_m": Quantity(car.track, 0.005, "test"),
        **{key: Quantity(value, 0.0, "test") for key, value in extra.items()},
    }
    return Vehicle(quantities=quantities)
