"""Rollover on the full plant: thresholds against a slow ramp until the wheels lift, coefficient, wheel lift and probability.

    python benchmarks/rollover_study.py thresholds [seeds] [first] [--plain]     bias and coverage of the thresholds of both sides
    python benchmarks/rollover_study.py drives [seeds] [first] [--plain]         coefficient, wheel lift, and the probability's calibration

Seeds below 1000 were looked at while the relation's spreads were set; the default begins beyond them.

Every seed draws a vehicle of one of the five presets that gives as real vehicles do (`giving`; --plain: without), a load anywhere on it, and a verdict: the truth with errors as large as
the verdict says (height 2 %, roll gradient 4 %, lateral offset 6 mm, mass 1 %, roll inertia 6 %). Tracks, roll centres,
spring rates and wheels are the data sheet's, with its errors. The plant shares nothing with the relation that is judged.
"""

from __future__ import annotations

import argparse
import itertools
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.giving import giving
from parsers.drive import Drive, ImportRecord, Signal
from parsers.signals import WHEELS
from pipelines.prepare.spans import runs
from pipelines.results import FloatArray, ParameterEstimate
from pipelines.rollover import assess_rollover
from pipelines.rollover.body import Body, draw_body
from pipelines.rollover.threshold import limits
from pipelines.rollover_results import Rollover
from pipelines.simulation.loads import Load, loaded, truth
from pipelines.simulation.logs.drive import Choice, SimulatedLog, default_mount, simulate_log
from pipelines.simulation.logs.vehicle import data_sheet
from pipelines.simulation.manoeuvres.base import Options, figures_of
from pipelines.simulation.plant.run import simulate
from pipelines.simulation.plant.vehicle import PRESETS, PlantVehicle
from pipelines.simulation.records import Demand, PlantRun, straight_road
from pipelines.vehicles.vehicle import Vehicle
from pipelines.vehicles.vehicle_file import parse_vehicle

NAMES = ("suv", "sedan", "van", "off_road", "truck")
ERRORS = {
    "cg_height_m": 0.02, "mass_kg": 0.01, "sprung_mass_kg": 0.01, "roll_gradient_degpg": 0.04, "roll_inertia_kgm2": 0.06,
    "cg_to_front_axle_m": 0.005,
}  # fmt: skip
OFFSET_STD = 0.006
LEAST_LIFT_S = 0.08
MANOEUVRES = ("sine_with_dwell", "slalom", "double_lane_change", "step_steer")


def figure(value: float | None) -> float:
    """A figure that must be there."""
    if value is None:
        raise ValueError("a figure is missing")
    return value


def vehicle_of(rng: np.random.Generator, seed: int | None) -> tuple[str, PlantVehicle, tuple[Load, ...]]:
    """A preset with its roll centres, springs and CG a little other, and a load. seed: of what gives; None: nothing does."""
    name = NAMES[int(rng.integers(len(NAMES)))]
    base = PRESETS[name]
    axis = float(rng.normal(0.0, 0.02))
    made = replace(
        base,
        sprung_cg_height_m=base.sprung_cg_height_m * float(rng.uniform(0.97, 1.08)),
        roll_center_height_front_m=base.roll_center_height_front_m + axis,
        roll_center_height_rear_m=base.roll_center_height_rear_m + axis,
        spring_rate_front_npm=base.spring_rate_front_npm * float(rng.uniform(0.95, 1.15)),
        spring_rate_rear_npm=base.spring_rate_rear_npm * float(rng.uniform(0.95, 1.15)),
    )
    weight = float(rng.uniform(0.0, 0.10)) * base.mass_kg
    place = Load(
        weight,
        0.5 * base.wheelbase_m,
        float(rng.uniform(-0.3, 0.3)),
        float(rng.uniform(0.6, 1.6)) * base.sprung_cg_height_m,
    )
    return name, made if seed is None else giving(made, seed), (place,)


def verdict_of(true: dict[str, float], rng: np.random.Generator) -> dict[str, ParameterEstimate]:
    """The truth with errors as large as it says."""
    found = {}
    for name, share in (*ERRORS.items(), ("cg_lateral_offset_m", 0.0)):
        std = share * abs(true[name]) or OFFSET_STD
        value = true[name] + std * float(rng.standard_normal())
        found[name] = ParameterEstimate(
            name, value, std, value - 1.96 * std, value + 1.96 * std, "identified", ""
        )
    return found


def sheet_of(vehicle: PlantVehicle, rng: np.random.Generator) -> Vehicle:
    """The data sheet with its errors."""
    return parse_vehicle(data_sheet(vehicle, default_mount(vehicle), rng), Path("vehicle.toml"))


def ramp(vehicle: PlantVehicle, loads: tuple[Load, ...], side: float) -> PlantRun:
    """Steered ever more, slowly, at 65 km/h on a road that grips as much as it takes."""
    figures, speed, seconds = figures_of(loaded(vehicle, loads)), 18.0, 60.0
    times = np.arange(round(seconds / 0.01) + 1) * 0.01
    top = 2.5 * figures.steering_wheel_rad(1.3 * figures.static_stability_factor * 9.80665, speed)
    steer = side * np.clip((times - 3) / (seconds - 3), 0, 1) * top
    zero = np.zeros(len(times))
    demand = Demand(0.01, steer, np.full(len(times), speed), zero, zero)
    return simulate(vehicle, demand, straight_road(1.3 * seconds * speed, 3.0), loads=loads, rate_hz=100.0)


def lifting_g(run: PlantRun, side: float) -> float:
    """Lateral over vertical tyre force when both wheels of the inner side are first off the road."""
    c = run.columns
    across, normal = np.zeros(len(run.time_s)), np.zeros(len(run.time_s))
    for wheel in WHEELS:
        angle = c[f"wheel_steer_{wheel}_rad"]
        across += c[f"tire_lateral_force_{wheel}_n"] * np.cos(angle) + c[
            f"tire_longitudinal_force_{wheel}_n"
        ] * np.sin(angle)
        normal += c[f"tire_normal_force_{wheel}_n"]
    inner = ("fl", "rl") if side > 0 else ("fr", "rr")
    off = np.flatnonzero(np.all([c[f"tire_normal_force_{w}_n"] <= 1.0 for w in inner], axis=0))
    return abs(float(across[off[0]] / normal[off[0]])) if len(off) else float("nan")


def thresholds(seeds: range, plain: bool) -> None:
    """Errors of the limits of both sides, in percent, and coverage of their 95 % intervals."""
    rows: dict[str, list[tuple[float, float, float]]] = {}
    for seed in seeds:
        rng = np.random.default_rng([7, seed])
        name, vehicle, loads = vehicle_of(rng, None if plain else seed)
        body = draw_body(verdict_of(truth(vehicle, loads), rng), sheet_of(vehicle, rng))
        assert isinstance(body, Body)
        table = limits(body, Vehicle())
        for side in (1.0, -1.0):
            true = lifting_g(ramp(vehicle, loads, side), side)
            if not np.isfinite(true):
                continue
            for limit in table:
                told = limit.left if side > 0 else limit.right
                value, low, high = (figure(x) for x in (told.value, told.low, told.high))
                entry = (value / true - 1, (high - low) / (2 * value), float(low <= true <= high))
                for key in (limit.name, f"{limit.name}, {name}"):
                    rows.setdefault(key, []).append(entry)
    print(f"{'limit':28s} {'n':>4s} {'bias %':>8s} {'rms %':>8s} {'half-width %':>13s} {'coverage':>9s}")
    for key in sorted(rows):
        figures = np.array(rows[key])
        error = 100 * figures[:, 0]
        print(
            f"{key:28s} {len(figures):4d} {error.mean():8.2f} {np.sqrt(np.mean(error**2)):8.2f} "
            f"{100 * figures[:, 1].mean():13.2f} {figures[:, 2].mean():9.2f}"
        )


def drive_of(simulated: SimulatedLog, without: Callable[[str], bool] = lambda _: False) -> Drive:
    """The sensors' signals as a drive."""
    signals = {}
    for group in simulated.log.groups:
        for name, values in group.columns.items():
            there = np.isfinite(values)
            if not without(name):
                signals[name] = Signal(name, group.time_ns[there], values[there], "plant", True)
    record = ImportRecord(
        "simulated",
        (Path("log"),),
        "0" * 64,
        "complete",
        0,
        {},
        (),
        "simulated",
        None,
        float(simulated.run.time_s[-1]),
        (),
    )
    return Drive(signals, record)


def true_lifts(run: PlantRun) -> dict[str, list[tuple[float, float]]]:
    """wheel -> (start, end) of true lifts of LEAST_LIFT_S or more; "left", "right": both wheels of the side."""
    off = {w: run.columns[f"tire_normal_force_{w}_n"] <= 0.0 for w in WHEELS}
    off |= {"left": off["fl"] & off["rl"], "right": off["fr"] & off["rr"]}
    step = float(run.time_s[1] - run.time_s[0])
    return {
        key: [
            (float(run.time_s[a]), float(run.time_s[b - 1]))
            for a, b in runs(rows)
            if (b - a) * step >= LEAST_LIFT_S
        ]
        for key, rows in off.items()
    }


def _score(found: Rollover, run: PlantRun) -> tuple[int, int, int, int]:
    """True lifts of single wheels, of these the detected; turn's lifts told as likely, and those of them where the wheel's
    true force stayed above 3 % of its load at rest."""
    true = true_lifts(run)
    total = hit = likely = false = 0
    told = [e for e in found.lifts if e.wheel in WHEELS]
    for wheel in WHEELS:
        mine = [(e.start_s - 0.1, e.start_s + e.duration_s + 0.1) for e in told if e.wheel == wheel]
        total += len(true[wheel])
        hit += sum(any(a < end and start < b for a, b in mine) for start, end in true[wheel])
    for event in told:
        if event.kind == "bounce" or event.probability < 0.5:
            continue
        force = run.columns[f"tire_normal_force_{event.wheel}_n"]
        rows = (run.time_s > event.start_s - 0.1) & (run.time_s < event.start_s + event.duration_s + 0.1)
        likely += 1
        false += bool(force[rows].min() > 0.03 * force[0])
    return total, hit, likely, false


def _told(found: Rollover) -> float:
    return figure(None if found.exceedance is None else found.exceedance.probability)


def drives(seeds: range, plain: bool) -> None:
    """Manoeuvres from mild to beyond the limit, with every sensor, with a navigation unit, and with CAN alone."""
    pairs: dict[str, list[tuple[float, bool]]] = {"tyre forces": [], "no tyre forces": []}
    counts, errors, slopes = np.zeros(4, dtype=int), [], []
    for seed in seeds:
        rng = np.random.default_rng([11, seed])
        _, vehicle, loads = vehicle_of(rng, None if plain else seed)
        options = Options(severity=float(rng.uniform(0.8, 3.2)), friction=float(rng.uniform(0.9, 1.5)))
        sensors = ("everything", "ins", "production")[seed % 3]
        simulated = simulate_log(
            Choice(MANOEUVRES[seed % 4], vehicle, loads, options, sensors=sensors, seed=seed)
        )
        verdict, sheet = verdict_of(dict(simulated.run.truth), rng), sheet_of(vehicle, rng)
        lifts = true_lifts(simulated.run)
        exceeded = bool(lifts["left"] or lifts["right"])
        blind = assess_rollover(
            verdict, sheet, drive_of(simulated, lambda n: n.startswith("tire_normal_force"))
        )
        pairs["no tyre forces"].append((_told(blind), exceeded))
        slow = peak_coefficient(simulated.run)
        if slow < 0.95 and blind.peak_coefficient is not None:
            value, std = figure(blind.peak_coefficient.value), figure(blind.peak_coefficient.std)
            errors.append((value / slow - 1, (value - slow) / std))
        if sensors == "everything":
            seen = assess_rollover(verdict, sheet, drive_of(simulated))
            pairs["tyre forces"].append((_told(seen), exceeded))
            counts += _score(seen, simulated.run)
            if seen.check is not None and seen.check.slope.value is not None:
                slopes.append((seen.check.slope.value, seen.check.rms, seen.check.consistent))
    calibration(pairs)
    error = np.array(errors)
    print(f"peak coefficient below 0.95, {len(error)} drives: bias {100 * error[:, 0].mean():.2f} %, rms {100 * np.sqrt(np.mean(error[:, 0] ** 2)):.2f} %, "
          f"within 1.96 std {np.mean(np.abs(error[:, 1]) < 1.96):.2f}")  # fmt: skip
    slope = np.array(slopes, dtype=np.float64)
    print(
        f"forces over accelerations, {len(slope)} drives: slope {slope[:, 0].mean():.4f} ± {slope[:, 0].std():.4f}, rms difference {slope[:, 1].mean():.4f}, consistent {slope[:, 2].mean():.2f}"
    )
    print(
        f"wheel lifts of {LEAST_LIFT_S} s or more: {counts[0]}, detected {counts[1]}; turn's lifts told as likely: {counts[2]}, "
        f"of these with more than 3 % of its load left {counts[3]}"
    )


def peak_coefficient(run: PlantRun) -> float:
    """Largest true share moved across below 3 Hz."""
    from pipelines.prepare.lowpass import lowpass

    force = {
        w: lowpass(np.asarray(run.columns[f"tire_normal_force_{w}_n"]), run.rate_hz, 3.0) for w in WHEELS
    }
    total: FloatArray = np.maximum(sum(force.values()), 1.0)
    return float(np.max(np.abs((force["fl"] + force["rl"] - force["fr"] - force["rr"]) / total)))


def calibration(pairs: dict[str, list[tuple[float, bool]]]) -> None:
    """How often the wheels lifted where a probability was told."""
    for key, told in pairs.items():
        table = np.array(told, dtype=np.float64)
        print(
            f"{key}: {len(table)} drives, both wheels of a side lifted in {int(table[:, 1].sum())}; Brier score {np.mean((table[:, 0] - table[:, 1]) ** 2):.3f}"
        )
        edges = (0.0, 0.01, 0.1, 0.5, 0.9, 0.99, 1.0001)
        for low, high in itertools.pairwise(edges):
            inside = table[(table[:, 0] >= low) & (table[:, 0] < high)]
            if len(inside):
                print(
                    f"   told {low:.2f}-{min(high, 1):.2f}: {len(inside):3d} drives, mean {inside[:, 0].mean():.3f}, lifted {inside[:, 1].mean():.3f}"
                )


def main() -> None:
    """Run the study that is asked for."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("what", nargs="?", default="thresholds", choices=("thresholds", "drives"))
    parser.add_argument("seeds", nargs="?", type=int, default=60, help="how many (default 60)")
    parser.add_argument("first", nargs="?", type=int, default=1000, help="the first of them (default 1000)")
    parser.add_argument("--plain", action="store_true", help="vehicles that do not give")
    chosen = parser.parse_args()
    study = thresholds if chosen.what == "thresholds" else drives
    study(range(chosen.first, chosen.first + chosen.seeds), chosen.plain)


if __name__ == "__main__":
    main()
