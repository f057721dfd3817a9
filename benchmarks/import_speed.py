"""Import speed: cogest against the libraries that engineers use today, as ratios from one run.

    python benchmarks/import_speed.py [--minutes 30] [--runs 3] [--only blf,csv] [--save]

Makes the logs (a seed, deterministic), runs peer and ours in turn in fresh processes, from file to columns in memory, each on
one core, and prints the median CPU time of each and their ratio; every value is compared with the peer's. Beside it: the
floor (what no reader can do without), what a second core gains, and how memory grows. --save writes the table with machine and
versions to results/; rows of formats that --only leaves out stay as they are there.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from importlib import metadata
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from benchmarks.import_logs.cases import CASES, SEED, Case, case_named, make_logs  # noqa: E402
from benchmarks.import_logs.memory import peak_mib  # noqa: E402

RESULT = HERE / "results" / "import_speed.md"
LIBRARIES = ("python-can", "cantools", "asammdf", "rosbags", "mcap", "polars", "pandas", "numpy", "numba")
PAIRS = 9
"""Runs on one core and on two."""
AROUND = ("cogest", "floor", "cogest")
"""What is run before each run of the peers, and again after it: a read of 0.2 s sees one moment of a shared machine, which
the next moment may be a third slower; a peer's 12 s see many."""


def start(side: str, case: Case, folder: Path, cores: int) -> subprocess.Popen[str]:
    """One side in a fresh process."""
    command = [sys.executable, __file__, "--child", side, case.name, str(folder), str(cores)]
    environment = os.environ | {"POLARS_MAX_THREADS": str(cores)}
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment)


def figures(process: subprocess.Popen[str]) -> dict[str, float]:
    """CPU and wall seconds, values and growth of memory (MiB), once it is done."""
    told, _ = process.communicate()
    if process.returncode:
        raise SystemExit(f"{' '.join(map(str, process.args))} ended with {process.returncode}")  # type: ignore[arg-type]
    return dict(json.loads(told.splitlines()[-1]))


def measure(side: str, case: Case, folder: Path, cores: int) -> dict[str, float]:
    """The figures of one side in a fresh process."""
    return figures(start(side, case, folder, cores))


def side_by_side_s(case: Case, folder: Path) -> float:
    """Wall seconds for the log read by two processes at once, each on a core of its own: they share nothing.

    Twice the work, so that twice the time of one alone over it is what this machine's second core gives to such work at
    the moment. It may be half of one, or somebody else's; without this nobody could tell that from a reader that does not use two.
    """
    allowed = os.sched_getaffinity(0)
    started = []
    for core in sorted(allowed)[:2]:
        os.sched_setaffinity(0, {core})
        started.append(start("cogest", case, folder, 1))
    os.sched_setaffinity(0, allowed)
    return max(figures(process)["wall_s"] for process in started)


def _read(side: str, case: Case, folder: Path) -> int:
    """Read with one side; the number of values."""
    from benchmarks.import_logs import floors, sides

    if side == "floor":
        return int(getattr(floors, case.floor or "")(folder / case.file))
    columns = sides.ours(case, folder) if side == "cogest" else sides.theirs(side, case, folder)
    return sum(len(part) for parts in columns.values() for part in parts)


def child(side: str, name: str, folder: Path, cores: int) -> None:
    """What runs in the fresh process: imports and a first small log are not counted, the reading is."""
    allowed = sorted(os.sched_getaffinity(0))
    os.sched_setaffinity(0, allowed[:cores])
    case = case_named(name)
    _read(side, case, folder / "small")
    peak, before, start = peak_mib(), resource.getrusage(resource.RUSAGE_SELF), time.perf_counter()
    values = _read(side, case, folder)
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_SELF)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    print(json.dumps({"cpu_s": cpu, "wall_s": wall, "values": values, "grown_mib": peak_mib() - peak}))


def check(case: Case, folder: Path) -> None:
    """Compare every value with every peer's, and stop where one differs."""
    from benchmarks.import_logs import sides

    mine = sides.ours(case, folder)
    for peer in case.peers:
        problems = sides.differences(mine, sides.theirs(peer, case, folder))
        if problems:
            raise SystemExit(f"{case.name} differs from {peer}: {'; '.join(problems)}")


def row(case: Case, folder: Path, runs: int) -> str:
    """One line of the table."""
    measure("cogest", case, folder, 1)  # compiles, and warms the file cache
    found: dict[str, list[dict[str, float]]] = {side: [] for side in (*AROUND, *case.peers)}
    for _ in range(runs):
        for side in (*AROUND, *case.peers, *AROUND):
            found[side].append(measure(side, case, folder, 1))

    def median(side: str, what: str) -> float:
        return statistics.median(run[what] for run in found[side])

    best = min(case.peers, key=lambda peer: median(peer, "cpu_s"))
    cpu, floor = median("cogest", "cpu_s"), median("floor", "cpu_s")
    # in turn, pair by pair: a shared machine's speed wanders by more than what is asked for
    gains, machine = [], []
    for _ in range(PAIRS):
        one, two = (measure("cogest", case, folder, n)["wall_s"] for n in (1, 2))
        gains.append(one / two)
        machine.append(2 * one / side_by_side_s(case, folder))
    low, two, high = statistics.quantiles(gains, n=4)
    cores = f"{two:.2f} ({low:.2f}-{high:.2f}) of {statistics.median(machine):.2f} x"
    return (
        f"| {case.name} | {best} | {median(best, 'cpu_s'):.2f} | {cpu:.3f} | {median(best, 'cpu_s') / cpu:.1f} x | "
        f"{case.target:g} x | {cpu / max(floor, 1e-3):.1f} x | {cores} | {median('cogest', 'grown_mib'):.0f} | "
        f"{median(best, 'grown_mib'):.0f} |"
    )


def head(minutes: float, runs: int) -> list[str]:
    """Machine, versions and what the columns mean."""
    versions = ", ".join(f"{name} {metadata.version(name)}" for name in LIBRARIES)
    return [
        "# Import speed",
        "",
        f"`python benchmarks/import_speed.py --minutes {minutes:g} --runs {runs} --save`, seed {SEED}; {platform.machine()}, "
        f"{os.cpu_count()} cores, Python {platform.python_version()}; {versions}.",
        "",
        f"CPU seconds on one core, from file to columns in memory: median of {runs} runs of the peer, and of "
        f"{2 * runs * AROUND.count('cogest')} of cogest around them. Floor: libdeflate, lz4 or zstd on the containers, "
        "counting the lines, or reading the file. Two cores: wall time on one core over that on two, median of "
        f"{PAIRS} pairs run in turn (and their middle half), and (of ...) what two processes gain that each read the log on a "
        "core of their own, at those moments. Memory: growth of the peak in MiB, the wanted columns included. Every value equals the "
        "peer's.",
        "",
        "| format | peer | peer CPU s | cogest CPU s | ratio | target | x floor | two cores | MiB | peer MiB |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]


def saved_rows() -> dict[str, str]:
    """The rows of the table that was saved last, by format."""
    lines = RESULT.read_text(encoding="utf-8").splitlines() if RESULT.exists() else []
    return {line.split("|")[1].strip(): line for line in lines if line.startswith("|")}


def main() -> None:
    """Run and print the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--minutes", type=float, default=30)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--only", default=",".join(case.name for case in CASES))
    parser.add_argument("--logs", type=Path, help="folder for the logs, kept; made where it is empty")
    parser.add_argument("--save", action="store_true")
    parser.add_argument("--child", nargs=4)
    arguments = parser.parse_args()
    if arguments.child:
        side, name, folder, cores = arguments.child
        child(side, name, Path(folder), int(cores))
        return
    names = set(arguments.only.split(","))
    lines = head(arguments.minutes, arguments.runs)
    with tempfile.TemporaryDirectory() as text:
        folder = arguments.logs or Path(text)
        if not (folder / "small").exists():
            make_logs(folder, arguments.minutes * 60, names)
            make_logs(folder / "small", 2, names)
        old = saved_rows() if arguments.save else {}
        for case in CASES:
            if case.name in names:
                check(case, folder)
                lines.append(row(case, folder, arguments.runs))
                print(lines[-1], file=sys.stderr)
            elif case.name in old:
                lines.append(old[case.name])
    table = "\n".join([*lines, ""])
    print(table)
    if arguments.save:
        RESULT.parent.mkdir(exist_ok=True)
        RESULT.write_text(table, encoding="utf-8")


if __name__ == "__main__":
    main()
