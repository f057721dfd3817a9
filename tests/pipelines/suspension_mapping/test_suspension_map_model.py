"""(146)-(150) as pure functions: signs, known values, and friction against its closed form."""

from __future__ import annotations

import numpy as np
import pytest

from parsers.signals import WHEELS
from pipelines.models.suspension_map import (
    GRAVITY,
    dry_friction,
    eta_lateral,
    eta_longitudinal,
    ground_force,
    lateral_height,
    longitudinal_height,
)


def test_a_left_turn_unloads_the_left_side_and_braking_loads_the_front() -> None:
    assert [np.sign(lateral_height(w, 0.5, 0.1, 1.6)) for w in WHEELS] == [-1, 1, -1, 1]
    assert [np.sign(longitudinal_height(w, 0.5, 0.3, 2.8)) for w in WHEELS] == [-1, -1, 1, 1]


def test_load_transfer_is_moved_not_made() -> None:
    total = sum(lateral_height(w, 0.5, 0.1, 1.6) for w in WHEELS)
    assert total == pytest.approx(0.0)
    # moment about the x axis: half the track times what each side gains
    gained = lateral_height("fr", 0.55, 0.1, 1.6) + lateral_height("rr", 0.45, 0.1, 1.6)
    assert gained * 1.6 == pytest.approx(0.1)


def test_ground_force_by_hand() -> None:
    n = np.ones(3)
    force = ground_force(4000 * n, 50.0, 2 * n, -300 * n, 100 * n)
    assert force == pytest.approx(4000 + 50 * (GRAVITY + 2) - 300 + 100)


def test_eta_is_one_at_rest_and_falls_with_what_it_is_told_of() -> None:
    a_y, zero = np.array([3.0, -3.0]), np.zeros(2)
    assert eta_lateral(a_y, zero, zero) == pytest.approx(1.0)
    heave = np.array([0.1, 0.1])
    # (1 - |x|)² where a_y and x have the same sign, (1 + ...)² would need another sign of both
    assert eta_longitudinal(a_y, heave) == pytest.approx([0.81, 1.21])
    lean = np.array([0.05, 0.05])
    assert eta_lateral(a_y, heave, lean) == pytest.approx([0.81 * 0.95**2, 1.21 * 1.05**2])


def test_dry_friction_turns_over_within_its_travel_and_ignores_noise() -> None:
    travel = 0.002
    out = np.concatenate((np.linspace(0, 0.02, 200), np.linspace(0.02, 0.0, 200)))
    starts = np.zeros(400)
    starts[0] = 1
    state = dry_friction(out, starts, travel)
    k = np.arange(200)
    assert state[:200] == pytest.approx(1 - np.exp(-(0.02 / 199) * k / travel), abs=1e-12)
    assert state[-1] < -0.99
    rng = np.random.default_rng(0)
    noisy = 0.02 + 1e-5 * rng.standard_normal(400)
    assert np.abs(dry_friction(noisy, starts, travel)).max() < 0.2


def test_friction_starts_anew_where_a_stretch_begins() -> None:
    deflection = np.linspace(0, 0.02, 100)
    starts = np.zeros(100)
    starts[[0, 50]] = 1
    assert dry_friction(deflection, starts, 0.002)[50] == 0.0
