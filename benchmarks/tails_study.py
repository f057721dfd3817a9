"""Which tails do the verdict's errors have, over simulators of several authors?

python benchmarks/calibration_study.py --drives 200 --jobs 2 --out plant.jsonl
python benchmarks/foreign_study.py --drives 64 --jobs 2 --out foreign.jsonl
python benchmarks/foreign_study.py --drives 49 --strangers --jobs 2 --out strangers.jsonl
python benchmarks/tails_study.py plant.jsonl foreign.jsonl strangers.jsonl

Every answer called identified gives its error in standard deviations, z. Student's distributions of several degrees of freedom,
all with a 95 % interval of 1.96 standard deviations, are scored by the logarithm of the density that they gave to the errors (the
higher the better, in hundredths of a nat an answer above the normal distribution), and by the share of errors within their 50 and
80 % intervals. Parameters of one drive hang together: the 90 % spans are those of drawing authors, or drives of the plant, anew.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from scipy.stats import norm
from scipy.stats import t as student

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

from pipelines.joint.tails import FREEDOM  # noqa: E402

FREEDOMS = (3.0, 4.0, 5.0, 6.0, 8.0, 12.0, float("inf"))
NAMES = frozenset(
    {
        "cg_height_m", "mass_kg", "cg_to_front_axle_m", "cg_lateral_offset_m", "roll_arm_m", "pitch_inertia_kgm2",
        "roll_gradient_degpg",
    }
)  # fmt: skip
"""One of each kind: sprung and corner masses and the sprung CG's height say the same again."""

OUTER = 0.975
DRAWS = 400


def errors(path: Path) -> dict[str, list[float]]:
    """z of the identified answers by group: an author's, or a drive's of the plant."""
    found: dict[str, list[float]] = defaultdict(list)
    rows = [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]
    # of a drive of the plant that was run twice, the last
    drives = {row["text"]: row for row in rows if "text" in row}
    for row in rows:
        if "z" in row and row["status"] == "identified" and row["name"] in NAMES:
            found[row["author"]].append(row["z"])
    for text, row in drives.items():
        for name, (value, std, _, _, status, *_) in row["answers"].get("verdict", {}).items():
            truth = row["truth"].get(name)
            if name in NAMES and status == "identified" and truth is not None:
                found[text].append((value - truth) / std)
    return dict(found)


def scale(freedom: float) -> float:
    """By which Student's distribution has the 95 % interval of the standard normal one."""
    return float(norm.ppf(OUTER) / (norm.ppf(OUTER) if np.isinf(freedom) else student.ppf(OUTER, freedom)))


def score(z: np.ndarray, freedom: float) -> float:
    """Mean logarithm of the density."""
    if np.isinf(freedom):
        return float(norm.logpdf(z).mean())
    each = scale(freedom)
    return float((student.logpdf(z / each, freedom) - np.log(each)).mean())


def within(z: np.ndarray, freedom: float, level: float) -> float:
    """Share of errors inside the central interval of a level."""
    law = norm if np.isinf(freedom) else student(freedom)
    return float(np.mean(np.abs(z) <= scale(freedom) * law.ppf(0.5 + level / 2)))


def line(label: str, groups: Mapping[str, Sequence[float]]) -> str:
    """A table's row: answers, and gain over the normal distribution for each number of degrees of freedom."""
    z = np.concatenate([np.array(g) for g in groups.values()])
    normal = score(z, float("inf"))
    gains = [f"{100 * (score(z, f) - normal):+.1f}" for f in FREEDOMS[:-1]]
    shares = [f"{within(z, f, 0.5):.2f} / {within(z, f, 0.8):.2f}" for f in (FREEDOM, float("inf"))]
    outer = float(np.mean(np.abs(z) <= norm.ppf(OUTER)))
    return "| " + " | ".join([label, str(len(z)), *gains, *shares, f"{outer:.2f}"]) + " |"


def best(groups: Mapping[str, Sequence[float]], rng: np.random.Generator) -> str:
    """The freedom of the best score, and over groups drawn anew."""
    names = list(groups)

    def of(chosen: Sequence[str]) -> float:
        z = np.concatenate([np.array(groups[n]) for n in chosen])
        return max(FREEDOMS, key=lambda f: score(z, f))

    drawn = [of([names[i] for i in rng.integers(0, len(names), len(names))]) for _ in range(DRAWS)]
    return f"{of(names):g} (90 % of {DRAWS} draws: {np.quantile(drawn, 0.05, method='lower'):g} to {np.quantile(drawn, 0.95, method='higher'):g})"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("files", type=Path, nargs="+")
    a = parser.parse_args()
    sources = {path.stem: errors(path) for path in a.files}
    head = [
        "drives of",
        "answers",
        *(f"{f:g}" for f in FREEDOMS[:-1]),
        f"50 / 80 % by {FREEDOM:g}",
        "by normal",
        "95 %",
    ]
    print("| " + " | ".join(head) + " |\n|" + "---|" * len(head))
    for label, groups in sources.items():
        print(line(label, groups))
    # every source with the same weight would need one author each: all answers alike
    everything = {f"{s} {name}": z for s, groups in sources.items() for name, z in groups.items()}
    print(line("all", everything))
    rng = np.random.default_rng(0)
    for label, groups in [*sources.items(), ("all", everything)]:
        print(f"- {label}: best {best(groups, rng)}")


if __name__ == "__main__":
    main()
