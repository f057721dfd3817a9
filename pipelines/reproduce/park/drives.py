"""The paper's five drives as demands on the plant: two stops, the circle, the slalom with U-turns, the public road."""

from __future__ import annotations

import numpy as np

from pipelines.reproduce.park.plant import STEP_S, ParkCar, ParkDemand
from pipelines.results import FloatArray

GRAVITY = 9.80665
KMH = 1 / 3.6


def _time(seconds: float) -> FloatArray:
    return np.arange(0.0, seconds, STEP_S)


def _smooth(values: FloatArray, seconds: float) -> FloatArray:
    """A moving mean over so many seconds, ends held: what a driver's hand does to a step."""
    rows = max(1, round(seconds / STEP_S))
    padded = np.concatenate((np.full(rows, values[0]), values, np.full(rows, values[-1])))
    sums = np.concatenate(([0.0], np.cumsum(padded)))
    mean = (sums[rows:] - sums[:-rows]) / rows
    return np.asarray(mean[rows // 2 + 1 : rows // 2 + 1 + len(values)])


def braking(car: ParkCar, speed_kmh: float, deceleration_g: float, cruise_s: float = 2.7) -> ParkDemand:
    """Figs 6 and 7: a steady speed, then one stop at a steady deceleration (the paper: 7 to 9.7 s, then braking)."""
    stop_s = speed_kmh * KMH / (deceleration_g * GRAVITY)
    t = _time(cruise_s + stop_s + 0.2)
    zero = np.zeros(len(t))
    level = car.mass * deceleration_g * GRAVITY * car.wheel_radius / car.brake_gain
    pressure = level * np.clip((t - cruise_s) / 0.25, 0.0, 1.0)
    return ParkDemand(zero, np.full(len(t), speed_kmh * KMH), zero, pressure, speed_kmh * KMH)


def circle() -> ParkDemand:
    """Fig. 8: a circle of 35 m, from 0 to 50 km/h in half a minute, then 20 s at that speed."""
    t = _time(50.0)
    speed = np.minimum(0.3 + (50 * KMH - 0.3) * t / 30.0, 50 * KMH)
    zero = np.zeros(len(t))
    curvature = _smooth(np.where(t > 1.0, 1 / 35.0, 0.0), 2.0)
    return ParkDemand(curvature, speed, zero, zero, 0.5)


def slalom() -> ParkDemand:
    """Fig. 9: three slaloms from 20 to 100 km/h at up to 0.45 g, with two U-turns between them."""
    t = _time(160.0)
    speed = np.full(len(t), 20 * KMH)
    acceleration = np.zeros(len(t))
    for number, begin in enumerate((4.0, 58.0, 112.0)):
        here = (t >= begin) & (t < begin + 36.0)
        rise = np.clip((t - begin) / 28.0, 0.0, 1.0)
        top = (60, 80, 100)[number] * KMH
        speed = np.where(here, 20 * KMH + (top - 20 * KMH) * rise, speed)
        swing = 0.45 * GRAVITY * np.minimum(1.0, 0.4 + rise) * np.sin(2 * np.pi * 0.4 * (t - begin))
        # the swing ends before the foot goes on the brake
        acceleration = np.where(here & (t < begin + 30.0), swing, acceleration)
    for begin in (47.0, 101.0):
        acceleration = np.where((t >= begin) & (t < begin + 8.0), 0.35 * GRAVITY, acceleration)
    smooth_speed = _smooth(speed, 7.0)
    curvature = _smooth(acceleration, 0.3) / np.maximum(smooth_speed, 4.0) ** 2
    zero = np.zeros(len(t))
    return ParkDemand(curvature, smooth_speed, zero, zero, 20 * KMH)


def public_road(rng: np.random.Generator) -> ParkDemand:
    """Fig. 10: five minutes at 0 to 90 km/h with stops at up to 0.3 g, corners at up to 0.5 g, and a gentle slope
    around 200 s that the difference of 2-D and 3-D speed hardly shows."""
    t = _time(300.0)
    speed = np.zeros(len(t))
    acceleration = np.zeros(len(t))
    begin, level = 0.0, 30 * KMH
    while begin < 300.0:
        lasts = float(rng.uniform(12.0, 24.0))
        here = (t >= begin) & (t < begin + lasts)
        speed[here] = level
        turn = begin + float(rng.uniform(0.55, 0.75)) * lasts
        swing = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.2, 0.5)) * GRAVITY
        acceleration[(t >= turn) & (t < turn + 3.5)] = swing
        begin += lasts
        level = float(rng.uniform(20, 90)) * KMH if level < 40 * KMH else float(rng.uniform(5, 35)) * KMH
    speed = _smooth(speed, 4.0)
    curvature = _smooth(acceleration / np.maximum(speed, 6.0) ** 2, 1.5)
    grade = _smooth(np.where((t > 190.0) & (t < 215.0), 0.02, 0.0), 6.0)
    return ParkDemand(curvature, speed, grade, np.zeros(len(t)), float(speed[0]))
