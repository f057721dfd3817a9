"""`cogest batch` at scale: two workers against one, what scheduling costs, memory over many drives, an unchanged batch.

    python benchmarks/batch_scale.py [--mode short|long] [--drives N] [--rounds N] [--only speed,many] [--save] [--work DIR]

short: 16 drives, 2 rounds, then 48 drives (a quarter of an hour on two cores). long: 40 drives, 5 rounds, then 1 000 drives
(two hours). Drives are of one minute (`short_drives`), with their HTML reports, as a user's. Rounds are paired and interleaved:
one worker, two workers and a plain loop over the same drives in one process, each into a new store, in turn.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

from benchmarks.batch_run import Run, watched  # noqa: E402
from benchmarks.short_drives import write_short_drives  # noqa: E402

PROGRAM = Path(sys.executable).parent / "cogest"
MODES = {"short": (16, 2, 48), "long": (40, 5, 1000)}
"""Drives and rounds of the speed-up, and drives of the large batch."""

SPEED_UP, OVERHEAD, GROWTH = 1.8, 0.05, 1.10
"""What is asked for: two workers against one; share lost to scheduling; memory of the last drives against the first."""


def batch(fleet: Path, store: Path, workers: int, reports: str = "html") -> Run:
    """`cogest batch` as a user runs it. Raises RuntimeError where it fails."""
    command = [str(PROGRAM), "batch", str(fleet), "--out", str(store), "--workers", str(workers), "--json"]
    command += ["--reports", reports]
    run = watched(command, store.with_suffix(".err"))
    if run.code != 0:
        raise RuntimeError(f"exit code {run.code}: {run.errors[-2000:]}")
    return run


def plain_loop(fleet: Path, store: Path) -> None:
    """The floor: every drive in this process, one after the other, without an engine; prints its seconds as JSON."""
    from cogest_cli.version import version
    from pipelines.engines.one_core import one_core
    from pipelines.fleet.find import find_drives
    from pipelines.fleet.job_text import job_text
    from pipelines.fleet.records import Choices, Job
    from pipelines.fleet.store import open_store

    found = find_drives(str(fleet), str(store))
    open_store(str(store), create=True)
    order = sorted(found.drives, key=lambda d: (-d.size, d.name))
    began, cpu = time.perf_counter(), time.process_time()
    with one_core():
        from reports.drive_job import run

        for drive in order:
            run(job_text(Job(drive, Choices(version=version()), str(store), "", "")))
    print(json.dumps({"loop_s": time.perf_counter() - began, "cpu_s": time.process_time() - cpu}))


def floor(fleet: Path, store: Path) -> dict[str, float]:
    """`plain_loop` in a process of its own, on one core from its start as a worker is."""
    from pipelines.engines.one_core import DRAWING, ONE_CORE

    command = [sys.executable, __file__, "--loop", str(fleet), str(store)]
    environment = {**os.environ, **ONE_CORE, **DRAWING}
    done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
    told: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
    return told


def speed(work: Path, drives: int, rounds: int, say: Callable[[str], None]) -> list[str]:
    """One worker, two workers, plain loop, round by round."""
    fleet = work / "speed"
    size = sum(path.stat().st_size for path in write_short_drives(fleet, drives))
    say(f"{drives} drives of a minute, {size / 2**20:.1f} MiB")
    batch(fleet, work / "warm", 2)  # compiled kernels and fonts are kept on disk from here on
    shutil.rmtree(work / "warm")
    rows, ratios, loops, shares = [], [], [], []
    for number in range(rounds):
        runs: dict[int, Run] = {}
        for workers in ((1, 2), (2, 1))[number % 2]:
            store = work / f"store{workers}"
            runs[workers] = batch(fleet, store, workers)
            shutil.rmtree(store)
        plain = floor(fleet, work / "plain")
        shutil.rmtree(work / "plain")
        one, two = runs[1], runs[2]
        ratios.append(one.loop_s / two.loop_s)
        loops.append(one.loop_s / plain["loop_s"] - 1)
        shares.append(two.overhead(2))
        rows.append(
            f"| {number + 1} | {one.loop_s:.1f} | {two.loop_s:.1f} | {ratios[-1]:.2f} | {one.wall_s / two.wall_s:.2f} "
            f"| {100 * one.overhead(1):.1f} | {100 * shares[-1]:.1f} | {plain['loop_s']:.1f} | {100 * loops[-1]:+.1f} "
            f"| {plain['cpu_s'] / drives:.2f} | {one.cpu_s / drives:.2f} |"
        )
        say(rows[-1])
    return [
        f"## Two workers against one: {drives} drives of a minute ({size / 2**20:.1f} MiB), {rounds} rounds",
        "",
        "| round | 1 worker s | 2 workers s | ratio | whole program | idle of 1 % | idle of 2 % | plain loop s | 1 worker over loop % "
        "| CPU s a drive, loop | the program whole |",
        "|" + " --- |" * 11,
        *rows,
        "",
        f"- Two workers against one, median of the paired ratios: **{median(ratios):.2f}** (asked for: {SPEED_UP})",
        f"- Scheduling, one worker over a plain loop in one process, median: **{100 * median(loops):+.1f} %** (asked for: at most "
        f"{100 * OVERHEAD:g} %)",
        f"- Share of two workers' time without a drive, their start and the last drive's wait included, median: "
        f"**{100 * median(shares):.1f} %**",
        "",
    ]


def many(
    work: Path, drives: int, seconds: float, reports: str, workers: int, say: Callable[[str], None]
) -> list[str]:
    """One batch of many drives: time, memory; the same again unchanged; what `cogest results` takes over it."""
    fleet, store = work / "many", work / "many_store"
    size = sum(path.stat().st_size for path in write_short_drives(fleet, drives, seconds=seconds))
    say(f"{drives} drives of {seconds:g} s, {size / 2**20:.1f} MiB")
    run = batch(fleet, store, workers, reports)
    part = min(100, max(drives // 5, 1))
    skipped = 2 * workers  # a worker's first drives load what it needs
    first, last = run.held(skipped, skipped + part), run.held(drives - part, drives + 1)
    parent, worker, together = run.peak
    stored = sum(path.stat().st_size for path in store.rglob("*") if path.is_file())
    say(f"done in {run.wall_s:.0f} s; workers {first[1]:.0f} -> {last[1]:.0f} MiB")
    again = [batch(fleet, store, workers, reports) for _ in range(3)]
    shown = [_timed([str(PROGRAM), "results", str(store), "--csv"]) for _ in range(3)]
    joining = run.at("reported") - run.at("joining")
    return [
        f"## {drives} drives of {seconds:g} s in one batch, {workers} workers, --reports {reports}",
        "",
        f"- {run.done} done in {run.wall_s:.0f} s ({run.cpu_s / drives:.2f} s of CPU a drive, all told): {3600 * run.done / run.loop_s:.0f} drives an hour, {run.loop_s * workers / drives:.2f} s of a "
        f"worker a drive; share of the workers' time without a drive {100 * run.overhead(workers):.1f} %",
        f"- joining the vehicles, tables and the fleet report: {joining:.1f} s",
        f"- logs {size / drives / 1e6:.2f} MB a drive, store {stored / drives / 1e6:.2f} MB a drive",
        f"- resident memory, first {part} drives against last {part}: parent {first[0]:.0f} -> {last[0]:.0f} MiB, a worker "
        f"{first[1]:.0f} -> {last[1]:.0f} MiB (asked for: at most {GROWTH:g} times)",
        f"- most: parent {parent:.0f} MiB, a worker {worker:.0f} MiB, all together {together:.0f} MiB",
        f"- the same batch again, nothing changed: {median(r.wall_s for r in again):.1f} s in all "
        f"({median(r.at('found') for r in again):.1f} s to know that nothing is to do)",
        f"- `cogest results --csv` over it: {median(shown):.2f} s",
        "",
    ]


def _timed(command: list[str]) -> float:
    began = time.perf_counter()
    subprocess.run(command, check=True, capture_output=True)
    return time.perf_counter() - began


def main() -> None:
    """Run, print, keep if asked to."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--mode", choices=MODES, default="short")
    parser.add_argument("--drives", type=int, help="of the large batch")
    parser.add_argument("--speed-drives", type=int)
    parser.add_argument("--rounds", type=int)
    parser.add_argument("--workers", type=int, default=2, help="of the large batch")
    parser.add_argument("--seconds", type=float, default=60.0, help="of a drive of the large batch")
    parser.add_argument("--reports", default="html", help="of the large batch's drives: html, none")
    parser.add_argument("--only", default="speed,many")
    parser.add_argument("--save", action="store_true")
    parser.add_argument("--work", type=Path, help="a folder for fleets and stores; default: a temporary one")
    parser.add_argument("--loop", nargs=2, type=Path, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.loop:
        plain_loop(*asked.loop)
        return
    pair, rounds, large = MODES[asked.mode]
    lines = [
        "# `cogest batch` at scale", "",
        f"`python benchmarks/batch_scale.py --mode {asked.mode}`: {platform.machine()}, {os.cpu_count()} cores, Python "
        f"{platform.python_version()}", "",
    ]  # fmt: skip

    def say(text: str) -> None:
        print(text, file=sys.stderr, flush=True)

    with tempfile.TemporaryDirectory() as temporary:
        work = asked.work or Path(temporary)
        work.mkdir(parents=True, exist_ok=True)
        if "speed" in asked.only:
            lines += speed(work, asked.speed_drives or pair, asked.rounds or rounds, say)
        if "many" in asked.only:
            lines += many(work, asked.drives or large, asked.seconds, asked.reports, asked.workers, say)
    text = "\n".join(lines)
    print(text)
    if asked.save:
        results = ROOT / "benchmarks" / "results"
        results.mkdir(exist_ok=True)
        (results / "batch_scale.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
