"""What a drive of a batch costs: CPU seconds, bytes read and written, operations on the store, with and without its report.

    python benchmarks/drive_cost.py [--drives 16] [--save]

A batch of one-minute drives (`short_drives`) with the serial engine, in this process on one core; CPU is the process's own,
so that other programs hardly disturb it. The first drive of each format, which loads what is needed, is not counted.
"""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import mean

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

WARM = 1
"""First drives of each format that are not counted."""


class Counted:
    """A store's storage that counts what is asked of it, and the bytes that go in and out."""

    def __init__(self, inner: object, asked: Counter[str]) -> None:
        self._inner, self._asked = inner, asked

    def __getattr__(self, name: str) -> object:
        found = getattr(self._inner, name)
        if name in ("place", "parallel", "at"):
            return found

        def call(*given: object) -> object:
            if not (name == "publish" and isinstance(given[1], Mapping)):
                self._asked[name] += 1
            else:
                self._asked["publish: files"] += len(given[1])
                self._asked["bytes written"] += sum(len(content) for content in given[1].values())
            return found(*given)

        return call


def run(fleet: Path, store: Path, formats: Sequence[str]) -> None:
    """One batch in this process; prints a row for each format of logs, and operations a drive."""
    import psutil

    from cogest_cli.version import version
    from pipelines.engines.base import Limits
    from pipelines.fleet import batch as batches
    from pipelines.fleet import storage
    from pipelines.fleet import store as stores
    from pipelines.fleet.events import DriveEnded, Event
    from pipelines.fleet.find import find_drives
    from pipelines.fleet.records import Choices
    from reports.drive_job import FUNCTION

    asked: Counter[str] = Counter()
    plain = storage.storage_at
    stores.storage_at = batches.storage_at = lambda place: Counted(plain(place), asked)  # type: ignore[assignment]
    process = psutil.Process()
    rows: list[tuple[str, float, float]] = []
    counted: list[Counter[str]] = []
    last = [time.process_time(), process.io_counters().read_chars]

    def watch(event: Event) -> None:
        if isinstance(event, DriveEnded):
            assert event.status == "done", event.reason
            now = [time.process_time(), process.io_counters().read_chars]
            rows.append((event.name.rpartition(".")[2], now[0] - last[0], now[1] - last[1]))
            counted.append(Counter(asked))
            last[:] = [time.process_time(), process.io_counters().read_chars]

    found = find_drives(str(fleet), str(store))
    choices = Choices(formats=tuple(formats), version=version())
    made = batches.Batch(str(fleet), str(store), choices, "serial", limits=Limits())
    batches.run_batch(made, found, FUNCTION, watch)
    sizes = {d.name.rpartition(".")[2]: d.size for d in found.drives}
    told = ", ".join(formats) or "none"
    for form in sorted({row[0] for row in rows}):
        mine = [row for row in rows if row[0] == form][WARM:]
        print(
            f"| {form} | {told} | {mean(r[1] for r in mine):.2f} | {sizes[form] / 1e6:.2f} | {mean(r[2] for r in mine) / 1e6:.2f} |"
        )
    whole = counted[-1] - counted[WARM - 1]
    several = len(rows) - WARM
    print(
        f"  reports {told}: "
        + ", ".join(f"{name} {number / several:.4g}" for name, number in sorted(whole.items()))
    )


def main() -> None:
    """Make the fleet, run with and without reports, each in a process of its own."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--drives", type=int, default=16)
    parser.add_argument("--save", action="store_true")
    parser.add_argument("--run", nargs=3, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.run:
        run(Path(asked.run[0]), Path(asked.run[1]), tuple(filter(None, asked.run[2].split(","))))
        return
    from benchmarks.short_drives import write_short_drives
    from pipelines.engines.one_core import DRAWING, ONE_CORE

    environment = {**os.environ, **ONE_CORE, **DRAWING}
    table, operations = [], []
    with tempfile.TemporaryDirectory() as folder:
        fleet = Path(folder) / "fleet"
        for _ in write_short_drives(fleet, asked.drives, vehicles=4):
            pass
        for formats in ("html", ""):
            store = Path(folder) / f"store_{formats}"
            command = [sys.executable, __file__, "--run", str(fleet), str(store), formats]
            done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, env=environment)
            lines = done.stdout.splitlines()
            table += [line for line in lines if line.startswith("|")]
            operations += [f"-{line[1:]}" for line in lines if line.startswith("  ")]
    text = "\n".join(
        [
            "# What a drive costs", "",
            f"`python benchmarks/drive_cost.py`: {asked.drives} drives of a minute at 50 Hz; {platform.machine()}, Python {platform.python_version()}", "",
            "| log | report | CPU s | log MB | MB read |", "| --- | --- | --- | --- | --- |", *table, "",
            "Read counts what the system's cache gave, too: with a report, matplotlib asks its font's file again for every text.", "",
            "Asked of the store, a drive (all processes):", "", *operations, "",
        ]
    )  # fmt: skip
    print(text)
    if asked.save:
        results = ROOT / "benchmarks" / "results"
        results.mkdir(exist_ok=True)
        (results / "drive_cost.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
