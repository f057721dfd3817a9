"""The foreign simulators must be right themselves before they judge: balances that hold whatever their authors chose."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).resolve().parents[2] / "benchmarks"))

import foreign_parts as fp
from foreign_car import G, Load, draw_car, squeezed, with_load
from foreign_course import Course
from foreign_logs import STYLES, Case, make_log

CAR = draw_car(np.random.default_rng(8))
SPEED = np.concatenate([np.full(300, 15.0), np.linspace(15, 7, 200), np.full(300, 7.0)])


def _drive(style: str, steer: float) -> np.ndarray:
    simulator, choices = STYLES[style]
    angle = np.concatenate([np.zeros(100), np.full(len(SPEED) - 100, steer)])
    level = np.zeros(len(SPEED))
    return np.asarray(simulator.run(CAR, Course(SPEED, angle, level, level), choices))


@pytest.mark.parametrize("style", ["planes", "ride", "ride, hubs past the springs", "pillars"])
def test_signs_are_those_of_iso_8855_and_the_wheels_carry_the_weight(style: str) -> None:
    turning, braking = _drive(style, 0.02)[-100:].mean(axis=0), _drive(style, 0.0)[760:960].mean(axis=0)
    assert turning[fp.FY] > 0.2
    assert turning[fp.R] > 0.02
    assert turning[fp.ROLL] > 0
    assert turning[fp.DEFLECTION + 1] > turning[fp.DEFLECTION]
    assert braking[fp.FX] < -2
    assert braking[fp.PITCH] > 0
    assert braking[fp.DEFLECTION] > braking[fp.DEFLECTION + 2]
    assert braking[fp.NORMAL : fp.NORMAL + 4].sum() == pytest.approx(CAR.mass * G, rel=0.01)


@pytest.mark.parametrize(
    "style", ["ride", "ride, hubs past the springs", "ride, axis in the ground", "ride, all simple"]
)
def test_load_transfer_is_the_whole_moment_however_it_is_split(style: str) -> None:
    """Steady turn: side force times CG height, and what the body's shift adds."""
    row = _drive(style, 0.02)[-100:].mean(axis=0)
    normal, half = row[fp.NORMAL : fp.NORMAL + 4], np.array(CAR.track) / 2
    seen = (normal[1] - normal[0]) * half[0] + (normal[3] - normal[2]) * half[1]
    at_rest = -CAR.mass * G * CAR.y
    _, choices = STYLES[style]
    arm = CAR.sprung_height - choices.axis * CAR.axis
    asked = CAR.mass * row[fp.FLAT_Y] * CAR.height + CAR.sprung * G * arm * row[fp.ROLL]
    assert seen - at_rest == pytest.approx(asked, rel=0.02)


def test_a_load_presses_the_springs_by_its_weight() -> None:
    full = with_load(CAR, Load(150.0, CAR.x, 0.2, 1.5), sags=False)
    forces = np.concatenate([CAR.pair(i) @ squeezed(CAR, full)[2 * i : 2 * i + 2] for i in (0, 1)])
    assert forces.sum() == pytest.approx(150.0 * G)
    assert full.height > CAR.height
    assert full.y == pytest.approx((CAR.mass * CAR.y + 30.0) / full.mass)


def test_a_case_is_the_same_drive_twice() -> None:
    case = Case("planes", "dwell", "deflection", "plain", 3)
    one, two = make_log(case), make_log(case)
    assert one.frame.equals(two.frame)
    assert one.vehicle == two.vehicle
    assert {"suspension_deflection_fl_m", "brake_pressure_pa"} <= set(one.frame.columns)
