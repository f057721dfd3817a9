"""How good are LTM, MLTM, HFLTM and their batch companion on the full plant with strut forces? Errors over many drives.

python benchmarks/load_transfer_study.py [--drives 60] [--cross 30] [--names load_transfer_batch,…] [--plain] [--save]

Every drive: a preset that gives as real vehicles do (`giving`; --plain: without), a driver and a load of 0-11 % of its mass anywhere, one of four manoeuvres, the sensor set `struts`
with drawn errors, a vehicle file each of whose figures is wrong by its stated spread, and spring seats that move 30 kg
fl->fr and rr->rl, the other way, or nothing. Errors of the CG's place are related to wheelbase and track.
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1])]

from benchmarks.giving import giving  # noqa: E402
from pipelines.estimators.base import Estimator  # noqa: E402
from pipelines.estimators.registry import estimators  # noqa: E402
from pipelines.settings import defaults  # noqa: E402
from pipelines.simulation.loads import Load  # noqa: E402
from pipelines.simulation.logs.as_drive import drive_of  # noqa: E402
from pipelines.simulation.logs.drive import Choice, simulate_log  # noqa: E402
from pipelines.simulation.plant.vehicle import PRESETS, PlantVehicle  # noqa: E402
from pipelines.vehicles.vehicle_file import parse_vehicle  # noqa: E402

NAMES = ("load_transfer_batch", "load_transfer", "modified_load_transfer", "high_frequency_load_transfer")
MANOEUVRES = ("handling_track", "rural", "urban", "public_road")
VEHICLES = ("suv", "sedan", "van", "off_road")
SHOWN = ("mass_kg", "sprung_mass_kg", "cg_to_front_axle_m", "cg_lateral_offset_m", "corner_mass_fl_kg", "corner_mass_rr_kg",
         "roll_arm_m", "pitch_arm_m", "drag_area_m2")  # fmt: skip
RESULT = Path(__file__).parent / "results" / "load_transfer_study.md"
Row = tuple[float, float, bool, bool]


def draw_loads(vehicle: PlantVehicle, rng: np.random.Generator) -> tuple[Load, ...]:
    """A driver, and something anywhere."""
    length, height = vehicle.wheelbase_m, vehicle.wheel_radius_front_m
    driver = Load(75.0, 0.48 * length, 0.37, height + 0.42, 0.5, 0.45, 0.9)
    more = float(rng.uniform(0, 200)) * vehicle.mass_kg / 1900
    place = (rng.uniform(0.3, 1.05) * length, rng.uniform(-0.35, 0.35), rng.uniform(0.6, 1.6))
    return driver, Load(more, *(float(p) for p in place))


def one_drive(
    seed: int, methods: list[Estimator], cross: float, rows: dict[tuple[str, str], list[Row]], plain: bool
) -> None:
    """Simulate, estimate, and add a row a method and parameter: error, std, held, identified."""
    rng = np.random.default_rng([seed, 9])
    manoeuvre, name = MANOEUVRES[seed % 4], VEHICLES[seed // 4 % 4]
    vehicle = replace(PRESETS[name], cross_weight_kg=(0.0, cross, -cross)[seed % 3])
    vehicle = vehicle if plain else giving(vehicle, seed)
    made = simulate_log(Choice(manoeuvre, vehicle, draw_loads(vehicle, rng), sensors="struts", seed=seed))
    file = parse_vehicle(made.sheet, Path("simulated.toml"))
    sizes = {"cg_to_front_axle_m": vehicle.wheelbase_m, "cg_lateral_offset_m": vehicle.track_front_m}
    drive = drive_of(made.log)
    for method in methods:
        settings = defaults(method)
        found = method.estimate(method.prepare(drive, settings), file, settings, np.random.default_rng(seed))
        for key in SHOWN:
            entry, true = found.parameters[key], made.run.truth[key]
            if entry.value is None or entry.std is None or entry.low is None or entry.high is None:
                continue
            size = sizes.get(key, abs(true))
            held = entry.low <= true <= entry.high
            rows[method.name, key].append(
                ((entry.value - true) / size, entry.std / size, held, entry.status == "identified")
            )


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--drives", type=int, default=60)
    parser.add_argument("--cross", type=float, default=30.0)
    parser.add_argument("--names", default=",".join(NAMES))
    parser.add_argument(
        "--plain", action="store_true", help="roll centres stay, loads stay under their wheels"
    )
    parser.add_argument("--save", action="store_true")
    given = parser.parse_args()
    wanted = given.names.split(",")
    methods = [e for e in estimators() if e.name in wanted]
    rows: dict[tuple[str, str], list[Row]] = defaultdict(list)
    for seed in range(given.drives):
        one_drive(seed, methods, given.cross, rows, given.plain)
    lines = [
        f"{given.drives} drives{' of plain presets' if given.plain else ''}, diagonal shift 0, +{given.cross:g} and -{given.cross:g} kg; % of the truth, place: of wheelbase or track",
        "",
        "| method | parameter | given | bias | RMSE | worst | median std | coverage | identified |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for name in wanted:
        for key in SHOWN:
            part = np.array(rows[name, key], dtype=float)
            if not len(part):
                continue
            error = 100 * part[:, 0]
            lines.append(
                f"| {name} | {key} | {len(part)} | {error.mean():+.2f} | {np.sqrt(np.mean(error**2)):.2f} | "
                f"{np.abs(error).max():.2f} | {100 * np.median(part[:, 1]):.2f} | {part[:, 2].mean():.2f} | {part[:, 3].mean():.2f} |"
            )
    text = "\n".join(lines)
    print(text)
    if given.save:
        RESULT.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
