"""load_balance: what the steered wheels' side force takes from the engine while a vehicle turns in and out of bends."""

from __future__ import annotations

import numpy as np
from plant_balance import Car, vehicle_file

from pipelines.estimators.load_balance.along import along_relation
from pipelines.estimators.load_balance.data import Columns
from pipelines.estimators.load_balance.relations import YAW_OVER_PITCH
from pipelines.joint.vehicle.unknowns import before_the_log, body_of
from pipelines.results import FloatArray

HZ, SPEED = 50.0, 9.0


def steered(mass: float, inertia: float, ahead: float, behind: float) -> dict[str, FloatArray]:
    """A two-wheel vehicle on stiff tyres through cones every 18 m at a held speed: yaw rate, side force, what holds it back."""
    t = np.arange(round(120 * HZ)) / HZ
    length, turn = ahead + behind, np.pi * SPEED / 18.0
    # Fourier's steering of one frequency; tyres of 25 000 N to the degree hardly slip
    stiff = 1.4e6
    angle = 0.11 * np.sin(turn * t)
    a = np.array(
        [
            [-2 * stiff / (mass * SPEED), -SPEED - stiff * (ahead - behind) / (mass * SPEED)],
            [
                -stiff * (ahead - behind) / (inertia * SPEED),
                -stiff * (ahead**2 + behind**2) / (inertia * SPEED),
            ],
        ]
    )
    b = np.array([stiff / mass, stiff * ahead / inertia])
    # the steady answer to a sine: (i w - A)^-1 B
    wave = 0.11 * np.exp(1j * turn * t)
    state = np.linalg.solve(1j * turn * np.eye(2) - a, b)
    side, yaw = (np.imag(state[i] * wave) for i in range(2))
    yaw_acc = np.imag(1j * turn * state[1] * wave)
    accel = np.imag(1j * turn * state[0] * wave) + SPEED * yaw
    front = (behind * mass * accel + inertia * yaw_acc) / length
    slip = angle - (side + ahead * yaw) / SPEED
    assert np.allclose(front, stiff * slip, atol=1e-6 * np.abs(front).max())
    return {"yaw": yaw, "yaw_acc": yaw_acc, "yaw2": yaw**2, "fy": accel, "held": front * angle}


def test_turning_in_costs_what_the_yaw_inertia_takes() -> None:
    known = before_the_log(vehicle_file(Car(), None))
    p = known.at(np.zeros(len(known.names))) | {"corner_drag": 0.0, "drag": 0.0, "rolling": 0.0}
    body = body_of(p, None)
    # the accelerations below are those of the CG
    p |= {"imu_x": body.whole_x, "imu_y": body.whole_y}
    moving = steered(
        body.mass, YAW_OVER_PITCH * p["pitch_inertia"], body.whole_x, p["wheelbase"] - body.whole_x
    )
    n = len(moving["yaw"])
    nothing, rng = np.zeros(n), np.random.default_rng(3)
    columns = {
        "on": nothing, "fx_brake": nothing, "fx_tilt": nothing, "fx_tilt_brake": nothing, "v2_on": nothing,
        "fx": -moving["held"] / body.mass + rng.normal(0, 1e-3, n), "v": np.full(n, SPEED), "v2": np.full(n, SPEED**2),
        "vdot": nothing, "drive": nothing, **{k: v for k, v in moving.items() if k != "held"},
    }  # fmt: skip
    columns["fx_drive"] = columns["fx"]
    columns["dfx"], columns["fy2"] = np.gradient(columns["fx"]) * HZ, columns["fy"] ** 2
    time_s = np.arange(n) / HZ
    data = Columns(columns, time_s, np.floor(time_s / 12).astype(np.int64), HZ, (), None, 0.0, (True, False))
    # nothing drives it: it slows down by what its front wheels hold it back
    relation = along_relation(data, known)
    assert relation is not None
    told = relation.vector(p)
    held = moving["held"][relation.rows]
    names = list(relation.columns)

    def left(*ignored: str) -> float:
        """Share of the front wheels' hold that the balance does not explain, with some of its terms ignored."""
        vector = np.where(np.isin(names, ignored), 0.0, told)
        return float(np.std(relation.table @ vector / p["radius"]) / np.std(held))

    assert left() < 0.1
    assert left("turn_steer") > 2.5 * left()
    assert left("side_steer") > 0.5
