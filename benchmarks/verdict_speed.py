"""How long the verdict of half an hour takes: the estimators that reduce the log to relations, and the joint posterior over these.

    python benchmarks/verdict_speed.py [--minutes 30] [--drives 2] [--cache DIR] [--sets deflection,ins,…] [--save]

Mixed public road of random vehicles with unknown loads, logged at 100 Hz; one process, serial. Each step runs twice and the
second time counts, since the first compiles and loads. The floor is what any method has to do at least: one pass over the
log's columns (their products with each other), timed in the same run.
"""

from __future__ import annotations

import argparse
import platform
import sys
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeVar

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

from benchmarks.calibration_drives import Kept, kept_drive, median_plan, simulation_hash  # noqa: E402
from benchmarks.calibration_study import WITNESSES  # noqa: E402
from pipelines.analyze import run_estimator  # noqa: E402
from pipelines.estimators.registry import estimators  # noqa: E402
from pipelines.results import Estimate, FloatArray  # noqa: E402
from pipelines.verdict.combine import verdict_of  # noqa: E402

RESULT = ROOT / "benchmarks" / "results" / "verdict_speed.md"
LIMIT_S = 10.0
T = TypeVar("T")


@dataclass(frozen=True)
class Timed:
    """Seconds of one drive. slowest: the estimator that took longest, and its seconds."""

    text: str
    rows: int
    floor: float
    relations: float
    verdict: float
    slowest: tuple[str, float]


def second_time(work: Callable[[], T]) -> tuple[T, float]:
    """The result, and how long it took once it had run before."""
    work()
    began = time.perf_counter()
    found = work()
    return found, time.perf_counter() - began


def floor_of(kept: Kept) -> tuple[int, float]:
    """Rows of the finest table, and seconds for the products of all of a table's columns with each other."""
    assert kept.drive is not None
    columns: dict[int, list[FloatArray]] = {}
    for signal in kept.drive.signals.values():
        columns.setdefault(len(signal.values), []).append(np.nan_to_num(signal.values))
    tables = [np.column_stack(group) for group in columns.values()]
    _, seconds = second_time(lambda: [table.T @ table for table in tables])
    return max(len(table) for table in tables), seconds


def timed(kept: Kept) -> Timed:
    """All steps of one drive."""
    drive, vehicle = kept.drive, kept.vehicle()
    assert drive is not None
    results: list[Estimate] = []
    spent: dict[str, float] = {}
    for estimator in estimators():
        if estimator.name in WITNESSES:
            continue
        settings = {s.name: s.default for s in estimator.settings}

        def run(one: object = estimator, given: object = settings) -> Estimate:
            return run_estimator(one, drive, vehicle, given, 0)  # type: ignore[arg-type]

        found, spent[estimator.name] = second_time(run)
        results.append(found)
    _, verdict = second_time(lambda: verdict_of(results, vehicle))
    rows, floor = floor_of(kept)
    slowest = max(spent.items(), key=lambda pair: pair[1])
    return Timed(kept.plan.text, rows, floor, sum(spent.values()), verdict, slowest)


def table(found: Sequence[Timed]) -> str:
    """As Markdown."""
    lines = [
        "| drive | rows | one pass over the log, s | relations, s | verdict, s | both | over the floor | slowest estimator |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for t in found:
        both = t.relations + t.verdict
        lines.append(
            f"| {t.text} | {t.rows} | {t.floor:.3f} | {t.relations:.2f} | {t.verdict:.2f} | {both:.2f} | {both / t.floor:.0f} "
            f"| {t.slowest[0]} {t.slowest[1]:.2f} s |"
        )
    most = max(t.relations + t.verdict for t in found)
    return "\n".join(
        [*lines, "", f"Most: {most:.1f} s (the aim: below {LIMIT_S:g} s, relations and verdict together)."]
    )


def main() -> None:
    """Drive, time, print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--drives", type=int, default=2)
    parser.add_argument("--cache", type=Path, default=Path.home() / ".cache" / "cogest_calibration")
    parser.add_argument("--sets", default="deflection,production,ins,axle_load,struts,imu")
    parser.add_argument("--save", action="store_true")
    a = parser.parse_args()
    code = simulation_hash(ROOT)
    plans = [
        replace(median_plan(seed, sensors), minutes=a.minutes)
        for sensors in a.sets.split(",")
        for seed in range(a.drives)
    ]
    found = []
    for plan in plans:
        kept = kept_drive(plan, a.cache, code)
        if kept.drive is None:
            print(f"{plan.text}: {kept.reason}", flush=True)
            continue
        found.append(timed(kept))
        print(found[-1], flush=True)
    text = table(found)
    print(text)
    if a.save:
        heading = f"# Half an hour's verdict\n\n`python benchmarks/verdict_speed.py`, one core of {platform.processor() or platform.machine()}, Python {platform.python_version()}.\n\n"
        RESULT.write_text(f"{heading}{text}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
