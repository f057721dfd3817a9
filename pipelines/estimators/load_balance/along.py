"""The longitudinal balance: drive and brake torque against the longitudinal specific force. It tells the mass.

    s_d T_d - s_b T_b = R (m (f_x + g pitch) + D + f_r m g) + 4 I_w v'/R

R is that of the wheels that brake, or drive: tyres roll on a third less than their squash, and loads move with f_x.

Grade drops out, as specific force and tyre forces both are along the road; the torques' scales stay unknowns.
"""

from __future__ import annotations

import numpy as np

from pipelines.estimators.load_balance.attitude import nod
from pipelines.estimators.load_balance.data import Columns
from pipelines.estimators.load_balance.forces import Terms, add, air_pressure
from pipelines.estimators.load_balance.relations import YAW_OVER_PITCH, Coefficients, Relation, make_relation
from pipelines.joint.vehicle.body import BRAKED_FRONT, even_factor
from pipelines.joint.vehicle.unknowns import TOWED, Body, Known, Values, body_of
from pipelines.models.roll import GRAVITY

SLOWEST = 3.0
"""m/s: slower than that the brakes hold what they must, and wheel speeds are coarse."""


def rolling_radius(p: Values, body: Body, front: float) -> tuple[float, float]:
    """Of the wheels that brake or drive: m, and by how much it grows per m/s² of f_x. front: the front axle's share.

    `radius` is the mean of all four under the empty vehicle.
    """
    third = 1 / (3 * p["tyre_rate"])
    share = body.whole_x / p["wheelbase"]
    carried = 0.5 * body.mass * GRAVITY * (front * (1 - share) + (1 - front) * share)
    radius = p["radius"] + third * (0.25 * p["empty_mass"] * GRAVITY - carried)
    return radius, third * (2 * front - 1) * body.moment / (2 * p["wheelbase"])


def along_terms(
    sag: float | None, drive: bool, brake: bool, by_pressure: bool, gain: float, guessed: bool, springs: bool
) -> Coefficients:
    """The longitudinal balance, over the radius: forces. Rows are split into braking and not braking.

    drive: the torque that drives is logged, what an engine holds back while braking in it too.
    guessed: the body's pitch follows from the acceleration, not from deflections: by springs and tyres where their
    rates are known (springs), else by what is usual.
    """

    def coefficients(p: Values) -> Terms:
        body, terms = body_of(p, sag), Terms()
        # where pitch is guessed, its motion on the road is missing: simulated cars came out 2-5 % too light
        grip = 1 + p["gain_long"] * (1.5 if guessed and springs else 3.0 if guessed else 1.0)
        scale = {kind: even_factor(p[f"{kind}_scale"]) for kind in ("brake", "drive")}
        if by_pressure:
            scale["brake"] = even_factor(p["brake_gain"] / gain)
        # one torque alone stands for both: a log without the other has no scale of it
        scale = {"brake": scale["brake" if brake else "drive"], "drive": scale["drive" if drive else "brake"]}
        if brake:
            add(terms, "brake", -1.0)
        if drive:
            add(terms, "drive", 1.0)
        for mode, name, front in (("brake", "on", BRAKED_FRONT), ("drive", "off", p["drive_front"])):
            radius, grows = rolling_radius(p, body, front)
            # what is towed takes part in all that goes along the road
            moved = body.mass + p[TOWED] * (p["pushes"] if mode == "brake" else 1.0)
            mass = grip * radius * moved / scale[mode]
            add(terms, f"fx2_{mode}", -grip * grows * moved / scale[mode])
            if guessed and springs:
                add(terms, f"fx_{mode}", -mass * (1 + (0.5 + 0.5 * p["tilt"]) * GRAVITY * nod(p, mode, sag)))
            else:
                add(terms, f"fx_{mode}", -mass)
                add(terms, f"fx_tilt_{mode}", -mass * (p["tilt"] if guessed else 1.0))
            add(terms, f"fz_{name}", -mass * p["askew_pitch"])
            # what a nose that a load lifts reads of gravity is in the offset, here as in every relation that shares it
            held = 0.0 if drive else p["engine_drag"]
            add(terms, name, -mass * (p["offset_x"] + GRAVITY * p["rolling"] + held))
            if not drive:
                add(terms, f"fx_{mode}", mass * p["recovered"])
            add(terms, f"v2_{name}", -radius * air_pressure(p) * p["drag"] / scale[mode])
        radius = p["radius"]
        mean = scale["drive"]
        add(terms, "vdot", -4 * p["wheel_inertia"] / radius / mean)
        add(terms, "fy2", -radius * p["corner_drag"])
        # the steered wheels' side force points backwards: F_yf sin(steer), with steer = L r / v and F_yf = (m b f_y + I_zz r') / L;
        # what the tyres' slip adds to the angle goes with the square of the side force (`corner_drag`)
        add(terms, "side_steer", -radius * body.mass * (p["wheelbase"] - body.whole_x) / mean)
        add(terms, "turn_steer", -radius * YAW_OVER_PITCH * p["pitch_inertia"] / mean)
        # the inertial unit ahead of the CG, or to its left, reads less of what turns the vehicle, or more: left out, the CG comes to
        # where the unit is
        add(terms, "yaw2", -radius * body.mass * (body.whole_x - p["imu_x"]) / mean)
        add(terms, "yaw_acc", -radius * body.mass * (p["imu_y"] - body.whole_y) / mean)
        add(terms, "dfx", radius * body.mass * p["late_long"])
        return terms

    return coefficients


def pads_terms(gain: float) -> Coefficients:
    """Brake torque as logged against pressure times the vehicle file's gain: each has a scale, and both mean the same pads."""

    def coefficients(p: Values) -> Terms:
        return {
            "brake": even_factor(p["brake_scale"]),
            "pushed": -even_factor(p["brake_gain"] / gain) * (1 + p["pads"]),
            "one": p["brake_zero"],
        }

    return coefficients


def pads_relation(data: Columns, known: Known) -> Relation | None:
    """It binds the two scales; None where torque or pressure or its gain is missing."""
    c = data.columns
    if not data.has("brake", "pushed"):
        return None
    gain = float(known.mean[known.index("brake_gain")])
    # at rest brakes hold as much as they must and not what pressure gives
    where = (c["v"] > SLOWEST) & (c["on"] > 0.98)
    return make_relation(
        "along by pressure", "brake torque against brake pressure", data, {}, pads_terms(gain), ("on", "pushed"),
        where.astype(float), known, least_s=5.0,
    )  # fmt: skip


def along_relation(data: Columns, known: Known) -> Relation | None:
    """The balance of torques, or None where there are none or the longitudinal acceleration is missing."""
    drive, brake = data.has_torque
    if not (drive or brake) or not data.has("fx"):
        return None
    c = data.columns
    on = c["on"]
    off = 1 - on
    extra = {
        "off": off,
        "fx_tilt_drive": c["fx_tilt"] - c["fx_tilt_brake"],
        "v2_off": c["v2"] - c["v2_on"],
        "fx2_brake": c["fx_brake"] ** 2,
        "fx2_drive": c["fx_drive"] ** 2,
    }
    if data.has("yaw"):
        steer = c["yaw"] / np.maximum(c["v"], SLOWEST)
        extra["turn_steer"] = c["yaw_acc"] * steer
        extra["side_steer"] = c["fy"] * steer if data.has("fy") else c["yaw2"]
    if "fz" in c:
        extra |= {"fz_on": c["fz"] * on, "fz_off": c["fz"] * off}
    where = (c["v"] > SLOWEST) & ~(np.abs(c.get("fy", np.zeros(len(on)))) > 3.0)
    if not drive:
        where = where & (on > 0.98)
    if not brake:
        where = where & (on < 0.02)
    gain = float(known.mean[known.index("brake_gain")])
    terms = along_terms(
        data.sag, drive, brake, "by_pressure" in c, gain, "deflection" not in data.kinds, known.springs
    )
    # the torques are the instruments: a rough road shakes the acceleration, and its shaking would lower the mass
    names = ["brake", "drive", "dfx", "fy2"]
    # where only braking is looked at, what is left of the rest is the smoothed edges of the pedals: it would test the filter
    names += ["on", "v2_on"] if brake else []
    names += ["off", "v2_off"] if drive else []
    return make_relation("along", "torque against longitudinal acceleration", data, extra, terms, names,
                     where.astype(float), known)  # fmt: skip
