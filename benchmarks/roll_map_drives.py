"""Random vehicles and drives for the plant in benchmarks/roll_map_plant.py: parameters around measured vehicles, five manoeuvres,
roads with bank and roughness by distance."""

from __future__ import annotations

import numpy as np
from roll_map_plant import RATE, Axle, Car, G, integrate
from scipy.signal import lfilter

from pipelines.results import FloatArray
from pipelines.vehicles.measured import measured_inertias, measured_vehicles


def random_car(rng: np.random.Generator) -> Car:
    """A measured vehicle (mass, height, track, body style), an inertia as measured ones scatter, a load, and
    suspension, tyres and roll centres as road vehicles have them."""
    table, scale = measured_vehicles(), measured_inertias()
    style = rng.choice(["Sedan", "Hatchback", "SUV", "Pickup", "Van", "Minivan", "Wagon", "Coupe"])
    near = np.flatnonzero((np.array(table.body) == style) & (table.mass > 850) & (table.mass < 2700))
    row = int(rng.choice(near))
    empty, height, track = float(table.mass[row]), float(table.height[row]), float(table.track[row])
    design = np.column_stack([np.ones(len(scale.mass)), np.log(scale.mass), np.log(scale.track)])
    beta, rest, *_ = np.linalg.lstsq(design, np.log(scale.roll), rcond=None)
    scatter = float(np.sqrt(rest[0] / (len(scale.mass) - 3)))
    empty_inertia = float(np.exp(beta @ (1, np.log(empty), np.log(track)) + scatter * rng.standard_normal()))
    driver = (max(50.0, 75 + 12 * rng.standard_normal()), height + 0.08)
    top = float(height / rng.uniform(0.36, 0.40))
    more = (
        (rng.uniform(0, 120), top + 0.15)
        if rng.random() < 0.25
        else (rng.uniform(0, 400), height * rng.uniform(0.7, 1.2))
    )
    load = driver[0] + more[0]
    load_height = (driver[0] * driver[1] + more[0] * more[1]) / load
    mass = empty + load
    cg = (empty * height + load * load_height) / mass
    inertia = empty_inertia + 0.1 * load
    inertia += empty * (height - cg) ** 2 + driver[0] * (driver[1] - cg) ** 2 + more[0] * (more[1] - cg) ** 2
    unsprung = empty * rng.uniform(0.08, 0.13)
    hub = rng.uniform(0.29, 0.33) + 0.04 * (empty > 1800)
    sprung = mass - unsprung
    sprung_height = (mass * cg - unsprung * hub) / sprung
    # hubs, brakes and wheels sit outside, links further in: radius of gyration of an axle's unsprung mass
    wide = rng.uniform(0.80, 0.95) * track / 2
    body = inertia - unsprung * (wide**2 + (hub - cg) ** 2) - sprung * (sprung_height - cg) ** 2
    stiff_axle = style in ("Pickup", "Van") and rng.random() < 0.7
    centres = (rng.normal(0.05, 0.03), rng.normal(0.26, 0.05) if stiff_axle else rng.normal(0.11, 0.04))
    base = 1.6 * track + 0.25
    share = rng.uniform(0.46, 0.60)
    arm = sprung_height - share * centres[0] - (1 - share) * centres[1]
    stiffness = sprung * arm * G / np.radians(rng.uniform(3.0, 7.0))
    damping = 2 * rng.uniform(0.2, 0.45) * np.sqrt(stiffness * (body + sprung * arm**2))
    tyre = rng.uniform(170e3, 240e3) * np.sqrt(mass / 1600)
    axles, slip = [], rng.uniform(0.8e-3, 3e-3)
    for part, damped, centre in zip(
        (f := rng.uniform(0.48, 0.65), 1 - f), (0.52, 0.48), centres, strict=True
    ):
        axles.append(
            Axle(
                unsprung / 2, hub, unsprung / 2 * wide**2, centre, part * stiffness, damped * damping,
                rng.uniform(0.35, 0.75), rng.uniform(0.08, 0.20) / (track / 2), rng.uniform(15, 70) * track,
                slip, tyre * track**2 / 2,
            )
        )  # fmt: skip
    grip = rng.uniform(9, 13)
    return Car(
        style, sprung, sprung_height, body, (1 - share) * base, share * base, track, axles[0], axles[1],
        rng.uniform(0.0, 6.0), mass * 1.0 * share * (1 - share) * base**2, grip, grip * rng.uniform(1.12, 1.35), tyre,
        empty, height, empty_inertia, load, load_height,
        float(np.clip(rng.normal(0.5, 0.12), 0.3, 0.8)), rng.uniform(-0.5, 0.5),
    )  # fmt: skip


MANOEUVRES = ("sine with dwell", "slalom", "double lane change", "slow circle", "country road")


CIRCLE_M = 30.0
"""Radius of the slow circle."""


def _smooth(values: FloatArray, time_s: float) -> FloatArray:
    keep = np.exp(-1 / RATE / time_s)
    return np.asarray(lfilter([1 - keep], [1, -keep], values))


def manoeuvre(kind: str, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Speed in m/s and the lateral acceleration in m/s² that the driver steers for, at 1 kHz; 4 s of standstill first."""
    lengths = {
        "sine with dwell": 34,
        "slalom": 40,
        "double lane change": 36,
        "slow circle": 75,
        "country road": 310,
    }
    t = np.arange(lengths[kind] * RATE) / RATE
    start = 8.0
    s = np.maximum(t - start, 0.0)
    speed = np.full(len(t), rng.uniform(16, 24))
    wanted = np.zeros(len(t))
    if kind == "sine with dwell":
        for i, peak in enumerate(rng.uniform(0.6, 1.0, 3) * rng.uniform(4, 7)):
            x = s - 8 * i - 1
            first, dwell = 0.75 / 0.7, 0.75 / 0.7 + 0.5
            wanted += peak * np.sin(2 * np.pi * 0.7 * x) * ((x > 0) & (x < first))
            wanted -= peak * ((x >= first) & (x < dwell))
            wanted += peak * np.sin(2 * np.pi * 0.7 * (x - 0.5)) * ((x >= dwell) & (x < dwell + 0.25 / 0.7))
        speed[:] = 22.0
    elif kind == "slalom":
        rhythm = rng.uniform(0.3, 0.55)
        phase = 2 * np.pi * rhythm * (s + rng.uniform(0.0, 0.4) * s**2 / s[-1])
        wanted = rng.uniform(2.5, 5.0) * np.sin(phase) * np.minimum(s / 3, 1)
        speed[:] = rng.uniform(10, 17)
    elif kind == "double lane change":
        for i, side in enumerate((1, -1, 1)):
            x = s - 9 * i - 1
            peak, period = side * rng.uniform(3, 6.5), rng.uniform(1.6, 2.4)
            for when, sign in ((0.0, 1), (period + 1.0, -1)):
                inside = (x > when) & (x < when + period)
                wanted += sign * peak * np.sin(2 * np.pi * (x - when) / period) * inside
    elif kind == "slow circle":
        speed = 3 + np.minimum(s / 60, 1) * (np.sqrt(rng.uniform(4, 6.5) * CIRCLE_M) - 3)
        wanted = speed**2 / CIRCLE_M * np.minimum(s / 4, 1) * rng.choice([-1, 1])
    else:
        speed = 16 + 4 * np.sin(2 * np.pi * t / 70 + rng.uniform(0, 6))
        turns = _smooth(_smooth(rng.standard_normal(len(t)), 1.2), 1.2)
        wanted = np.clip(rng.uniform(0.8, 1.6) * turns / turns.std(), -4, 4) * np.minimum(s / 3, 1)
    speed = speed * 0.5 * (1 - np.cos(np.pi * np.clip((t - 4) / 4, 0, 1)))
    return speed, _smooth(_smooth(wanted, 0.06), 0.04)


def drive_car(
    car: Car, kind: str, rng: np.random.Generator
) -> tuple[dict[str, FloatArray], tuple[float, float]]:
    """True motion at 500 Hz by name, and the equivalent linear damping of each axle over the drive: the one that
    takes as much energy from the motion as dampers and friction do."""
    speed, wanted = manoeuvre(kind, rng)
    base = car.ahead + car.behind
    weights = np.array(car.shares) * car.sprung_kg + (car.front.kg, car.rear.kg)
    stiff = weights * G * (car.grip_front, car.grip_rear)
    understeer = (weights[0] / stiff[0]) - (weights[1] / stiff[1])
    steer = wanted * (base / np.maximum(speed, 3.0) ** 2 + understeer)
    way = np.cumsum(speed) / RATE
    grid = np.arange(0.0, way[-1] + 20, 0.05)
    length = rng.uniform(30, 90) / 0.05
    keep = np.exp(-2 / length)
    # a circle's ground is the same every lap
    lap = round(2 * np.pi * CIRCLE_M / 0.05) if kind == "slow circle" else None
    bumps = np.resize(rng.standard_normal(len(grid) + 8000)[:lap], len(grid) + 8000)
    slow = lfilter([1 - keep], [1, -keep], lfilter([1 - keep], [1, -keep], bumps))
    slow = slow[8000:] / slow[8000:].std() * np.radians(rng.uniform(0.1, 0.8))
    keep = np.exp(-0.05 / 1.5)
    rough = lfilter([1 - keep], [1, -keep], np.resize(rng.standard_normal(len(grid))[:lap], len(grid)))
    rough *= np.radians(rng.uniform(0.03, 0.12)) / rough.std()
    bank = slow + rough
    front, rear = np.interp(way + base, grid, bank), np.interp(way, grid, bank)
    front, rear = _smooth(front, 0.01), _smooth(rear, 0.01)
    front[:50], rear[:50] = front[50], rear[50]
    inputs = np.column_stack(
        (speed, steer, front, rear, np.gradient(front, 1 / RATE), np.gradient(rear, 1 / RATE))
    )
    motion, damping = integrate(car, inputs)
    share = car.shares
    sway = (
        share[0] * car.front.centre * motion["front_turn"] + share[1] * car.rear.centre * motion["rear_turn"]
    )
    lateral = motion["road"] + car.imu_ahead * motion["yaw_turn"] - sway
    lateral = lateral - (car.imu_height - car.axis) * motion["turn"]
    motion["accel_y"] = lateral * np.cos(motion["roll"]) + G * np.sin(motion["roll"])
    motion["accel_z"] = G * np.cos(motion["roll"]) - lateral * np.sin(motion["roll"])
    return motion, damping
