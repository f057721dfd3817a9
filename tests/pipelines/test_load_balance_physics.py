"""load_balance: what passes the links by, what the pads bind, and how sure weighted rows are."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from plant_balance import Car, vehicle_file

from pipelines.estimators.load_balance.along import along_terms, pads_relation, rolling_radius
from pipelines.estimators.load_balance.attitude import nod, pitch_compliance
from pipelines.estimators.load_balance.data import Columns
from pipelines.estimators.load_balance.relations import YAW_OVER_PITCH, Relation, pitch_terms, roll_terms
from pipelines.estimators.load_balance.solve import solve
from pipelines.joint.vehicle.body import hub_height
from pipelines.joint.vehicle.unknowns import Known, before_the_log, body_of
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Quantity, Vehicle

G = 9.80665


def test_drag_and_rolling_resistance_do_not_reach_the_brakes_links() -> None:
    """At a steady deceleration the links carry pitch_center * (what the brakes make), and the rest as when driven."""
    known = before_the_log(vehicle_file(Car(), None))
    p = known.at(np.zeros(len(known.names))) | {
        "pitch_center_brake": 0.2, "pitch_center_drive": 0.05, "patch_lag": 0.0, "offset_x": 0.0, "rolling_shift": 0.0,
        "jack_brake": 0.0, "jack_drive": 0.0, "poles_sink": 0.0,
    }  # fmt: skip
    # arms whose poles stand as high as the hubs: no moment of the hubs' inertia about them
    p["hubs_past"] = 0.2 / hub_height(p)
    body, speed, f_x = body_of(p, None), 20.0, -2.0
    drag = 0.5 * 1.204 * p["air"] * p["drag"] * speed**2
    rolling = p["rolling"] * body.mass * G
    brakes = -(body.mass * f_x + drag + rolling)
    terms = pitch_terms("suspension", known, None)(p)
    row = {"fx_brake": f_x, "v2": speed**2, "v2_on": speed**2, "on_rolling": 1.0}
    lift = (
        0.5
        * 1.204
        * p["air"]
        * speed**2
        * (body.x * p["lift_front"] + (body.x - p["wheelbase"]) * p["lift_rear"])
    )
    found = sum(terms[name] * value for name, value in row.items()) - lift
    carried = 0.2 * brakes + 0.05 * rolling
    assert found == pytest.approx(body.moment * f_x + drag * p["drag_height"] + carried)


def test_a_lagging_patch_reads_as_height() -> None:
    known = before_the_log(vehicle_file(Car(), None))
    p = known.at(np.zeros(len(known.names)))
    mass = body_of(p, None).mass
    higher = p | {"patch_lag": p["patch_lag"] + 0.01}
    # a load has the patches give more, as its own braking force does
    for kind, moved in (("suspension", 0.01 * mass * mass / p["empty_mass"]), ("tyre", 0.0)):
        terms = pitch_terms(kind, known, None)
        assert terms(higher)["fx_brake"] - terms(p)["fx_brake"] == pytest.approx(moved)


def test_an_engine_that_holds_back_pushes_on_the_links_as_driving_does() -> None:
    """While the brakes are on: as far as its torque is all that slows the vehicle, or what is usual where no torque is logged."""
    known = before_the_log(vehicle_file(Car(), None))
    p = known.at(np.zeros(len(known.names))) | {"pitch_center_brake": 0.2, "pitch_center_drive": 0.05}
    terms = pitch_terms("suspension", known, None)(p)
    a_metre = body_of(p, None).mass * p["radius"]
    assert terms["fx_brake"] != pytest.approx(terms["fx_drive"], rel=0.1)
    assert terms["fx_brake"] + terms["drive_on"] * a_metre == pytest.approx(terms["fx_drive"])
    assert -terms["fx_brake"] * p["engine_drag"] + terms["held_on"] == pytest.approx(
        -terms["fx_drive"] * p["engine_drag"]
    )


def test_hubs_on_swing_arms_pass_the_springs_by() -> None:
    """With all of it past, the springs miss what hubs push at their own height; tyres miss nothing.

    Arms to the middle of the car carry the body's own inertia at the poles' height and all of the hubs', as textbooks part it.
    """
    known = before_the_log(vehicle_file(Car(), None))
    p = known.at(np.zeros(len(known.names))) | {
        "pitch_center_brake": 0.1,
        "gain_pitch_suspension": 0.0,
        "poles_sink": 0.0,
    }
    hubs = p["unsprung_front"] + p["unsprung_rear"]
    for kind, missed in (("suspension", hubs * hub_height(p)), ("tyre", 0.0)):
        terms = pitch_terms(kind, known, None)
        assert terms(p | {"hubs_past": 0.0})["fx_brake"] - terms(p | {"hubs_past": 1.0})[
            "fx_brake"
        ] == pytest.approx(missed)
    springs, _ = pitch_compliance(p)
    bare, all_past = (nod(p | {"hubs_past": past}, "brake", None) for past in (0.0, 1.0))
    assert all_past - bare == pytest.approx(springs * hubs * hub_height(p))
    body = body_of(p, None)
    terms = pitch_terms("suspension", known, None)(p | {"hubs_past": 1.0, "patch_lag": 0.0})
    assert terms["fx_brake"] == pytest.approx(body.sprung * (body.h - 0.1))


@pytest.mark.parametrize("drives", [False, True])
def test_springs_of_a_car_on_swing_arms_bear_what_free_bodies_say(drives: bool) -> None:
    """Each hub about its arm's pole, the whole car about the road: hubs' inertia, brakes on hubs or shafts from the body."""
    pole, arm, accel = 0.45, 1.1, 1.0
    known = before_the_log(vehicle_file(Car(), None))
    p = known.at(np.zeros(len(known.names))) | {
        "patch_lag": 0.0, "gain_pitch_suspension": 0.0, "jack_brake": 0.0, "jack_drive": 0.0, "wheel_inertia": 0.0, "poles_sink": 0.0, "hub_low": 0.0,
    }  # fmt: skip
    half, radius = p["wheelbase"] / 2, p["radius"]
    # a shaft's torque turns the wheel about its hub, so its force has a lever of the pole's height above the hub only
    lever = pole - radius if drives else pole
    p |= {"pitch_center_brake": half / arm * pole, "pitch_center_drive": half / arm * (pole - radius)}
    p |= {"hubs_past": half / arm}
    body = body_of(p, None)
    # front axle, rear axle: tyre force and hubs' inertia along x, and the load that tyres and springs gain (rear +)
    force = body.mass * accel * np.array([0.6, 0.4])
    hub = np.array([p["unsprung_front"], p["unsprung_rear"]]) * accel
    tyre = np.array([-1.0, 1.0]) * body.moment * accel / p["wheelbase"]
    # moment of tyre force, inertia and vertical forces about the pole is nothing: arms point at the middle of the car
    spring = tyre - np.array([-1.0, 1.0]) * (force * lever - hub * (pole - radius)) / arm
    found = pitch_terms("suspension", known, None)(p)["fx_drive" if drives else "fx_brake"]
    assert found == pytest.approx(half * (spring[1] - spring[0]) / accel)


def test_side_force_of_steered_wheels_is_no_torque_for_the_links() -> None:
    known = before_the_log(vehicle_file(Car(), None))
    p = known.at(np.zeros(len(known.names))) | {"patch_lag": 0.0, "product": 0.0}
    body = body_of(p, None)
    held_back = body.mass * (p["wheelbase"] - body.whole_x)
    low, high = (
        pitch_terms("suspension", known, None)(p | {"pitch_center_drive": h})["yaw2"] for h in (0.05, 0.15)
    )
    # what else there is beside yaw² comes from the unit's place, and the links' height enters it times that lever
    lever = body.x - p["imu_x"]
    assert high - low == pytest.approx(-0.1 * held_back - 0.5 * 0.1 * lever * body.mass)


def roll_known(**values: float) -> tuple[Known, dict[str, float]]:
    known = before_the_log(vehicle_file(Car(), None))
    return known, known.at(np.zeros(len(known.names))) | values


def test_a_car_that_turns_in_rolls_by_its_product_of_inertia_and_by_its_axles_roll_centres() -> None:
    """By hand: F_front = (b m f_y + I_z r') / L, each axle's links carry up to their roll centre, and I_xz r' on top."""
    known, p = roll_known(roll_center_front=0.05, roll_center_rear=0.15, product=0.0, track_grows=0.0)
    terms = roll_terms("suspension", known, None)
    body, yaw_inertia = body_of(p, None), YAW_OVER_PITCH * p["pitch_inertia"]
    # what the unit's place adds is the same for any split and product
    even = terms(p | {"roll_center_front": 0.1, "roll_center_rear": 0.1})["yaw_acc"]
    rate, length, ahead = 0.4, p["wheelbase"], p["imu_x"] - body.x
    carried = 0.05 * (yaw_inertia * rate / length) - 0.15 * (yaw_inertia * rate / length)
    share = body.whole_x / length
    arm = (1 - share) * 0.05 + share * 0.15 - 0.1
    # the arm of f_y changes with the mean roll centre, and f_y at the CG holds the unit's lever times r'
    lever = -body.sprung * arm * ahead * rate
    assert (terms(p)["yaw_acc"] - even) * rate == pytest.approx(-carried + lever, rel=1e-6)
    assert terms(p | {"product": -40.0})["yaw_acc"] - terms(p)["yaw_acc"] == pytest.approx(40.0)
    tyres = roll_terms("tyre", known, None)
    assert tyres(p)["yaw_acc"] == pytest.approx(
        tyres(p | {"roll_center_front": 0.1, "roll_center_rear": 0.1})["yaw_acc"]
    )


@pytest.mark.parametrize("hz", [0.3, 1.0, 1.8])
def test_a_unit_that_is_late_is_late_with_all_its_axes(hz: float) -> None:
    """Sines that the unit shows 20 ms late, put together as they were: what is left is of the third order."""
    known, p = roll_known(late_roll_suspension=-0.02, askew_yaw=0.0, product=0.0)
    terms, straight = (
        roll_terms("suspension", known, None)(p | {"late_roll_suspension": t}) for t in (-0.02, 0.0)
    )
    w, t = 2 * np.pi * hz, np.linspace(0, 2 / hz, 500)
    late = t - 0.02
    shown = {"fy": np.sin(w * late), "dfy": w * np.cos(w * late), "ddfy": -w * w * np.sin(w * late),
             "roll_acc": np.cos(w * late), "droll_acc": -w * np.sin(w * late)}  # fmt: skip
    true = straight["fy"] * np.sin(w * t) + straight["roll_acc"] * np.cos(w * t)
    put = np.sum([terms[n] * c for n, c in shown.items()], axis=0)
    ignored = straight["fy"] * shown["fy"] + straight["roll_acc"] * shown["roll_acc"]
    assert np.abs(put - true).max() < 0.3 * np.abs(ignored - true).max()


def braked(ratio: float, seconds: float = 120.0) -> Columns:
    """Rows of braking in which the logged torque is `ratio` times what pressure makes."""
    rng = np.random.default_rng(4)
    n = round(seconds * 10)
    pushed = 1500 + 800 * np.sin(np.arange(n) / 7) + 400 * rng.standard_normal(n)
    columns: dict[str, FloatArray] = {
        "pushed": pushed, "brake": ratio * pushed + 10 * rng.standard_normal(n), "one": np.ones(n), "on": np.ones(n),
        "v": np.full(n, 15.0),
    }  # fmt: skip
    time_s = np.arange(n) / 10
    block = np.floor(time_s / 12).astype(np.int64)
    return Columns(columns, time_s, block, 10.0, (), None, 0.0, (True, True))


@pytest.mark.parametrize("ratio", [0.95, 1.0, 1.06])
def test_pads_bind_the_scales_of_torque_and_pressure(ratio: float) -> None:
    gain = 7e-4
    known = before_the_log(
        Vehicle(quantities={"brake_gain_nmppa": Quantity(gain, 0.03 * gain, "vehicle file")})
    )
    # without a zero error, so that the answer has a closed form
    std = known.std.copy()
    std[known.index("brake_zero")] = 1e-9
    known = replace(known, std=std)
    relation = pads_relation(braked(ratio), known)
    assert relation is not None
    fit = solve([relation], known)
    p = fit.values()
    assert p["brake_gain"] / gain * (1 + p["pads"]) / p["brake_scale"] == pytest.approx(ratio, rel=2e-3)
    # by their variances: 4 % of the torque against 3 % and the 2.5 % by which the two may differ
    share = 0.04**2 / (0.04**2 + 0.03**2 + 0.025**2)
    assert p["brake_scale"] == pytest.approx(1 - share * (ratio - 1), abs=4e-3)
    i = known.index("brake_scale")
    spread = known.std[i] * np.sqrt(fit.covariance[i, i])
    assert spread == pytest.approx(0.04 * np.sqrt(1 - share), rel=0.05)


def test_rows_that_are_weighted_for_being_quiet_are_as_sure_as_they_are() -> None:
    """Noise of ten times the size on rows that the instrument hardly counts must not widen the answer."""
    rng = np.random.default_rng(5)
    n = 20_000
    quiet = np.arange(n) % 200 < 100
    x = rng.standard_normal(n)
    weight = np.where(quiet, 1.0, 0.02)
    noise = np.where(quiet, 0.1, 1.0) * rng.standard_normal(n)
    known = before_the_log(Vehicle())
    relation = Relation(
        "line", "line", ("y", "x"), np.column_stack([0.33 * x + noise, x]), (weight * x)[:, None], ("x",), np.arange(n),
        np.arange(n) // 100, lambda p: {"y": -1.0, "x": p["radius"]}, (known.index("radius"),),
    )  # fmt: skip
    i = known.index("radius")
    fit = solve([relation], known)
    std = known.std[i] * np.sqrt(fit.covariance[i, i])
    wx = weight * x
    honest = np.sqrt(np.sum((wx * np.where(quiet, 0.1, 1.0)) ** 2)) / float(wx @ x)
    assert std == pytest.approx(honest, rel=0.35)
    assert fit.values()["radius"] == pytest.approx(0.33, abs=4 * honest)


@pytest.mark.parametrize(("front", "accel"), [(0.65, -3.0), (1.0, 2.0), (0.0, 2.0)])
def test_torque_becomes_force_on_tyres_that_stand_as_the_load_and_the_pedals_have_them(
    front: float, accel: float
) -> None:
    """Wheel by wheel: a third of each tyre's squash off its free radius, where the sheet has the four's mean when empty."""
    known = before_the_log(vehicle_file(Car(), None))
    p = known.at(np.zeros(len(known.names))) | {"load": 300.0, "load_x": 2.4}
    body, length = body_of(p, None), p["wheelbase"]
    free = p["radius"] + G * p["empty_mass"] / 4 / (3 * p["tyre_rate"])
    load = np.array([length - body.whole_x, body.whole_x]) / length * body.mass * G / 2
    load += np.array([-1.0, 1.0]) * body.moment * accel / (2 * length)
    by_axle = free - load / (3 * p["tyre_rate"])
    radius, grows = rolling_radius(p, body, front)
    assert radius + grows * accel == pytest.approx(front * by_axle[0] + (1 - front) * by_axle[1])


def test_torque_balance_holds_for_a_car_that_rolls_on_those_tyres() -> None:
    """Brake and drive torques made from the forces by hand: nothing is left over."""
    known = before_the_log(vehicle_file(Car(), None))
    p = known.at(np.zeros(len(known.names))) | {
        "load": 300.0, "load_x": 2.4, "drive_front": 1.0, "wheel_inertia": 0.0, "corner_drag": 0.0, "gain_long": 0.0,
        "late_long": 0.0, "askew_pitch": 0.0, "offset_x": 0.0, "air": 0.97,
    }  # fmt: skip
    body, speed = body_of(p, None), 25.0
    terms = along_terms(None, True, True, False, 1.0, True, True)(p)
    still = 0.5 * 1.204 * 0.97 * p["drag"] * speed**2 + p["rolling"] * body.mass * G
    for mode, name, front, force in (("brake", "on", 0.65, -5000.0), ("drive", "off", 1.0, 4000.0)):
        accel = (force - still) / body.mass
        # along the body's own x: its nose dives by what springs and tyres give
        felt = accel / (1 + G * nod(p, mode, None))
        radius, grows = rolling_radius(p, body, front)
        torque = abs(force) * (radius + grows * felt)
        row = {mode: torque, f"fx_{mode}": felt, f"fx2_{mode}": felt**2, name: 1.0, f"v2_{name}": speed**2}
        left = sum(terms[column] * value for column, value in row.items())
        assert left == pytest.approx(0.0, abs=0.004 * torque)
        doubled = left + terms[f"fx_{mode}"] * 0.05 * felt
        assert abs(doubled) > 0.03 * torque


@pytest.mark.parametrize(("ahead", "left"), [(-1.2, 0.0), (0.9, 0.0), (0.0, 0.4)])
def test_torques_against_acceleration_do_not_ask_where_the_inertial_unit_sits(
    ahead: float, left: float
) -> None:
    """A vehicle that rolls round a bend: the unit reads what its own place makes of turning."""
    known = before_the_log(vehicle_file(Car(), None))
    p = known.at(np.zeros(len(known.names)))
    body, turn, quicker = body_of(p, None), 0.35, 0.2

    def missing(ahead: float, left: float) -> float:
        """Of the force balance over the mass, m/s²."""
        here = p | {"imu_x": body.whole_x - ahead, "imu_y": body.whole_y + left}
        terms = along_terms(None, True, True, False, 1.0, True, True)(here)
        row = {"fx_drive": -0.2 - ahead * turn**2 - left * quicker, "yaw2": turn**2, "yaw_acc": quicker}
        return float(sum(terms[name] * value for name, value in row.items())) / (p["radius"] * body.mass)

    lever = abs(ahead * turn**2 + left * quicker)
    assert missing(ahead, left) == pytest.approx(missing(0.0, 0.0), abs=0.1 * lever)
