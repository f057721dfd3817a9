"""How honest is `load_balance` (or the whole verdict) on the full plant? Bias, error and coverage over many drives.

python benchmarks/public_road_study.py [--drives 100] [--manoeuvre public_road] [--sensors deflection] [--jobs 2]
    [--minutes 10] [--presets suv,sedan,van] [--verdict [--no-witnesses]] [--pitch-center told|untold] [--wrong NAME] [--save]
    [--data sheet|measured] [--plain]

Every drive: a preset vehicle that gives as real ones do (`giving`; --plain: without), an unknown load (roof 50-250 kg, or rear, side, seats), a manoeuvre, drawn sensor errors, and a
vehicle file each of whose figures is wrong by its stated spread. The estimator knows neither the load nor the plant.
--data: a data sheet's vehicle file, or that of a measured vehicle (`benchmarks/vehicle_data.py`).
--wrong: radius (wheel radius 3 % off), askew (inertial unit turned by 2 deg more), scale (deflection sensors 2 % off, all
alike), springs (5 % off with a stated 2 %).
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1])]

from benchmarks.calibration_study import WITNESSES  # noqa: E402
from benchmarks.giving import giving  # noqa: E402
from benchmarks.vehicle_data import QUALITIES, measured  # noqa: E402
from parsers.drive import Drive, ImportRecord, Signal  # noqa: E402
from pipelines.estimators.base import Estimator  # noqa: E402
from pipelines.estimators.load_balance.estimator import LoadBalance  # noqa: E402
from pipelines.estimators.registry import estimators  # noqa: E402
from pipelines.needs import readiness  # noqa: E402
from pipelines.results import Estimate, ParameterEstimate  # noqa: E402
from pipelines.simulation.loads import Load, loaded, truth  # noqa: E402
from pipelines.simulation.logs.loads import PLACES  # noqa: E402
from pipelines.simulation.logs.vehicle import data_sheet, rolling_radii_m  # noqa: E402
from pipelines.simulation.manoeuvres.base import Options, figures_of  # noqa: E402
from pipelines.simulation.manoeuvres.registry import make_scenario  # noqa: E402
from pipelines.simulation.plant.run import simulate  # noqa: E402
from pipelines.simulation.plant.vehicle import PRESETS, PlantVehicle  # noqa: E402
from pipelines.simulation.sensors.sets import DEFAULT_MOUNT, sensor_set  # noqa: E402
from pipelines.simulation.sensors.truth import Fit  # noqa: E402
from pipelines.simulation.sensors.units import SensorLog, apply  # noqa: E402
from pipelines.vehicles.vehicle import Quantity, Vehicle  # noqa: E402
from pipelines.vehicles.vehicle_file import parse_vehicle  # noqa: E402
from pipelines.verdict.combine import combine  # noqa: E402

RESULT = Path(__file__).parent / "results" / "public_road_study.md"
SHOWN = ("mass_kg", "cg_height_m", "cg_to_front_axle_m", "cg_lateral_offset_m", "sprung_mass_kg",
         "sprung_cg_height_m", "roll_arm_m", "roll_stiffness_nmprad", "corner_mass_fl_kg", "corner_mass_rr_kg")  # fmt: skip


@dataclass(frozen=True)
class Job:
    """One drive: everything that its process needs."""

    seed: int
    manoeuvre: str
    sensors: str
    minutes: float
    preset: str
    verdict: bool
    told: bool
    wrong: str
    data: str = "sheet"
    witnesses: bool = True
    plain: bool = False

    @property
    def vehicle(self) -> PlantVehicle:
        """The preset, which gives unless it is to be plain."""
        made = PRESETS[self.preset]
        return made if self.plain else giving(made, self.seed)


@dataclass(frozen=True)
class Answer:
    """One parameter of one drive. size: what errors are related to (wheelbase, track, or the truth itself)."""

    seed: int
    name: str
    truth: float
    size: float
    value: float
    std: float
    low: float
    high: float
    status: str


def draw_loads(vehicle: PlantVehicle, rng: np.random.Generator) -> list[Load]:
    """A driver, and on top roof load in three drives of five, else rear, side or seats."""
    place = str(rng.choice(["roof", "roof", "roof", "rear", "side", "seats"]))
    kilos = float(rng.uniform(50, 250))
    return [*PLACES["seats"][1](vehicle, 75.0), *PLACES[place][1](vehicle, kilos)]


def as_drive(log: SensorLog) -> Drive:
    """A sensor log as the importer would hand it on."""
    signals = {}
    for group in log.groups:
        for name, values in group.columns.items():
            there = np.isfinite(values)
            if there.sum() > 2:
                signals[name] = Signal(name, group.time_ns[there], values[there], f"simulated: {group.name}")
    start = min(int(s.time_ns[0]) for s in signals.values())
    return Drive(
        signals, ImportRecord("simulated", (), "", "complete", 0, {}, (), "clock", None, 0.0, ()), start
    )


def vehicle_file(
    preset: PlantVehicle, job: Job, rng: np.random.Generator, reference: dict[str, float]
) -> Vehicle:
    """A data sheet of the empty vehicle, wrong by its stated spreads, and wrong on purpose where asked."""
    file = parse_vehicle(data_sheet(preset, DEFAULT_MOUNT, rng, reference=reference), Path("vehicle.toml"))
    quantities = dict(file.quantities)
    quantities.pop("pitch_center_height_m", None)
    quantities.pop("pitch_center_height_drive_m", None)
    if job.told:
        share, x, length = preset.drive_front_share, preset.sprung_cg_behind_front_axle_m, preset.wheelbase_m
        driving = share * preset.side_slope_drive_front * x
        driving -= (1 - share) * preset.side_slope_drive_rear * (length - x)
        for key, true in (
            ("pitch_center_height_m", preset.pitch_axis_height_m),
            ("pitch_center_height_drive_m", driving),
        ):
            quantities[key] = Quantity(true + 0.02 * float(rng.standard_normal()), 0.02, "vehicle file")
    if job.data == "measured":
        told = measured(replace(file, quantities=quantities), preset, np.random.default_rng([job.seed, 23]))
        quantities = dict(told.quantities)
    factors = {"radius": ("wheel_radius_m", 1.03), "springs": ("spring_rate", 1.05)}
    if job.wrong in factors:
        begin, factor = factors[job.wrong]
        quantities = {
            k: replace(q, value=q.value * factor) if k.startswith(begin) else q for k, q in quantities.items()
        }
    return replace(file, quantities=quantities)


def make_drive(job: Job) -> tuple[Drive, Vehicle]:
    """Simulate one drive and its vehicle file."""
    rng = np.random.default_rng([job.seed, 4])
    preset = job.vehicle
    loads = draw_loads(preset, rng)
    full = loaded(preset, loads)
    options = Options(duration_s=60 * job.minutes if job.minutes > 0 else None)
    scenario = make_scenario(job.manoeuvre, figures_of(full), options, rng)
    run = simulate(preset, scenario.demand, scenario.road, loads=loads)
    mount = DEFAULT_MOUNT
    if job.wrong == "askew":
        mount = replace(mount, misalignment_rad=(np.radians(2), np.radians(-2), np.radians(2)))
    sensors = sensor_set(job.sensors, mount, Fit(*rolling_radii_m(preset)))
    drive = as_drive(apply(run, sensors, rng))
    if job.wrong == "scale":
        signals = {
            n: replace(s, values=1.02 * s.values) if n.startswith("suspension_deflection") else s
            for n, s in drive.signals.items()
        }
        drive = replace(drive, signals=signals)
    return drive, vehicle_file(preset, job, rng, truth(preset, loads))


def run_one(estimator: Estimator, drive: Drive, vehicle: Vehicle, seed: int) -> Estimate:
    """One estimator as `analyze` runs it."""
    rng = np.random.default_rng(seed)
    defaults = {s.name: s.default for s in estimator.settings}
    return estimator.estimate(estimator.prepare(drive, defaults), vehicle, defaults, rng)


def run_drive(job: Job) -> list[Answer]:
    """All answers of one drive."""
    drive, vehicle = make_drive(job)
    if job.verdict:
        asked = [e for e in estimators() if job.witnesses or e.name not in WITNESSES]
        ready = [e for e in asked if readiness(e, drive.signals, vehicle).ready]
        found: dict[str, ParameterEstimate] = dict(
            combine([run_one(e, drive, vehicle, job.seed) for e in ready], vehicle)
        )
    else:
        found = dict(run_one(LoadBalance(), drive, vehicle, job.seed).parameters)
    answers = []
    preset = PRESETS[job.preset]
    sizes = {"cg_to_front_axle_m": preset.wheelbase_m, "cg_lateral_offset_m": preset.track_front_m}
    for name in SHOWN:
        p = found.get(name)
        if p is None or p.value is None or p.std is None or p.reference is None:
            continue
        assert p.low is not None
        assert p.high is not None
        size = sizes.get(name, abs(p.reference))
        answers.append(Answer(job.seed, name, p.reference, size, p.value, p.std, p.low, p.high, p.status))
    return answers


def table(answers: list[Answer]) -> str:
    """A line a parameter: bias, RMSE, mean std in per cent of its size, coverage, worst error in standard deviations."""
    rows: dict[str, list[Answer]] = defaultdict(list)
    for answer in answers:
        rows[answer.name].append(answer)
    lines = [
        "| parameter | drives | identified | bias % | RMSE % | 95th % | within 3 % | mean std % | coverage | worst error / std, identified |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for name, group in rows.items():
        error = np.array([(a.value - a.truth) / a.size for a in group])
        std = np.array([a.std / a.size for a in group])
        inside = np.array([a.low <= a.truth <= a.high for a in group])
        sure = np.array([a.status == "identified" for a in group])
        worst = float(np.max(np.abs(error / std)[sure])) if sure.any() else float("nan")
        lines.append(
            f"| {name} | {len(group)} | {sure.sum()} | {100 * error.mean():+.2f} | {100 * np.sqrt(np.mean(error**2)):.2f} "
            f"| {100 * np.quantile(np.abs(error), 0.95):.2f} | {np.mean(np.abs(error) <= 0.03):.2f} | {100 * std.mean():.2f} | {inside.mean():.2f} | {worst:.1f} |"
        )
    return "\n".join(lines)


def main() -> None:
    """Run the drives and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--drives", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--manoeuvre", default="public_road")
    parser.add_argument("--sensors", default="deflection")
    parser.add_argument("--minutes", type=float, default=0.0, help="0: the manoeuvre's own length")
    parser.add_argument("--presets", default="suv,sedan,van")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--verdict", action="store_true")
    parser.add_argument(
        "--no-witnesses",
        action="store_true",
        help="leave the published methods out, which the verdict does not use",
    )
    parser.add_argument("--pitch-center", choices=("told", "untold"), default="told")
    parser.add_argument("--data", choices=QUALITIES, default="sheet", help="the quality of the vehicle file")
    parser.add_argument("--wrong", choices=("", "radius", "askew", "scale", "springs"), default="")
    parser.add_argument(
        "--plain", action="store_true", help="roll centres stay, loads stay under their wheels"
    )
    parser.add_argument("--each", action="store_true", help="print every drive's height and mass")
    parser.add_argument("--save", action="store_true")
    a = parser.parse_args()
    presets = a.presets.split(",")
    jobs = [
        Job(seed, a.manoeuvre, a.sensors, a.minutes, presets[seed % len(presets)], a.verdict,
            a.pitch_center == "told", a.wrong, a.data, not a.no_witnesses, a.plain)
        for seed in range(a.first, a.first + a.drives)
    ]  # fmt: skip
    if a.jobs > 1:
        with ProcessPoolExecutor(a.jobs) as pool:
            found = [answer for part in pool.map(run_drive, jobs) for answer in part]
    else:
        found = [answer for job in jobs for answer in run_drive(job)]
    if a.each:
        for answer in found:
            if answer.name in ("mass_kg", "cg_height_m", "cg_to_front_axle_m", "cg_lateral_offset_m"):
                z = (answer.value - answer.truth) / answer.std
                print(f"{answer.seed:4d} {answer.name:20s} {answer.value:9.4f} ± {answer.std:.4f} truth {answer.truth:9.4f}"
                      f" z {z:+.2f} {answer.status}")  # fmt: skip
    what = "the verdict" if a.verdict else "load_balance"
    extra = f", wrong on purpose: {a.wrong}" if a.wrong else ""
    head = (f"{what}: {a.drives} drives of {a.manoeuvre}, sensors {a.sensors}, vehicles {a.presets}{' as they are' if a.plain else ' that give'}, pitch centre "
            f"{a.pitch_center}{', vehicle measured' if a.data == 'measured' else ''}{extra} (seeds from {a.first})")  # fmt: skip
    text = f"{head}\n\n{table(found)}\n"
    print(text)
    if a.save:
        with RESULT.open("a", encoding="utf-8") as file:
            file.write(text + "\n")


if __name__ == "__main__":
    main()
