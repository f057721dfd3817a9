"""Was the load the same in two drives? Against known answers, and its false alarms and power on made-up fleets."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np
import pytest
from scipy.stats import chi2, ncx2

from pipelines.hierarchy.contrast import Contrast, compared, half_seen, share_of
from pipelines.hierarchy.records import DriveTold
from pipelines.results import FloatArray
from tests.pipelines.hierarchy.toy_fleet import BEFORE, SCALES, Drive, drawn, kept, posterior, told, weighed

USUAL = np.array([200.0, 1.6, 0.1, 0.9])
ALL_SEEN = weighed(SCALES, (10.0, 20.0, 5.0, 15.0))


def contrasts(drives: Sequence[DriveTold]) -> list[Contrast]:
    found = posterior(drives)
    precision = np.linalg.inv(found.s_covariance)
    shares = []
    for part, drive in zip(found.parts, drives, strict=True):
        assert drive.kept is not None
        share = share_of(part, drive.kept.mode)
        assert share is not None
        shares.append(share)
    right = precision @ found.s
    return [compared(a, b, precision, right) for a, b in itertools.pairwise(shares)]


def fleet(
    rng: np.random.Generator, loads: Sequence[FloatArray], relations: Sequence[dict[str, float]] = ALL_SEEN
) -> list[DriveTold]:
    """Drives of one vehicle; what is each drive's own is drawn anew in each."""
    truth = drawn(rng)
    found = []
    for number, load in enumerate(loads):
        offset = math.sqrt(0.5) * (truth["offset_x"] + BEFORE["offset_x"][1] * rng.standard_normal())
        near = load * (1 + 0.2 * rng.standard_normal(4))
        noise = rng.standard_normal(len(relations))
        relation = kept(Drive(load, {"offset_x": offset}), truth, relations, noise, mode=near)
        found.append(told(number, relation))
    return found


def test_two_weighings() -> None:
    """One relation, the mass on a scale of 10 kg: chi² is the difference over its standard deviation, squared."""
    scale = weighed(SCALES[:1], (10.0,))
    truth = {name: mean for name, (mean, _) in BEFORE.items()}
    quiet = np.zeros(1)
    drives = [
        told(i, kept(Drive(np.array([kilos, 1.4, 0.0, 0.9]), {}), truth, scale, quiet))
        for i, kilos in enumerate((150.0, 175.0))
    ]
    found = contrasts(drives)[0]
    assert found.figures == 1
    # what is usual for loads still has a little to say of what both have in common, which does not matter here
    assert found.chi2 == pytest.approx(25.0**2 / 200.0, rel=1e-3)
    assert found.probability == pytest.approx(chi2.sf(found.chi2, 1), rel=1e-9)
    assert found.difference[0] == pytest.approx(25.0, rel=0.02)


def test_the_vehicles_own_mass_cancels() -> None:
    """An empty mass known to a ton costs the difference of two loads nothing."""
    scale = weighed(SCALES[:1], (10.0,))
    truth = {name: mean for name, (mean, _) in BEFORE.items()} | {"empty_mass": 2900.0}
    loads = (np.array([150.0, 1.4, 0.0, 0.9]), np.array([175.0, 1.4, 0.0, 0.9]))
    drives = [told(i, kept(Drive(load, {}), truth, scale, np.zeros(1))) for i, load in enumerate(loads)]
    assert contrasts(drives)[0].difference[0] == pytest.approx(25.0, rel=0.02)


def test_false_alarms_and_power() -> None:
    """1 % and 5 % are that of unchanged loads, whatever the load and wherever it was made linear; a change is as likely
    found as the noncentral law says."""
    rng = np.random.default_rng(7)
    chances = []
    for _ in range(150):
        load = np.array(
            [rng.uniform(40, 500), rng.uniform(0.5, 2.6), 0.2 * rng.standard_normal(), rng.uniform(0.6, 1.6)]
        )
        chances += [c.probability for c in contrasts(fleet(rng, [load] * 8))]
    share = np.mean(np.array(chances) < np.array([[0.01], [0.05], [0.5]]), axis=1)
    spread = np.sqrt(np.array([0.01, 0.05, 0.5]) * np.array([0.99, 0.95, 0.5]) / len(chances))
    # neighbours share a drive, so that a little more than binomial
    assert np.all(np.abs(share - [0.01, 0.05, 0.5]) < 4 * spread)


def test_power_is_as_said() -> None:
    rng = np.random.default_rng(8)
    found, said = [], []
    for _ in range(300):
        change = np.array([240.0, 1.6, 0.1, 0.9])
        one = contrasts(fleet(rng, [USUAL, change]))[0]
        moved = np.concatenate([change[:1] - USUAL[:1], change[0] * change[1:] - USUAL[0] * USUAL[1:]])
        strength = float(moved @ one.information @ moved)
        found.append(one.probability < 0.01)
        said.append(float(ncx2.sf(chi2.isf(0.01, one.figures), one.figures, strength)))
    assert 0.1 < np.mean(said) < 0.9
    assert np.mean(found) == pytest.approx(np.mean(said), abs=0.09)


def test_half_seen_is_found_in_half_the_cases() -> None:
    found = contrasts(fleet(np.random.default_rng(1), [USUAL, USUAL]))[0]
    middle = (1.0, 1.4, 0.0, 0.9)
    kilos = half_seen(found, middle, 0.01)
    strength = kilos**2 * float(np.array(middle) @ found.information @ np.array(middle))
    assert ncx2.sf(chi2.isf(0.01, found.figures), found.figures, strength) == pytest.approx(0.5, abs=1e-6)


def test_more_drives_make_it_sharper() -> None:
    """What the drives share is known better with more of them, and helps the difference of two."""
    springs = [
        {"empty_mass": 0.01, "moment 0": 0.1, "spring_front": 0.002},
        {"spring_front": 0.001, "moment 0": -0.02},
    ]
    rng = np.random.default_rng(3)
    few, many = (contrasts(fleet(rng, [USUAL] * n, springs))[0] for n in (2, 12))
    assert many.information[0, 0] >= few.information[0, 0] * (1 - 1e-9)


def test_nothing_seen() -> None:
    """Relations that do not see the load: no figures, and certainly no change."""
    blind = [{"spring_front": 1e-3}]
    found = contrasts(fleet(np.random.default_rng(2), [USUAL, 3 * USUAL], blind))[0]
    assert (found.figures, found.probability) == (0, 1.0)
    assert half_seen(found, (1.0, 1.4, 0.0, 0.9), 0.01) == math.inf


def test_a_drive_without_a_load() -> None:
    truth = {name: mean for name, (mean, _) in BEFORE.items()}
    before = {name: pair for name, pair in BEFORE.items() if not name.startswith("load")}
    relation = kept(Drive(USUAL, {}), truth, [{"spring_front": 1e-3}], np.zeros(1), before=before)
    found = posterior([told(0, relation)])
    assert share_of(found.parts[0], relation.mode) is None
