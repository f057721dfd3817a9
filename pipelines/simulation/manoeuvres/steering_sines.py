"""Open-loop sines of the steering wheel: the sweep of a frequency response, the on-centre weave."""

from __future__ import annotations

import numpy as np

from pipelines.results import FloatArray
from pipelines.simulation.manoeuvres.base import Options, Scenario, VehicleFigures
from pipelines.simulation.manoeuvres.script import STEP_S, Script, proving_ground, steered

SWEEP_HZ = (0.2, 3.0)
SWEEP_S = 50.0
WEAVE_HZ = 0.2
_FRICTION = 0.9


def sweep(amplitude_rad: float, low_hz: float, high_hz: float, seconds: float) -> FloatArray:
    """A sine whose frequency grows exponentially, eased in and out over one second; (n,) at the demand's step."""
    t = STEP_S * np.arange(1, round(seconds / STEP_S) + 1)
    growth = np.log(high_hz / low_hz) / seconds
    phase = 2 * np.pi * low_hz * (np.exp(growth * t) - 1) / growth
    return np.asarray(amplitude_rad * np.clip(np.minimum(t, t[-1] - t), 0, 1) * np.sin(phase))


def _sines(
    vehicle: VehicleFigures, options: Options, wave: FloatArray, speed: float, repeats: int
) -> Script:  # fmt: skip
    """Rest, reach the speed, the wave (its first half to the side asked for), stop, rest."""
    side = options.signs()[0]

    def turns(script: Script) -> None:
        script.hold(2.0)
        script.steer(side * wave)

    return steered(vehicle, options, _FRICTION, speed, turns, repeats)


def sine_sweep(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Sine sweep of the steering wheel, 0.2 to 3 Hz at 100 km/h.

    ISO 7401, continuous sinusoidal input: constant speed and amplitude, the amplitude being that of a steady 4 m/s²
    (held to what the vehicle stands: the yaw resonance adds to it), the frequency from 0.2 Hz up. ISO 7401 asks for
    at least 0.2 to 2 Hz; 3 Hz also covers the roll resonance of a stiff car.
    """
    speed = vehicle.reachable_mps(options.speed(100 / 3.6))
    lateral = options.severity * min(4.0, 0.8 * vehicle.safe_lateral_mps2(5.0, options.grip(_FRICTION)))
    amplitude = vehicle.steering_wheel_rad(lateral, speed)
    script = _sines(vehicle, options, sweep(amplitude, *SWEEP_HZ, SWEEP_S), speed, 1)
    return Scenario(
        "sine_sweep",
        "Sine sweep",
        "ISO 7401 (continuous sinusoidal input)",
        script.demand(),
        proving_ground(script.distance_m, _FRICTION, options, vehicle, rng),
        (f"amplitude {np.degrees(amplitude):.0f} deg at the steering wheel for {lateral:.1f} m/s²",),
    )


def weave(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """On-centre weave: 0.2 Hz at 100 km/h, 2 m/s².

    ISO 13674-1: a sine of 0.2 Hz at constant 100 km/h, with a peak lateral acceleration of 2 m/s²; ten cycles.
    """
    speed = vehicle.reachable_mps(options.speed(100 / 3.6))
    lateral = 2.0 * options.severity
    amplitude = vehicle.steering_wheel_rad(lateral, speed)
    t = STEP_S * np.arange(1, round(10 / WEAVE_HZ / STEP_S) + 1)
    wave = amplitude * np.clip(np.minimum(t, t[-1] - t), 0, 1) * np.sin(2 * np.pi * WEAVE_HZ * t)
    script = _sines(vehicle, options, np.asarray(wave), speed, 1)
    return Scenario(
        "weave",
        "On-centre weave",
        "ISO 13674-1",
        script.demand(),
        proving_ground(script.distance_m, _FRICTION, options, vehicle, rng),
        (f"amplitude {np.degrees(amplitude):.1f} deg at the steering wheel for {lateral:.1f} m/s²",),
    )
