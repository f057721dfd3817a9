"""What the weight on wheels does to a body's roll, against the energy of a plane body on two wheels that are thin discs."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from pipelines.joint.vehicle.laden import side_moment
from pipelines.models.roll import GRAVITY

HALF, RADIUS, RATE, SPRUNG, HEIGHT = 0.78, 0.32, 30e3, 1200.0, 0.55


def travel(side: float, lift: float, roll: float, centre: float, upright: float) -> float:
    """How far a wheel's hub is up against the body, with its foot on the ground. side: 1 towards which the body rolls."""

    def foot(d: float) -> float:
        tilt = upright * d / HALF
        out = HALF + centre / HALF * d
        up = d + RADIUS * (1 - np.cos(tilt))
        return float(lift - side * out * np.sin(roll) + up * np.cos(roll))

    return float(brentq(foot, -0.3, 0.3, xtol=1e-14))


def hub_up(d: float, side: float, lift: float, roll: float, centre: float, upright: float) -> float:
    """Height of a hub above ground, m."""
    out = HALF + centre / HALF * d - RADIUS * np.sin(upright * d / HALF)
    return float(lift - side * out * np.sin(roll) + (RADIUS + d) * np.cos(roll))


def energy(lift: float, roll: float, centre: float, upright: float, hub: float) -> float:
    """hub: mass of each wheel of the two, that of both axles."""
    weight = SPRUNG * GRAVITY
    found = weight * (lift + HEIGHT * np.cos(roll))
    for side in (1.0, -1.0):
        d = travel(side, lift, roll, centre, upright)
        found += 0.5 * weight * d + 0.5 * RATE * d * d
        found += 2 * hub * GRAVITY * hub_up(d, side, lift, roll, centre, upright)
    return float(found)


@pytest.mark.parametrize("centre", [0.0, 0.1])
@pytest.mark.parametrize("upright", [0.0, 0.6, 1.0])
@pytest.mark.parametrize("hub", [0.0, 60.0])
def test_the_roll_stiffness_of_discs_is_that_of_springs_weight_and_feet(
    centre: float, upright: float, hub: float
) -> None:
    def least(roll: float) -> float:
        return float(
            minimize_scalar(
                lambda lift: energy(lift, roll, centre, upright, hub), bracket=(-0.01, 0.01), tol=1e-12
            ).fun
        )

    step = 0.01
    found = (least(step) - 2 * least(0.0) + least(-step)) / step**2
    p = {
        "empty_mass": SPRUNG, "lean_path": 0.0, "wheelbase": 2.7, "side_path": 1.0, "wheel_plane": 1.0, "camber": upright, "radius": RADIUS, "hub_low": 0.0, "unsprung_front": 2 * hub, "unsprung_rear": 2 * hub, "axis_sinks": 0.0, "sinks_front": 0.0, "sinks_rear": 0.0, "paths_told": 0.0, "path_front": 0.0, "path_rear": 0.0, "load": 0.0, "free_front": 10.0, "free_rear": 10.0, "stop_front": 0.0, "stop_rear": 0.0,
        "square_front": 0.0, "square_rear": 0.0, "cube_front": 0.0, "cube_rear": 0.0,
        "load_x": 1.3, "spring_front": RATE, "spring_rear": RATE, "roll_center_front": centre, "roll_center_rear": centre,
    }  # fmt: skip
    body = SimpleNamespace(x=1.3, sprung=SPRUNG)
    eased = side_moment(p, body, "front") + side_moment(p, body, "rear")
    tipping = SPRUNG * GRAVITY * (HEIGHT - centre)
    # hubs that lean with the body tip it as they do in the balances' arm
    hubs = 4 * hub * GRAVITY * RADIUS * (1 - upright)
    assert found == pytest.approx(2 * RATE * HALF**2 - tipping - hubs + eased, rel=2e-3)
    # a simple model's weight does not tip the body: what the springs hold is all that holds it
    level = p | {
        "unsprung_front": 0.0,
        "unsprung_rear": 0.0,
        "side_path": 0.0,
        "wheel_plane": 0.0,
        "lean_path": HEIGHT - centre,
    }
    held = side_moment(level, body, "front") + side_moment(level, body, "rear")
    assert held == pytest.approx(tipping)
