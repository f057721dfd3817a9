"""Trends of springs and dampers: what was planted comes back, chance is as stated, and what cannot be told."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence

import numpy as np
import pytest

from pipelines.hierarchy.drift import DAMPERS, SPRINGS, line_of, slopes_of
from pipelines.hierarchy.records import DriveTold, Trend
from pipelines.hierarchy.trends import PARTS, trends
from tests.pipelines.hierarchy.toy_fleet import BEFORE, Drive, drawn, kept, posterior, told

DAMPERS_SEEN: list[dict[str, float]] = [
    {"bump_front": 1 / 20}, {"rebound_front": 1 / 30}, {"bump_rear": 1 / 20}, {"rebound_rear": 1 / 30}
]  # fmt: skip
SPRINGS_SEEN: list[dict[str, float]] = [
    {"spring_front": 1 / 400}, {"spring_rear": 1 / 400}, {"bar_front": 1 / 300}, {"bar_rear": 1 / 200}
]  # fmt: skip
EVERYTHING = DAMPERS_SEEN + SPRINGS_SEEN
SCATTER = 0.04


def drives(
    rng: np.random.Generator, days: Sequence[float], *, dampers: float = 0.0, springs: float = 0.0,
    seen: Sequence[dict[str, float]] = EVERYTHING, season: float = 0.0,
) -> tuple[list[DriveTold], dict[str, float]]:  # fmt: skip
    """Drives of one vehicle whose parts change by a share a year; its true rates at the first day."""
    truth, found = drawn(rng), []
    for number, day in enumerate(days):
        years, common = day / 365.25, rng.standard_normal()
        wave = season * math.cos(2 * math.pi * years)
        figures = {name: truth[name] * (1 + springs * years) for name in SPRINGS}
        for name in DAMPERS:
            mine = SCATTER * math.sqrt(0.5) * (common + rng.standard_normal())
            figures[name] = truth[name] * (1 + dampers * years + wave + mine)
        load = np.array([rng.uniform(50, 400), 1.4, 0.0, 0.9])
        noise = rng.standard_normal(len(seen))
        found.append(told(number, kept(Drive(load, figures), truth, seen, noise), day))
    return found, truth


def by_name(found: Sequence[DriveTold]) -> dict[str, Trend]:
    return {trend.parameter: trend for trend in trends(posterior(found), found)}


def test_a_line_through_known_figures() -> None:
    """One part, hardly any noise or scatter: the slope is that of the straight line through the drives' figures."""
    seen = [{"spring_front": 1.0}]
    days = [0.0, 100.0, 250.0, 400.0, 700.0, 730.0]
    found, truth = drives(np.random.default_rng(1), days, springs=-0.04, seen=seen)
    trend = by_name(found)["spring_rate_front_npm"]
    assert trend.per_year == pytest.approx(-0.04 * truth["spring_front"], rel=0.02)
    assert trend.detected
    assert trend.probability < 0.01
    assert trend.text.startswith(f"falls: {trend.per_year:+.0f} N/m a year (")
    assert "about -4 % of the" in trend.text
    assert (trend.from_utc[:10], trend.to_utc[:10], trend.drives) == ("2024-01-01", "2025-12-31", 6)


def test_worn_dampers_are_recovered() -> None:
    rng = np.random.default_rng(2)
    hits, held, scores = 0, 0, []
    for _ in range(25):
        found, truth = drives(rng, np.linspace(0, 730, 12).tolist(), dampers=-0.12)
        trend = by_name(found)["roll_damping_nmsprad"]
        true = -0.12 * sum(0.25 * truth[name] * BEFORE["track_front"][0] ** 2 for name in DAMPERS)
        hits += trend.detected
        held += trend.low <= true <= trend.high
        scores.append((trend.per_year - true) / trend.std)
    assert hits >= 22
    assert held >= 20
    assert abs(np.mean(scores)) < 0.7


def test_springs_of_a_live_axle_roll_by_where_they_stand() -> None:
    """At 0.7 of the track: roll falls by half of what as soft springs at the wheels make of it, and the bar stays."""
    before = BEFORE | {"spring_base_rear": (0.7, 0.003)}
    at_wheels = 0.5 * 1.6**2
    roll = {"spring_rear": at_wheels / 300, "bar_rear": 1 / 300, "track_rear": 38e3 * 1.6 / 300}
    rng, found, truth = np.random.default_rng(4), [], drawn(np.random.default_rng(3))
    truth |= {"spring_base_rear": 0.7, "track_rear": 1.6}
    for number, day in enumerate(np.linspace(0, 800, 12).tolist()):
        spring = truth["spring_rear"] * (1 - 0.08 * day / 365.25)
        bar = truth["bar_rear"] - (1 - 0.7**2) * at_wheels * spring
        drive = Drive(np.array([150.0, 1.4, 0.0, 0.9]), {"spring_rear": spring, "bar_rear": bar})
        seen = [{"spring_rear": 1 / 300}, roll, SPRINGS_SEEN[0], SPRINGS_SEEN[2]]
        wide = before | {"bar_rear": (8e3 - (1 - 0.7**2) * at_wheels * 38e3, 12e3)}
        found.append(told(number, kept(drive, truth, seen, rng.standard_normal(4), before=wide), day))
    trend = by_name(found)
    fallen = -0.08 * truth["spring_rear"]
    rate, stiffness = trend["spring_rate_rear_npm"], trend["roll_stiffness_nmprad"]
    assert rate.detected
    assert abs(rate.per_year - fallen) < 2.5 * rate.std
    assert rate.std < 0.2 * abs(fallen)
    assert abs(stiffness.per_year - 0.7**2 * at_wheels * fallen) < 2.5 * stiffness.std
    assert stiffness.std < 0.25 * abs(at_wheels * fallen)
    # what changes by a share is the bar, and not its unknown, which is less than none here
    days = np.linspace(-400, 400, 12) / 365.25
    slopes = slopes_of(posterior(found), range(12), days)["springs"]
    assert slopes.base[slopes.parts.index("bar_rear")] == pytest.approx(truth["bar_rear"], rel=0.25)


def test_chance_is_as_stated() -> None:
    """Without a trend, with scatter and a yearly wave: 1 % are detected, 5 % lie outside their intervals."""
    rng = np.random.default_rng(4)
    chances = []
    for _ in range(60):
        found, _ = drives(rng, np.sort(rng.uniform(0, 800, 8)).tolist(), season=0.03)
        chances += [t.probability for t in by_name(found).values() if math.isfinite(t.per_year)]
    assert len(chances) > 200
    # six parts of a vehicle are not independent: up to three times what is stated by chance
    assert np.mean(np.array(chances) < 0.01) < 0.03
    assert np.mean(np.array(chances) < 0.05) < 0.10
    assert 0.35 < np.median(chances) < 0.75


def test_winter_and_summer_are_no_wear() -> None:
    """Half a year: dampers in warm and cold oil differ by as much as they wear, and the interval says so."""
    rng = np.random.default_rng(5)
    short, _ = drives(rng, np.linspace(0, 182, 30).tolist())
    long, _ = drives(rng, np.linspace(0, 1095, 30).tolist())
    half, three = (by_name(found)["roll_damping_nmsprad"] for found in (short, long))
    assert math.isfinite(three.per_year)
    assert not half.detected
    assert "cannot be told" in half.text or half.std > 4 * three.std


def test_what_the_relations_do_not_see() -> None:
    found, _ = drives(
        np.random.default_rng(6), np.linspace(0, 730, 8).tolist(), dampers=-0.2, seen=SPRINGS_SEEN
    )
    told_trends = by_name(found)
    blind = told_trends["roll_damping_nmsprad"]
    assert math.isnan(blind.per_year)
    assert not blind.detected
    assert blind.probability == 1.0
    assert blind.text == "cannot be told: these drives' relations do not see this part change"
    assert math.isfinite(told_trends["spring_rate_rear_npm"].per_year)


def test_a_sum_is_told_where_its_parts_are_not() -> None:
    """Relations that see all dampers together: the roll damping's trend, and not that of one axle."""
    seen = [dict.fromkeys(DAMPERS, 1 / 100)]
    found, _ = drives(np.random.default_rng(7), np.linspace(0, 730, 12).tolist(), dampers=-0.15, seen=seen)
    told_trends = by_name(found)
    assert told_trends["roll_damping_nmsprad"].detected
    one = told_trends["damper_rate_front_nspm"]
    assert not one.detected or one.std > 1.5 * 0.5 * told_trends["roll_damping_nmsprad"].std


@pytest.mark.parametrize(
    ("days", "why"),
    [
        ([0.0, 200.0, 400.0, 600.0], "4 drives with a date; a trend needs 5"),
        ([0.0, 5.0, 10.0, 15.0, 20.0, 25.0], "within 25 days; a trend needs 30"),
    ],
)
def test_too_few_or_too_short(days: list[float], why: str) -> None:
    found, _ = drives(np.random.default_rng(8), days)
    all_parts = trends(posterior(found), found)
    assert [t.parameter for t in all_parts] == [p.parameter for p in PARTS]
    assert all(why in t.text and math.isnan(t.per_year) and not t.detected for t in all_parts)


def test_drives_without_a_date_do_not_count() -> None:
    found, _ = drives(np.random.default_rng(9), np.linspace(0, 730, 6).tolist())
    undated = [DriveTold(d.drive_id, None if i < 2 else d.start_utc, {}, d.kept) for i, d in enumerate(found)]
    trend = by_name(undated)["roll_damping_nmsprad"]
    assert trend.drives == 4
    assert "2 more have no date" in trend.text
    nothing = [DriveTold(d.drive_id, "yesterday", {}, d.kept) for d in found]
    assert by_name(nothing)["roll_damping_nmsprad"].from_utc == ""


def test_order_does_not_matter() -> None:
    found, _ = drives(np.random.default_rng(10), np.linspace(0, 730, 7).tolist(), dampers=-0.1)
    shuffled = list(found)
    random.Random(1).shuffle(shuffled)
    for name, trend in by_name(found).items():
        other = by_name(shuffled)[name]
        assert other.per_year == pytest.approx(trend.per_year, rel=1e-6, nan_ok=True)
        assert other.text == trend.text


def test_few_drives_have_wider_tails() -> None:
    """The law is a mixture over scatters: its interval is wider than 1.96 of its narrowest member."""
    found, _ = drives(np.random.default_rng(11), np.linspace(0, 730, 5).tolist())
    at = (np.linspace(0, 730, 5) - 365) / 365.25
    slopes = slopes_of(posterior(found), range(5), at)["dampers"]
    assert slopes.weight.sum() == pytest.approx(1.0)
    weights = np.array([float(name == "bump_front") for name in slopes.parts])
    line = line_of(slopes, weights)
    assert line is not None
    assert line.low < line.slope < line.high
    narrowest = math.sqrt(float(np.min(np.einsum("i,gij,j->g", weights, slopes.covariance, weights))))
    assert line.high - line.low > 2 * 1.96 * narrowest
