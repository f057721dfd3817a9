"""A short drive with a little of everything: the one that the sample logs are made of."""

from __future__ import annotations

import numpy as np

from pipelines.results import FloatArray
from pipelines.simulation.manoeuvres.base import FULL_LOCK_RAD, Options, Scenario, VehicleFigures
from pipelines.simulation.manoeuvres.script import STEP_S, Script, fitted, proving_ground
from pipelines.simulation.manoeuvres.sine_with_dwell import dwell_wave
from pipelines.simulation.records import GRAVITY

SWEEP_S, SWEEP_HZ = 7.0, (0.25, 0.75)


def sweep(amplitude_rad: float) -> FloatArray:
    """A sine whose frequency rises evenly, eased in and out; (n,) at the demand's step."""
    t = STEP_S * np.arange(1, round(SWEEP_S / STEP_S) + 1)
    low, high = SWEEP_HZ
    phase = 2 * np.pi * (low * t + (high - low) * t**2 / (2 * SWEEP_S))
    return np.asarray(amplitude_rad * np.sin(phase) * np.sqrt(np.sin(np.pi * t / t[-1])))


def mixed_minute(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Three quarters of a minute with a little of everything: launch, weaving, sine with dwell, a soft and a hard stop.

    Our own. Standstill at both ends and between the stops; the lateral part at the test speed.
    """
    grip = options.grip(0.9)
    speed = vehicle.reachable_mps(options.speed(55 / 3.6))
    hard = vehicle.safe_lateral_mps2(options.severity * 4.5, grip)
    # the sweep goes a fifth beyond
    angle = min(vehicle.steering_wheel_rad(hard, speed), FULL_LOCK_RAD / 1.2)

    def write(repeats: int) -> Script:
        script = Script(vehicle, grip)
        script.rest(3.0)
        for _ in range(repeats):
            script.reach(speed, 3.2)
            script.hold(0.5)
            script.steer(options.signs()[0] * sweep(0.8 * angle))
            for side in options.signs():
                script.reach(speed + 0.3, 2.0)
                quiet = np.zeros(round(1.2 / STEP_S))
                script.coast(np.concatenate((side * dwell_wave(1.2 * angle), quiet)))
            script.brake_to_rest(min(0.25 * options.severity, 0.6 * grip) * GRAVITY, rest_s=1.5)
            script.reach(0.7 * speed, 3.0)
            script.brake_to_rest(min(0.55 * options.severity, 0.7 * grip) * GRAVITY, rest_s=2.0)
        script.rest(1.0)
        return script

    script = fitted(write, options, repeats=1)
    return Scenario(
        "mixed_minute",
        "Mixed minute",
        "",
        script.demand(),
        proving_ground(script.distance_m, 0.9, options, vehicle, rng),
        (f"steering for {hard:.1f} m/s² at {3.6 * speed:.0f} km/h",),
    )
