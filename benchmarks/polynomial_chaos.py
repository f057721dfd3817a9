"""Polynomial chaos expansions beside chaospy: the same terms, points and values, in one run, as ratios of CPU time.

python benchmarks/polynomial_chaos.py [filter]     (pip install '.[peers]'; OPENBLAS_NUM_THREADS=1 for figures of one core)

Expansion: the polynomials are made and fitted to the model's values at the collocation points. Ours includes the whole
pseudo-inverse and the condition, which chaospy does not give. Evaluation: the fitted expansion at fresh points. The
target is 10 times chaospy's speed in each.

With `filter`: only the gPC-EKF's speed, in samples a second of CPU time; the target is 70 000 at 15 terms and 60 points.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1])]

from pipelines.chaos.bases import Basis, hermite, jacobi, laguerre, legendre  # noqa: E402
from pipelines.chaos.collocation import collocate, collocate_at  # noqa: E402
from pipelines.chaos.expansion import expand  # noqa: E402
from pipelines.chaos.space import Space, total_degree  # noqa: E402

TARGET = 10.0
SHORTEST = 0.02
"""s: what is quicker is run several times between two looks at the clock."""

CASES: dict[str, tuple[tuple[Basis, ...], int]] = {
    "Legendre, 1 variable, order 8": ((legendre(),), 8),
    "Legendre, 2 variables, order 4": ((legendre(),) * 2, 4),
    "Legendre, 4 variables, order 2": ((legendre(),) * 4, 2),
    "Hermite, 3 variables, order 4": ((hermite(),) * 3, 4),
    "Beta(2, 3), 4 variables, order 4": ((jacobi(2, 3),) * 4, 4),
    "mixed, 4 variables, order 3": ((legendre(), jacobi(2, 3), hermite(), laguerre(3.0)), 3),
    "Legendre, 6 variables, order 4": ((legendre(),) * 6, 4),
    "Legendre, 4 variables, order 8": ((legendre(),) * 4, 8),
}
FRESH = (1, 1000, 20_000)


def seconds(run: Callable[[], object], rounds: int) -> float:
    """CPU time of one run in s: the median of some rounds, after one that compiles."""
    began = time.process_time()
    run()
    run()
    repeat = max(1, int(SHORTEST / max((time.process_time() - began) / 2, 1e-7)))
    found = []
    for _ in range(rounds):
        began = time.process_time()
        for _ in range(repeat):
            run()
        found.append((time.process_time() - began) / repeat)
    return statistics.median(found)


def theirs(basis: Basis) -> object:
    """chaospy's distribution of one of our bases."""
    import chaospy

    if basis.kind == "jacobi":
        return chaospy.Beta(basis.first, basis.second, -1, 1)
    if basis.kind == "laguerre":
        return chaospy.Gamma(basis.first)
    return chaospy.Normal(0, 1) if basis.kind == "hermite" else chaospy.Uniform(-1, 1)


def verdict(ours: float, peer: float) -> str:
    """Both times and their ratio."""
    ratio = peer / ours
    return f"{ours * 1e6:10.1f} µs {peer * 1e6:12.1f} µs {ratio:7.0f} x{'' if ratio >= TARGET else '  below target'}"


def compare(bases: tuple[Basis, ...], order: int) -> None:
    """One case: expansion, then evaluation."""
    import chaospy

    space = Space(bases)
    joint = chaospy.J(*[theirs(basis) for basis in bases])
    points = collocate(space, order).points
    values = np.exp(0.2 * points.sum(axis=1))

    def ours_fit() -> object:
        return expand(collocate_at(space, total_degree(space.dimensions, order), points), values)

    def peer_fit() -> object:
        return chaospy.fit_regression(chaospy.generate_expansion(order, joint, normed=True), points.T, values)

    print(f"   {'expansion':24s}{verdict(seconds(ours_fit, 7), seconds(peer_fit, 3))}")
    expansion = expand(collocate_at(space, total_degree(space.dimensions, order), points), values)
    fitted = peer_fit()
    for count in FRESH:
        fresh = space.sample(np.random.default_rng(0), count)
        difference = float(np.abs(expansion.evaluate(fresh)[:, 0] - fitted(*fresh.T)).max())
        here = seconds(lambda fresh=fresh: expansion.evaluate(fresh), 7)
        there = seconds(lambda fresh=fresh: fitted(*fresh.T), 3)
        print(f"   {f'evaluation at {count}':24s}{verdict(here, there)}   (differ by {difference:.0e})")


def filter_speeds(rows: int = 20_000) -> None:
    """The state-space filter of a mass on a spring, both forms of the update: four variables, order 2, 4 points a term."""
    from pipelines.filters.gpc_filter import GpcSettings, Uncertain, estimate_state_space
    from pipelines.filters.gpc_update import PUBLISHED, SQUARE_ROOT
    from pipelines.models.mass_spring import MASS_SPRING

    rng = np.random.default_rng(0)
    force = 100 * np.sin(0.03 * np.arange(rows))[:, None] + 20 * rng.standard_normal((rows, 1))
    position = 0.3 * np.sin(0.03 * np.arange(rows))[:, None] + 0.01 * rng.standard_normal((rows, 1))
    states = (Uncertain(0.0, 0.5), Uncertain(0.0, 0.5))
    for name, logarithm in (("", False), (", positive parameters", True)):
        spread = 0.3 if logarithm else 30.0
        parameters = (
            Uncertain(100.0, spread, logarithm=logarithm),
            Uncertain(400.0, spread, logarithm=logarithm),
            Uncertain(0.0),
            Uncertain(0.0),
        )
        for form, title in ((PUBLISHED, "as published"), (SQUARE_ROOT, "square root")):
            how = GpcSettings(noise=(1e-4,), form=form)

            def run(parameters: tuple[Uncertain, ...] = parameters, how: GpcSettings = how) -> object:
                return estimate_state_space(MASS_SPRING, force, position, 0.01, states, parameters, how)

            found = run()
            s, q = found.collocation.inverse.shape
            rate = rows / seconds(run, 5)
            note = (
                ""
                if rate >= 70_000 and found.done == rows
                else f"  (target 70 000; {found.done} samples done)"
            )
            print(f"gPC-EKF {title}{name}: {s} terms, {q} points: {rate:9.0f} samples/s{note}")


def main() -> None:
    """Print all cases."""
    if sys.argv[1:] == ["filter"]:
        filter_speeds()
        return
    if find_spec("chaospy") is None:
        sys.exit("chaospy is not installed: pip install '.[peers]', or see the filter alone with `filter`")
    for name, (bases, order) in CASES.items():
        terms = len(total_degree(len(bases), order))
        print(f"{name}: {terms} terms, {4 * terms} points          ours         chaospy")
        compare(bases, order)
    filter_speeds()


if __name__ == "__main__":
    main()
