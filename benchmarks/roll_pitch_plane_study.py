"""How honest are roll_plane, pitch_plane and gpc_roll_plane on whole vehicles? Bias, error and coverage on the plant.

python benchmarks/roll_pitch_plane_study.py [drives] [--seed N] [--kind roads|manoeuvres|heavy] [--plain]

Every drive: a preset that gives as real vehicles do (`giving`; --plain: without), in four of five a load anywhere in it that the vehicle file does not tell, all sensors with the errors of
their kind, and a vehicle file wrong by its stated spread. Errors of the lateral and the longitudinal place are shares of the
track and of the wheelbase.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1])]

from benchmarks.giving import giving  # noqa: E402
from pipelines.estimators.base import Estimator  # noqa: E402
from pipelines.estimators.roll_pitch_plane.pitch import PitchPlane  # noqa: E402
from pipelines.estimators.roll_pitch_plane.published import GpcRollPlane  # noqa: E402
from pipelines.estimators.roll_pitch_plane.roll import RollPlane  # noqa: E402
from pipelines.simulation.loads import Load  # noqa: E402
from pipelines.simulation.logs.as_drive import drive_of  # noqa: E402
from pipelines.simulation.logs.drive import Choice, SimulatedLog, preset, simulate_log  # noqa: E402
from pipelines.vehicles.vehicle_file import parse_vehicle  # noqa: E402

CARS = ("suv", "sedan", "van")
KINDS = {
    "roads": (("rural", "handling_track", "off_road", "launch_and_stop", "public_road"), CARS),
    "manoeuvres": (
        ("slalom", "circle_35m", "double_lane_change", "mixed_minute", "weave", "straight_braking"),
        CARS,
    ),
    "heavy": (("handling_track", "rural", "mixed_minute", "urban"), ("truck", "off_road")),
}


def simulated(seed: int, kind: str, plain: bool = False) -> SimulatedLog:
    """One random drive."""
    manoeuvres, vehicles = KINDS[kind]
    rng = np.random.default_rng([13, seed])
    vehicle = preset(vehicles[(seed // len(manoeuvres)) % len(vehicles)])
    load = Load(
        rng.uniform(0.03, 0.15) * vehicle.mass_kg, rng.uniform(0.3, 0.9) * vehicle.wheelbase_m,
        rng.uniform(-0.3, 0.3), rng.uniform(0.6, 1.6),
    )  # fmt: skip
    loads = () if rng.random() < 0.2 else (load,)
    vehicle = vehicle if plain else giving(vehicle, seed)
    return simulate_log(
        Choice(manoeuvres[seed % len(manoeuvres)], vehicle, loads, sensors="everything", seed=seed)
    )


def main() -> None:
    """Run the drives and print a line for each estimator and parameter."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("drives", type=int, nargs="?", default=60)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kind", choices=tuple(KINDS), default="roads")
    parser.add_argument(
        "--plain", action="store_true", help="roll centres stay, loads stay under their wheels"
    )
    given = parser.parse_args()
    estimators: tuple[Estimator, ...] = (RollPlane(), PitchPlane(), GpcRollPlane())
    found: dict[tuple[str, str], list[tuple[float, float, float, float]]] = defaultdict(list)
    silent: dict[tuple[str, str], int] = defaultdict(int)
    for seed in range(given.seed, given.seed + given.drives):
        made = simulated(seed, given.kind, given.plain)
        drive, vehicle = drive_of(made.log), parse_vehicle(made.sheet, Path("vehicle.toml"))
        for estimator in estimators:
            prepared = estimator.prepare(drive, {})
            result = estimator.estimate(prepared, vehicle, {}, np.random.default_rng(seed))
            for name, answer in result.parameters.items():
                truth = made.run.truth[name]
                size = {
                    "cg_lateral_offset_m": made.choice.vehicle.track_front_m,
                    "cg_to_front_axle_m": made.choice.vehicle.wheelbase_m,
                }.get(name, truth)
                key = (estimator.name, name)
                if answer.status == "not_identifiable" or answer.value is None or answer.std is None:
                    silent[key] += 1
                    continue
                inside = (
                    answer.low is not None and answer.high is not None and answer.low <= truth <= answer.high
                )
                sure = answer.status == "identified"
                found[key].append(((answer.value - truth) / size, answer.std / size, inside, sure))
    print(
        "| estimator | parameter | told | bias % | RMSE % | stated % | coverage | identified | worst error / std |"
    )
    print("|---|---|---|---|---|---|---|---|---|")
    for key in sorted({*found, *silent}):
        told = len(found[key])
        head = f"| `{key[0]}` | `{key[1]}` | {told} of {told + silent[key]} |"
        if told == 0:
            print(f"{head} – | – | – | – | – | – |")
            continue
        error, std, inside, sure = np.array(found[key], dtype=float).T
        print(
            f"{head} {100 * error.mean():+.1f} | {100 * np.sqrt(np.mean(error**2)):.1f} | "
            f"{100 * np.sqrt(np.mean(std**2)):.1f} | {inside.mean():.2f} | {100 * sure.mean():.0f} % | "
            f"{np.abs(error / std).max():.1f} |"
        )


if __name__ == "__main__":
    main()
