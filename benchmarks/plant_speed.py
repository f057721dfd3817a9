"""The plant's speed: simulated seconds a second of one core, at the default step; the median of the runs.

python benchmarks/plant_speed.py [runs]
"""

from __future__ import annotations

import os
import statistics
import sys
import time

import numpy as np

from pipelines.simulation.plant.run import simulate
from pipelines.simulation.plant.vehicle import PRESETS
from pipelines.simulation.records import Demand, PlantRun, Road

DURATION_S = 120.0


def drive() -> tuple[Demand, Road]:
    """Two minutes with starts, stops, bends, steering, roughness and hills: every part of the plant works."""
    t = np.arange(0, DURATION_S + 0.005, 0.01)
    speed = 18 * np.clip(np.sin(2 * np.pi * t / 60 - 0.5), 0, 0.8)
    zero = np.zeros(len(t))
    s = np.arange(0, 2500, 0.1)
    rough = np.random.default_rng(1).standard_normal((2, len(s))).cumsum(axis=1) * 1e-3
    rough -= np.linspace(0, 1, len(s)) * rough[:, -1:]
    wave = np.sin(2 * np.pi * s / 200)
    grip = np.full(len(s), 0.9)
    steering = 0.2 * np.sin(2 * np.pi * 0.5 * t)
    road = Road(0.1, 0.008 * wave, 0.05 * wave, 0.02 * wave, rough[0], rough[1], grip, grip)
    return Demand(0.01, steering, speed, zero, zero), road


def main() -> None:
    """Warm the kernels, run, and print the ratio."""
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    demand, road = drive()
    vehicle = PRESETS["suv"]

    def once() -> tuple[float, PlantRun]:
        start = time.perf_counter()
        run = simulate(vehicle, demand, road)
        return time.perf_counter() - start, run

    _, run = once()
    seconds = statistics.median(once()[0] for _ in range(runs))
    simulated = float(run.time_s[-1])
    peak = np.abs(run.columns["accel_y_mps2"]).max()
    print(
        f"{simulated:.0f} s of driving (up to {peak:.1f} m/s² across) in {seconds * 1000:.0f} ms: "
        f"{simulated / seconds:.0f} times real time on one core (target: at least 200)"
    )


if __name__ == "__main__":
    main()
