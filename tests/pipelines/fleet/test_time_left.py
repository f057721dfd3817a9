"""Time left: exact where the cost is a line in the size, near it where drives scatter, fail or differ by orders of magnitude."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.fleet.time_left import LEAST, TimeLeft, fit_cost, told


def test_a_line_is_found_again():
    sizes = [10**k for k in range(3, 9)]
    a, b = fit_cost(sizes, [2.0 + 3e-6 * size for size in sizes])
    assert a == pytest.approx(2.0, rel=1e-9)
    assert b == pytest.approx(3e-6, rel=1e-9)


def test_costs_are_never_negative():
    a, b = fit_cost([100, 200, 300], [3.0, 2.0, 1.0])
    assert b == 0.0
    assert a > 0.0
    a, b = fit_cost([100, 200, 400], [0.1, 1.0, 3.0])
    assert a >= -1e-12
    assert b > 0.0


def test_sizes_all_alike_and_empty_logs():
    a, b = fit_cost([1000, 1000, 1001], [4.0, 4.0, 4.0])
    assert a + b * 1000 == pytest.approx(4.0, rel=1e-3)
    assert fit_cost([0, 0, 0], [4.0, 5.0, 6.0]) == (5.0, 0.0)


def test_a_few_drives_that_hang_or_fail_at_once_do_not_move_it():
    rng = np.random.default_rng(1)
    sizes = (10 ** rng.uniform(5, 8, 200)).astype(int).tolist()
    seconds = [(3.0 + 2e-6 * s) * rng.lognormal(0, 0.1) for s in sizes]
    for k in range(0, 200, 20):
        seconds[k] = 0.01 if k % 40 else 3600.0
    a, b = fit_cost(sizes, seconds)
    assert a == pytest.approx(3.0, rel=0.15)
    assert b == pytest.approx(2e-6, rel=0.15)


def _run(sizes: list[int], seconds: list[float], workers: int, upto: int) -> tuple[float, float]:
    """What is said after `upto` drives, and what it really took from there."""
    free = [0.0] * workers
    ends = []
    for size, took in zip(sizes, seconds, strict=True):
        k = free.index(min(free))
        free[k] += took
        ends.append((free[k], size, took))
    ends.sort()
    left = TimeLeft(len(sizes), sum(sizes), 0.0)
    for end, size, took in ends[:upto]:
        left.ended(size, took, end)
    now = ends[upto - 1][0]
    said = left.seconds(now)
    assert said is not None
    return said, ends[-1][0] - now


@pytest.mark.parametrize("workers", [1, 2, 8])
@pytest.mark.parametrize(("share", "factor"), [(0.2, 1.5), (0.5, 1.2), (0.8, 1.2)])
def test_sizes_over_three_orders_of_magnitude_the_largest_first(workers, share, factor):
    # after a fifth only logs of 25 MB and more have ended: what a drive costs whatever its size is an extrapolation
    rng = np.random.default_rng(2)
    sizes = sorted((10 ** rng.uniform(5, 8, 400)).astype(int).tolist(), reverse=True)
    seconds = [(3.0 + 2e-6 * s) * rng.lognormal(0, 0.2) for s in sizes]
    said, true = _run(sizes, seconds, workers, int(share * 400))
    assert true / factor < said < true * factor


def test_counting_drives_alone_would_be_far_off():
    sizes = sorted(range(10**6, 10**8, 10**6), reverse=True)
    seconds = [2e-6 * s for s in sizes]
    said, true = _run(sizes, seconds, 1, 20)
    by_count = sum(seconds[:20]) * 79 / 20
    assert said == pytest.approx(true, rel=0.02)
    assert by_count > 1.5 * true


def test_nothing_is_said_too_early_and_it_runs_down_between_ends():
    left = TimeLeft(10, 1000, 0.0)
    for k in range(LEAST):
        assert left.seconds(10.0 * (k + 1)) is None
        left.ended(100, 10.0, 10.0 * (k + 1))
    at = left.seconds(30.0)
    assert at == pytest.approx(70.0)
    assert left.seconds(35.0) == pytest.approx(65.0)
    assert left.seconds(300.0) == pytest.approx(350.0)
    assert left.a_minute(30.0) == pytest.approx(6.0)


def test_what_another_batch_did_is_no_work():
    left = TimeLeft(6, 600, 0.0)
    for k in range(3):
        left.ended(100, 10.0, 10.0 * (k + 1))
    left.ended(100, 0.0, 30.0, work=False)
    assert left.seconds(30.0) == pytest.approx(20.0)


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.0, "about 10 s"), (44.0, "about 40 s"), (90.0, "about 2 min"), (719.0, "about 12 min"), (5400.0, "about 1 h 30 min"),
        (7190.0, "about 2 h"), (8400.0, "about 2 h 20 min"), (260_000.0, "about 3 days"),
    ],
)  # fmt: skip
def test_said_as_people_do(seconds, text):
    assert told(seconds) == text
