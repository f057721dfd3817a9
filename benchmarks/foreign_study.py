"""How honest is the verdict on simulators that no estimator was built from? A table by parameter, author and sensors.

python benchmarks/foreign_study.py [--drives 40] [--first 0] [--style NAME] [--sensors NAME] [--file NAME] [--drive NAME]
                                   [--exact] [--jobs 1] [--strangers] [--out FILE.jsonl] [--save]

Every drive goes through the importer and `pipelines.analyze.analyze` as a user's would. Styles, sensors and vehicle
files are dealt out in turn unless one is named; the published witnesses are left out, since they speak for no parameter here.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import warnings
from collections import defaultdict
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "benchmarks")]

from foreign_course import DRIVES  # noqa: E402
from foreign_logs import FILES, SENSORS, STYLES, Case, Log, make_log  # noqa: E402
from foreign_recorders import STRANGE_FILES, STRANGE_SENSORS, STRANGERS, make_stranger  # noqa: E402

from pipelines.analyze import Request, analyze  # noqa: E402
from pipelines.drive_results import DriveResults  # noqa: E402
from pipelines.results import INNER, OUTER  # noqa: E402

ESTIMATORS = "roll_map,load_balance,brake_roll_batch,axle_load_gls,base_excitation_batch,load_transfer_batch,roll_plane,pitch_plane"
JUDGED = ("cg_height_m", "mass_kg", "cg_to_front_axle_m", "cg_lateral_offset_m", "roll_arm_m", "roll_stiffness_nmprad",
          "roll_inertia_kgm2", "pitch_inertia_kgm2", "roll_gradient_degpg")  # fmt: skip


@dataclass(frozen=True)
class Answer:
    """One parameter of one drive."""

    case: Case
    name: str
    status: str
    value: float
    truth: float
    std: float
    held: tuple[bool, ...]
    """Whether the 50, 80 and 95 % intervals hold the truth."""

    @property
    def z(self) -> float:
        """Error in standard deviations."""
        return (self.value - self.truth) / self.std

    @property
    def percent(self) -> float:
        """Error, of a metre for the lateral place."""
        size = 1.0 if self.name == "cg_lateral_offset_m" else abs(self.truth)
        return 100 * (self.value - self.truth) / size


@dataclass(frozen=True)
class Outcome:
    """A drive's answers; broken: estimators that failed; said: what was called wrong or unusual."""

    case: Case
    answers: tuple[Answer, ...]
    broken: tuple[str, ...] = ()
    said: tuple[str, ...] = ()


def warned(results: DriveResults) -> tuple[str, ...]:
    """What results say of trouble: the importer's repairs, estimators that cannot make sense of a signal, relations and stated
    figures in conflict, unknowns that ended far from what was known."""
    joint = results.joint
    repaired = [d.found for d in results.record.decisions if d.kind != "offset"]
    lost = [f"{e.estimator}: {e.reason}" for e in results.estimates if any(w in e.reason for w in LOST)]
    against = [] if joint is None else [c.relation for c in joint.relations if c.probability < 0.003]
    far = [] if joint is None else [f"far: {f}" for f in (*joint.spoke_for, *joint.far)]
    return (*repaired, *against, *far, *lost)


def through_the_product(log: Log) -> DriveResults:
    """Importer, estimators, verdict."""
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        drive, vehicle = Path(folder, "drive.csv"), Path(folder, "vehicle.toml")
        log.frame.write_csv(drive)
        vehicle.write_text(log.vehicle, encoding="utf-8")
        return analyze(Request((drive,), vehicle=vehicle, estimators=ESTIMATORS))


def simulated(case: Case) -> Log:
    """The case's log, by whoever wrote its simulator and its recorder."""
    return make_stranger(case) if case.style in STRANGERS else make_log(case)


def judge(case: Case) -> Outcome:
    """Simulate and analyse one drive."""
    log = simulated(case)
    return outcome_of(case, log, through_the_product(log))


def outcome_of(case: Case, log: Log, results: DriveResults) -> Outcome:
    """The verdict beside the truth."""
    found = []
    for name, p in results.verdict.items():
        truth = log.truth.get(name)
        if truth is None or p.value is None or not p.std or p.low is None or p.high is None:
            continue
        intervals = [p.interval(level) for level in (*INNER, OUTER)]
        held = tuple(i is not None and bool(i[0] <= truth <= i[1]) for i in intervals)
        found.append(Answer(case, name, p.status, p.value, truth, p.std, held))
    broken = tuple(e.estimator for e in results.estimates if e.status == "failed")
    return Outcome(case, tuple(found), broken, warned(results))


def line(label: str, group: list[Answer]) -> str:
    """A row of a table."""
    error, z = np.array([a.percent for a in group]), np.array([a.z for a in group])
    worst = group[int(np.argmax(np.abs(z)))]
    spread = float(
        np.median([abs(100 * a.std / (1.0 if a.name == "cg_lateral_offset_m" else a.truth)) for a in group])
    )
    return (
        f"| {label} | {len(group)} | {error.mean():+.1f} | {np.median(np.abs(error)):.1f} | {spread:.1f} "
        f"| {' / '.join(f'{share:.2f}' for share in np.mean([a.held for a in group], axis=0))} | {z.mean():+.2f} | {np.sqrt(np.mean(z * z)):.2f} "
        f"| {worst.z:+.1f} ({worst.case.style}, {worst.case.sensors}, {worst.case.file}, {worst.case.drive}, {worst.case.seed}) |"
    )


LOST = ("contradict each other", "does not follow", "check its channel")
"""Words with which estimators give a signal up."""

HEAD = (
    "| {} | answers | bias % | median error % | median std % | 50 / 80 / 95 % hold | mean z | rms z | worst z |\n"
    "|---|---|---|---|---|---|---|---|---|"
)


def table(title: str, answers: list[Answer], key: Callable[[Answer], str]) -> str:
    """One table: a row for each value of the key, in order of appearance of the sorted keys."""
    groups: dict[str, list[Answer]] = defaultdict(list)
    for answer in answers:
        groups[key(answer)].append(answer)
    return "\n".join([HEAD.format(title), *(line(k, groups[k]) for k in sorted(groups))])


def rows(outcomes: list[Outcome]) -> list[dict[str, object]]:
    """Every answer in short, as `benchmarks/tails_study.py` reads them."""
    return [
        {"author": a.case.style, "name": a.name, "status": a.status, "z": float(a.z), "held": a.held}
        for o in outcomes
        for a in o.answers
        if a.name in JUDGED
    ]


def report(outcomes: list[Outcome]) -> str:
    """All tables."""
    answers = [a for o in outcomes for a in o.answers if a.name in JUDGED]
    told = [a for a in answers if a.status == "identified"]
    height = [a for a in answers if a.name == "cg_height_m" and a.status != "not_identifiable"]
    parts = [
        table("parameter, status", answers, lambda a: f"{a.name}, {a.status}"),
        table("CG height told, by author", height, lambda a: a.case.style),
        table("CG height told, by sensors and file", height, lambda a: f"{a.case.sensors}, {a.case.file}"),
    ]
    far = [f"{a.name} {a.z:+.1f} ({a.percent:+.1f} %): {a.case}" for a in told if abs(a.z) > 2.5]
    broken = [f"{o.case}: {', '.join(o.broken)}" for o in outcomes if o.broken]
    said = [
        f"{', '.join(map(str, vars(o.case).values()))}: {'; '.join(o.said)[:200]}" for o in outcomes if o.said
    ]
    lists = [
        ("Identified, more than 2.5 standard deviations off", far),
        ("Estimators that broke down", broken),
        ("Drives on which something was called wrong or unusual", said),
    ]
    parts += [f"{title}: {len(each)}\n" + "".join(f"\n- {r}" for r in each) for title, each in lists]
    return "\n\n".join(parts) + "\n"


def cases(a: argparse.Namespace) -> list[Case]:
    """The drives, by chance from the seed, but for what was named."""
    found = []
    if a.strangers:
        return strange_cases(a)
    for seed in range(a.first, a.first + a.drives):
        rng = np.random.default_rng([seed, 77])
        style = a.style or list(STYLES)[seed % len(STYLES)]
        sensors = a.sensors or str(rng.choice(SENSORS, p=[0.35, 0.2, 0.05, 0.12, 0.13, 0.15]))
        file = a.file or str(rng.choice(FILES, p=[0.5, 0.3, 0.2]))
        drive = a.drive or str(rng.choice(DRIVES[:-1], p=[0.6, 0.1, 0.1, 0.1, 0.1]))
        found.append(Case(style, drive, sensors, file, seed, a.exact))
    return found


def strange_cases(a: argparse.Namespace) -> list[Case]:
    """The same for the second lot of authors, recorders and vehicle files."""
    found = []
    for seed in range(a.first, a.first + a.drives):
        rng = np.random.default_rng([seed, 78])
        style = a.style or list(STRANGERS)[seed % len(STRANGERS)]
        sensors = a.sensors or str(rng.choice(STRANGE_SENSORS, p=[0.3, 0.15, 0.1, 0.1, 0.1, 0.1, 0.05, 0.1]))
        if sensors == "rig" and STRANGERS[style][2]:
            sensors = "deflection"
        file = a.file or str(rng.choice(list(STRANGE_FILES), p=[0.3, 0.35, 0.35]))
        drive = a.drive or str(rng.choice(DRIVES[:-1], p=[0.6, 0.1, 0.1, 0.1, 0.1]))
        found.append(Case(style, drive, sensors, file, seed, a.exact))
    return found


def main() -> None:
    """Run the drives and print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--drives", type=int, default=40)
    parser.add_argument("--first", type=int, default=0, help="seed of the first drive")
    parser.add_argument("--style", choices=[*STYLES, *STRANGERS])
    parser.add_argument("--sensors", choices=sorted({*SENSORS, *STRANGE_SENSORS}))
    parser.add_argument("--file", choices=[*FILES, *STRANGE_FILES])
    parser.add_argument("--drive", choices=DRIVES)
    parser.add_argument("--exact", action="store_true", help="vehicle files without errors")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument(
        "--strangers", action="store_true", help="the second lot of authors, recorders and files"
    )
    parser.add_argument(
        "--out", type=Path, help="every answer's error in standard deviations, a JSON line each"
    )
    parser.add_argument("--save", action="store_true")
    a = parser.parse_args()
    if a.jobs > 1:
        with ProcessPoolExecutor(a.jobs) as pool:
            outcomes = list(pool.map(judge, cases(a)))
    else:
        outcomes = [judge(case) for case in cases(a)]
    text = f"The verdict on {len(outcomes)} drives of foreign simulators (seeds from {a.first})\n\n" + report(
        outcomes
    )
    print(text)
    if a.out:
        a.out.write_text("".join(json.dumps(row) + "\n" for row in rows(outcomes)), encoding="utf-8")
    if a.save:
        name, title = ("strangers", ", strangers' recorders and files") if a.strangers else ("study", "")
        (ROOT / f"benchmarks/results/foreign_{name}.md").write_text(
            f"# Foreign simulators{title}\n\n{text}", encoding="utf-8"
        )


if __name__ == "__main__":
    main()
