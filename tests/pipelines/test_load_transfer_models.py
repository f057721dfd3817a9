"""LTM, MLTM and HFLTM: forces sum to m A_z, moments close, signs by a free body, one model as a case of the other."""

from __future__ import annotations

import numpy as np
import pytest

from pipelines.models.load_transfer import (
    Motion,
    Size,
    bounce,
    corners_from_imu,
    hfltm_forces,
    level,
    ltm_forces,
    mltm_forces,
    position,
    rotation,
    vertical_at_cg,
)
from pipelines.models.roll import GRAVITY

SIZE = Size(2.8, 1.6)
MASS, BEHIND, LEFT, ROLL_ARM, PITCH_ARM, DRAG = 1700.0, 1.3, 0.77, 0.6, 0.55, 0.5


def motion(rows: int = 40, seed: int = 0) -> Motion:
    rng = np.random.default_rng(seed)
    return Motion(
        rng.normal(0, 2, rows), rng.normal(0, 3, rows), GRAVITY + rng.normal(0, 1, rows), rng.normal(0, 0.03, rows),
        rng.normal(0, 0.02, rows), rng.uniform(5, 30, rows),
    )  # fmt: skip


def still(**changes: float) -> Motion:
    values = {
        "accel_x": 0.0,
        "accel_y": 0.0,
        "vertical": GRAVITY,
        "roll": 0.0,
        "pitch": 0.0,
        "speed": 0.0,
    } | changes
    return Motion(**{name: np.array([value]) for name, value in values.items()})


def forces(m: Motion) -> np.ndarray:
    return ltm_forces(m, SIZE, MASS, BEHIND, LEFT, ROLL_ARM, PITCH_ARM, DRAG)


def masses() -> np.ndarray:
    front, left = 1 - BEHIND / SIZE.wheelbase, 1 - LEFT / SIZE.track
    return MASS * np.array([front * left, front * (1 - left), (1 - front) * left, (1 - front) * (1 - left)])


def test_forces_sum_to_the_weight_and_moments_close() -> None:
    m = motion()
    f = forces(m)
    assert f.sum(axis=1) == pytest.approx(MASS * m.vertical)
    # about the CG: left less right, and rear less front
    across = LEFT * (f[:, 0] + f[:, 2]) - (SIZE.track - LEFT) * (f[:, 1] + f[:, 3])
    assert across == pytest.approx(-MASS * m.vertical * ROLL_ARM * (m.accel_y / GRAVITY + m.roll))
    along = (SIZE.wheelbase - BEHIND) * (f[:, 2] + f[:, 3]) - BEHIND * (f[:, 0] + f[:, 1])
    pushed = MASS * m.vertical * (m.accel_x / GRAVITY - m.pitch) + DRAG * m.speed**2
    assert along == pytest.approx(PITCH_ARM * pushed)


@pytest.mark.parametrize(
    ("change", "heavier", "lighter"),
    [
        ({"accel_y": 3.0}, (1, 3), (0, 2)),
        ({"roll": 0.05}, (1, 3), (0, 2)),
        ({"accel_x": 3.0}, (2, 3), (0, 1)),
        ({"pitch": 0.05}, (0, 1), (2, 3)),
        ({"speed": 30.0}, (2, 3), (0, 1)),
    ],
)
def test_signs_of_a_free_body(
    change: dict[str, float], heavier: tuple[int, int], lighter: tuple[int, int]
) -> None:
    """A left turn or a lean to the right loads the right, driving and drag the rear, a nose that is down the front."""
    moved = (forces(still(**change)) - forces(still()))[0]
    assert moved[list(heavier)].min() > 0
    assert moved[list(lighter)].max() < 0


def test_a_leaning_body_on_level_ground_stands_as_its_cg_does() -> None:
    """Static free body: the CG h above the roll axis moves by h sin(roll) to the right."""
    roll = 0.04
    f = forces(still(roll=roll))[0]
    share = (f[1] + f[3]) / f.sum()
    assert share == pytest.approx((LEFT + ROLL_ARM * roll) / SIZE.track)


def test_a_body_axis_accelerometer_holds_the_lean_already() -> None:
    roll, lateral = 0.06, 4.0
    read = lateral * np.cos(roll) + GRAVITY * np.sin(roll)
    normal = GRAVITY * np.cos(roll) - lateral * np.sin(roll)
    _, across = level(np.zeros(1), np.array([read]), np.array([normal]), np.array([roll]), np.zeros(1))
    assert across[0] == pytest.approx(lateral)
    assert read / GRAVITY == pytest.approx(lateral / GRAVITY + roll, abs=2e-3)


def test_mltm_is_the_ltm_where_all_corners_move_alike() -> None:
    m = motion()
    corners = np.repeat(m.vertical[:, None], 4, axis=1)
    modified = mltm_forces(m, corners, SIZE, masses(), ROLL_ARM, PITCH_ARM, DRAG)
    assert modified == pytest.approx(forces(m), rel=1e-12)
    assert position(masses(), SIZE) == pytest.approx((MASS, BEHIND, LEFT))
    assert bounce(masses(), corners) == pytest.approx(modified.sum(axis=1))


def test_hfltm_is_the_mltm_with_equal_arms_and_without_drag_and_angles() -> None:
    m = motion()
    flat = Motion(m.accel_x, m.accel_y, m.vertical, np.zeros(40), np.zeros(40), np.zeros(40))
    corners = GRAVITY + np.random.default_rng(1).normal(0, 1, (40, 4))
    arms = np.array([ROLL_ARM] * 3 + [PITCH_ARM] * 2)
    quick = hfltm_forces(m, corners, SIZE, masses(), arms)
    assert quick == pytest.approx(mltm_forces(flat, corners, SIZE, masses(), ROLL_ARM, PITCH_ARM, 0.0))


def test_rigid_body_kinematics_go_there_and_back() -> None:
    """Corners from one unit at the CG: (117) gives its reading back, (102) and (104) the accelerations."""
    rng = np.random.default_rng(2)
    heave, roll, pitch = GRAVITY + rng.normal(0, 1, 30), rng.normal(0, 1, 30), rng.normal(0, 1, 30)
    corners = corners_from_imu(heave, roll, pitch, (BEHIND, SIZE.track / 2 - LEFT), SIZE)
    assert vertical_at_cg(corners, masses(), SIZE) == pytest.approx(heave)
    assert rotation(corners, SIZE)[0] == pytest.approx(roll)
    assert rotation(corners, SIZE)[1] == pytest.approx(pitch)
    # left side up is right side down; nose down lifts the rear
    lifted = corners_from_imu(np.zeros(1), np.ones(1), np.ones(1), (1.4, 0.0), SIZE)[0]
    assert lifted[0] > lifted[1]
    assert lifted[2] > lifted[0]
