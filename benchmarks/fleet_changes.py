"""Load changes and trends of simulated vehicles: false alarms, power, recovered slopes.

python benchmarks/fleet_changes.py --cache DIR [--vehicles 6] [--drives 6] [--worn 3] [--made]

Size: drives of one load each; every pair of a vehicle is compared. Power: the same with more in the boot. Trends: dampers that
lose 15 % of their rates a year over two years, and the drives of one load as if they were as far apart (no trend).
--made: only drives that are in DIR already.
"""

from __future__ import annotations

import argparse
import math
import re
import sys
import time
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace
from datetime import timedelta
from itertools import combinations
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

from benchmarks.fleet_changes_drives import DAMPERS, SEED, Made, Wanted, drive  # noqa: E402
from benchmarks.fleet_drives import FIRST_DAY, fleet_vehicle  # noqa: E402
from parsers.errors import SettingsError  # noqa: E402
from pipelines.hierarchy.changes import CHANCE, load_changes  # noqa: E402
from pipelines.hierarchy.contrast import Contrast, compared, share_of  # noqa: E402
from pipelines.hierarchy.join import joined  # noqa: E402
from pipelines.hierarchy.trends import trends  # noqa: E402

SETS = ("deflection", "production", "ins", "struts", "axle_load", "deflection")
WORN = ("deflection", "ins", "deflection", "struts")
STEPS_KG = (15.0, 30.0, 60.0)
MORE = 2
FADE, DAYS, WORN_DRIVES = -0.15, 730.0, 12


def _drives(wanted: Sequence[Wanted], cache: Path, made_only: bool) -> list[Made]:
    found = []
    for one in wanted:
        if made_only and not (cache / f"{one.name}.pkl").exists():
            continue
        began = time.perf_counter()
        try:
            found.append(drive(one, cache))
        except SettingsError as error:
            print(error, flush=True)
            continue
        seconds = time.perf_counter() - began
        if seconds > 0.5:
            print(f"# {one.name}: {seconds:.1f} s", flush=True)
    return found


def _pairs(drives: Sequence[Made]) -> list[tuple[Made, Made, Contrast]]:
    """Every two drives of a vehicle compared, the lighter first."""
    whole = joined([d.told for d in drives])
    if whole.posterior is None:
        return []
    by_id = {d.told.drive_id: d for d in drives}
    precision = np.linalg.inv(whole.posterior.s_covariance)
    right = precision @ whole.posterior.s
    shares = []
    for row, part in enumerate(whole.posterior.parts):
        share = share_of(part, whole.posterior.mean(row))
        if share is not None:
            shares.append((by_id[part.drive_id], share))
    shares.sort(key=lambda both: (both[0].wanted.more_kg, both[0].wanted.number))
    return [(a, b, compared(x, y, precision, right)) for (a, x), (b, y) in combinations(shares, 2)]


def _size_and_power(fleet: dict[tuple[int, str], list[Made]]) -> None:
    chances: dict[tuple[str, float], list[float]] = defaultdict(list)
    for (_, sensors), drives in fleet.items():
        for a, b, contrast in _pairs(drives):
            if contrast.figures:
                chances[sensors, b.wanted.more_kg - a.wanted.more_kg].append(contrast.probability)
    kinds = dict.fromkeys(sensors for sensors, _ in chances)
    print(f"\nDetected at {100 * CHANCE:g} % by the change of the load (pairs); 0 kg: false alarms")
    steps = sorted({step for _, step in chances})
    print("| sensors | " + " | ".join(f"{step:+.0f} kg" for step in steps) + " |")
    for kind in (*kinds, "all"):
        cells = []
        for step in steps:
            found = np.array(
                [p for (k, s), ps in chances.items() if s == step and kind in (k, "all") for p in ps]
            )
            cells.append(f"{100 * np.mean(found < CHANCE):.0f} % ({len(found)})" if len(found) else "–")
        print(f"| {kind} | " + " | ".join(cells) + " |")
    same = np.array([p for (_, s), ps in chances.items() if s == 0 for p in ps])
    if len(same):
        shares = ", ".join(f"{100 * q:g} %: {100 * np.mean(same < q):.1f} %" for q in (0.01, 0.05, 0.1, 0.5))
        print(f"unchanged loads, {len(same)} pairs, share below {shares}")


def _intervals(fleet: dict[tuple[int, str], list[Made]]) -> None:
    """Differences of the joint answers against the truth, in their standard deviations."""
    print("\n| sensors | change | drives | mean z | RMS z | within 95 % | RMS error | least noticed |")
    scores: dict[tuple[str, str], list[tuple[float, float]]] = defaultdict(list)
    least: dict[str, list[float]] = defaultdict(list)
    for (_, sensors), drives in fleet.items():
        whole = joined([d.told for d in drives])
        if whole.posterior is None:
            continue
        truth = {d.told.drive_id: d.truth for d in drives}
        for change in load_changes(whole.posterior, whole.drives):
            for name, (size, std) in change.changes.items():
                true = truth[change.drive_id][name] - truth[change.before][name]
                scores[sensors, name].append((size - true, std))
            if said := re.search(r"a change of (\d+) kg", change.text):
                least[sensors].append(float(said[1]))
    for (sensors, name), found in scores.items():
        error, std = np.array(found).T
        z = error / std
        kilos = f"{np.median(least[sensors]):.0f} kg" if least[sensors] else "–"
        print(
            f"| {sensors} | {name} | {len(z)} | {z.mean():+.2f} | {math.sqrt(np.mean(z**2)):.2f} | "
            f"{100 * np.mean(np.abs(z) < 1.96):.0f} % | {math.sqrt(np.mean(error**2)):.4g} | {kilos} |"
        )


def _true_slopes(drives: Sequence[Made], fade: float) -> dict[str, float]:
    """A year, in SI: of the dampers' rates, and of the roll damping by the drives' own truth."""
    if not fade:
        return {}
    plant, _, _ = fleet_vehicle(SEED, drives[0].wanted.vehicle, drives[0].wanted.sensors)
    found = {
        f"damper_rate_{a}_nspm": fade * float(np.mean([getattr(plant, k) for k in DAMPERS if a in k]))
        for a in ("front", "rear")
    }
    years = np.array([d.wanted.day for d in drives]) / 365.25
    damping = np.array([d.truth["roll_damping_nmsprad"] for d in drives])
    return found | {"roll_damping_nmsprad": float(np.polyfit(years, damping, 1)[0])}


def _trends(fleet: dict[tuple[int, str], list[Made]], fade: float, title: str) -> None:
    print(
        f"\n{title}\n| vehicle | drives | part | true a year | found | 95 % | chance | detected | holds the truth |"
    )
    rows = []
    for (vehicle, sensors), drives in fleet.items():
        whole = joined([d.told for d in drives])
        if whole.posterior is None:
            continue
        true_slopes = _true_slopes(drives, fade)
        for trend in trends(whole.posterior, whole.drives):
            true = true_slopes.get(trend.parameter, 0.0)
            first = f"| {vehicle} {sensors} | {trend.drives} | {trend.title} | {true:+.0f} |"
            if not math.isfinite(trend.per_year):
                print(f"{first} cannot be told | – | – | – | – |")
                continue
            rows.append((trend.detected, true != 0, trend.low <= true <= trend.high))
            print(
                f"{first} {trend.per_year:+.0f} | {trend.low:+.0f} to {trend.high:+.0f} | {trend.probability:.2g} | "
                f"{'yes' if trend.detected else 'no'} | {'yes' if rows[-1][2] else 'no'} |"
            )
    if rows:
        detected, changed, held = np.array(rows).T
        print(
            f"told {len(rows)}; hold the truth {held.sum()}; detected {(detected & changed).sum()} of {changed.sum()} that "
            f"change, {(detected & ~changed).sum()} of {(~changed).sum()} that do not"
        )


def main() -> None:
    """Make what is missing, print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cache", type=Path, required=True)
    parser.add_argument("--vehicles", type=int, default=len(SETS))
    parser.add_argument("--drives", type=int, default=6)
    parser.add_argument("--worn", type=int, default=3)
    parser.add_argument("--made", action="store_true")
    chosen = parser.parse_args()
    loads: dict[tuple[int, str], list[Made]] = {}
    for vehicle in range(chosen.vehicles):
        sensors = SETS[vehicle % len(SETS)]
        wanted = [Wanted(vehicle, sensors, n, day=30.0 * n) for n in range(chosen.drives)]
        wanted += [
            Wanted(vehicle, sensors, 100 + n, more, day=30.0 * (chosen.drives + i * MORE + n))
            for i, more in enumerate(STEPS_KG)
            for n in range(MORE)
        ]
        loads[vehicle, sensors] = _drives(wanted, chosen.cache, chosen.made)
    _size_and_power(loads)
    _intervals(loads)
    worn: dict[tuple[int, str], list[Made]] = {}
    for vehicle in range(chosen.worn):
        sensors = WORN[vehicle % len(WORN)]
        days = np.linspace(0, DAYS, WORN_DRIVES)
        wanted = [
            Wanted(50 + vehicle, sensors, n, 0.0, FADE * float(day) / 365.25, float(day))
            for n, day in enumerate(days)
        ]
        worn[50 + vehicle, sensors] = _drives(wanted, chosen.cache, chosen.made)
    _trends(worn, FADE, f"Dampers that lose {-100 * FADE:g} % a year")
    still = {}
    for key, drives in loads.items():
        days = np.linspace(0, DAYS, max(len(drives), 2))
        still[key] = [
            replace(d, told=replace(d.told, start_utc=_start(float(day))))
            for d, day in zip(drives, days, strict=False)
        ]
    _trends(still, 0.0, "Nothing wears: the drives of the first tables as if over two years")


def _start(day: float) -> str:
    return (FIRST_DAY + timedelta(days=day)).isoformat()


if __name__ == "__main__":
    main()
