"""Drives on which something is wrong: a channel's sign, unit, name or clock, a spring rate, or nothing to learn from.

python benchmarks/foreign_faults.py [--drives 2] [--first 0] [--fault NAME]

What is hoped for: no answer called identified that is more than three standard deviations off. `said` counts drives
whose results warn: the importer's repairs, estimators that give a signal up, relations or stated figures in conflict,
unknowns that ended far from what was known.
"""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import polars as pl
from foreign_logs import Case, Log, make_log
from foreign_study import JUDGED, through_the_product, warned

from pipelines.drive_results import DriveResults

Change = Callable[[Log], Log]
HEIGHTS = ("cg_height_m", "sprung_cg_height_m", "mass_kg", "cg_to_front_axle_m", "roll_inertia_kgm2")


def columns(change: Callable[[pl.DataFrame], pl.DataFrame]) -> Change:
    """A fault of the log."""
    return lambda log: replace(log, frame=change(log.frame))


def scaled(by: float, *names: str) -> Change:
    """Channels in another unit, or with the sign turned."""
    return columns(lambda f: f.with_columns([(pl.col(n) * by).alias(n) for n in names]))


def late(seconds: float, *names: str) -> Change:
    """Channels that come late."""

    def change(frame: pl.DataFrame) -> pl.DataFrame:
        time = frame["time_s"].to_numpy()
        return frame.with_columns(
            [pl.Series(n, np.interp(time - seconds, time, frame[n].to_numpy())) for n in names]
        )

    return columns(change)


def swapped(one: str, other: str) -> Change:
    """Two channels under each other's name."""
    return columns(lambda f: f.with_columns(pl.col(one).alias(other), pl.col(other).alias(one)))


def stated(key: str, by: float) -> Change:
    """A figure of the vehicle file wrong by a factor, for every key that begins so."""

    def change(log: Log) -> Log:
        def wrong(m: re.Match[str]) -> str:
            return f"{m[1]}{float(m[2]) * by:.7g}"

        head, reference = log.vehicle.split("[reference]")
        return replace(
            log, vehicle=re.sub(rf"(?m)^({key}\w* = )(\S+)$", wrong, head) + "[reference]" + reference
        )

    return change


def level_sideways(log: Log) -> Log:
    """Lateral acceleration without gravity's share, as simulators print it: by what the car rolls, from speed and yaw."""
    frame = log.frame
    turning = frame["speed_mps"].to_numpy() * frame["yaw_rate_radps"].to_numpy()
    return replace(log, frame=frame.with_columns(pl.Series("accel_y_mps2", turning)))


def zero_at_start(log: Log) -> Log:
    """Deflections zeroed on the loaded car at the log's start."""
    names = [n for n in log.frame.columns if n.startswith("suspension_deflection")]
    first = log.frame.filter(pl.col("time_s") < 2.0)
    return replace(log, frame=log.frame.with_columns([pl.col(n) - first[n].mean() for n in names]))


def axle_loads(front: float, rear: float) -> Change:
    """Axle loads off by a factor each."""
    return columns(
        lambda f: f.with_columns(pl.col("axle_load_front_n") * front, pl.col("axle_load_rear_n") * rear)
    )


DEFLECTIONS = tuple(f"suspension_deflection_{w}_m" for w in ("fl", "fr", "rl", "rr"))
STRUTS = tuple(f"suspension_force_{w}_n" for w in ("fl", "fr", "rl", "rr"))
RATES = tuple(f"{a}_rate_radps" for a in ("roll", "pitch", "yaw"))
ACCELS = tuple(f"accel_{a}_mps2" for a in "xyz")

FAULTS: dict[str, tuple[str, Change]] = {
    "none": ("deflection", lambda log: log),
    "lateral acceleration turned": ("deflection", scaled(-1, "accel_y_mps2")),
    "forward acceleration turned": ("deflection", scaled(-1, "accel_x_mps2")),
    "roll rate turned": ("deflection", scaled(-1, "roll_rate_radps")),
    "pitch rate turned": ("deflection", scaled(-1, "pitch_rate_radps")),
    "yaw rate turned": ("deflection", scaled(-1, "yaw_rate_radps")),
    "one deflection turned": ("deflection", scaled(-1, "suspension_deflection_rl_m")),
    "all deflections turned": ("deflection", scaled(-1, *DEFLECTIONS)),
    "left and right swapped": ("deflection", swapped(DEFLECTIONS[0], DEFLECTIONS[1])),
    "front and rear swapped": ("deflection", swapped(DEFLECTIONS[0], DEFLECTIONS[2])),
    "forward and lateral swapped": ("deflection", swapped("accel_x_mps2", "accel_y_mps2")),
    "accelerations in g": ("deflection", scaled(1 / 9.81, *ACCELS)),
    "rates in degrees": ("deflection", scaled(57.29578, *RATES)),
    "deflections in mm": ("deflection", scaled(1000, *DEFLECTIONS)),
    "deflections in cm": ("deflection", scaled(100, *DEFLECTIONS)),
    "speed in km/h": ("deflection", scaled(3.6, "speed_mps")),
    "pressure in bar": ("deflection", scaled(1e-5, "brake_pressure_pa")),
    "deflections 100 ms late": ("deflection", late(0.1, *DEFLECTIONS)),
    "accelerations 100 ms late": ("deflection", late(0.1, *ACCELS)),
    "pressure 100 ms late": ("all", late(0.1, "brake_pressure_pa")),
    "springs 30 % too hard": ("deflection", stated("spring_rate_", 1.3)),
    "springs 30 % too soft": ("deflection", stated("spring_rate_", 0.7)),
    "springs 30 % too hard, torques": ("all", stated("spring_rate_", 1.3)),
    "springs and bars 30 % too hard": ("all", stated("(?:spring_rate|anti_roll)_", 1.3)),
    "mass 15 % too high": ("all", stated("mass_kg", 1.15)),
    "mass twice": ("all", stated("mass_kg", 2.0)),
    "mass twice, deflections": ("deflection", stated("mass_kg", 2.0)),
    "mass twice, INS": ("ins", stated("mass_kg", 2.0)),
    "mass halved": ("all", stated("mass_kg", 0.5)),
    "one deflection dead": ("deflection", scaled(0, "suspension_deflection_fl_m")),
    "one deflection 30 % short": ("deflection", scaled(0.7, "suspension_deflection_fr_m")),
    "all deflections 30 % short": ("deflection", scaled(0.7, *DEFLECTIONS)),
    "springs of the axle, not the wheel": ("deflection", stated("spring_rate_", 2.0)),
    "track in mm": ("deflection", stated("track_", 1000)),
    "lateral acceleration without gravity": ("deflection", level_sideways),
    "the same, from an INS": ("ins", level_sideways),
    "roll in degrees": ("ins", scaled(57.29578, "roll_rad", "pitch_rad")),
    "roll turned": ("ins", scaled(-1, "roll_rad")),
    "pitch turned": ("ins", scaled(-1, "pitch_rad")),
    "roll 100 ms late": ("ins", late(0.1, "roll_rad", "pitch_rad")),
    "torque halved": ("ins", scaled(0.5, "drive_torque_nm")),
    "drive torque 20 % high": ("all", scaled(1.2, "drive_torque_nm")),
    "drive torque 30 % low": ("all", scaled(0.7, "drive_torque_nm")),
    "the engine's torque": ("all", scaled(0.1, "drive_torque_nm")),
    "pressure 30 % high": ("all", scaled(1.3, "brake_pressure_pa")),
    "axle loads 15 % high": ("axle", axle_loads(1.15, 1.15)),
    "front axle's load 15 % low": ("axle", axle_loads(0.85, 1.0)),
    "struts 15 % low": ("struts", scaled(0.85, *STRUTS)),
    "zeroed on the loaded car": ("deflection", zero_at_start),
    "the same, with torques": ("all", zero_at_start),
}  # fmt: skip


def told(log: Log, results: DriveResults) -> Sequence[tuple[str, str, float, float]]:
    """Parameter, status, error in standard deviations and in per cent."""
    found = []
    for name in JUDGED:
        p, truth = results.verdict.get(name), log.truth.get(name)
        if p is None or p.value is None or not p.std or truth is None:
            continue
        size = 1.0 if name == "cg_lateral_offset_m" else truth
        found.append((name, p.status, (p.value - truth) / p.std, 100 * (p.value - truth) / size))
    return found


def main() -> None:
    """A table, a row a fault, and every confident wrong number."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--drives", type=int, default=2)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--fault", choices=FAULTS)
    a = parser.parse_args()
    print("| fault | answers identified | beyond 3 std | worst | said |\n|---|---|---|---|---|")
    for fault, (sensors, change) in FAULTS.items():
        if a.fault not in (None, fault):
            continue
        worst, beyond, count, said = (0.0, ""), [], 0, []
        for seed in range(a.first, a.first + a.drives):
            log = change(make_log(Case("ride", "mixed", sensors, "full", seed)))
            try:
                results = through_the_product(log)
            except Exception as error:
                said.append(f"refused: {error}"[:90])
                continue
            said.append("; ".join(warned(results))[:120] or "-")
            for name, status, z, percent in told(log, results):
                if status != "identified":
                    continue
                count += 1
                if abs(z) > abs(worst[0]):
                    worst = (z, f"{name} {z:+.1f} ({percent:+.1f} %)")
                if abs(z) > 3:
                    beyond.append(name)
        print(
            f"| {fault} | {count} | {len(beyond)} {' '.join(sorted(set(beyond)))} | {worst[1]} | {' // '.join(said)} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
