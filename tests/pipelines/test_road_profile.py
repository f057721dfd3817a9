"""Road surfaces: the spectrum and coherence that were asked for, no steps, grades that are slopes of a height."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy import signal

from pipelines.simulation.records import straight_road
from pipelines.simulation.roads.profile import (
    CLASS_ROUGHNESS,
    altitude_m,
    eased_in,
    hump,
    iso_spectrum,
    roughness,
    smoothed,
    terrain_spectrum,
    track_coherence,
    with_roughness,
)

STEP = 0.1


def bands(n, low=0.05, high=2.0, count=10):
    """Rows of each of `count` bands of equal width on a log scale."""
    edges = np.geomspace(low, high, count + 1)
    return [np.flatnonzero((n >= a) & (n < b)) for a, b in pairwise(edges)]


def welch(x, y):
    """Cross spectrum, and how many independent periodograms are in its mean (half overlap, Hann: 0.95 each)."""
    rows = 2048
    n, density = signal.csd(x, y, fs=1 / STEP, nperseg=rows, detrend="constant")
    return n, density, 0.95 * (2 * len(x) / rows - 1)


@pytest.mark.parametrize(
    "spectrum",
    [iso_spectrum("A"), iso_spectrum("C"), iso_spectrum("D", waviness=2.3), terrain_spectrum(4096e-6)],
    ids=["A", "C", "D 2.3", "terrain"],
)
def test_spectrum_of_both_tracks_is_the_one_asked_for(spectrum):
    tracks = roughness(spectrum, 20_000.0, STEP, 1.6, np.random.default_rng(3))
    for track in tracks:
        assert track.shape == (200_001,)
        n, density, means = welch(track, track)
        for rows in bands(n):
            ratio = np.mean(density[rows].real / spectrum(n[rows]))
            # a periodogram's relative deviation is 1; four deviations, and 2 % for the window's leakage
            assert abs(ratio - 1) < 4 / np.sqrt(means * len(rows) / 1.5) + 0.02


def test_classes_have_the_standards_levels():
    assert CLASS_ROUGHNESS["A"] == pytest.approx(16e-6)
    assert CLASS_ROUGHNESS["C"] == pytest.approx(256e-6)
    assert CLASS_ROUGHNESS["H"] == pytest.approx(262_144e-6)
    n = np.array([0.005, 0.1, 0.2, 20.0])
    assert iso_spectrum("C")(n) == pytest.approx([0, 256e-6, 64e-6, 0])
    assert terrain_spectrum(1e-3)(np.array([0.1])) == pytest.approx([1e-3])


def test_tracks_agree_in_long_waves_and_not_in_short_ones():
    track = 1.6
    left, right = roughness(iso_spectrum("C"), 20_000.0, STEP, track, np.random.default_rng(5))
    n, cross, means = welch(left, right)
    _, own, _ = welch(left, left)
    for rows in bands(n):
        found = np.mean(cross[rows].real / own[rows].real)
        expected = np.mean(track_coherence(n[rows], track))
        assert abs(found - expected) < 4 / np.sqrt(means * len(rows) / 1.5) + 0.02
    assert track_coherence(np.array([0.001]), track)[0] > 0.99
    assert track_coherence(np.array([2.0]), track)[0] < 0.01


def test_a_periodic_profile_has_no_seam():
    left, right = roughness(iso_spectrum("B"), 900.0, STEP, 1.6, np.random.default_rng(1), periodic=True)
    assert left.shape == right.shape == (9000,)
    for track in (left, right):
        steps = np.diff(np.concatenate((track, track[:2])))
        assert np.abs(steps[-2:]).max() < 5 * steps.std()


def test_roughness_scales_with_its_root_and_repeats_for_a_seed():
    draws = [roughness(iso_spectrum("C", k), 200.0, STEP, 1.6, np.random.default_rng(9)) for k in (1, 1, 4)]
    assert np.array_equal(draws[0][0], draws[1][0])
    assert draws[2][1] == pytest.approx(2 * draws[0][1])


def test_a_rough_road_begins_flat_and_keeps_the_rest():
    road = straight_road(100.0, 0.7)
    left, right = roughness(iso_spectrum("E"), 101.0, STEP, 1.6, np.random.default_rng(2))
    rough = with_roughness(road, left, right, STEP)
    assert rough.left_m[0] == rough.right_m[0] == 0
    assert rough.left_m[60:] == pytest.approx(left[60:])
    assert np.all(rough.friction_left == 0.7)
    lengths = {len(v) for v in vars(rough).values() if isinstance(v, np.ndarray)}
    assert lengths == {len(left)}


def test_altitude_is_the_integral_of_the_grade():
    road = straight_road(500.0, step_m=0.5)
    place = 0.5 * np.arange(len(road.grade_rad))
    grade = smoothed(np.where((place > 100) & (place < 300), 0.1, 0.0), 0.5, 40.0)
    tilted = type(road)(**{**vars(road), "grade_rad": grade})
    height = altitude_m(tilted)
    assert np.gradient(height, 0.5) == pytest.approx(np.sin(grade), abs=2e-4)
    assert height[-1] == pytest.approx(200 * np.sin(0.1), rel=0.01)
    # smooth: the grade's own slope is that of a 40 m raised cosine at most
    assert np.abs(np.diff(grade)).max() < 0.1 / 40 * 2.1 * 0.5


def test_hump_and_ease_are_level_at_their_ends():
    x = np.arange(0, 20, 0.01)
    bump = hump(x, 5.0, 3.7, 0.07)
    assert bump.max() == pytest.approx(0.07, rel=1e-3)
    assert bump[x < 5].max() == bump[x > 8.71].max() == 0
    assert np.abs(np.diff(bump)).max() < 0.07 * np.pi / 3.7 * 0.0101
    ease = eased_in(x, 4.0, 2.0)
    assert (ease[0], ease[-1]) == (0, 1)
    assert np.all(np.diff(ease) >= 0)


def test_smoothing_keeps_constants_and_sums():
    assert smoothed(np.full(50, 3.0), 0.1, 1.0) == pytest.approx(np.full(50, 3.0))
    pulse = np.zeros(200)
    pulse[100] = 1.0
    soft = smoothed(pulse, 0.1, 2.0)
    assert soft.sum() == pytest.approx(1.0)
    assert np.flatnonzero(soft > 1e-12)[[0, -1]] == pytest.approx([90, 110])
