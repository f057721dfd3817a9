"""A robust spread, and the distance of one figure from a few others at a stated chance."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.hierarchy.distance import crowd, distance, qn, quartiles


def slow_qn(values: list[float]) -> float:
    """The definition, by sorting: the k-th of the distances, k = h (h - 1) / 2, h = n // 2 + 1, of 2 figures 0.399 of it."""
    gaps = sorted(abs(a - b) for i, a in enumerate(values) for b in values[:i])
    h = len(values) // 2 + 1
    return gaps[h * (h - 1) // 2 - 1]


def test_against_the_definition() -> None:
    values = [3.0, 1.0, 4.0, 1.5, 9.0, 2.6, 5.3]
    assert qn(np.array(values)) == pytest.approx(2.2219 * 0.857 * slow_qn(values))


@pytest.mark.parametrize("n", [6, 10, 19, 40])
def test_it_is_the_standard_deviation_of_normal_figures(n: int) -> None:
    rng = np.random.default_rng(n)
    found = np.mean([qn(rng.normal(0, 2.0, n)) for _ in range(800)])
    assert found == pytest.approx(2.0, rel=0.06)


def test_quartiles_of_many() -> None:
    values = np.random.default_rng(0).normal(5.0, 3.0, 4000)
    values[:400] = 1e4
    assert quartiles(values) == pytest.approx(3.0, rel=0.25)


def test_a_third_of_wild_figures_moves_it_little() -> None:
    rng = np.random.default_rng(1)
    clean = rng.normal(0, 1, 30)
    wild = clean.copy()
    wild[:9] += 100.0
    assert qn(wild) < 2.5 * qn(clean)
    assert np.std(wild) > 20 * qn(clean)


@pytest.mark.parametrize(
    ("others", "between"), [(3, 4.0), (5, 1.0), (6, 4.0), (10, 4.0), (19, 0.0), (19, 1.0)]
)
def test_chance_is_at_most_what_is_said(others: int, between: float) -> None:
    rng = np.random.default_rng([others, int(10 * between)])
    found = []
    for _ in range(1500):
        x = rng.normal(0, np.hypot(between, 1.0), others + 1)
        found.append(distance(x[0], 1.0, crowd(x[1:], np.ones(others))).probability)
    share = np.mean(np.array(found) < 0.01)
    assert share < 0.01 + 3 * np.sqrt(0.01 / 1500)


def test_one_far_off_is_found_beside_another() -> None:
    rng = np.random.default_rng(3)
    others = np.append(rng.normal(0, 1.0, 15), [40.0, 50.0])
    found = distance(12.0, 0.5, crowd(others, np.full(17, 0.5)))
    assert found.probability < 1e-3
    assert found.score > 5


def test_an_interval_as_wide_as_the_distance() -> None:
    found = distance(12.0, 10.0, crowd(np.random.default_rng(3).normal(0, 1.0, 15), np.full(15, 0.5)))
    assert found.probability > 0.1


def test_one_figure_has_no_spread() -> None:
    with pytest.raises(ValueError, match="two figures"):
        qn(np.array([1.0]))
