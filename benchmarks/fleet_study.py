"""What does a fleet know more than a drive? Every drive's answers alone and with its vehicle's drives joined, against the truth.

python benchmarks/fleet_study.py --cache DIR [--vehicles 20] [--drives 20] [--seed 0] [--always] [--make]

Reads the drives that `benchmarks/fleet_drives.py` made (--make: makes what is missing). --always: the fleet whose vehicles have
one recorder for good.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

from benchmarks.fleet_drives import FleetDrive, kept_drive  # noqa: E402
from pipelines.hierarchy.vehicle import join_vehicle  # noqa: E402
from pipelines.results import FloatArray, ParameterEstimate  # noqa: E402

SHOWN = (
    "cg_height_m", "mass_kg", "cg_to_front_axle_m", "cg_lateral_offset_m", "roll_stiffness_nmprad", "roll_inertia_kgm2",
    "roll_center_height_m",
)  # fmt: skip
VEHICLE = {
    "empty_mass_kg": "empty_mass", "empty_cg_height_m": "empty_h", "empty_cg_to_front_axle_m": "empty_x",
    "spring_rate_front_npm": "spring_front", "spring_rate_rear_npm": "spring_rear",
    "anti_roll_stiffness_front_nmprad": "bar_front", "roll_center_height_front_m": "roll_center_front",
    "roll_center_height_rear_m": "roll_center_rear", "roll_stiffness_nmprad": "empty_roll_stiffness",
}  # fmt: skip
"""The vehicle's parameters that are true of the empty vehicle -> the truth's name."""

COUNTS = (1, 2, 5, 10, 20)


@dataclass(frozen=True)
class Pair:
    """One answer alone and joined: errors and spreads."""

    parameter: str
    sensors: str
    alone: float
    alone_std: float
    joined: float
    joined_std: float
    alone_said: bool
    joined_said: bool


def _figures(entry: ParameterEstimate | None, truth: float) -> tuple[float, float, bool] | None:
    if entry is None or entry.value is None or entry.std is None:
        return None
    return entry.value - truth, entry.std, entry.status != "not_identifiable"


def pairs_of(drives: Sequence[FleetDrive]) -> tuple[list[Pair], tuple[str, ...]]:
    """All answers of one vehicle's drives, and the join's notes."""
    known = join_vehicle(f"v{drives[0].vehicle:02d}", [d.told for d in drives])
    found = []
    for drive in drives:
        for name in SHOWN:
            alone = _figures(drive.told.verdict.get(name), drive.truth[name])
            joined = _figures(known.drives[drive.told.drive_id].get(name), drive.truth[name])
            if alone is not None and joined is not None:
                found.append(
                    Pair(name, drive.sensors, alone[0], alone[1], joined[0], joined[1], alone[2], joined[2])
                )
    return found, (*known.notes, *(note for said in known.drive_notes.values() for note in said))


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _line(label: str, pairs: Sequence[Pair]) -> str:
    a, s, j, t = (
        np.array([getattr(p, key) for p in pairs]) for key in ("alone", "alone_std", "joined", "joined_std")
    )
    middle = [float(np.median(np.abs(x))) for x in (a, j)]
    held = [float(np.mean(np.abs(x) <= 1.96 * y)) for x, y in ((a, s), (j, t))]
    return (
        f"| {label} | {len(pairs)} | {_rms(a):.4g} | {_rms(j):.4g} | {_rms(j) / _rms(a):.2f} | {middle[0]:.4g} | {middle[1]:.4g} | "
        f"{middle[1] / middle[0]:.2f} | {held[0]:.2f} | {held[1]:.2f} | {np.mean(j / t):+.2f} | {_rms(j / t):.2f} |"
    )


HEAD = (
    "| | answers | RMSE alone | RMSE joined | ratio | median alone | median joined | ratio | 95 % holds alone | 95 % holds joined | "
    "mean z joined | rms z joined |\n|---|---|---|---|---|---|---|---|---|---|---|---|"
)


def answers_table(pairs: Sequence[Pair]) -> str:
    """By parameter, and by parameter and sensor set."""
    lines = [HEAD]
    for name in SHOWN:
        mine = [p for p in pairs if p.parameter == name]
        if not mine:
            continue
        lines.append(_line(f"**{name}**", mine))
        for sensors in sorted({p.sensors for p in mine}):
            lines.append(_line(f"{name}, {sensors}", [p for p in mine if p.sensors == sensors]))
        both = [p for p in mine if p.alone_said]
        if both:
            lines.append(_line(f"{name}, where the drive alone says more than was known", both))
    return "\n".join(lines)


def _typical(values: Sequence[float]) -> str:
    return f"{np.median(values):.2f}" if values else "-"


def vehicle_table(fleet: Sequence[Sequence[FleetDrive]]) -> str:
    """Spread of the vehicle's parameters over what was known, and how honest it is, against the number of drives."""
    most = max(len(drives) for drives in fleet)
    counts = [c for c in COUNTS if c <= most]
    heads = "".join(f" {c} drives | rms z | 95 % holds |" for c in counts)
    lines = [f"| spread over that before, median |{heads}", "|---|" + "---|---|---|" * len(counts)]
    ratio: dict[tuple[str, int], list[float]] = {}
    z: dict[tuple[str, int], list[float]] = {}
    for drives in fleet:
        for count in counts:
            known = join_vehicle("v", [d.told for d in drives[:count]])
            for name, true in VEHICLE.items():
                answer = known.vehicle.get(name)
                if answer is None or answer.estimate.prior is None:
                    continue
                estimate = answer.estimate
                assert estimate.value is not None
                assert estimate.std is not None
                ratio.setdefault((name, count), []).append(estimate.std / answer.estimate.prior.std)
                error = estimate.value - drives[0].truth[f"vehicle:{true}"]
                z.setdefault((name, count), []).append(error / estimate.std)
    for name in VEHICLE:
        cells = []
        for count in counts:
            away = np.array(z.get((name, count), [np.nan]))
            cells.append(
                f" {_typical(ratio.get((name, count), []))} | {_rms(away):.2f} | {np.mean(np.abs(away) <= 1.96):.2f} |"
            )
        lines.append(f"| {name} |" + "".join(cells))
    return "\n".join(lines)


def read_fleet(chosen: argparse.Namespace, say: Callable[[str], None]) -> list[list[FleetDrive]]:
    """The drives that are there, by vehicle."""
    fleet = []
    for vehicle in range(chosen.vehicles):
        found = [
            kept_drive(chosen.cache, chosen.seed, vehicle, number, not chosen.always, chosen.make)
            for number in range(chosen.drives)
        ]
        there = [drive for drive in found if drive is not None]
        if there:
            fleet.append(there)
    say(f"{len(fleet)} vehicles, {sum(map(len, fleet))} drives")
    return fleet


def main() -> None:
    """Read or make the fleet, print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cache", type=Path, required=True)
    parser.add_argument("--vehicles", type=int, default=20)
    parser.add_argument("--drives", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--always", action="store_true")
    parser.add_argument("--make", action="store_true")
    chosen = parser.parse_args()
    fleet = read_fleet(chosen, print)
    pairs: list[Pair] = []
    for drives in fleet:
        found, notes = pairs_of(drives)
        pairs += found
        for note in notes:
            print(f"vehicle {drives[0].vehicle}: {note}")
    print()
    print(answers_table(pairs))
    print()
    print(vehicle_table(fleet))


if __name__ == "__main__":
    main()
