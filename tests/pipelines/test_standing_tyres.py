"""What standing tyres hold of a vehicle's pose until they roll: the memory, its place in the balance, and a stop of the full plant."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from plant_balance import Car, vehicle_file

from pipelines.estimators.load_balance.attitude import attitude_terms, held_share, pitch_compliance
from pipelines.estimators.load_balance.data import collect
from pipelines.estimators.load_balance.estimator import LoadBalance
from pipelines.estimators.load_balance.forces import FORCES
from pipelines.estimators.load_balance.nodding import QUICK, nodding_columns
from pipelines.estimators.load_balance.smoothing import SIDE_MEMORY_M, Smoother, held_by_tyres
from pipelines.joint.vehicle.body import held_rate
from pipelines.joint.vehicle.laden import rate_under_load
from pipelines.joint.vehicle.unknowns import AXLES, before_the_log, body_of
from pipelines.prepare.prepared import Prepared, Segment
from pipelines.results import FloatArray
from pipelines.simulation.logs.as_drive import drive_of as log_as_drive
from pipelines.simulation.logs.drive import Choice, preset, simulate_log
from pipelines.simulation.plant.vehicle import PlantVehicle
from pipelines.vehicles.vehicle import Quantity
from tests.pipelines.true_unknowns import true_unknowns

RATE = 60.0


def drive_of(columns: dict[str, FloatArray], still: np.ndarray) -> Prepared:
    n = len(still)
    t = np.arange(n) / RATE
    return Prepared(RATE, 15.0, t, columns, (Segment(0, n),), {}, frozenset(columns), still)


def plain_suv() -> PlantVehicle:
    """Without dry friction, and with links that neither dive nor lift."""
    level = dict.fromkeys(
        ("side_slope_front", "side_slope_rear", "side_slope_drive_front", "side_slope_drive_rear"), 0.0
    )
    return replace(
        preset("suv"),
        friction_n=0.1,
        spring_stiffening_pm2=0.0,
        **level,
    )


def test_the_memory_is_what_a_plain_loop_makes_of_it() -> None:
    rng = np.random.default_rng(1)
    n = 400
    travel = np.cumsum(rng.standard_normal(n)) * 1e-3
    speed = np.where(np.arange(n) % 150 < 60, 0.004, rng.uniform(0.0, 6.0, n))
    still = speed < 0.01
    state, wanted = 0.0, [0.0]
    for i in range(1, n):
        way = 0.0 if still[i] else speed[i] / RATE
        state = (state + travel[i] - travel[i - 1]) * np.exp(-way / 0.5)
        wanted.append(state)
    found = held_by_tyres(travel, drive_of({}, still), speed, 0.5)
    np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-15)


def test_standing_it_holds_all_and_half_a_metre_on_a_third() -> None:
    n = 600
    i = np.arange(n)
    speed = np.where((i >= 200) & (i < 400), 0.0, 0.6)
    travel = np.where(i < 250, 0.03, 0.01)
    found = held_by_tyres(travel, drive_of({}, speed == 0), speed, 0.5)
    assert np.abs(found[:250]).max() == 0.0
    assert found[399] == pytest.approx(-0.02)
    assert found[400 + 49] == pytest.approx(-0.02 * np.exp(-1.0), rel=1e-6)
    assert abs(found[-1]) < 2e-3 * 0.5
    # where nobody knows the speed, nothing is held
    assert (
        np.abs(held_by_tyres(travel, drive_of({}, np.zeros(n, dtype=bool)), np.full(n, np.nan), 0.5)).max()
        == 0.0
    )


def test_the_columns_hold_a_stop_and_roll_it_off() -> None:
    n = round(120 * RATE)
    t = np.arange(n) / RATE
    still = (t < 10) | ((t > 40) & (t < 55))
    speed = np.where(still, 0.0, 3.0)
    # the brakes bite until the body rocks back after the halt
    along = np.where((t > 36) & (t < 40.3), -2.0, 0.0)
    columns = {"pitch": -0.008 * along, "accel_x": along, "speed": speed}
    prepared = drive_of(columns, still)
    smooth = Smoother(prepared, 2.0)
    found = dict.fromkeys((*QUICK, "on", "yaw"), np.zeros(len(smooth.rows)))
    made = nodding_columns(prepared, found | {"v": speed[smooth.rows]}, smooth, speed)
    at = t[smooth.rows]
    # the high-pass takes a fifth of what jumps within 0.8 s, at the halt and at the start
    for name, size in (("quick_scrub", -0.016), ("quick_held", 2.0)):
        jump = made[name][np.searchsorted(at, 40.7)] - made[name][np.searchsorted(at, 39.9)]
        assert jump == pytest.approx(0.8 * size, rel=0.15)
        gone = made[name][np.searchsorted(at, 55.7)] - made[name][np.searchsorted(at, 54.9)]
        assert gone == pytest.approx(-0.8 * size, rel=0.15)
        assert np.nanmax(np.abs(made[name][at < 25])) < 0.02 * abs(size)


def test_their_place_in_the_balance() -> None:
    known = before_the_log(vehicle_file(Car(), None))
    p = known.at(np.zeros(len(known.names))) | {"nod_wound": -0.02}
    terms = attitude_terms(None)(p)
    assert terms["quick_held"] == pytest.approx(-0.02 * pitch_compliance(p)[0] * body_of(p, None).mass)
    assert terms["quick_scrub"] == held_share(p) > 0
    # springs and standing tyres side by side, axle by axle: the pitch that a moment makes of either
    moment, share = 1000.0, {}
    for axle in AXLES:
        held = p[f"standing_{axle}"] * (2 * p[f"roll_center_{axle}"] / p[f"track_{axle}"]) ** 2
        share[axle] = held / rate_under_load(p, axle)
    assert share["front"] != share["rear"]
    force = moment / p["wheelbase"]
    free = [force / (2 * rate_under_load(p, axle)) for axle in AXLES]
    held_back = sum(x * share[axle] for x, axle in zip(free, AXLES, strict=True)) / sum(free)
    assert held_share(p) == pytest.approx(held_back)
    level = {f"roll_center_{axle}": 0.0 for axle in AXLES}
    assert held_share(p | level) == 0.0


def test_a_rigid_axle_and_a_stated_tyre_have_their_own_hold() -> None:
    file = vehicle_file(Car(), None)
    usual = before_the_log(replace(file, body="SUV"))
    rigid = before_the_log(replace(file, body="Pickup"))
    row = usual.index("standing_rear")
    assert rigid.mean[row] < usual.mean[row]
    assert usual.mean[row] == usual.mean[usual.index("standing_front")]
    stated = {**file.quantities, "tire_lateral_rate_npm": Quantity(9e4, 4e3, "rig")}
    told = before_the_log(replace(file, body="SUV", quantities=stated))
    assert told.mean[row] == pytest.approx(0.8 * 9e4)
    # what is as good as infinite means no tyre: upright they give by no less
    huge = {**file.quantities, "tire_lateral_rate_npm": Quantity(1e9, 1e8, "none")}
    clipped = before_the_log(replace(file, body="SUV", quantities=huge))
    assert clipped.mean[row] == pytest.approx(0.8 * usual.mean[usual.index("tyre_rate")])


def test_a_hard_stop_leaves_the_full_plants_nose_down_by_that() -> None:
    """Wheels without dry friction: what is left of the pitch at rest is held by the tyres' sides."""
    plant = plain_suv()
    made = simulate_log(
        Choice("straight_braking", plant, (), sensors="perfect", seed=3, error_scale=0.0, sheet_errors=0.0)
    )
    p = true_unknowns(made, vehicle_file(Car(), None)).values
    drive = log_as_drive(made.log)
    pitch, speed = drive.signals["pitch"], drive.signals["speed"]
    t = (pitch.time_ns - pitch.time_ns[0]) / 1e9
    v = np.interp(pitch.time_ns, speed.time_ns, speed.values)
    prepared = Prepared(100.0, 50.0, t, {}, (Segment(0, len(t)),), {}, frozenset(), np.abs(v) < 0.02)
    state = held_by_tyres(pitch.values, prepared, v, SIDE_MEMORY_M)
    halt = int(np.flatnonzero((t > 5) & (np.abs(v) < 0.02))[0])
    rest = slice(halt + 250, halt + 350)
    left = float(np.mean(pitch.values[rest]) - np.mean(pitch.values[t < 1.0]))
    assert float(pitch.values[halt - 40]) > 0.02
    assert left == pytest.approx(-held_share(p) * float(np.mean(state[rest])), rel=0.2)
    assert left > 5e-4


def test_springs_of_a_vehicle_that_stopped_hard_show_less_than_its_weight() -> None:
    """Held rear wheels hang lower than their load has them: the balance adds what the tyres' sides carry."""
    known = before_the_log(vehicle_file(Car(), None))
    p = known.at(np.zeros(len(known.names)))
    for axle in AXLES:
        terms: dict[str, float] = {}
        FORCES["deflection"](p, [1.0, 1.0, 1.0, 1.0], terms)
        assert terms[f"scrub_{axle}"] == pytest.approx(2 * held_rate(p, axle))
    turned: dict[str, float] = {}
    FORCES["deflection"](p, [0.8, -0.8, 0.8, -0.8], turned)
    assert turned["scrub_front"] == turned["scrub_rear"] == 0.0
    plant = plain_suv()
    made = simulate_log(
        Choice("straight_braking", plant, (), sensors="perfect", seed=3, error_scale=0.0, sheet_errors=0.0)
    )
    q = true_unknowns(made, vehicle_file(Car(), None)).values
    estimator = LoadBalance()
    prepared = estimator.prepare(log_as_drive(made.log), {})
    data = collect(prepared, known, 2.0)
    stood = data.columns["rest"] == 1
    after = stood & (data.time_s > 20)
    bare, whole = np.zeros(len(stood)), np.zeros(len(stood))
    for axle in AXLES:
        for side in "lr":
            bare += q[f"spring_{axle}"] * data.columns[f"d_{axle[0]}{side}"]
        whole += 2 * held_rate(q, axle) * data.columns[f"scrub_{axle}"]
    lost = float(np.mean(bare[after])) - float(np.mean(bare[stood & (data.time_s < 3)]))
    assert lost < -80.0
    assert lost + float(np.mean(whole[after])) == pytest.approx(0.0, abs=0.4 * abs(lost))
