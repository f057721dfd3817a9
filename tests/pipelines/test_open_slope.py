"""What leaves a roll gradient open is named, and nothing that does not."""

from __future__ import annotations

import pytest

from pipelines.estimators.roll_map.open_slope import (
    BY_FRICTION,
    BY_NOISE,
    BY_RATE,
    BY_ROAD,
    FRICTION,
    ROAD,
    why_open,
)


@pytest.mark.parametrize(
    ("noise", "friction", "road", "bank", "level", "words"),
    [
        (0.3, 0.05, 0.1, 0.001, 0.01, BY_NOISE),
        (0.02, 0.2, 0.1, 0.001, 0.01, BY_FRICTION),
        (0.001, 0.01, 0.2, 1e-5, 1e-6, BY_ROAD),  # a ramp without noise
        (0.15, 0.1, 0.12, 0.02, 1e-4, BY_ROAD),  # the spread is what the angle wanders by
    ],
)
def test_the_largest_part_is_named(
    noise: float, friction: float, road: float, bank: float, level: float, words: str
) -> None:
    assert why_open(noise, {FRICTION: friction, ROAD: road}, bank, level, angle=True) == words


def test_deflections_know_no_road_and_a_rate_alone_is_told_as_that() -> None:
    assert why_open(0.01, {FRICTION: 0.3}, 0.0, 0.001, angle=True) == BY_FRICTION
    assert why_open(0.01, {FRICTION: 0.3}, 0.0, 0.0, angle=False) == BY_RATE
    assert why_open(0.0, {}, 0.0, 0.0, angle=True) == BY_NOISE
