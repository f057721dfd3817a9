"""Distributions over the drive: the figure, its densities, results.json and the archive."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sample_results import bare, hostile, rich

from pipelines.drive_results import DriveResults
from pipelines.results import Distribution
from reports.archive import load_results, save_results
from reports.figures.distributions import density, draw, level, usable
from reports.figures.drawing import Drawing, Missing
from reports.results_json import to_json
from tests.reports.sample_distributions import distribution, particle_filter


def only(found: Distribution) -> DriveResults:
    good = rich()
    return replace(good, estimates=(replace(particle_filter(), distributions=(found,)),))


def test_density_of_normal_quantiles_is_normal() -> None:
    from statistics import NormalDist

    levels = tuple(float(x) for x in np.linspace(0.005, 0.995, 41))
    quantiles = np.array([NormalDist(3.0, 0.5).inv_cdf(share) for share in levels])
    grid = np.linspace(1.0, 5.0, 201)
    found = density(levels, quantiles, grid)
    assert np.trapezoid(found, grid) == pytest.approx(1.0, abs=0.02)
    expected = np.array([NormalDist(3.0, 0.5).pdf(x) for x in grid])
    assert np.abs(found - expected).max() < 0.1 * expected.max()


def test_two_peaks_stay_two() -> None:
    levels = tuple(float(x) for x in np.linspace(0.02, 0.98, 25))
    quantiles = np.where(np.array(levels) < 0.5, 0.4, 0.8) + 0.02 * np.array(levels)
    grid = np.linspace(0.3, 0.9, 121)
    found = density(levels, quantiles, grid)
    peaks = np.flatnonzero((found[1:-1] > found[:-2]) & (found[1:-1] > found[2:]))
    assert len(peaks) == 2


def test_levels_between_are_interpolated() -> None:
    found = distribution("cg_height_m", 0.6, 0.02)
    np.testing.assert_allclose(level(found, 0.5), found.quantiles[3])
    np.testing.assert_allclose(level(found, 0.175), 0.5 * (found.quantiles[1] + found.quantiles[2]))


def test_drawn_with_a_panel_pair_a_parameter() -> None:
    drawn = draw(rich())
    assert isinstance(drawn, Drawing)
    text = " ".join(drawn.svgs)
    for title in ("Roll stiffness", "Roll damping", "CG height above ground"):
        assert title in text
    assert "Of the filter" in drawn.caption
    assert "reference" in drawn.caption
    assert sum(len(svg) for svg in drawn.svgs) < 300_000


def test_nothing_to_draw_says_so() -> None:
    missing = draw(bare())
    assert isinstance(missing, Missing)
    assert "no estimator" in missing.reason


def test_what_cannot_be_drawn_is_left_out() -> None:
    good = distribution("cg_height_m", 0.6, 0.02)
    assert usable(good)
    short = replace(good, time_s=good.time_s[:1], quantiles=tuple(q[:1] for q in good.quantiles))
    falling = replace(good, levels=tuple(reversed(good.levels)))
    uneven = replace(good, quantiles=good.quantiles[:-1])
    nothing = replace(good, quantiles=tuple(np.full_like(q, np.nan) for q in good.quantiles))
    for bad in (short, falling, uneven, nothing):
        assert not usable(bad)
        assert isinstance(draw(only(bad)), Missing)


def test_gaps_in_time_and_flat_distributions_are_drawn() -> None:
    good = distribution("cg_height_m", 0.6, 0.02)
    holes = tuple(np.where(np.arange(40) < 5, np.nan, q) for q in good.quantiles)
    assert isinstance(draw(only(replace(good, quantiles=holes))), Drawing)
    flat = tuple(np.full(40, 0.6) for _ in good.levels)
    assert isinstance(draw(only(replace(good, quantiles=flat))), Drawing)


def test_hostile_texts_are_escaped() -> None:
    drawn = draw(hostile())
    assert isinstance(drawn, Drawing)
    assert "<script" not in " ".join(drawn.svgs)


def test_json_and_archive_keep_them(tmp_path: Path) -> None:
    results = rich()
    entry = next(e for e in to_json(results)["estimates"] if e["estimator"] == "marginalized_particle_filter")
    assert [d["parameter"] for d in entry["distributions"]][2] == "cg_height_m"
    first = entry["distributions"][0]
    assert len(first["quantiles"]) == len(first["levels"])
    assert len(first["quantiles"][0]) == len(first["time_s"])
    save_results(results, tmp_path / "results.archive.json")
    again = load_results(tmp_path / "results.archive.json")
    before = next(e for e in results.estimates if e.distributions).distributions[0]
    after = next(e for e in again.estimates if e.distributions).distributions[0]
    assert after.levels == before.levels
    for one, other in zip(after.quantiles, before.quantiles, strict=True):
        np.testing.assert_array_equal(one, other)
