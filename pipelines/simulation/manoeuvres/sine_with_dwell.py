"""Sine with dwell: the steering of the stability-control test of FMVSS 126."""

from __future__ import annotations

import numpy as np

from pipelines.results import FloatArray
from pipelines.simulation.manoeuvres.base import Options, Scenario, VehicleFigures
from pipelines.simulation.manoeuvres.script import STEP_S, Script, fitted, proving_ground
from pipelines.simulation.manoeuvres.steering_ramps import slow_ramp_angle_rad
from pipelines.simulation.records import GRAVITY

FREQUENCY_HZ = 0.7
DWELL_S = 0.5
SPEED_MPS = 80 / 3.6
SCALARS = (1.5, 2.0, 2.5)
"""First amplitudes of a series, in A: the standard begins at 1.5 A and goes on in steps of 0.5 A, up to the greater of
6.5 A and 270 degrees. That needs a stability control, which the plant has not: `severity` goes further."""
_LARGEST_RAD = np.radians(300.0)


def dwell_wave(amplitude_rad: float) -> FloatArray:
    """One sine of 0.7 Hz that stays for 500 ms at its second peak; (n,) at the demand's step, first half positive.

    FMVSS 126 S7.9.1. The last row is 0 again.
    """
    t = STEP_S * np.arange(1, round((1 / FREQUENCY_HZ + DWELL_S) / STEP_S) + 1)
    second_peak = 0.75 / FREQUENCY_HZ
    # the clock of the sine stands still during the dwell
    clock = np.where(t <= second_peak, t, np.maximum(t - DWELL_S, second_peak))
    wave = amplitude_rad * np.sin(2 * np.pi * FREQUENCY_HZ * np.minimum(clock, 1 / FREQUENCY_HZ))
    wave[-1] = 0.0
    return np.asarray(wave)


def sine_with_dwell(vehicle: VehicleFigures, options: Options, rng: np.random.Generator) -> Scenario:
    """Sine with dwell, series of growing amplitude to both sides.

    FMVSS 126 S7.9: 80 km/h, coasting; the amplitude is a multiple of A, the steering-wheel angle at which a slowly
    increasing steer (S7.6) reaches 0.3 g, here by `slow_ramp_angle_rad`. One series a side; severity multiplies every
    amplitude, which is cut at 300 degrees. Each side starts from standstill.
    """
    speed = vehicle.reachable_mps(options.speed(SPEED_MPS))
    unit = slow_ramp_angle_rad(vehicle, 0.3 * GRAVITY, speed)
    amplitudes = np.minimum(unit * np.array(SCALARS) * options.severity, _LARGEST_RAD)

    def write(repeats: int) -> Script:
        script = Script(vehicle, options.grip(0.9))
        script.rest(4.0)
        for _ in range(repeats):
            for side in options.signs():
                for amplitude in amplitudes:
                    # a little faster, so that coasting brings it to the test speed
                    script.reach(speed + 0.3, 2.0)
                    script.hold(2.0)
                    quiet = np.zeros(round(0.5 / STEP_S))
                    after = np.zeros(round(2.0 / STEP_S))
                    script.coast(np.concatenate((quiet, side * dwell_wave(float(amplitude)), after)))
                script.reach(0.0, 3.0)
                script.rest(4.0)
        return script

    script = fitted(write, options, repeats=1)
    return Scenario(
        "sine_with_dwell",
        "Sine with dwell",
        "FMVSS 126 (49 CFR 571.126) S7.9",
        script.demand(),
        proving_ground(script.distance_m, 0.9, options, vehicle, rng),
        (
            f"A = {np.degrees(unit):.0f} deg at the steering wheel",
            f"amplitudes {', '.join(f'{np.degrees(a):.0f}' for a in amplitudes)} deg",
        ),
    )
