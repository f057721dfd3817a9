"""How honest is the verdict on a car whose physics is not ours? Bias, error and coverage by parameter and status.

python benchmarks/textbook_study.py [--drives 20] [--first 0] [--sensors deflection|ins|production|all] [--jobs 1]

Every drive: a car of `textbook_car` with an unknown load, its log and its vehicle file of `textbook_logs`, written to
disk and put through `pipelines.analyze.analyze` as a user's would be.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
import warnings
from collections import Counter, defaultdict
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1]), str(Path(__file__).resolve().parent)]

from textbook_logs import SENSORS, make_log  # noqa: E402

from pipelines.analyze import Request, analyze  # noqa: E402


@dataclass(frozen=True)
class Answer:
    """One parameter of one drive's verdict."""

    seed: int
    name: str
    status: str
    value: float
    truth: float
    std: float
    inside: bool

    @property
    def error(self) -> float:
        """In standard deviations."""
        return (self.value - self.truth) / self.std


@dataclass(frozen=True)
class Outcome:
    """What became of one drive. finite: whether its simulation stayed so; failed: estimators that broke down."""

    finite: bool
    answers: tuple[Answer, ...] = ()
    failed: tuple[str, ...] = ()


def run_drive(seed: int, sensors: str) -> Outcome:
    """Simulate one drive and analyse it."""
    with np.errstate(all="ignore"):
        log = make_log(seed, sensors)
    if not np.isfinite(log.motion).all():
        return Outcome(False)
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        drive, vehicle = Path(folder, "drive.csv"), Path(folder, "vehicle.toml")
        log.frame.write_csv(drive)
        vehicle.write_text(log.vehicle, encoding="utf-8")
        results = analyze(Request((drive,), vehicle=vehicle))
    answers = []
    for name, p in results.verdict.items():
        if p.value is None or p.reference is None or not p.std or p.low is None or p.high is None:
            continue
        inside = p.low <= p.reference <= p.high
        answers.append(Answer(seed, name, p.status, p.value, p.reference, p.std, inside))
    failed = tuple(f"{e.estimator}: {e.reason}" for e in results.estimates if e.status == "failed")
    return Outcome(True, tuple(answers), failed)


def table(answers: list[Answer]) -> str:
    """A line a parameter and status: bias, RMSE, mean std in per cent of the truth; coverage; the worst error in standard
    deviations, and its drive. The lateral offset may be next to nothing: its errors are in per cent of a metre."""
    rows: dict[tuple[str, str], list[Answer]] = defaultdict(list)
    for answer in answers:
        rows[answer.name, answer.status].append(answer)
    lines = [
        "| parameter | status | count | bias % | RMSE % | mean std % | coverage | worst abs(error) / std (drive) |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for (name, status), group in sorted(rows.items()):
        size = np.array([1.0 if name == "cg_lateral_offset_m" else abs(a.truth) for a in group])
        error = 100 * np.array([a.value - a.truth for a in group]) / size
        std = 100 * np.array([a.std for a in group]) / size
        inside = np.mean([a.inside for a in group])
        worst = max(group, key=lambda a: abs(a.error))
        lines.append(
            f"| {name} | {status} | {len(group)} | {error.mean():+.2f} | {np.sqrt(np.mean(error**2)):.2f} "
            f"| {std.mean():.2f} | {inside:.2f} | {abs(worst.error):.1f} ({worst.seed}) |"
        )
    return "\n".join(lines)


def main() -> None:
    """Run the drives and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--drives", type=int, default=20)
    parser.add_argument("--first", type=int, default=0, help="seed of the first drive")
    parser.add_argument("--sensors", choices=SENSORS, default="deflection")
    parser.add_argument("--jobs", type=int, default=1)
    a = parser.parse_args()
    seeds = range(a.first, a.first + a.drives)
    one = partial(run_drive, sensors=a.sensors)
    if a.jobs > 1:
        with ProcessPoolExecutor(a.jobs) as pool:
            outcomes = list(pool.map(one, seeds))
    else:
        outcomes = [one(seed) for seed in seeds]
    dropped = sum(not o.finite for o in outcomes)
    print(
        f"the verdict on the textbook car: drives {a.first} to {a.first + a.drives - 1}, sensors {a.sensors}; "
        f"{dropped} dropped, whose simulation left finite numbers\n"
    )
    print(table([answer for o in outcomes for answer in o.answers]))
    failures = Counter(failure for o in outcomes for failure in o.failed)
    for failure, count in failures.items():
        print(f"\nfailed in {count} drives: {failure}")


if __name__ == "__main__":
    main()
