"""Do the relations that estimators hand to the joint posterior say what is true, as surely as they claim? On the full plant.

python benchmarks/evidence_study.py [drives] [--seed N] [--case NAME] [--plain]

Every drive: a preset that gives as real vehicles do (`giving`; --plain: without) with a load anywhere in it, sensors with the errors of their kind, and a vehicle file wrong by its stated
spread. A relation is predicted from the plant's true figures; what the plant does not have (errors of the sensors, what
only that relation knows) counts with its spread. chi² a number is 1 where the spread is right and less where it is wider.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "pipelines")]

from true_unknowns import misfit, random_drive, true_unknowns  # noqa: E402

from benchmarks.giving import giving  # noqa: E402
from parsers.drive import Drive  # noqa: E402
from pipelines.estimators.axle_load_gls.estimator import AxleLoadGls  # noqa: E402
from pipelines.estimators.base import Estimator  # noqa: E402
from pipelines.estimators.base_excitation.companion import BaseExcitationBatch  # noqa: E402
from pipelines.estimators.brake_roll.estimator import BrakeRollBatch  # noqa: E402
from pipelines.estimators.load_balance.estimator import LoadBalance  # noqa: E402
from pipelines.estimators.load_transfer.companion import LoadTransferBatch  # noqa: E402
from pipelines.estimators.roll_map.estimator import RollMap  # noqa: E402
from pipelines.estimators.roll_pitch_plane.pitch import PitchPlane  # noqa: E402
from pipelines.estimators.roll_pitch_plane.roll import RollPlane  # noqa: E402
from pipelines.evidence import Evidence  # noqa: E402
from pipelines.simulation.logs.as_drive import drive_of  # noqa: E402
from pipelines.vehicles.vehicle import Vehicle  # noqa: E402
from pipelines.vehicles.vehicle_file import parse_vehicle  # noqa: E402

CARS = ("suv", "sedan", "van")
ROADS = ("rural", "launch_and_stop", "handling_track", "public_road", "urban")
LIVELY = ("rural", "handling_track", "double_lane_change", "off_road", "public_road")
STRAIGHT = ("straight_braking", "slalom_u_turns", "public_road", "launch_and_stop", "handling_track", "rural")
FRONT = ("axle_load_front", "tire_normal_force_fl", "suspension_force_fl")
CASES: dict[str, tuple[tuple[Callable[[], Estimator], ...], tuple[str, ...], tuple[str, ...], str, tuple[str, ...]]] = {
    "truck, rear axle": ((AxleLoadGls,), ("truck_flat", "truck_slope", "urban", "hills"), ("truck",), "axle_load", ()),
    "cars, both axles": ((AxleLoadGls,), ROADS, CARS, "everything", ()),
    "cars, rear axle": ((AxleLoadGls,), ROADS, CARS, "everything", FRONT),
    "ride": ((BaseExcitationBatch,), ("off_road", "rough_straight"), CARS, "vertical", ()),
    "braking and bends": ((BrakeRollBatch,), STRAIGHT, CARS, "ins", ()),
    "struts": ((LoadTransferBatch,), ROADS, CARS, "struts", ()),
    "planes": ((RollPlane, PitchPlane), LIVELY, CARS, "everything", ()),
    "balances, deflections": ((LoadBalance, RollMap), ROADS, CARS, "deflection", ()),
    "balances, navigation unit": ((LoadBalance, RollMap), ROADS, CARS, "ins", ()),
    "balances, truck": ((LoadBalance, RollMap), ("truck_flat", "truck_slope", "urban", "hills"), ("truck",), "axle_load", ()),
}  # fmt: skip
"""Estimators, manoeuvres, vehicles, sensor set, and signals that are left out."""


def _relations(estimators: Sequence[Estimator], drive: Drive, vehicle: Vehicle, seed: int) -> list[Evidence]:
    """Of all the estimators on one drive."""
    found: list[Evidence] = []
    for estimator in estimators:
        rng = np.random.default_rng(seed)
        found.extend(estimator.estimate(estimator.prepare(drive, {}), vehicle, {}, rng).evidence)
    return found


def main() -> None:
    """Run the drives and print a line for each relation."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("drives", type=int, nargs="?", default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--case", choices=tuple(CASES))
    parser.add_argument(
        "--plain", action="store_true", help="roll centres stay, loads stay under their wheels"
    )
    given = parser.parse_args()
    print("| case | relation | drives | numbers | chi² a number | within 95 % | largest z | mean z |")
    print("|---|---|---|---|---|---|---|---|")
    for name, (makes, manoeuvres, vehicles, sensors, left_out) in CASES.items():
        if given.case not in (None, name):
            continue
        chi: dict[str, list[float]] = defaultdict(list)
        normal: dict[str, list[float]] = defaultdict(list)
        numbers: dict[str, int] = defaultdict(int)
        for seed in range(given.seed, given.seed + given.drives):
            made = random_drive(seed, manoeuvres, vehicles, sensors, None if given.plain else giving)
            drive, vehicle = drive_of(made.log), parse_vehicle(made.sheet, Path("vehicle.toml"))
            drive = replace(drive, signals={n: s for n, s in drive.signals.items() if n not in left_out})
            truth = true_unknowns(made, vehicle)
            for relation in _relations([make() for make in makes], drive, vehicle, seed):
                off, covariance = misfit(relation, truth)
                key = f"{relation.source}: {relation.kind} by {relation.carrier}"
                chi[key].append(float(off @ np.linalg.solve(covariance, off)))
                numbers[key] += len(off)
                normal[key].extend((off / np.sqrt(np.diag(covariance))).tolist())
        for key, values in chi.items():
            z = np.array(normal[key])
            print(
                f"| {name} | {key} | {len(values)} | {numbers[key]} | {sum(values) / numbers[key]:.2f} | "
                f"{np.mean(np.abs(z) < 1.96):.2f} | {np.abs(z).max():.1f} | {z.mean():+.2f} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
