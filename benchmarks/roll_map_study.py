"""How honest is `roll_map`? Bias, error and coverage on vehicles and drives that it was not built from.

python benchmarks/roll_map_study.py [drives] [--seed N] [--deflections] [--jobs N]

Every drive: a random vehicle, load, road, manoeuvre and set of sensor faults (benchmarks/roll_map_drives.py), estimated with four
vehicle files that know more and more, each value in them wrong by its stated standard deviation:
  a  name, body, mass, wheelbase, tracks
  b  and the roll stiffness to 5 %, roll centres to 2 cm
  c  and the load: 10 kg, 10 cm
  d  and the accelerometer's place to 3 cm, tyre rate, unsprung masses, empty roll inertia to 5 %
Then the error against the Cramér-Rao bound on a plant that equals the model (benchmarks/roll_map_bound.py).
"""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

sys.path[:0] = [str(Path(__file__).resolve().parents[1]), str(Path(__file__).resolve().parent)]

from roll_map_drives import MANOEUVRES, drive_car, random_car  # noqa: E402
from roll_map_plant import Car, truths  # noqa: E402

from parsers.drive import Drive, ImportRecord, Signal  # noqa: E402
from pipelines.estimators.roll_map.estimator import RollMap  # noqa: E402
from pipelines.results import FloatArray  # noqa: E402
from pipelines.vehicles.vehicle import Quantity, Vehicle  # noqa: E402

LEVELS = ("a", "b", "c", "d")
SETTINGS = {"draws": 40_000.0}


@dataclass(frozen=True)
class Answer:
    """One parameter of one drive at one level."""

    level: str
    kind: str
    seed: int
    name: str
    truth: float
    value: float
    std: float
    low: float
    high: float
    status: str


def _taken(motion: FloatArray, rate_hz: float, late_s: float, lag_s: float) -> tuple[FloatArray, FloatArray]:
    """Times and values of a 500 Hz column seen at a rate, after a first-order filter and a delay."""
    if lag_s > 0:
        keep = np.exp(-0.002 / lag_s)
        motion = np.asarray(lfilter([1 - keep], [1, -keep], motion - motion[0])) + motion[0]
    t = np.arange(0.0, (len(motion) - 1) / 500 - 0.1, 1 / rate_hz)
    return t, np.interp(t - late_s, np.arange(len(motion)) / 500, motion)


def _wander(n: int, rate_hz: float, per_root_s: float, rng: np.random.Generator) -> FloatArray:
    """A random walk."""
    return np.asarray(np.cumsum(rng.standard_normal(n)) * per_root_s / np.sqrt(rate_hz))


def record(car: Car, motion: dict[str, FloatArray], rng: np.random.Generator, deflections: bool) -> Drive:
    """What the logger writes: noise, drifting offsets, a mounting askew, 0.5 % scale errors, steps, rates, delays."""
    askew = np.radians(rng.normal(0, 0.8, 2))

    def scale() -> float:
        return 1 + 0.005 * float(rng.standard_normal())

    signals: dict[str, Signal] = {}

    def add(
        name: str, t: FloatArray, clean: FloatArray, noise: float, walk: float, offset: float, step: float
    ) -> None:
        rate = 1 / (t[1] - t[0])
        values = scale() * clean + noise * rng.standard_normal(len(t)) + offset * rng.standard_normal()
        values = values + _wander(len(t), rate, walk, rng)
        values = np.round(values / step) * step if step else values
        signals[name] = Signal(name, np.round(t * 1e9).astype(np.int64), values, name)

    imu_lag = rng.uniform(0, 0.006)
    sensed = motion["accel_y"] * np.cos(askew[0]) + motion["accel_z"] * np.sin(askew[0])
    add("accel_y", *_taken(sensed, 100, 0.0, imu_lag), rng.uniform(0.03, 0.12), 0.002, 0.05, 0.01)
    gyro = motion["rate"] + askew[1] * motion["yaw"]
    add("roll_rate", *_taken(gyro, 100, 0.0, imu_lag), rng.uniform(0.001, 0.005), 1e-4, 0.004, 3e-4)
    add("yaw_rate", *_taken(motion["yaw"], 100, 0.0, imu_lag), 0.003, 1e-4, 0.004, 3e-4)
    if deflections:
        for axle, letter in (("front", "f"), ("rear", "r")):
            e = motion["roll"] - motion[axle]
            for side, sign in (("l", -0.5), ("r", 0.5)):
                add(
                    f"suspension_deflection_{letter}{side}",
                    *_taken(sign * car.track * e, 100, 0.004, 0.0),
                    3e-4,
                    0,
                    2e-3,
                    1e-4,
                )
    else:
        rate = float(rng.choice([20, 50]))
        t, angle = _taken(motion["roll"] + askew[0], rate, rng.uniform(0, 0.03), rng.uniform(0, 0.03))
        add(
            "roll",
            t,
            angle,
            np.radians(rng.uniform(0.02, 0.1)),
            np.radians(0.01),
            np.radians(0.3),
            np.radians(0.01),
        )
    add("speed", *_taken(motion["speed"], 10, 0.1, 0.0), 0.03, 0.0, 0.0, 0.01)
    still = signals["speed"]
    signals["speed"] = Signal(
        "speed", still.time_ns, np.where(still.values < 0.09, 0.0, still.values), "speed"
    )
    length = len(motion["roll"]) / 500
    return Drive(
        signals,
        ImportRecord("simulated", (Path("plant"),), "0", "complete", 0, {}, (), "plant", None, length, ()),
    )


def vehicle_of(car: Car, level: str, rng: np.random.Generator) -> Vehicle:
    """A vehicle file at a level; its values miss the truth by their stated standard deviations."""

    def missed(value: float, std: float) -> Quantity:
        return Quantity(value + std * float(rng.standard_normal()), std, "vehicle file")

    base = car.ahead + car.behind
    found = {
        "mass_kg": missed(car.empty_kg, 0.02 * car.empty_kg),
        "wheelbase_m": missed(base, 0.003 * base),
        "track_front_m": missed(car.track, 0.005 * car.track),
    }
    found["track_rear_m"] = found["track_front_m"]
    stiffness = car.front.stiffness + car.rear.stiffness
    load: dict[str, Quantity] = {}
    sensors: dict[str, Quantity] = {}
    if level >= "b":
        found["roll_stiffness_nmprad"] = missed(stiffness, 0.05 * stiffness)
        found["roll_center_height_front_m"] = missed(car.front.centre, 0.02)
        found["roll_center_height_rear_m"] = missed(car.rear.centre, 0.02)
    if level >= "c":
        load = {"mass_kg": missed(car.load_kg, 10), "height_m": missed(car.load_height, 0.1)}
    if level >= "d":
        sensors = {
            "imu_above_ground_m": missed(car.imu_height, 0.03),
            "imu_behind_front_axle_m": missed(car.ahead - car.imu_ahead, 0.05),
        }
        found["cg_to_front_axle_m"] = missed(car.ahead, 0.05)
        found["tire_vertical_rate_npm"] = missed(car.tyre_npm, 0.05 * car.tyre_npm)
        found["unsprung_mass_front_kg"] = missed(car.front.kg, 0.05 * car.front.kg)
        found["unsprung_mass_rear_kg"] = missed(car.rear.kg, 0.05 * car.rear.kg)
        found["roll_inertia_kgm2"] = missed(car.empty_inertia, 0.05 * car.empty_inertia)
    return Vehicle("study", car.style, found, load, sensors, {})


def one_drive(job: tuple[int, str, bool, tuple[str, ...]]) -> list[Answer]:
    """Simulate one drive and estimate it at the levels asked for."""
    seed, kind, deflections, levels = job
    rng = np.random.default_rng([20261121, seed])
    car = random_car(rng)
    motion, damping = drive_car(car, kind, rng)
    drive = record(car, motion, rng, deflections)
    truth = truths(car, damping)
    estimator = RollMap()
    answers = []
    for level in levels:
        vehicle = vehicle_of(car, level, np.random.default_rng([seed, ord(level)]))
        prepared = estimator.prepare(drive, SETTINGS)
        estimate = estimator.estimate(prepared, vehicle, SETTINGS, np.random.default_rng([seed, 7]))
        for name, value in truth.items():
            p = estimate.parameters[name]
            v, std, low, high = (np.nan if x is None else x for x in (p.value, p.std, p.low, p.high))
            answers.append(Answer(level, kind, seed, name, value, v, std, low, high, p.status))
    return answers


def run(
    drives: int, seed: int, deflections: bool, jobs: int, levels: tuple[str, ...] = LEVELS
) -> list[Answer]:
    """Answers of `drives` drives, the manoeuvres in turn."""
    todo = [(seed + i, MANOEUVRES[i % len(MANOEUVRES)], deflections, levels) for i in range(drives)]
    if jobs == 1:
        return [answer for job in todo for answer in one_drive(job)]
    with ProcessPoolExecutor(jobs) as pool:
        return [answer for found in pool.map(one_drive, todo, chunksize=2) for answer in found]


def table(answers: list[Answer]) -> str:
    """Bias, RMSE, mean std in % of the truth; coverage of 95 %; statuses; errors beyond four std."""
    lines = [
        "| | parameter | bias % | RMSE % | std % | 95 % covers | told only | identified | weak | not | beyond 4 std |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    groups: dict[tuple[str, str], list[Answer]] = defaultdict(list)
    for answer in answers:
        groups[answer.level, answer.name].append(answer)
    for (level, name), found in sorted(groups.items(), key=lambda item: item[0][0]):
        said = [a for a in found if np.isfinite(a.value)]
        told = [a for a in said if a.status != "not_identifiable"]
        shares = [np.mean([a.status == s for a in found]) for s in ("identified", "weak", "not_identifiable")]
        if not said:
            lines.append(f"| {level} | {name} | | | | | | 0 | 0 | 1.00 | |")
            continue
        error = np.array([(a.value - a.truth) / a.truth for a in said])
        std = np.array([a.std / a.truth for a in said])
        covered = np.mean([a.low <= a.truth <= a.high for a in said])
        of_told = f"{np.mean([a.low <= a.truth <= a.high for a in told]):.2f} of {len(told)}" if told else "–"
        lines.append(
            f"| {level} | {name} | {100 * error.mean():+.1f} | {100 * np.sqrt(np.mean(error**2)):.1f} | {100 * std.mean():.1f} "
            f"| {covered:.2f} | {of_told} | {shares[0]:.2f} | {shares[1]:.2f} | {shares[2]:.2f} | {int(np.sum(np.abs(error) > 4 * std))} |"
        )
    return "\n".join(lines)


def by_manoeuvre(answers: list[Answer], level: str) -> str:
    """Coverage among the told ones, bias and ratio of RMSE to mean std by manoeuvre."""
    names = (
        "roll_gradient_degpg",
        "roll_natural_frequency_hz",
        "roll_damping_ratio",
        "roll_inertia_kgm2",
        "cg_height_m",
    )
    lines = [f"| level {level} | " + " | ".join(names) + " |", "|---|" + "---|" * len(names)]
    for kind in MANOEUVRES:
        cells = []
        for name in names:
            told = [
                a for a in answers
                if (a.level, a.kind, a.name) == (level, kind, name) and a.status != "not_identifiable"
            ]  # fmt: skip
            if not told:
                cells.append("not told")
                continue
            error = np.array([(a.value - a.truth) / a.truth for a in told])
            std = np.array([a.std / a.truth for a in told])
            inside = np.mean([a.low <= a.truth <= a.high for a in told])
            cells.append(
                f"{inside:.2f} of {len(told)}, {100 * error.mean():+.1f} %, {100 * np.sqrt(np.mean(error**2)):.1f}/{100 * std.mean():.1f}"
            )
        lines.append(f"| {kind} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main() -> None:
    """Run by hand."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("drives", type=int, nargs="?", default=60)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument(
        "--deflections", action="store_true", help="suspension deflections in place of a roll angle"
    )
    parser.add_argument("--levels", default="abcd")
    chosen = parser.parse_args()
    answers = run(chosen.drives, chosen.seed, chosen.deflections, chosen.jobs, tuple(chosen.levels))
    print(
        f"{chosen.drives} drives from seed {chosen.seed}, {'deflections' if chosen.deflections else 'roll angle'}\n"
    )
    print(table(answers))
    for level in (chosen.levels[0], chosen.levels[-1]):
        print(f"\n{by_manoeuvre(answers, level)}")


if __name__ == "__main__":
    main()
