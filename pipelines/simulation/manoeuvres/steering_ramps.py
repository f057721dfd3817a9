"""Open-loop ramps of the steering wheel: slowly increasing steer, step steer."""

from __future__ import annotations

import numpy as np

from pipelines.results import FloatArray
from pipelines.simulation.manoeuvres.base import Options, Scenario, VehicleFigures
from pipelines.simulation.manoeuvres.script import STEP_S, Script, proving_ground, steered
from pipelines.simulation.records import GRAVITY

SLOW_RATE_RADPS = np.radians(13.5)
STEP_RATE_RADPS = np.radians(400.0)
RESPONSE_S = 0.25
"""How far a car's lateral acceleration is behind a slow ramp of the steering wheel: lag of tyres, yaw and roll."""
_FRICTION = 0.9


def slow_ramp_angle_rad(vehicle: VehicleFigures, lateral_mps2: float, speed_mps: float) -> float:
    """Steering-wheel angle at which the ramp of 13.5 deg/s reaches a lateral acceleration: the steady one, and the lag.

    At 0.3 g it is A of FMVSS 126, here from linear understeer instead of a test with this very vehicle.
    """
    return vehicle.steering_wheel_rad(lateral_mps2, speed_mps) + float(SLOW_RATE_RADPS) * RESPONSE_S


def ramp(angle_rad: float, rate_radps: float, hold_s: float, back_s: float) -> FloatArray:
    """Steering-wheel angles: from 0 to the angle at an even rate, held, eased back to 0. (n,) at the demand's step."""
    t = STEP_S * np.arange(1, max(round(abs(angle_rad) / rate_radps / STEP_S), 1) + 1)
    up = np.sign(angle_rad) * np.minimum(rate_radps * t, abs(angle_rad))
    x = np.linspace(0, 1, max(round(back_s / STEP_S), 2))
    back = angle_rad * 0.5 * (1 + np.cos(np.pi * x))
    return np.concatenate((up, np.full(round(hold_s / STEP_S), angle_rad), back))


def slowly_increasing_steer(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Slowly increasing steer: 13.5 deg/s at 80 km/h up to about 0.5 g.

    FMVSS 126 S7.6: constant 80 km/h, the steering wheel turned at 13.5 deg/s until the lateral acceleration is about
    0.5 g, to both sides. The angle comes from the linear understeer, so that a limit understeering car stays below it.
    """
    speed = vehicle.reachable_mps(options.speed(80 / 3.6))
    lateral = options.severity * vehicle.safe_lateral_mps2(0.5 * GRAVITY, options.grip(_FRICTION))
    angle = slow_ramp_angle_rad(vehicle, lateral, speed)

    def turns(script: Script) -> None:
        for side in options.signs():
            script.hold(3.0)
            script.steer(ramp(side * angle, float(SLOW_RATE_RADPS), 0.5, 2.0))

    script = steered(vehicle, options, _FRICTION, speed, turns, repeats=1)
    return Scenario(
        "slowly_increasing_steer",
        "Slowly increasing steer",
        "FMVSS 126 (49 CFR 571.126) S7.6",
        script.demand(),
        proving_ground(script.distance_m, _FRICTION, options, vehicle, rng),
        (
            f"up to {np.degrees(angle):.0f} deg at the steering wheel, for {lateral:.1f} m/s² if it stays linear",
        ),
    )


def step_steer(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Step steer: to 4 m/s² at 100 km/h within 0.15 s, held for 4 s.

    ISO 7401, step input: from straight running at constant speed the wheel is turned as fast as possible (200 to
    500 deg/s, 10 to 90 % within 0.15 s) to the angle of a steady 4 m/s² and held until the motion is steady; both sides.
    """
    speed = vehicle.reachable_mps(options.speed(100 / 3.6))
    lateral = options.severity * vehicle.safe_lateral_mps2(4.0, options.grip(_FRICTION))
    angle = vehicle.steering_wheel_rad(lateral, speed)
    # 10 to 90 % of an even ramp is 0.8 of its time
    rate = max(float(STEP_RATE_RADPS), 0.8 * angle / 0.15)

    def turns(script: Script) -> None:
        for side in options.signs():
            script.hold(3.0)
            script.steer(ramp(side * angle, rate, 4.0, 1.5))

    script = steered(vehicle, options, _FRICTION, speed, turns, repeats=2)
    return Scenario(
        "step_steer",
        "Step steer",
        "ISO 7401 (step input)",
        script.demand(),
        proving_ground(script.distance_m, _FRICTION, options, vehicle, rng),
        (f"{np.degrees(angle):.0f} deg at the steering wheel for {lateral:.1f} m/s²",),
    )
