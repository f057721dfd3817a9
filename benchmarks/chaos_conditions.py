"""Condition numbers of collocation matrices, and what they cost: the tables in docs/polynomial_chaos.md.

python benchmarks/chaos_conditions.py [draws]

First: Hammersley points, and the median and the worst twentieth of random draws, for 1 to 4 times as many points as
terms. Second: errors of coefficients found from random points, in units of the part of the function that the expansion
leaves out, by the condition of the draw.
"""

from __future__ import annotations

import argparse
import itertools
import sys
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).resolve().parents[1])]

from pipelines.chaos.bases import hermite, jacobi, laguerre, legendre  # noqa: E402
from pipelines.chaos.collocation import collocate_at, hammersley  # noqa: E402
from pipelines.chaos.space import Space, total_degree  # noqa: E402

BASES = {"uniform": legendre(), "Beta(1, 5)": jacobi(1, 5), "normal": hermite(), "exponential": laguerre()}
SHAPES = ((1, 4), (2, 2), (2, 4), (4, 2), (4, 4), (8, 2))
FACTORS = (1, 2, 3, 4)
EDGES = (1, 3, 10, 30, 100, 300, 1000, np.inf)


def conditions(draws: int) -> None:
    """The first table."""
    rng = np.random.default_rng(1)
    heads = [f"{factor}S Hammersley | {factor}S random, worst 5 %" for factor in FACTORS]
    print("| Variables | d | order | S | " + " | ".join(heads) + " |")
    for name, basis in BASES.items():
        for d, order in SHAPES:
            space = Space((basis,) * d)
            indices = total_degree(d, order)
            cells = []
            for factor in FACTORS:
                count = factor * len(indices)
                even = collocate_at(space, indices, space.quantile(hammersley(count, d))).condition
                drawn = [
                    collocate_at(space, indices, space.sample(rng, count)).condition for _ in range(draws)
                ]
                middle, worst = np.quantile(drawn, (0.5, 0.95))
                cells.append(f"{even:.2g} | {middle:.2g}, {worst:.2g}")
            print(f"| {name} | {d} | {order} | {len(indices)} | " + " | ".join(cells) + " |")


def costs(draws: int) -> None:
    """The second table: f = exp(-0.3 x) and 1 / (1 + (x - 1)²/4), one variable, orders 2 to 6, 1 to 4 times the terms."""
    rng = np.random.default_rng(2)
    print("\nMedian error / truncated part, by condition of a random draw; number of draws")
    for name, basis in BASES.items():
        space = Space((basis,))
        nodes, weights = basis.gauss(60)
        found = []
        for order in (2, 3, 4, 5, 6):
            indices = total_degree(1, order)
            terms = basis.evaluate(nodes, order)
            for function in (lambda x: np.exp(-0.3 * x), lambda x: 1 / (1 + 0.25 * (x - 1) ** 2)):
                exact = terms.T @ (weights * function(nodes))
                left = np.sqrt(weights @ (function(nodes) - terms @ exact) ** 2)
                for factor in FACTORS:
                    for _ in range(draws):
                        drawn = collocate_at(space, indices, space.sample(rng, factor * len(indices)))
                        error = np.linalg.norm(drawn.inverse @ function(drawn.points[:, 0]) - exact)
                        found.append((drawn.condition, error / left))
        condition, ratio = np.array(found).T
        cells = []
        for low, high in itertools.pairwise(EDGES):
            chosen = (condition >= low) & (condition < high)
            if chosen.sum() >= 20:
                cells.append(f"{low:g}-{high:g}: {np.median(ratio[chosen]):.2g} ({chosen.sum()})")
        print(f"{name:12s} " + ",  ".join(cells))


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("draws", nargs="?", type=int, default=200, help="random ones (default 200)")
    draws = parser.parse_args().draws
    conditions(draws)
    costs(draws)


if __name__ == "__main__":
    main()
