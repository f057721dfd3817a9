"""The specific force at the CG, from the inertial unit's own: its place, offsets and how askew it sits, as terms of a balance."""

from __future__ import annotations

from pipelines.estimators.load_balance.forces import Terms, add, add_swing
from pipelines.joint.vehicle.unknowns import Body, Values


def _place(p: Values, body: Body) -> tuple[float, float, float]:
    """The inertial unit from the sprung CG: ahead, left, above."""
    return body.x - p["imu_x"], p["imu_y"] - body.y, p["imu_h"] - body.h


def forward(
    p: Values, body: Body, amount: float, terms: Terms, split: tuple[float, float] | None = None
) -> None:
    """Adds amount * f_x at the CG. split: other amounts while braking and while driving (offsets take the mean)."""
    rx, ry, rz = _place(p, body)
    for name, part in zip(("fx_brake", "fx_drive"), split or (amount, amount), strict=True):
        add(terms, name, part)
    add(terms, "one", amount * p["offset_x"])
    add(terms, "fy", -amount * p["askew_yaw"])
    add(terms, "fz", amount * p["askew_pitch"])
    add_swing(terms, "pitch", -amount * rz, p)
    add(terms, "yaw_acc", amount * ry)
    add(terms, "yaw2", amount * rx)


def sideways(p: Values, body: Body, amount: float, terms: Terms) -> None:
    """Adds amount * f_y at the CG."""
    rx, ry, rz = _place(p, body)
    add(terms, "fy", amount)
    add(terms, "one", amount * p["offset_y"])
    add(terms, "fx", amount * p["askew_yaw"])
    add(terms, "fz", -amount * p["askew_roll"])
    add(terms, "yaw_acc", -amount * rx)
    add_swing(terms, "roll", amount * rz, p)
    add(terms, "yaw2", amount * ry)


def upward(p: Values, body: Body, amount: float, terms: Terms) -> None:
    """Adds amount * f along the road's normal at the CG."""
    rx, ry, _ = _place(p, body)
    add(terms, "fz", amount)
    add(terms, "fz_tilt", amount)
    add(terms, "one", amount * p["offset_z"])
    add(terms, "fx", -amount * p["askew_pitch"])
    add(terms, "fy", amount * p["askew_roll"])
    add_swing(terms, "roll", -amount * ry, p)
    add_swing(terms, "pitch", amount * rx, p)
