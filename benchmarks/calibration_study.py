"""Is the verdict as sure as it should be? Simulation-based calibration over random vehicles, loads, manoeuvres and sensors.

python benchmarks/calibration_study.py [--drives 200] [--jobs 2] [--out FILE.jsonl] [--cache DIR] [--more N] [--save]
python benchmarks/calibration_study.py --medians deflection|ins|imu [--drives 50] [--data sheet|measured]
python benchmarks/calibration_study.py --evaluate --out FILE.jsonl     (the tables again, nothing is run)
python benchmarks/calibration_study.py --drives 40 --sensors ins --no-witnesses --error-scale 0 --sheet-errors 0

Every drive: a random vehicle of the full plant (`pipelines.simulation.plant.random_vehicle`), an unknown load, a manoeuvre with
random options, drawn sensor errors, and a vehicle file whose figures are off by their stated spreads; in half of the drives it
does not say about which height the links let the body pitch. --medians: ten minutes of public road, all of that told.
--data: whether the vehicle file is a data sheet's or that of a measured vehicle (`benchmarks/vehicle_data.py`); it is off by
its stated spreads in either case, and the drives are the same. --recorded-on: what the file says the log is of (`docs/vehicle.md`).
Drives are kept on disk: a study of new verdict code costs no simulation. --error-scale, --sheet-errors set those errors' size;
--each prints every drive's main answers.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections import Counter
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, replace
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

from benchmarks.calibration_drives import (  # noqa: E402
    Plan,
    kept_drive,
    median_plan,
    random_plan,
    simulation_hash,
)
from benchmarks.calibration_tables import (  # noqa: E402
    FAR,
    SHOWN,
    VERDICT,
    Record,
    answers_of,
    coverage_table,
    far_table,
    medians_table,
    methods_table,
    narrower,
    save_reliability,
    sensors_table,
)
from benchmarks.vehicle_data import QUALITIES  # noqa: E402
from pipelines.analyze import run_estimator  # noqa: E402
from pipelines.estimators.registry import estimators  # noqa: E402
from pipelines.prepare.deflection_zero import less_their_zeros  # noqa: E402
from pipelines.results import Estimate, ParameterEstimate  # noqa: E402
from pipelines.vehicles.keys import RECORDED  # noqa: E402
from pipelines.vehicles.vehicle import Vehicle  # noqa: E402
from pipelines.verdict.combine import verdict_of  # noqa: E402

RESULT = ROOT / "benchmarks" / "results" / "calibration_study.md"
FIGURE = ROOT / "docs" / "images" / "reliability.png"
WITNESSES = frozenset(
    {
        "base_excitation", "hekf_ekf", "integrated_observer", "load_transfer", "modified_load_transfer",
        "high_frequency_load_transfer", "gpc_bayesian_map", "gpc_roll_plane", "suspension_mapping",
        "marginalized_particle_filter",
    }
)  # fmt: skip
"""Published methods: no part of the verdict where another speaks; --no-witnesses leaves them out to save time."""


@dataclass(frozen=True)
class Job:
    """One drive: everything that its process needs."""

    plan: Plan
    cache: Path
    code: str
    witnesses: bool
    mass_std: float | None = None
    data: str = "sheet"
    skip: tuple[str, ...] = ()
    recorded_on: str | None = None


def judge(results: Sequence[Estimate], vehicle: Vehicle) -> tuple[dict[str, ParameterEstimate], Record]:
    """The one place where the study asks for the verdict: its answers, and what stands behind them."""
    verdict = verdict_of(results, vehicle)
    joint = verdict.joint
    if joint is None:
        return dict(verdict.parameters), {}
    behind: Record = {
        "method": joint.method,
        "inflation": round(joint.inflation, 3),
        "far": [*joint.spoke_for, *joint.far],
        "not_counted": [list(pair) for pair in joint.not_counted],
        "relations": [[r.relation, r.source, r.numbers, r.chi2, r.probability, r.widened] for r in joint.relations],
        "shares": {
            name: [[s.relation, round(s.bits, 3), s.std_alone] for s in learned.shares[:4]]
            for name, learned in joint.learned.items()
            if name in SHOWN
        },
    }  # fmt: skip
    return dict(verdict.parameters), behind


def _figures(entries: Iterable[ParameterEstimate]) -> dict[str, list[object]]:
    """Answers with figures as the records hold them: value, std, low, high, status, the prior's std, inner intervals."""
    return {
        p.name: [
            p.value,
            p.std,
            p.low,
            p.high,
            p.status,
            p.prior.std if p.prior else None,
            *map(list, p.inner),
        ]
        for p in entries
        if p.value is not None and p.std is not None
    }


def run_drive(job: Job) -> Record:
    """Simulate or fetch one drive, run every estimator, ask for the verdict."""
    began = time.perf_counter()
    kept = kept_drive(job.plan, job.cache, job.code)
    record: Record = {
        "plan": asdict(job.plan), "text": job.plan.text, "body": kept.body, "truth": kept.truth, "sizes": kept.sizes,
        "reason": kept.reason, "old": kept.old, "answers": {}, "failed": [],
    }  # fmt: skip
    if kept.drive is None:
        return record
    file = replace(kept.vehicle(job.mass_std, job.data), recorded_on=job.recorded_on)
    drive, vehicle = less_their_zeros(kept.drive, file)
    simulated = time.perf_counter()
    results, seconds = [], {}
    for estimator in estimators():
        if estimator.name in job.skip or (estimator.name in WITNESSES and not job.witnesses):
            continue
        defaults = {s.name: s.default for s in estimator.settings}
        estimate = run_estimator(estimator, drive, vehicle, defaults, job.plan.seed)
        results.append(estimate)
        if estimate.status == "ran":
            record["answers"][estimate.estimator] = _figures(estimate.parameters.values())
            seconds[estimate.estimator] = round(estimate.runtime_s, 3)
        elif estimate.status == "failed":
            record["failed"].append(f"{estimate.estimator}: {estimate.reason}")
    judged = time.perf_counter()
    answers, record["behind"] = judge(results, vehicle)
    record["answers"][VERDICT] = _figures(answers.values())
    ended = time.perf_counter()
    record["seconds"] = {
        "drive": simulated - began,
        "verdict": ended - judged,
        "all": ended - began,
        **seconds,
    }
    return record


def _run_safely(job: Job) -> Record:
    """A crash of one drive is a finding, not the end of the study."""
    try:
        return run_drive(job)
    except Exception as error:
        return {"plan": asdict(job.plan), "text": job.plan.text, "answers": {}, "truth": {}, "sizes": {}, "body": "",
                "reason": f"CRASH {type(error).__name__}: {error}", "old": False, "failed": []}  # fmt: skip


def run_all(jobs: Sequence[Job], workers: int, out: Path, each: bool) -> None:
    """Run the jobs; each record is appended as it comes."""
    with out.open("a", encoding="utf-8") as file:

        def keep(number: int, record: Record) -> None:
            file.write(json.dumps(record) + "\n")
            file.flush()
            took = record.get("seconds", {}).get("all", 0.0)
            print(f"[{number}/{len(jobs)}] {record['text']}: {took:.1f} s {record['reason']}", flush=True)
            if each:
                show_answers(record)

        if workers <= 1:
            for number, job in enumerate(jobs, 1):
                keep(number, _run_safely(job))
            return
        with ProcessPoolExecutor(workers) as pool:
            waiting = [pool.submit(_run_safely, job) for job in jobs]
            for number, done in enumerate(as_completed(waiting), 1):
                keep(number, done.result())


def show_answers(record: Record) -> None:
    """Print the main answers of one drive, and all that are far off."""
    for a in answers_of([record]):
        if a.name in SHOWN or (abs(a.z) > FAR and a.status == "identified"):
            print(f"      {a.name:24s} {a.value:10.4f} ± {a.std:.4f}  truth {a.truth:10.4f}  {100 * a.error:+6.2f} %"
                  f"  z {a.z:+5.2f}  {a.status}")  # fmt: skip
    behind = record.get("behind") or {}
    for relation, source, numbers, chi2, probability, widened in behind.get("relations", []):
        print(
            f"      relation {relation} ({source}): chi2 {chi2:.1f} of {numbers}, p {probability:.3f}, widened {widened:.2f}"
        )
    print(f"      {behind.get('method', '')}; inflation {behind.get('inflation')}; far: {behind.get('far')}")


def read_records(path: Path) -> list[Record]:
    """The records of a study's file; of a drive that was run twice, the last."""
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    return list({r["text"]: r for r in map(json.loads, lines)}.values())


def summary(records: Sequence[Record], title: str, medians: bool) -> str:
    """All tables as Markdown."""
    ran = [r for r in records if r["answers"]]
    failed = Counter(r["reason"].split(";")[0][:120] for r in records if r["reason"])
    old = sum(bool(r["old"]) for r in ran)
    answers = answers_of(ran)
    parts = [f"## {title}", f"{len(ran)} drives; {sum(failed.values())} more could not be driven."]
    parts += [f"- {count} x {reason}" for reason, count in failed.most_common()]
    if old:
        parts.append(f"- {old} drives were simulated by older code.")
    parts += [f"- {reason}" for reason in sorted({text for r in ran for text in r["failed"]})[:10]]
    if medians:
        parts += ["### Medians, whatever the status", medians_table(ran)]
    for status in ("identified", "weak"):
        chosen = [a for a in answers if a.status == status]
        parts += [f"### Called {status}: {len(chosen)} answers", coverage_table(chosen)]
    wrong = Counter(r["plan"]["wrong"] for r in ran if r["plan"].get("wrong"))
    if wrong:
        # the levels are meant over what the verdict takes for possible, wrong files among it
        parts[2:2] = [
            "- One kind of figures of the vehicle file is wrong by several of its spreads in "
            f"{wrong.total()} drives: {', '.join(f'{title} {count}' for title, count in wrong.most_common())}."
        ]
        right = answers_of(r for r in ran if not r["plan"].get("wrong"))
        chosen = [a for a in right if a.status == "identified"]
        parts += [
            f"### Called identified where the file is right: {len(chosen)} answers",
            coverage_table(chosen),
        ]
    learned_of = [a for a in answers if a.status != "not_identifiable"]
    parts += ["### By sensor set, identified and weak", sensors_table(learned_of)]
    parts += [f"### Identified and beyond {FAR:g} standard deviations", far_table(ran)]
    parts += ["### The verdict against each method on the same drives", methods_table(ran)]
    wider, learned = narrower(ran)
    parts.append(
        f"Interval narrower than the prior's where something was learned: {learned - len(wider)} of {learned} answers."
    )
    parts += [f"- wider: {a.text}: {a.name} ({a.status})" for a in wider[:10]]
    times = sorted(r["seconds"]["verdict"] for r in ran if "seconds" in r)
    if times:
        parts.append(f"Time for the verdict: median {times[len(times) // 2]:.2f} s, most {times[-1]:.2f} s.")
    return "\n\n".join(parts).replace("\n\n- ", "\n- ") + "\n"


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--drives", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--more", type=int, default=0, help="so many drives beyond those in --out")
    parser.add_argument(
        "--medians", default="", metavar="SET", help="ten minutes of public road with one sensor set"
    )
    parser.add_argument("--sensors", default=None, help="this set in every drive")
    parser.add_argument("--seeds", default="", help="these seeds alone, separated by commas")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--no-witnesses", action="store_true")
    parser.add_argument("--skip", default="", help="estimators left out, separated by commas")
    parser.add_argument("--error-scale", type=float, default=None)
    parser.add_argument("--sheet-errors", type=float, default=None)
    parser.add_argument(
        "--mass-std", type=float, default=None, help="the empty mass is known so well, e.g. 0.003: weighed"
    )
    parser.add_argument("--data", choices=QUALITIES, default="sheet", help="the quality of the vehicle file")
    parser.add_argument(
        "--recorded-on", choices=RECORDED, default=None, help="what the vehicle file says the log is of"
    )
    parser.add_argument("--untold", action="store_true", help="no pitch centre in any vehicle file")
    parser.add_argument("--told", action="store_true", help="pitch centre in every vehicle file")
    parser.add_argument("--cache", type=Path, default=Path.home() / ".cache" / "cogest_calibration")
    parser.add_argument("--out", type=Path, default=None)
    parser.add_argument("--evaluate", action="store_true")
    parser.add_argument("--each", action="store_true")
    parser.add_argument(
        "--save", action="store_true", help="write the tables, and the figure, where the docs have them"
    )
    return parser.parse_args()


def _plan(seed: int, a: argparse.Namespace) -> Plan:
    plan = median_plan(seed, a.medians) if a.medians else random_plan(seed, a.sensors)
    if a.error_scale is not None:
        plan = replace(plan, error_scale=a.error_scale)
    if a.sheet_errors is not None:
        plan = replace(plan, sheet_errors=a.sheet_errors)
    if a.told or a.untold:
        plan = replace(plan, told=a.told)
    return plan


def main() -> None:
    """Run what is asked for, and print the tables."""
    a = _arguments()
    name = f"medians_{a.medians}" if a.medians else "study"
    name += "" if a.data == "sheet" else f"_{a.data}"
    name += "" if a.recorded_on is None else f"_{a.recorded_on}"
    out: Path = a.out or a.cache / f"{name}.jsonl"
    out.parent.mkdir(parents=True, exist_ok=True)
    if not a.evaluate:
        before = read_records(out) if a.more else []
        if not a.more:
            out.unlink(missing_ok=True)
        first = max((r["plan"]["seed"] for r in before), default=a.first - 1) + 1
        seeds = range(first, first + (a.more or a.drives))
        chosen = [int(s) for s in a.seeds.split(",")] if a.seeds else seeds
        code = simulation_hash(ROOT)
        jobs = [
            Job(
                _plan(seed, a),
                a.cache,
                code,
                not a.no_witnesses,
                a.mass_std,
                a.data,
                tuple(a.skip.split(",")),
                a.recorded_on,
            )
            for seed in chosen
        ]
        run_all(jobs, a.jobs, out, a.each)
    records = read_records(out)
    title = f"Medians with the sensor set `{a.medians}`" if a.medians else "Calibration over random drives"
    title += {
        "sheet": "",
        "measured": ", vehicle measured",
        "levelled": ", vehicle measured, unit levelled",
        "zeroed": ", vehicle measured, unit levelled, deflections zeroed",
    }[a.data]
    title += "" if a.mass_std is None else f", empty mass known to {100 * a.mass_std:g} %"
    title += "" if a.recorded_on is None else f", recorded on a {a.recorded_on}"
    text = summary(records, title, bool(a.medians))
    print(text)
    if a.save:
        keep_text(text, title)
        if not a.medians and a.data == "sheet" and a.recorded_on is None:
            identified = [x for x in answers_of(records) if x.status == "identified"]
            save_reliability(identified, FIGURE)


def keep_text(text: str, title: str) -> None:
    """Put a section into the results page in place of the one with the same title."""
    head = "# Calibration of the verdict\n\nWritten by `benchmarks/calibration_study.py --save`.\n"
    page = RESULT.read_text(encoding="utf-8") if RESULT.exists() else head
    sections = page.split("\n## ")
    others = [f"## {s.strip()}\n" for s in sections[1:] if s.splitlines()[0].strip() != title]
    RESULT.write_text("\n".join([sections[0].rstrip() + "\n", *others, text]), encoding="utf-8")


if __name__ == "__main__":
    main()
