"""`cogest reproduce berntorp`: the batch at its bound, what truth means on the full plant, and the study's page."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from pipelines.models.roll import GRAVITY
from pipelines.reproduce.base import Reproduction
from pipelines.reproduce.berntorp import filters, tables
from pipelines.reproduce.berntorp.batch import cramer_rao, fit_batch
from pipelines.reproduce.berntorp.plant import HIGH_SUV, drive, effective
from pipelines.reproduce.berntorp.setup import (
    MATCHED,
    RANGES,
    STEP_S,
    Motion,
    RollBody,
    as_modelled,
    measured,
)
from pipelines.reproduce.berntorp.study import prepare
from pipelines.reproduce.registry import RUNS_OF, paper


@pytest.fixture(scope="module")
def motion() -> Motion:
    return drive(HIGH_SUV)


@pytest.fixture(scope="module")
def matched(motion: Motion) -> Motion:
    return as_modelled(motion, MATCHED)


def test_as_modelled_follows_equation_1(matched: Motion) -> None:
    """(I_x + m h²) φ'' + D φ' + K φ = m h (a_y + g φ), by differences of the roll."""
    roll, rate = matched.roll, matched.rate
    twice = np.gradient(rate, STEP_S)
    moment = MATCHED.mass * MATCHED.height
    total = MATCHED.inertia + moment * MATCHED.height
    left = total * twice + MATCHED.damping * rate + MATCHED.stiffness * roll
    right = moment * (matched.accel + GRAVITY * roll)
    inner = slice(2, -2)
    assert np.abs(left - right)[inner].max() < 0.02 * np.abs(right).max()


def test_batch_recovers_what_made_the_motion_and_takes_the_upper_of_two_mirror_images(
    matched: Motion,
) -> None:
    y = np.column_stack((matched.roll, matched.rate))
    for offsets in (False, True):
        fit = fit_batch(y, matched.accel, MATCHED.mass, MATCHED.inertia, offsets=offsets)
        # the likelihood expects noise: without any, its variance's logarithm pulls by half a per cent
        np.testing.assert_allclose(fit.theta, MATCHED.theta, rtol=0.01)
        assert fit.theta[2] >= np.sqrt(MATCHED.inertia / MATCHED.mass)
        assert fit.misfit < 0.01


def test_bound_is_that_of_the_notes_and_the_batch_reaches_it(matched: Motion) -> None:
    bound = cramer_rao(matched, MATCHED)
    np.testing.assert_allclose(100 * bound / MATCHED.theta, [3.6, 3.3, 3.4], atol=0.15)
    assert (cramer_rao(matched, MATCHED, offsets=True) > bound).all()
    rng = np.random.default_rng(0)
    fits = [fit_batch(*measured(matched, rng), MATCHED.mass, MATCHED.inertia) for _ in range(60)]
    errors = np.array([fit.theta for fit in fits]) - MATCHED.theta
    ratio = np.sqrt(np.mean(errors**2, axis=0)) / bound
    assert (ratio > 0.75).all()
    assert (ratio < 1.25).all()
    stated = np.array([fit.std for fit in fits])
    assert ((np.abs(errors) < 1.96 * stated).mean(axis=0) > 0.85).all()


def test_truth_of_the_full_plant_nears_its_parts_where_it_has_only_those() -> None:
    """Hard tyres, a roll axis on the ground, light wheels: K and D become the suspension's own."""
    bare = replace(
        HIGH_SUV, tire_vertical_rate_front_npm=2e7, tire_vertical_rate_rear_npm=2e7, roll_center_height_front_m=0.0,
        roll_center_height_rear_m=0.0, unsprung_mass_front_kg=0.5, unsprung_mass_rear_kg=0.5, wheel_inertia_front_kgm2=0.01,
        wheel_inertia_rear_kgm2=0.01,
    )  # fmt: skip
    found = effective(bare)
    half = np.array([bare.track_front_m, bare.track_rear_m]) / 2
    rates = np.array([bare.spring_rate_front_npm, bare.spring_rate_rear_npm])
    bars = bare.anti_roll_stiffness_front_nmprad + bare.anti_roll_stiffness_rear_nmprad
    assert found.stiffness == pytest.approx(2 * float(half**2 @ rates) + bars, rel=0.02)
    dampers = [
        (bare.damper_compression_front_nspm + bare.damper_extension_front_nspm) / 2,
        (bare.damper_compression_rear_nspm + bare.damper_extension_rear_nspm) / 2,
    ]
    assert found.damping == pytest.approx(2 * float(half**2 @ dampers), rel=0.03)
    assert found.height == pytest.approx(bare.sprung_cg_height_m, rel=0.01)


def test_the_study_vehicle_lies_in_the_papers_box_and_above_the_mirror() -> None:
    found = effective(HIGH_SUV)
    for value, name in zip(found.theta, ("K", "D", "h"), strict=True):
        assert RANGES[name][0] < value < RANGES[name][1]
    assert found.height > 1.2 * np.sqrt(found.inertia / found.mass)


def test_the_motion_is_a_sine_with_dwell(motion: Motion) -> None:
    assert len(motion.time_s) == 201
    assert motion.accel[0] == pytest.approx(0.0, abs=0.01)
    assert 4.0 < np.abs(motion.accel).max() < 7.0
    assert motion.steering.max() == pytest.approx(-motion.steering.min(), rel=0.15)


def test_measurements_carry_the_stated_noise(matched: Motion) -> None:
    rng = np.random.default_rng(1)
    left = np.concatenate(
        [measured(matched, rng)[0] - np.column_stack((matched.roll, matched.rate)) for _ in range(40)]
    )
    np.testing.assert_allclose(left.std(axis=0), np.radians([0.1, 0.3]), rtol=0.05)


def test_mirror_image_has_the_same_motion(motion: Motion) -> None:
    scale = MATCHED.inertia / (MATCHED.mass * MATCHED.height**2)
    mirror = RollBody(*(scale * MATCHED.theta).tolist(), MATCHED.mass, MATCHED.inertia)  # type: ignore[call-arg]
    np.testing.assert_allclose(
        as_modelled(motion, mirror).roll, as_modelled(motion, MATCHED).roll, atol=1e-10
    )


@pytest.fixture(scope="module")
def page() -> Reproduction:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tables, "SEVERITIES", (2.0,))
        return paper("berntorp").reproduce(3, np.random.default_rng(0), lambda _text, _share: None)


def test_page_holds_every_figure_of_the_paper(page: Reproduction) -> None:
    titles = [*(t.name for t in page.traces), *(s.title for s in page.scatters)]
    for number in range(2, 9):
        assert any(title.startswith(f"Fig {number}:") for title in titles), number
    assert len(page.claims) == 8
    assert {claim.agreement for claim in page.claims} <= {"agrees", "differs", "not shown"}


def test_page_states_raw_and_honest_intervals_of_every_filter(page: Reproduction) -> None:
    for setup in ("richer plant", "plant as modelled"):
        methods = {row.method for row in page.study if row.setup == setup}
        for name in (filters.ALGORITHM, filters.NONBO, filters.NONADAP, filters.FEW, filters.KERNEL):
            assert sum(method.startswith(f"{name}, ") for method in methods) >= 2, name
    rows = {(r.setup, r.method, r.parameter): r for r in page.study}
    assert all(row.bound is not None and row.bound > 0 for row in rows.values())


def test_joined_clouds_have_rows_beside_each_filters_own(page: Reproduction) -> None:
    joined = [row for row in page.study if row.method.endswith(", 4 clouds joined")]
    own = [row for row in page.study if row.method.endswith(", its own interval")]
    assert len(joined) == len(own) == 30
    assert {row.runs for row in joined} == {2}
    assert {row.runs for row in own} == {3}


@pytest.mark.parametrize("build", [filters.algorithm, filters.nonbo, filters.kernel])
def test_four_clouds_hold_the_truth_of_the_plant_as_modelled(
    build: Callable[..., filters.Filter], matched: Motion
) -> None:
    """24 drives: fewer than 19 held is less likely than 1 in 1 000 at a coverage of 0.95."""
    rng = np.random.default_rng(5)
    setup = prepare("plant as modelled", matched, MATCHED, rng)
    chosen = build(setup.started, MATCHED) if build is filters.algorithm else build(MATCHED)
    mean, std = filters.pooled_runs(chosen, matched, 24, rng)
    held = (np.abs(mean - MATCHED.theta) < 1.96 * std).sum(axis=0)
    assert (held >= 19).all()


def test_a_thousand_runs_are_the_default() -> None:
    assert RUNS_OF["berntorp"] == 1000
