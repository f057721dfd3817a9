"""How honest are the base-excitation estimators? Bias, error and coverage on the whole-vehicle plant.

python benchmarks/base_excitation_study.py [drives] [--seed N] [--plain]

Every drive: a car preset that gives as real vehicles do (`giving`; --plain: without), a load anywhere in it, off-road terrain or a rough straight, accelerometers at all wheels with
errors of half to twice the usual size, some with dropouts and wild samples, and a vehicle file wrong by its stated spread.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1])]

from benchmarks.giving import giving  # noqa: E402
from parsers.drive import Drive, ImportRecord, Signal  # noqa: E402
from pipelines.estimators.base_excitation.companion import BaseExcitationBatch  # noqa: E402
from pipelines.estimators.base_excitation.estimator import BaseExcitation  # noqa: E402
from pipelines.simulation.loads import Load  # noqa: E402
from pipelines.simulation.logs.drive import Choice, SimulatedLog, preset, simulate_log  # noqa: E402
from pipelines.vehicles.vehicle_file import parse_vehicle  # noqa: E402

CARS = ("suv", "sedan", "van")
ROADS = ("off_road", "rough_straight")


def simulated(seed: int, plain: bool = False) -> SimulatedLog:
    """One random drive."""
    rng = np.random.default_rng([8, seed])
    load = Load(rng.uniform(70, 300), rng.uniform(0.8, 2.2), rng.uniform(-0.3, 0.3), rng.uniform(0.6, 1.8))
    vehicle = preset(CARS[seed % 3])
    return simulate_log(
        Choice(
            ROADS[seed % 2],
            vehicle if plain else giving(vehicle, seed),
            (load,),
            sensors="vertical",
            error_scale=rng.uniform(0.5, 2),
            dropouts_per_s=0.02 * (seed % 2),
            outlier_share=1e-4,
            seed=seed,
        )
    )


def drive_of(made: SimulatedLog) -> Drive:
    """Its vertical accelerations as an importer would give them."""
    signals = {}
    for group in made.log.groups:
        for name, values in group.columns.items():
            if name.startswith("accel_z_"):
                there = np.isfinite(values)
                signals[name] = Signal(name, group.time_ns[there], values[there], "simulated")
    seconds = float(made.run.time_s[-1])
    record = ImportRecord("simulated", (), "", "complete", 0, {}, (), "simulated", None, seconds, ())
    return Drive(signals, record)


def main() -> None:
    """Run the drives and print a line for each estimator and parameter."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("drives", type=int, nargs="?", default=60)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--plain", action="store_true", help="roll centres stay, loads stay under their wheels"
    )
    given = parser.parse_args()
    found: dict[tuple[str, str], list[tuple[float, float, float]]] = defaultdict(list)
    silent: dict[tuple[str, str], int] = defaultdict(int)
    for seed in range(given.seed, given.seed + given.drives):
        made = simulated(seed, given.plain)
        drive, vehicle = drive_of(made), parse_vehicle(made.sheet, Path("vehicle.toml"))
        for estimator in (BaseExcitationBatch(), BaseExcitation()):
            prepared = estimator.prepare(drive, {})
            answers = estimator.estimate(prepared, vehicle, {}, np.random.default_rng(seed)).parameters
            for name, answer in answers.items():
                key, truth = (estimator.name, name), made.run.truth.get(name)
                if truth is None:
                    continue
                if answer.status == "not_identifiable" or answer.value is None or answer.std is None:
                    silent[key] += 1
                    continue
                # masses and dampers as shares, places in metres
                scale = 1.0 if name.endswith("_m") else truth
                inside = (
                    answer.low is not None and answer.high is not None and answer.low <= truth <= answer.high
                )
                found[key].append(((answer.value - truth) / scale, answer.std / scale, float(inside)))
    print("estimator, parameter: told (silent), bias, RMSE, said std, coverage, largest error in std")
    for key, rows in found.items():
        error, std, inside = np.array(rows).T
        print(
            f"{key[0]:22s} {key[1]:24s} {len(rows):3d} ({silent[key]:2d})  {error.mean():+.4f}  "
            f"{np.sqrt(np.mean(error**2)):.4f}  {np.sqrt(np.mean(std**2)):.4f}  {inside.mean():.2f}  {np.abs(error / std).max():.1f}"
        )


if __name__ == "__main__":
    main()
