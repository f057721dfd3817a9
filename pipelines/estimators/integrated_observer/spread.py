"""How far the observer's answer can be off: it is run again with each quantity moved by its standard deviation.

Its own covariance knows nothing of wrong vehicle data, offsets, wheel radii or late speed, which is where its error
comes from.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from pipelines.estimators.brake_roll.data import BrakeRollData, WheelScale
from pipelines.estimators.brake_roll.speed import shifted
from pipelines.estimators.brake_roll.vehicle import BrakeRollVehicle
from pipelines.estimators.integrated_observer.core import Gates, Observed, ObserverInput, observe
from pipelines.filters.roll_adaptation import AdaptationGains
from pipelines.models.braking import LongitudinalCar
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Quantity

MODEL_ERROR = 0.05
"""Of the height: what the paper itself claims at best, and what lumping the axles with the body costs."""

UNEQUAL_TYRES = 0.06
"""By how much the normalised slip stiffness of the axles may differ: load, bent slip curves, wear."""

SUNK = 0.2 * 0.22 / (2 * 220_000.0 * 0.32)
"""Relative change of rolling radius per N of braking force: a fifth of a tyre's deflection, height over wheelbase
0.22, two tyres of 220 kN/m and 0.32 m an axle."""

OFFSETS = {"accel_x": 0.06, "accel_y": 0.07, "roll_rate": 0.002, "yaw_rate": 0.002}
"""What remains of sensor offsets, m/s² and rad/s."""


@dataclass(frozen=True)
class Setup:
    """One run of the observer: its columns, the car, the gains, the gates and where it starts."""

    data: ObserverInput
    car: LongitudinalCar
    gains: AdaptationGains | None
    gates: Gates
    start_m: float

    def run(self) -> Observed:
        """Do it."""
        return observe(self.data, self.car, self.gains, self.gates, height_m=self.start_m)


@dataclass(frozen=True)
class Spread:
    """std: of the final height in m. parts: each cause's share in m. memory: how much of the start is left (0-1)."""

    std: float
    parts: dict[str, float]
    memory: float


def _last(observed: Observed) -> float:
    height = observed.height[np.isfinite(observed.height)]
    return float(height[-1]) if len(height) else math.nan


def _relative(quantity: Quantity | None) -> float:
    return 0.0 if quantity is None or quantity.value == 0 else quantity.std / abs(quantity.value)


def _moved_gains(setup: Setup, known: BrakeRollVehicle) -> dict[str, Setup]:
    """The lateral part's quantities, each moved by one standard deviation."""
    gains = setup.gains
    if gains is None:
        return {}

    def scaled(name: str, relative: float) -> Setup:
        return replace(setup, gains=replace(gains, **{name: getattr(gains, name) * (1 + relative)}))

    return {
        "roll stiffness": scaled("stiffness_nmprad", _relative(known.stiffness)),
        "roll damping": scaled("damping_nmsprad", min(_relative(known.damping), 0.5)),
        "roll inertia": scaled("inertia_kgm2", min(_relative(known.inertia), 0.3)),
        "roll axis height": replace(setup, gains=replace(gains, centre_m=gains.centre_m + known.centre.std)),
    }


def _with_mass(setup: Setup, mass: float) -> Setup:
    car = setup.car
    return replace(setup, car=replace(car, mass_kg=mass))


def _moved_sensors(setup: Setup, raw: BrakeRollData, scale: WheelScale) -> dict[str, Setup]:
    """The sensors' remaining errors."""
    data = setup.data
    found = {
        "offset of accel_x": replace(data, f_x=data.f_x + OFFSETS["accel_x"]),
        "offset of accel_y": replace(data, f_y=data.f_y + OFFSETS["accel_y"]),
        "offset of yaw_rate": replace(data, yaw_rate=data.yaw_rate + OFFSETS["yaw_rate"]),
    }
    if data.roll_rate is not None:
        found["offset of roll_rate"] = replace(data, roll_rate=data.roll_rate + OFFSETS["roll_rate"])
    if data.front_torque is not None and data.rear_torque is not None:
        found["unequal tyres"] = replace(data, front_torque=data.front_torque * (1 + UNEQUAL_TYRES))
        found["wheel radius, front"] = replace(data, front=data.front * (1 + scale.std))
        found["wheel radius, rear"] = replace(data, rear=data.rear * (1 + scale.std))
        late = raw.true.delay_std_s if raw.true is not None else 0.05
        # load moves to the front tyres, which sink and roll on a smaller radius; the rear ones rise
        sunk = SUNK * setup.car.mass_kg * -data.f_x
        found["tyres' sinking"] = replace(data, front=data.front * (1 + sunk), rear=data.rear * (1 - sunk))
        found["delay of the speed"] = replace(data, speed=shifted(data.speed, late, data.rate_hz))
        gain = raw.true.gain_std if raw.true is not None else 0.05
        found["gain of accel_x"] = replace(data, f_x=data.f_x * (1 + gain))
    return {name: replace(setup, data=moved) for name, moved in found.items()}


def spread_of(
    setup: Setup, known: BrakeRollVehicle, raw: BrakeRollData, scale: WheelScale, prior_std: float
) -> Spread:
    """Run again with everything moved once, and from two other starts; sum the squares."""
    base = _last(setup.run())
    runs: dict[str, Setup] = {**_moved_gains(setup, known), **_moved_sensors(setup, raw, scale)}
    runs["mass"] = _with_mass(setup, setup.car.mass_kg + known.mass.std)
    data = setup.data
    if data.front_torque is not None and data.rear_torque is not None:
        if known.front is not None:
            moved = known.front.std
            car = replace(setup.car, front_m=setup.car.front_m + moved, rear_m=setup.car.rear_m - moved)
            runs["CG to front axle"] = replace(setup, car=car)
        if not raw.share_known:
            share = known.brake_front.value
            factor = 1 + known.brake_front.std / (share * (1 - share))
            runs["brake distribution"] = replace(
                setup, data=replace(data, front_torque=data.front_torque * factor)
            )
    step = 0.15
    above, below = (_last(replace(setup, start_m=setup.start_m + d).run()) for d in (step, -step))
    memory = min(max((above - below) / (2 * step), 0.0), 1.0)
    parts = {name: abs(_last(run.run()) - base) for name, run in runs.items()}
    parts["model"] = MODEL_ERROR * base
    parts["memory of the start"] = memory * prior_std
    parts["restlessness"] = _restlessness(setup.run().height, data.rate_hz)
    parts = {name: value for name, value in parts.items() if math.isfinite(value)}
    return Spread(math.sqrt(sum(v * v for v in parts.values())), parts, memory)


def _restlessness(height: FloatArray, rate_hz: float, window_s: float = 5.0) -> float:
    """Scatter of the estimate over the last third of the drive, by blocks of five seconds."""
    tail = height[len(height) * 2 // 3 :]
    tail = tail[np.isfinite(tail)]
    block = max(1, round(window_s * rate_hz))
    if len(tail) < 2 * block:
        return float(np.std(tail)) if len(tail) else 0.0
    means = tail[: len(tail) // block * block].reshape(-1, block).mean(axis=1)
    return float(np.std(means))
