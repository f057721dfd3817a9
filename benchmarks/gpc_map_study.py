"""How honest is gpc_bayesian_map on whole vehicles? Bias, error and coverage on the plant, on rough ground and on roads.

python benchmarks/gpc_map_study.py [drives] [--seed N] [--roads rough|public]

Every drive: a car preset, a load anywhere in it, accelerometers at all wheels with errors of half to twice the usual size, some
with dropouts and wild samples (on public roads among all other sensors), and a vehicle file wrong by its stated spread.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import defaultdict
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1]), str(Path(__file__).resolve().parent)]

from base_excitation_study import drive_of  # noqa: E402

from pipelines.estimators.gpc_bayesian_map.estimator import GpcBayesianMap  # noqa: E402
from pipelines.simulation.loads import Load  # noqa: E402
from pipelines.simulation.logs.drive import Choice, SimulatedLog, preset, simulate_log  # noqa: E402
from pipelines.simulation.manoeuvres.base import Options  # noqa: E402
from pipelines.vehicles.vehicle_file import parse_vehicle  # noqa: E402

CARS = ("suv", "sedan", "van")
ROADS = {"rough": ("off_road", "rough_straight"), "public": ("rural", "urban", "public_road")}
PUBLIC_S = 120.0


def simulated(seed: int, roads: str) -> SimulatedLog:
    """One random drive."""
    rng = np.random.default_rng([11, seed])
    load = Load(rng.uniform(70, 300), rng.uniform(0.8, 2.2), rng.uniform(-0.3, 0.3), rng.uniform(0.6, 1.8))
    names = ROADS[roads]
    return simulate_log(
        Choice(
            names[seed % len(names)],
            preset(CARS[(seed // len(names)) % 3]),
            (load,),
            Options(duration_s=PUBLIC_S) if roads == "public" else Options(),
            sensors="everything" if roads == "public" or seed % 5 == 0 else "vertical",
            error_scale=rng.uniform(0.5, 2),
            dropouts_per_s=0.02 * (seed % 2),
            outlier_share=1e-4,
            seed=seed,
        )
    )


def main() -> None:
    """Run the drives and print a line for each parameter."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("drives", type=int, nargs="?", default=50)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--roads", choices=tuple(ROADS), default="rough")
    given = parser.parse_args()
    found: dict[str, list[tuple[float, float, float]]] = defaultdict(list)
    silent: dict[str, int] = defaultdict(int)
    seconds = []
    estimator = GpcBayesianMap()
    for seed in range(given.seed, given.seed + given.drives):
        made = simulated(seed, given.roads)
        drive, vehicle = drive_of(made), parse_vehicle(made.sheet, Path("vehicle.toml"))
        started = time.process_time()
        prepared = estimator.prepare(drive, {})
        result = estimator.estimate(prepared, vehicle, {}, np.random.default_rng(seed))
        seconds.append(time.process_time() - started)
        words = []
        for name, answer in result.parameters.items():
            truth = made.run.truth[name]
            if answer.status == "not_identifiable" or answer.value is None or answer.std is None:
                silent[name] += 1
                continue
            inside = answer.low is not None and answer.high is not None and answer.low <= truth <= answer.high
            found[name].append(((answer.value - truth) / truth, answer.std / truth, float(inside)))
            words.append(f"{name} {100 * (answer.value / truth - 1):+.1f} ({100 * answer.std / truth:.1f})")
        explained = result.diagnostics.get("explained_share", float("nan"))
        error = result.diagnostics.get("surrogate_error", float("nan"))
        print(
            seed, made.choice.vehicle.name, made.choice.manoeuvre, f"{explained:.2f} {error:.2f} {seconds[-1]:.1f} s",
            "; ".join(words) or result.reason, flush=True,
        )  # fmt: skip
    print(f"CPU time a drive: median {np.median(seconds):.2f} s, largest {max(seconds):.2f} s")
    print("parameter: told (silent), bias, RMSE, said std, coverage, largest error in std")
    for name in sorted({*found, *silent}):
        if not found[name]:
            print(f"{name:24s}   0 ({silent[name]:2d})")
            continue
        error, std, inside = np.array(found[name]).T
        print(
            f"{name:24s} {len(error):3d} ({silent[name]:2d})  {error.mean():+.4f}  {np.sqrt(np.mean(error**2)):.4f}  "
            f"{np.sqrt(np.mean(std**2)):.4f}  {inside.mean():.2f}  {np.abs(error / std).max():.1f}"
        )


if __name__ == "__main__":
    main()
