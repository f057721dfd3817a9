"""load_balance: hand calculations, the solver against closed forms, planted truth, wrong inputs and refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from plant_balance import Car, demand, logged, simulate, vehicle_file

from parsers.drive import Drive, ImportRecord, Signal
from pipelines.estimators.load_balance.along import along_relation
from pipelines.estimators.load_balance.data import collect
from pipelines.estimators.load_balance.estimator import LoadBalance
from pipelines.estimators.load_balance.relations import Relation, relations
from pipelines.estimators.load_balance.solve import LEAST_SHARE, jacobian, solve
from pipelines.joint.doubts.listed import doubts_of
from pipelines.joint.doubts.weighed import WRONG_FILE
from pipelines.joint.vehicle.outputs import outputs_of
from pipelines.joint.vehicle.unknowns import CORNERS, before_the_log, body_of
from pipelines.needs import readiness
from pipelines.results import Estimate, FloatArray
from pipelines.vehicles.vehicle import Quantity, Vehicle

G = 9.80665
RNG = np.random.default_rng(0)
ESTIMATOR = LoadBalance()
MAIN = ("mass_kg", "cg_height_m", "cg_to_front_axle_m", "cg_lateral_offset_m")


def run(drive: Drive, vehicle: Vehicle) -> Estimate:
    return ESTIMATOR.estimate(ESTIMATOR.prepare(drive, {}), vehicle, {}, RNG)


def still(seconds: float, **values: float) -> Drive:
    """A log of constant signals at 100 Hz."""
    n = round(seconds * 100)
    t = np.arange(n, dtype=np.int64) * 10_000_000
    signals = {name: Signal(name, t, np.full(n, value), "made") for name, value in values.items()}
    return Drive(signals, ImportRecord("made", (), "", "complete", 0, {}, (), "clock", None, 0.0, ()))


def exact(car: Car) -> Vehicle:
    file = vehicle_file(car, None)
    return replace(file, quantities={k: Quantity(q.value, 0.0, "exact") for k, q in file.quantities.items()})


@pytest.fixture(scope="module")
def driven() -> tuple[Car, dict[str, FloatArray]]:
    rng = np.random.default_rng(5)
    car = Car()
    return car, simulate(car, demand(330, rng), rng)


def test_static_loads_equal_the_hand_calculation() -> None:
    """20 mm in front and 30 mm behind on both sides: the load is the springs' force over g, at its centre."""
    car = replace(Car(), load=0.0)
    d_front, d_rear = 0.010, 0.020
    log = still(
        60, suspension_deflection_fl=d_front, suspension_deflection_fr=d_front, suspension_deflection_rl=d_rear,
        suspension_deflection_rr=d_rear, accel_x=0.0, accel_y=0.0, accel_z=G, speed=0.0,
    )  # fmt: skip
    found = run(log, exact(car)).parameters
    front, rear = 2 * car.spring_front * d_front / G, 2 * car.spring_rear * d_rear / G
    mass = car.mass + front + rear
    bare = car.truth()["cg_to_front_axle_m"]
    x = (car.mass * bare + rear * car.wheelbase) / mass
    assert found["mass_kg"].value == pytest.approx(mass, rel=0.012)
    assert found["cg_to_front_axle_m"].value == pytest.approx(x, abs=0.02)
    assert found["cg_lateral_offset_m"].value == pytest.approx(0.0, abs=1e-3)
    answer = found["mass_kg"]
    assert answer.std is not None
    assert answer.value is not None
    assert abs(answer.value - mass) < 2 * answer.std


def test_friction_and_zero_errors_at_rest_stay_in_the_interval() -> None:
    """At one standstill dry friction may hold up to some tens of newtons a wheel: no figure is surer than that."""
    car = replace(Car(), load=0.0)
    zero = {f"suspension_deflection_{w}": 0.01 for w in ("fl", "fr", "rl", "rr")}
    answer = run(still(60, **zero, accel_x=0.0, accel_y=0.0, accel_z=G, speed=0.0), exact(car)).parameters[
        "mass_kg"
    ]
    assert answer.std is not None
    assert answer.std > 2 * 60 / G


def test_body_and_corner_loads_close() -> None:
    car = Car()
    known = before_the_log(exact(car))
    p = known.at(np.zeros(len(known.names))) | {
        "load": car.load, "load_x": car.load_at[0], "load_y": car.load_at[1], "load_h": car.load_at[2], "empty_y": 0.0,
    }  # fmt: skip
    body, truth = body_of(p, car.sag), car.truth()
    assert body.mass == pytest.approx(truth["mass_kg"])
    assert body.whole_h == pytest.approx(truth["cg_height_m"])
    assert body.whole_x == pytest.approx(truth["cg_to_front_axle_m"])
    assert body.whole_y == pytest.approx(truth["cg_lateral_offset_m"])
    told = outputs_of(p, {"sag": car.sag})
    corners = np.array([float(told[f"corner_mass_{w}_kg"]) for w in CORNERS])
    assert corners.sum() == pytest.approx(body.mass)
    # at rest the body leans under its load, and its CG with it (`test_laden`)
    place = float(told["cg_to_front_axle_m"]), float(told["cg_lateral_offset_m"])
    assert corners[2:].sum() * car.wheelbase == pytest.approx(body.mass * place[0])
    assert (corners[0] - corners[1] + corners[2] - corners[3]) * car.track / 2 == pytest.approx(
        body.mass * place[1]
    )
    assert place == pytest.approx((body.whole_x, body.whole_y), abs=0.02)


def linear_relation(rng: np.random.Generator, truth: float) -> Relation:
    """y = radius * x + noise, with x as its own instrument: the answer has a closed form."""
    n = 4000
    x = rng.standard_normal(n)
    y = truth * x + 0.1 * rng.standard_normal(n)
    return Relation(
        "line", "line", ("y", "x"), np.column_stack([y, x]), x[:, None], ("x",), np.arange(n),
        np.arange(n) // 100, lambda p: {"y": -1.0, "x": p["radius"]}, (before_the_log(Vehicle()).index("radius"),),
    )  # fmt: skip


def test_solver_equals_the_closed_form_of_a_line() -> None:
    known = before_the_log(Vehicle())
    relation = linear_relation(np.random.default_rng(3), 0.335)
    fit = solve([relation], known)
    y, x = relation.table.T
    least_squares = float(x @ y / (x @ x))
    i = known.index("radius")
    value, std = fit.values()["radius"], float(known.std[i] * np.sqrt(fit.covariance[i, i]))
    assert value == pytest.approx(least_squares, abs=0.2 * std)
    floor = LEAST_SHARE * float(np.abs(x) @ np.abs(0.335 * x)) / float(x @ x)
    assert std == pytest.approx(np.hypot(0.1 / np.sqrt(x @ x), floor), rel=0.3)
    untouched = np.delete(fit.u, i)
    assert np.abs(untouched).max() < 1e-9
    assert np.allclose(np.delete(np.diag(fit.covariance), i), 1.0)


@pytest.mark.parametrize("turn", [0.02, 2.0])
def test_a_straight_drive_tells_where_the_weight_lies_and_no_load_transfer(turn: float) -> None:
    """What rolls it is a rough road within the springs' dry friction: its products with a_y are no side force's."""
    rng = np.random.default_rng(9)
    car = Car()
    drive = logged(
        simulate(car, demand(90.0, rng, turn=turn), rng), rng, "suspension_force", "tire_normal_force"
    )
    known = before_the_log(vehicle_file(car, None))
    data = collect(ESTIMATOR.prepare(drive, {}), known, 2.0)
    roll = next(r for r in relations(data, known) if r.name.startswith("roll"))
    assert {"rest", "move"} <= {*roll.instrument_names}
    assert ("fy" in roll.instrument_names) == (turn > 1)
    place = run(drive, vehicle_file(car, None)).parameters["cg_lateral_offset_m"]
    assert place.status != "not_identifiable"
    assert place.value is not None
    assert place.std is not None
    assert abs(place.value - car.truth()["cg_lateral_offset_m"]) < 2.5 * place.std


def test_tyre_forces_tell_the_mass_of_a_vehicle_whose_file_does_not(
    driven: tuple[Car, dict[str, FloatArray]],
) -> None:
    car, columns = driven
    drive = logged(columns, np.random.default_rng(3), "suspension_force", "suspension_deflection")
    mass = run(drive, vehicle_file(car, None, "mass_kg")).parameters["mass_kg"]
    assert mass.value == pytest.approx(car.truth()["mass_kg"], rel=0.03)


def test_balances_that_contradict_each_other_raise_no_doubt_of_what_they_do_not_see() -> None:
    """What widens all answers must not make a prior wider than it was: bars came out hundreds of spreads off by that."""
    bars = {"anti_roll_stiffness_front_nmprad": 30e3, "anti_roll_stiffness_rear_nmprad": 20e3}
    file = Vehicle("test", "Pickup", {k: Quantity(v, 0.02 * v, "sheet") for k, v in bars.items()})
    rng = np.random.default_rng(4)
    fit = solve([linear_relation(rng, radius) for radius in (0.31, 0.35)], before_the_log(file))
    assert fit.inflation > 2
    assert np.linalg.eigvalsh(fit.covariance).max() < 1 + 1e-9
    ways: dict[bytes, float] = {}
    for doubt in doubts_of(fit, file):
        if doubt.doubt.names == ("bar_front", "bar_rear"):
            way = doubt.doubt.precision.tobytes()
            ways[way] = ways.get(way, 0.0) + doubt.weight
            assert np.abs(doubt.moved[:2]).max() < 1e-6
    # each wrong by itself, and both alike; over all places of the load
    assert list(ways.values()) == pytest.approx([0.5 * WRONG_FILE] * 2, rel=0.05)


def test_jacobian_knows_every_unknown_that_matters(driven: tuple[Car, dict[str, FloatArray]]) -> None:
    """The list of unknowns that a balance depends on is complete: any other one changes nothing."""
    car, columns = driven
    known = before_the_log(vehicle_file(car, None))
    prepared = ESTIMATOR.prepare(logged(columns, np.random.default_rng(1)), {})
    data = collect(prepared, known, 2.0)
    along = along_relation(data, known)
    assert along is not None
    found = (*relations(data, known), along)
    assert len(found) == 7
    u = np.random.default_rng(2).standard_normal(len(known.names))
    for relation in found:
        base, slope = jacobian(relation, known, u)
        for i in range(len(u)):
            moved = u.copy()
            moved[i] += 1e-3
            change = (relation.vector(known.at(moved)) - base) / 1e-3
            assert np.allclose(change, slope[:, i], rtol=0.02, atol=1e-2 * np.abs(slope).max() + 1e-9)


@pytest.mark.parametrize(
    ("left_out", "scales"),
    [
        ((), {"drive_scale", "brake_scale"}),
        (("drive_torque",), {"brake_scale"}),
        (("brake_torque",), {"drive_scale"}),
        (("drive_torque", "brake_torque"), set()),
    ],
)
def test_a_torque_that_the_log_lacks_has_no_scale(
    driven: tuple[Car, dict[str, FloatArray]], left_out: tuple[str, ...], scales: set[str]
) -> None:
    """The verdict said of a log without a drive torque that this was of a wrong scale."""
    car, columns = driven
    known = before_the_log(vehicle_file(car, None))
    prepared = ESTIMATOR.prepare(logged(columns, np.random.default_rng(1), *left_out), {})
    data = collect(prepared, known, 2.0)
    along = along_relation(data, known)
    found = [*relations(data, known), *([] if along is None else [along])]
    assert len(found) == (7 if scales else 6)
    names = {known.names[i] for relation in found for i in relation.unknowns}
    assert names & {"drive_scale", "brake_scale"} == scales
    if along is not None:
        # where only braking is looked at, or only driving, nothing asks what the pedals' edges hold
        asked = {*along.instrument_names}
        assert ({"off", "v2_off"} <= asked, {"on", "v2_on"} <= asked) == (
            "drive_scale" in scales,
            "brake_scale" in scales,
        )
        assert bool(asked & {"off", "v2_off"}) == ("drive_scale" in scales)


@pytest.mark.parametrize("left_out", ["suspension_force", "suspension_deflection", "drive_torque"])
def test_recovers_what_was_planted(driven: tuple[Car, dict[str, FloatArray]], left_out: str) -> None:
    car, columns = driven
    for seed in (1, 2):
        rng = np.random.default_rng(seed)
        found = run(logged(columns, rng, left_out), vehicle_file(car, rng)).parameters
        for name in MAIN:
            answer = found[name]
            assert answer.value is not None
            assert answer.std is not None
            assert answer.reference is not None
            assert abs(answer.value - answer.reference) < 3 * answer.std, name
            assert answer.low is not None
            assert answer.low < answer.value
        height, mass = found["cg_height_m"], found["mass_kg"]
        assert mass.status == "identified"
        assert height.status != "not_identifiable"
        assert height.value == pytest.approx(height.reference, rel=0.06)
        assert mass.value == pytest.approx(mass.reference, rel=0.03)
        assert "balance" in height.reason


def test_noise_does_not_let_mass_and_springs_collapse(driven: tuple[Car, dict[str, FloatArray]]) -> None:
    """Four times the noise: whatever shrinks with the residuals would shrink now."""
    car, columns = driven
    rng = np.random.default_rng(4)
    drive = logged(columns, rng, "suspension_force", "drive", "brake", noise=4.0)
    estimate = run(drive, vehicle_file(car, None))
    truth = car.truth()
    assert estimate.parameters["mass_kg"].value == pytest.approx(truth["mass_kg"], rel=0.03)
    assert estimate.parameters["cg_height_m"].value == pytest.approx(truth["cg_height_m"], rel=0.08)
    for axle, rate in (("front", car.spring_front), ("rear", car.spring_rear)):
        assert estimate.diagnostics[f"spring_{axle}"] == pytest.approx(rate, rel=0.04)


def test_mirrored_drive_gives_the_mirrored_answer(driven: tuple[Car, dict[str, FloatArray]]) -> None:
    car, columns = driven
    other = {"fl": "fr", "fr": "fl", "rl": "rr", "rr": "rl"}
    turned = {}
    for name, values in columns.items():
        side = name.rsplit("_", 1)[-1]
        if side in other:
            name = name[: -len(side)] + other[side]
        turned[name] = -values if name in ("accel_y", "roll_rate") else values
    file = vehicle_file(car, None)
    quiet = np.random.default_rng(0)
    one = run(logged(columns, quiet, "suspension_force", noise=0.0), file).parameters
    two = run(logged(turned, np.random.default_rng(0), "suspension_force", noise=0.0), file).parameters
    assert one["mass_kg"].value == pytest.approx(two["mass_kg"].value, rel=0.01)
    first, second = one["cg_lateral_offset_m"], two["cg_lateral_offset_m"]
    assert first.value is not None
    assert second.value is not None
    assert first.std is not None
    assert abs(first.value + second.value) < 2 * first.std


def test_wrong_springs_widen_or_stay_within_four_sigma(driven: tuple[Car, dict[str, FloatArray]]) -> None:
    car, columns = driven
    file = vehicle_file(car, None)
    wrong = {
        k: replace(q, value=1.05 * q.value) if k.startswith("spring_rate") else q
        for k, q in file.quantities.items()
    }
    found = run(
        logged(columns, np.random.default_rng(6), "suspension_force"), replace(file, quantities=wrong)
    )
    for name in MAIN:
        answer = found.parameters[name]
        assert answer.value is not None
        assert answer.std is not None
        assert answer.reference is not None
        assert abs(answer.value - answer.reference) < 4 * answer.std, name


@pytest.mark.parametrize("turned", ["suspension_deflection", "accel_x"])
def test_turned_signs_are_refused(driven: tuple[Car, dict[str, FloatArray]], turned: str) -> None:
    """What contradicts everything else is no answer: the prior's figures stand, and it is said what to look at."""
    car, columns = driven
    wrong = {n: -v if n.startswith(turned) else v for n, v in columns.items()}
    found = run(logged(wrong, np.random.default_rng(11), "suspension_force"), vehicle_file(car, None))
    height = found.parameters["cg_height_m"]
    assert height.status != "identified"
    assert height.value is not None
    assert height.std is not None
    assert abs(height.value - car.truth()["cg_height_m"]) < 4 * height.std
    assert found.diagnostics["inflation"] > 1.5


def test_deflections_without_spring_rates_say_what_is_missing(
    driven: tuple[Car, dict[str, FloatArray]],
) -> None:
    car, columns = driven
    drive = logged(columns, np.random.default_rng(7), "suspension_force", "drive", "brake")
    file = vehicle_file(car, None, "spring_rate_front_npm", "spring_rate_rear_npm")
    found = run(drive, file)
    assert "spring_rate_front_npm" in found.reason
    assert all(answer.status == "not_identifiable" for answer in found.parameters.values())


def test_torque_alone_tells_mass_and_no_height(driven: tuple[Car, dict[str, FloatArray]]) -> None:
    car, columns = driven
    drive = logged(columns, np.random.default_rng(8), "suspension", "pitch_rate")
    found = run(drive, vehicle_file(car, None)).parameters
    mass = found["mass_kg"]
    assert mass.status in ("identified", "weak")
    assert mass.value == pytest.approx(car.truth()["mass_kg"], rel=0.09)
    assert found["cg_height_m"].status == "not_identifiable"
    assert found["cg_lateral_offset_m"].status == "not_identifiable"
    assert "suspension deflections" in found["cg_height_m"].reason


def test_a_quiet_straight_drive_gives_no_height() -> None:
    """At constant speed the deflections tell mass and place, and nothing of the height."""
    rng = np.random.default_rng(9)
    car = Car()
    u = np.zeros((90_000, 3))
    u[:, 2] = 20.0
    found = run(
        logged(simulate(car, u, rng), rng, "suspension_force", "drive", "brake"), vehicle_file(car, None)
    )
    assert found.parameters["mass_kg"].status == "identified"
    height = found.parameters["cg_height_m"]
    assert height.status != "identified"
    assert height.std is not None
    assert height.prior is not None
    assert height.std > 0.4 * height.prior.std


def test_needs_and_empty_drives() -> None:
    lacking = readiness(ESTIMATOR, ["accel_y", "roll"], Vehicle())
    assert not lacking.ready
    assert any("suspension_deflection_fl" in words for words in lacking.missing_signals)
    assert any("wheelbase_m" in words for words in lacking.missing_vehicle)
    short = still(5, accel_x=0.0, suspension_force_fl=1.0)
    found = run(short, vehicle_file(Car(), None))
    assert found.status == "ran"
    assert {answer.status for answer in found.parameters.values()} == {"not_identifiable"}


def test_gaps_outliers_and_slow_sensors_are_survived(driven: tuple[Car, dict[str, FloatArray]]) -> None:
    car, columns = driven
    rng = np.random.default_rng(10)
    drive = logged(columns, rng, "suspension_force")
    signals = {}
    for name, signal in drive.signals.items():
        keep = np.ones(len(signal.values), dtype=bool)
        keep[9_000:12_000] = False
        if name == "accel_y":
            keep[20_000:23_000] = False
        if name.startswith("suspension"):
            keep[::2] = False
        values = signal.values.copy()
        values[rng.integers(0, len(values), 20)] += 0.05 if name.startswith("suspension") else 5.0
        signals[name] = Signal(name, signal.time_ns[keep], values[keep], signal.source)
    found = run(replace(drive, signals=signals), vehicle_file(car, None)).parameters
    for name in MAIN:
        answer = found[name]
        assert answer.value is not None
        assert answer.std is not None
        assert answer.reference is not None
        assert abs(answer.value - answer.reference) < 3 * answer.std, name
    assert found["cg_height_m"].status != "not_identifiable"
