"""Is the joint posterior what long chains of a plain sampler say? Sampled and Laplace answers against random-walk Metropolis.

python benchmarks/joint_mcmc.py [--drives mixed_minute:deflection,slalom:ins,mixed_minute:imu] [--chains 64] [--steps 60000] [--save]

A drive of a random vehicle of the full plant is simulated, its relations are joined, and the posterior is drawn from twice: by
`pipelines.joint.sampling.sample`, and by many chains of Metropolis that begin about the mode (random walks, and turns about Laplace's normal
distribution). Differences are in the chains' standard deviations; the chains' own Monte-Carlo error and split R-hat stand beside them.
"sampled" is as drawn: the verdict tells spreads 7 % wider than that.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "pipelines")]

from long_mcmc import figures_of, run_chains  # noqa: E402

from benchmarks.calibration_study import WITNESSES  # noqa: E402
from pipelines.analyze import run_estimator  # noqa: E402
from pipelines.estimators.registry import estimators  # noqa: E402
from pipelines.evidence import Evidence  # noqa: E402
from pipelines.joint.counted import counted  # noqa: E402
from pipelines.joint.information import slopes  # noqa: E402
from pipelines.joint.posterior import Joint, find_mode, log_density, values_at  # noqa: E402
from pipelines.joint.sampling.sample import sample  # noqa: E402
from pipelines.joint.vehicle.outputs import outputs_of  # noqa: E402
from pipelines.joint.vehicle.stated import stated_relations  # noqa: E402
from pipelines.joint.vehicle.unknowns import before_the_log  # noqa: E402
from pipelines.simulation.loads import Load  # noqa: E402
from pipelines.simulation.logs.as_drive import drive_of  # noqa: E402
from pipelines.simulation.logs.drive import Choice, simulate_log  # noqa: E402
from pipelines.simulation.logs.loads import PLACES  # noqa: E402
from pipelines.simulation.manoeuvres.base import Options  # noqa: E402
from pipelines.simulation.plant.random_vehicle import random_vehicle  # noqa: E402
from pipelines.vehicles.vehicle_file import parse_vehicle  # noqa: E402

SHOWN = ("cg_height_m", "mass_kg", "cg_to_front_axle_m", "cg_lateral_offset_m", "roll_stiffness_nmprad")
LOAD_KG = 150.0
RESULT = ROOT / "benchmarks" / "results" / "joint_mcmc.md"


def posterior_of(manoeuvre: str, sensors: str, seed: int) -> Joint:
    """The joint posterior at its mode, of one simulated minute."""
    vehicle = random_vehicle(np.random.default_rng([seed, 3]))
    loads: tuple[Load, ...] = tuple(PLACES["seats"][1](vehicle, LOAD_KG))
    made = simulate_log(Choice(manoeuvre, vehicle, loads, Options(duration_s=60.0), sensors, seed=seed))
    file = parse_vehicle(made.sheet, Path("vehicle.toml"))
    drive = drive_of(made.log)
    evidence: list[Evidence] = []
    for estimator in estimators():
        if estimator.name not in WITNESSES:
            defaults = {s.name: s.default for s in estimator.settings}
            found = run_estimator(estimator, drive, file, defaults, seed)
            assert found.status != "failed", f"{estimator.name}: {found.reason}"
            evidence += found.evidence
    known = before_the_log(file)
    kept, _ = counted(evidence, known)
    return find_mode((*kept, *stated_relations(file)), known)


def compare(name: str, joint: Joint, chains: int, steps: int) -> str:
    """One drive's table, as text."""
    density = log_density(joint)
    rng = np.random.default_rng(1)
    began = time.process_time()
    drawn = sample(density, [(joint.u, joint.covariance)], rng)
    took = time.process_time() - began
    lines = [f"{name}: {len(joint.u)} unknowns; {drawn.text}; {took:.1f} s"]
    starts = np.random.default_rng(2).multivariate_normal(joint.u, 0.5 * joint.covariance, 50 * chains)
    starts = starts[np.isfinite(density(starts))][:chains]
    ran = run_chains(density, starts, joint.covariance, rng, steps, thin=max(1, steps // 1000))
    kept = ran.draws.shape
    long = outputs_of(values_at(joint.known, ran.flat()), joint.given)
    short = outputs_of(values_at(joint.known, drawn.draws), joint.given)
    middle, gradients = slopes(joint)
    lines.append(f"chains: {kept[1]} of {steps} steps, {ran.accepted:.2f} accepted")
    lines.append(
        "parameter                 R-hat  mean ± error    sampled: mean   std   low  high    Laplace: mean   std"
    )
    for parameter in SHOWN:
        truth = figures_of(np.broadcast_to(long[parameter], kept[0] * kept[1]).reshape(kept[:2]))
        x = short[parameter]
        low, high = np.quantile(x, (0.025, 0.975))
        g = gradients[parameter]
        laplace = float(np.sqrt(g @ joint.covariance @ g))
        lines.append(
            f"{parameter:24s} {truth.r_hat:6.3f}  {truth.mean:9.4g} ± {truth.error_mean / truth.std:.2f} sd"
            f"  {(x.mean() - truth.mean) / truth.std:+13.2f} {x.std() / truth.std:5.2f}"
            f" {(low - truth.low) / truth.std:+5.2f} {(high - truth.high) / truth.std:+5.2f}"
            f"  {(middle[parameter] - truth.mean) / truth.std:+13.2f} {laplace / truth.std:5.2f}"
        )
    return "\n".join(lines)


def main() -> None:
    """All drives asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--drives", default="mixed_minute:deflection,slalom:ins,mixed_minute:imu")
    parser.add_argument("--chains", type=int, default=64)
    parser.add_argument("--steps", type=int, default=60_000)
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("--save", action="store_true")
    options = parser.parse_args()
    found: list[str] = []
    for drive in options.drives.split(","):
        manoeuvre, sensors = drive.split(":")
        joint = posterior_of(manoeuvre, sensors, options.seed)
        found.append(compare(drive, joint, options.chains, options.steps))
        print(f"\n{found[-1]}", flush=True)
    if options.save:
        heading = "# The joint posterior beside long chains\n\n`python benchmarks/joint_mcmc.py`\n"
        tables = "\n".join(f"\n```\n{table}\n```" for table in found)
        RESULT.write_text(f"{heading}{tables}\n", encoding="utf-8")


if __name__ == "__main__":
    main()
