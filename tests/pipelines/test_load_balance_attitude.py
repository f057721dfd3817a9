"""load_balance without deflections: the nose's motion against a closed form, a planted car, and what it must not say."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from plant_balance import Car, demand, logged, simulate, vehicle_file
from scipy.optimize import fsolve

from pipelines.estimators.load_balance.attitude import (
    attitude_relation,
    attitude_terms,
    nod,
    pitch_compliance,
)
from pipelines.estimators.load_balance.data import Columns, collect
from pipelines.estimators.load_balance.estimator import LoadBalance
from pipelines.estimators.load_balance.nodding import QUICK, nodding_columns
from pipelines.estimators.load_balance.relations import pitch_moments, vertical_forces
from pipelines.estimators.load_balance.smoothing import Smoother, friction_state
from pipelines.joint.vehicle.body import BRAKED_FRONT, even_factor, hub_height
from pipelines.joint.vehicle.poles import dip_levers
from pipelines.joint.vehicle.unknowns import TOWED, Known, before_the_log, body_of
from pipelines.models.roll import GRAVITY
from pipelines.prepare.prepared import Prepared, Segment
from pipelines.results import FloatArray

ESTIMATOR = LoadBalance()
RNG = np.random.default_rng(0)
RATE = 50.0


@pytest.fixture(scope="module")
def driven() -> tuple[Car, dict[str, FloatArray]]:
    rng = np.random.default_rng(15)
    car = Car()
    # brisk: of a gentle nod dry friction may take a share, and heights by it are as unsure
    return car, simulate(car, demand(330, rng, brake=5.0), rng)


def test_compliance_equals_the_hand_calculation() -> None:
    """A couple on two axles of springs: each gives force over rate, and their difference over the wheelbase is the angle."""
    p = {
        "spring_front": 30e3,
        "spring_rear": 20e3,
        "tyre_rate": 200e3,
        "wheelbase": 2.5,
        "empty_mass": 1500.0,
        "load": 0.0,
        "load_x": 1.0,
    }
    p |= {f"{kind}_{axle}": 0.0 for kind in ("square", "cube", "stop") for axle in ("front", "rear")}
    p |= {"free_front": 10.0, "free_rear": 10.0}
    moment = 5000.0
    force = moment / 2.5
    springs, tyres = pitch_compliance(p)
    assert springs * moment == pytest.approx((force / 60e3 + force / 40e3) / 2.5)
    assert tyres * moment == pytest.approx((force / 400e3 + force / 400e3) / 2.5)


def stopped(a: float, b: float, h: float, rate: float, fx: float) -> tuple[float, float, float]:
    """Springs' moment on a body of 1 kg whose massless wheels go up along its own axis, braked to the specific force fx (body axes): the
    moment, the nose-down pitch, and fz; from the equilibrium of forces and moments at the wheels' true places."""

    def unknowns(x: FloatArray) -> tuple[FloatArray, float, float]:
        # compressions beside those at rest, pitch, decelerating force: road axes
        front, rear, tilt, force = x
        rest = GRAVITY * np.array([b, a]) / (a + b)
        springs = rest + rate * np.array([front, rear])
        pull = force * np.array([BRAKED_FRONT, 1 - BRAKED_FRONT])
        normal = (springs + pull * np.sin(tilt)) / np.cos(tilt)
        along = -pull * np.cos(tilt) - normal * np.sin(tilt)
        height = h - np.array([front, rear])
        moment = a * springs[0] - b * springs[1]
        level = np.arctan2(front - rear, a + b) - tilt
        balance = moment + float(height @ along)
        weight = float(normal.sum()) - GRAVITY
        return np.array([balance, level, weight, float(along.sum()) - fx]), moment, float(springs.sum())

    found = fsolve(lambda x: unknowns(x)[0], np.array([0.0, 0.0, 0.0, -fx]), xtol=1e-12)
    _, moment, up = unknowns(found)
    return moment, float(found[2]), up


@pytest.mark.parametrize("fx", [-2.0, -6.0])
def test_wheels_that_go_up_along_a_dipped_body_hold_it(fx: float) -> None:
    a, b, h = 1.2, 1.5, 0.6
    moment, tilt, _ = stopped(a, b, h, 25.0, fx)
    p = {"wheelbase": a + b, "drive_front": 0.0, "poles_sink": 0.0, "poles_rear": 0.75}
    brake, drive = dip_levers(p, SimpleNamespace(x=a, mass=1.0))
    assert tilt > 0.01
    bare, dipped = -h * fx, -(h - tilt * brake) * fx
    assert abs(bare / moment - 1) > 3 * abs(dipped / moment - 1)
    assert dipped == pytest.approx(moment, rel=0.004)
    # driven rear wheels lift the tail of a body that sits back
    assert drive == pytest.approx(-b)


def test_links_take_from_the_nose_and_the_patch_adds() -> None:
    known = before_the_log(vehicle_file(Car(), None))
    p = known.at(np.zeros(len(known.names))) | {"pitch_center_brake": 0.0, "patch_lag": 0.0, "hubs_past": 0.0}
    body = body_of(p, None)
    bare = nod(p, "brake", None)
    springs, _ = pitch_compliance(p)
    assert bare < 0
    assert nod(p | {"pitch_center_brake": 0.1}, "brake", None) - bare == pytest.approx(
        0.1 * body.sprung * springs
    )
    assert nod(p | {"patch_lag": 0.01}, "brake", None) < bare
    # with all of the moment in the links the tyres alone give
    high = {"pitch_center_brake": body.whole_h, "hubs_past": body.whole_h / hub_height(p)}
    stiff = nod(p | high, "brake", None)
    assert stiff == pytest.approx(bare + springs * body.moment)


def test_a_driven_rear_axle_lifts_the_body_there_and_leaves_the_front_springs_alone() -> None:
    """Free bodies: whatever the links carry at the rear, the front axle's load changes by moment over wheelbase."""
    file = vehicle_file(Car(), None)
    known = before_the_log(file)
    p = known.at(np.zeros(len(known.names))) | {
        "load": 0.0, "hubs_past": 0.0, "pitch_center_brake": 0.0, "pitch_center_drive": 0.2, "patch_lag": 0.0,
        "spring_front": 25e3, "spring_rear": 45e3,
    }  # fmt: skip
    body = body_of(p, None)
    length = p["wheelbase"]
    lift = body.mass * 0.2 / (length - body.x)
    p["jack_drive"] = lift / body.sprung
    front, rear = -body.moment / length, body.moment / length - lift
    _, tyres = pitch_compliance(p)
    hand = (front / (2 * 25e3) - rear / (2 * 45e3)) / length - tyres * body.moment
    assert nod(p, "drive", None) == pytest.approx(hand)


@pytest.mark.parametrize("balance", ["attitude", "pitch", "vertical"])
def test_shafts_that_hold_back_while_the_brakes_are_on_pitch_as_in_driving(balance: str) -> None:
    """Brakes that are on and do nothing: all of the force is the shafts', by their torque, and its links are those of driving."""
    known = before_the_log(vehicle_file(Car(), None))
    p = known.at(np.random.default_rng(8).uniform(0.2, 0.6, len(known.names))) | {
        "pitch_center_drive": 0.3,
        TOWED: 0.0,
    }
    body = body_of(p, None)
    terms, head = {
        "attitude": lambda: (attitude_terms(None)(p), "quick_"),
        "pitch": lambda: (pitch_moments("deflection", p, body), ""),
        "vertical": lambda: (vertical_forces("deflection", p, body), ""),
    }[balance]()
    braked, driven = terms[f"{head}fx_brake"], terms[f"{head}fx_drive"]
    assert abs(braked - driven) > 0.01 * abs(driven)
    by_torque = terms[f"{head}drive_on"] / even_factor(p["drive_scale"]) * p["radius"] * body.mass
    assert braked + by_torque == pytest.approx(driven, rel=1e-9)
    # nobody's torque: as much as an engine holds back
    assert -terms[f"{head}held_on"] / p["engine_drag"] == pytest.approx(by_torque, rel=1e-9)
    # nor a motor's that takes a share of every stop: all of it
    assert terms[f"{head}held_fx"] / p["recovered"] == pytest.approx(by_torque, rel=1e-9)


def made(seconds: float, known: Known, height: float) -> tuple[Columns, FloatArray]:
    """A quasi-static car of a given whole height on a hilly road, as prepared signals would be: pitch = nod * a_x - grade."""
    n = round(seconds * RATE)
    t = np.arange(n) / RATE
    slope = 2.0 * np.sign(np.sin(2 * np.pi * t / 17)) * (np.abs(np.sin(2 * np.pi * t / 17)) > 0.4)
    slope = np.convolve(slope, np.ones(50) / 50, mode="same")
    grade = 0.03 * np.sin(2 * np.pi * t / 41) + 0.01 * np.sin(2 * np.pi * t / 23.7)
    speed = 6.0 + np.cumsum(slope - slope.mean()) / RATE
    p = known.at(np.zeros(len(known.names)))
    body = body_of(p, None)
    springs, tyres = pitch_compliance(p)
    both = springs + tyres
    path = (p["unsprung_front"] + p["unsprung_rear"]) * hub_height(p) + body.sprung * p["pitch_path"]
    moment = body.mass * (height + p["patch_lag"])
    v2 = 0.5 * 1.204 * p["air"] * p["drag"] * speed**2
    force = np.zeros(n)
    theta = np.zeros(n)
    for _ in range(30):
        # f_x is felt along the body, which leans with theta
        force = slope + 9.80665 * grade - 9.80665 * theta
        links = np.where(slope < -0.05, p["pitch_center_brake"], p["pitch_center_drive"])
        load = moment * force + path * 9.80665 * theta + 4 * p["wheel_inertia"] / p["radius"] * slope
        load += v2 * p["drag_height"]
        hubs = body.unsprung * (p["hubs_past"] * hub_height(p) - p["pitch_center_brake"])
        theta = -(both * load - springs * (links * (body.mass * force + v2) + hubs * force))
    zero = np.zeros(n)
    columns = {
        "accel_x": force, "pitch": theta - grade, "pitch_rate": np.gradient(theta - grade) * RATE, "speed": speed,
        "yaw_rate": zero, "brake_torque": np.where(slope < -0.05, 500.0, 0.0), "accel_y": zero,
        "accel_z": np.full(n, 9.80665),
    }  # fmt: skip
    prepared = Prepared(
        RATE, 15.0, t, columns, (Segment(0, n),), {}, frozenset(columns), np.zeros(n, dtype=bool)
    )
    return collect(prepared, known, 2.0), theta


def test_the_relation_vanishes_for_the_right_height_and_for_no_other() -> None:
    """Grade of several times the nod, and yet the mean products tell the height by which the car was made."""
    file = vehicle_file(Car(), None)
    known = before_the_log(file)
    true = body_of(known.at(np.zeros(len(known.names))), None).whole_h
    data, theta = made(600, known, true)
    relation = attitude_relation(data, known)
    assert relation is not None
    assert np.abs(theta).max() < 0.03
    p = known.at(np.zeros(len(known.names))) | {
        "bump_front": 0.0, "rebound_front": 0.0, "bump_rear": 0.0, "rebound_rear": 0.0, "rub": 0.0, "pitch_inertia": 0.0,
        "rolling": 0.0, "jack_brake": 0.0, "jack_drive": 0.0, "poles_sink": 0.0,
    }  # fmt: skip
    z = relation.instruments[:, relation.instrument_names.index("slope_off")]
    scale = p["empty_mass"] / (p["empty_mass"] + p["load"])

    def misfit(off: float) -> float:
        moved = p | {"empty_h": p["empty_h"] + off / scale}
        return float(z @ relation.table @ relation.vector(moved))

    per_metre = (misfit(0.05) - misfit(-0.05)) / 0.1
    assert abs(misfit(0.0) / per_metre) < 0.03
    assert abs(misfit(0.1) / per_metre) > 0.07


def test_quick_columns_lose_a_steady_grade_and_weigh_slow_straight_driving() -> None:
    n = round(200 * RATE)
    t = np.arange(n) / RATE
    base = {"pitch": 0.05 + 1e-4 * t, "pitch_rate": np.full(n, 0.01), "accel_x": np.zeros(n)}
    smooth = Smoother(
        Prepared(RATE, 15.0, t, base, (Segment(0, n),), {}, frozenset(base), np.zeros(n, dtype=bool)), 2.0
    )
    rows = len(smooth.rows)
    ones, wave = np.ones(rows), np.sin(2 * np.pi * 0.4 * t[smooth.rows])
    found = dict.fromkeys((*QUICK, "on", "yaw"), ones * 0)
    slow = nodding_columns(smooth.prepared, found | {"vdot": wave, "v": ones * 2}, smooth, np.full(n, 2.0))
    fast = nodding_columns(smooth.prepared, found | {"vdot": wave, "v": ones * 30}, smooth, np.full(n, 30.0))
    turning = nodding_columns(
        smooth.prepared, found | {"vdot": wave, "v": ones * 2, "yaw": ones * 0.5}, smooth, np.full(n, 2.0)
    )
    middle = slice(rows // 4, 3 * rows // 4)
    assert np.abs(slow["tip"][middle]).max() < 1e-4
    size = [float(np.std(made["slope_off"][middle])) for made in (slow, fast, turning)]
    assert size[0] > 10 * size[1] > 0
    assert size[0] > 10 * size[2] > 0
    lacking = Prepared(RATE, 15.0, t, {}, (Segment(0, n),), {}, frozenset(), np.zeros(n, dtype=bool))
    assert nodding_columns(lacking, found | {"vdot": wave, "v": ones}, smooth, np.ones(n)) == {}


def test_friction_remembers_and_keeps_to_its_limit() -> None:
    travel = np.concatenate([np.linspace(0, 1, 11), np.linspace(1, 0.8, 5)])
    prepared = Prepared(
        RATE, 15.0, np.arange(16) / RATE, {}, (Segment(0, 16),), {}, frozenset(), np.zeros(16, dtype=bool)
    )
    state = friction_state(travel, prepared, 0.2)
    assert state[10] == pytest.approx(1.0)
    assert state[-1] == pytest.approx(0.0)
    assert np.abs(state).max() <= 1.0


@pytest.mark.parametrize("seed", [1, 2])
def test_pitch_rate_and_torques_tell_height_and_mass(
    driven: tuple[Car, dict[str, FloatArray]], seed: int
) -> None:
    car, columns = driven
    rng = np.random.default_rng(seed)
    drive = logged(columns, rng, "suspension")
    found = ESTIMATOR.estimate(ESTIMATOR.prepare(drive, {}), vehicle_file(car, rng), {}, RNG)
    height, mass = found.parameters["cg_height_m"], found.parameters["mass_kg"]
    for answer in (height, mass):
        assert answer.value is not None
        assert answer.std is not None
        assert answer.reference is not None
        assert answer.prior is not None
        assert abs(answer.value - answer.reference) < 3 * answer.std
        assert answer.std < 0.85 * answer.prior.std
    assert height.value == pytest.approx(height.reference, rel=0.12)
    assert "pitch angle" in height.reason
    # nothing in these signals knows the sides or the axles apart
    for name in ("cg_lateral_offset_m", "cg_to_front_axle_m", "corner_mass_fl_kg"):
        assert found.parameters[name].status == "not_identifiable"


def test_without_spring_rates_the_nose_tells_no_height(driven: tuple[Car, dict[str, FloatArray]]) -> None:
    car, columns = driven
    drive = logged(columns, np.random.default_rng(3), "suspension")
    file = vehicle_file(car, None, "spring_rate_front_npm", "spring_rate_rear_npm")
    found = ESTIMATOR.estimate(ESTIMATOR.prepare(drive, {}), file, {}, RNG)
    assert found.parameters["cg_height_m"].status == "not_identifiable"
    assert "spring_rate_front_npm" in found.parameters["cg_height_m"].reason


def test_a_turned_pitch_rate_is_not_believed(driven: tuple[Car, dict[str, FloatArray]]) -> None:
    car, columns = driven
    wrong = columns | {"pitch_rate": -columns["pitch_rate"]}
    drive = logged(wrong, np.random.default_rng(4), "suspension")
    found = ESTIMATOR.estimate(ESTIMATOR.prepare(drive, {}), vehicle_file(car, None), {}, RNG)
    height = found.parameters["cg_height_m"]
    assert height.status != "identified"
    assert height.value is not None
    assert height.std is not None
    assert abs(height.value - car.truth()["cg_height_m"]) < 4 * height.std


def test_vectors_of_many_vehicles_are_those_of_each(driven: tuple[Car, dict[str, FloatArray]]) -> None:
    car, columns = driven
    known = before_the_log(vehicle_file(car, None))
    drive = logged(columns, np.random.default_rng(1), "suspension")
    relation = attitude_relation(collect(ESTIMATOR.prepare(drive, {}), known, 2.0), known)
    assert relation is not None
    u = np.random.default_rng(2).standard_normal((5, len(known.names)))
    many = relation.vector(dict(zip(known.names, (known.mean + known.std * u).T, strict=True)))  # type: ignore[arg-type]
    assert many.shape == (len(relation.columns), 5)
    for i, row in enumerate(u):
        assert np.allclose(many[:, i], relation.vector(known.at(row)))
    far = replace(relation, columns=relation.columns[:1])
    assert far.vector(known.at(u[0])).shape == (1,)
