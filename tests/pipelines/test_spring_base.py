"""Rigid axles: springs that stand closer together than the wheels, and a propeller shaft that rolls the axle."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from plant_balance import Car, demand, logged, simulate, vehicle_file

from parsers.drive import Drive
from parsers.errors import VehicleError
from pipelines.estimators.load_balance.data import collect
from pipelines.estimators.load_balance.estimator import LoadBalance
from pipelines.estimators.load_balance.forces import FORCES, Terms
from pipelines.estimators.load_balance.relations import roll_terms
from pipelines.estimators.load_transfer.evidence import roll_moment
from pipelines.joint.vehicle.laden import forces_lever, pressed
from pipelines.joint.vehicle.outputs import roll_damping_of, roll_stiffness_of
from pipelines.joint.vehicle.unknowns import before_the_log, body_of
from pipelines.limits import what_limits
from pipelines.prepare.spring_forces import at_the_wheels
from pipelines.results import Estimate, FloatArray
from pipelines.vehicles.anti_roll import closer_springs
from pipelines.vehicles.spring_base import UNSAID, narrowing
from pipelines.vehicles.vehicle import Quantity, Vehicle
from pipelines.vehicles.vehicle_file import read_vehicle

BASE = 1.12
LENGTHS = {"wheelbase_m": 3.2, "track_front_m": 1.62, "track_rear_m": 1.62, "mass_kg": 2000.0}
SPRINGS = {"spring_rate_front_npm": 36e3, "spring_rate_rear_npm": 40e3}
PARTS = 0.5 * 36e3 * 1.62**2, 0.5 * 40e3 * 1.62**2


def file(body: str = "Pickup", **more: float) -> Vehicle:
    quantities = {k: Quantity(v, 0.01 * v, "test") for k, v in {**LENGTHS, **SPRINGS, **more}.items()}
    return Vehicle("test", body, quantities)


def mean(vehicle: Vehicle) -> dict[str, float]:
    known = before_the_log(vehicle)
    return known.at(np.zeros(len(known.names)))


def spread(vehicle: Vehicle, name: str) -> float:
    known = before_the_log(vehicle)
    return float(known.std[known.index(name)])


def test_springs_between_the_wheels_roll_as_far_apart_as_they_stand() -> None:
    bars = {"anti_roll_stiffness_front_nmprad": 30e3, "anti_roll_stiffness_rear_nmprad": 4e3}
    dampers = {"damper_rate_front_nspm": 2000.0, "damper_rate_rear_nspm": 1800.0}
    bases = ({"spring_base_rear_m": 1.62}, {"spring_base_rear_m": BASE})
    wide, close = (mean(file(**bars, **dampers, **more)) for more in bases)
    assert float(roll_stiffness_of(wide, empty=True)) == pytest.approx(sum(PARTS) + 34e3)
    rear = 0.5 * 40e3 * BASE**2
    assert float(roll_stiffness_of(close, empty=True)) == pytest.approx(PARTS[0] + rear + 34e3)
    lost = 0.25 * (close["bump_rear"] + close["rebound_rear"]) * (1.62**2 - BASE**2)
    assert float(roll_damping_of(wide) - roll_damping_of(close)) == pytest.approx(lost)
    # how far apart they stand is known to a per cent, and the stiffness with it
    known = file(**bars, spring_base_rear_m=BASE)
    assert spread(known, "bar_rear") == pytest.approx(np.hypot(40.0, 2 * 0.01 * rear), rel=1e-6)


def _closed(rate: float, base: float, bump: float) -> Vehicle:
    """The pickup with rear springs that stiffen by travel, as a rig tells them."""
    curve = {"spring_rate_rear_bump_npm": bump * rate, "spring_rate_rear_rebound_npm": rate}
    return file(spring_base_rear_m=base, anti_roll_stiffness_front_nmprad=30e3, anti_roll_stiffness_rear_nmprad=4e3, **curve)  # fmt: skip


@pytest.mark.parametrize("base", [BASE, 1.62])
def test_springs_that_stiffen_do_so_where_they_stand(base: float) -> None:
    """A blind simulator's pickup and van read 10 % too stiff in roll, and 5 % too high, as if they stiffened at the wheels."""
    found = mean(_closed(40e3, base, 1.5)) | {"load": 400.0, "load_x": 3.2}
    down = float(pressed(found, "rear"))
    rate = 40e3 + 2 * found["square_rear"] * down + 3 * found["cube_rear"] * down**2
    assert rate > 1.2 * 40e3
    rear = 0.5 * rate * base**2 + 4e3
    assert float(roll_stiffness_of(found)) == pytest.approx(PARTS[0] + 30e3 + rear, rel=1e-4)


@pytest.mark.parametrize("base", [BASE, 1.62])
def test_balances_by_deflections_hold_curved_springs_and_dampers_where_they_stand(base: float) -> None:
    known = before_the_log(_closed(40e3, base, 1.5))
    found = known.at(np.zeros(len(known.names)))
    found |= {name: 0.0 for name in found if name.startswith(("friction", "stop", "zero", "stuck"))}
    t = np.arange(0, 60, 0.01)
    left, right = 0.03 + 0.02 * np.sin(0.5 * t), 0.02 - 0.03 * np.sin(0.5 * t)
    travel = {"fl": 0 * t, "fr": 0 * t, "rl": left, "rr": right}
    columns = {f"suspension_deflection_{w}": x for w, x in travel.items()} | {"accel_x": 0 * t, "accel_y": 0 * t, "speed": 0 * t + 20}  # fmt: skip
    drive = logged(columns, np.random.default_rng(0), noise=0.0)
    drive = replace(drive, signals={n: replace(s, values=columns[n]) for n, s in drive.signals.items()})
    data = collect(LoadBalance().prepare(drive, {}), known, 10.0, free_m={"front": 9.0, "rear": 9.0})

    def by_terms(lever: tuple[float, float]) -> FloatArray:
        terms = Terms()
        FORCES["deflection"](found, (0.0, 0.0, *lever), terms)
        one = terms.pop("one") * data.columns["one"]
        return one + sum(value * data.columns[name] for name, value in terms.items() if name in data.columns and value)  # fmt: skip

    ratio = base / 1.62
    at_springs = [0.5 * (left + right) + sign * ratio * 0.5 * (left - right) for sign in (1, -1)]
    forces = []
    for d in at_springs:
        v = np.gradient(d, t)
        spring = 40e3 * d + found["square_rear"] * d**2 + found["cube_rear"] * d**3
        forces.append(spring + np.where(v > 0, found["bump_rear"], found["rebound_rear"]) * v)
    moment = 0.5 * base * (forces[0] - forces[1]) + 4e3 / 1.62 * (left - right)
    inner = slice(20, -20)
    rows = np.searchsorted(t, data.time_s - data.time_s[0])
    told = by_terms((0.81, -0.81))
    np.testing.assert_allclose(told[inner], moment[rows][inner], atol=3e-3 * np.ptp(moment))
    lifted = by_terms((1.0, 1.0))
    lifted = lifted - lifted.mean()
    both = (forces[0] + forces[1])[rows]
    np.testing.assert_allclose(lifted[inner], (both - both.mean())[inner], atol=5e-3 * np.ptp(both))


def test_a_stated_roll_stiffness_below_that_of_the_springs_is_a_rigid_rear_axle() -> None:
    """The rest is the axle's about which the file is silent, and the stated sum binds it: it is not known twice."""
    total = PARTS[0] + 0.5 * 40e3 * BASE**2 + 30e3
    told = file(roll_stiffness_nmprad=total, anti_roll_stiffness_front_nmprad=30e3)
    found = mean(told)
    assert found["bar_front"] == 30e3
    assert found["bar_rear"] == pytest.approx(0.5 * 40e3 * (BASE**2 - 1.62**2))
    assert float(roll_stiffness_of(found, empty=True)) == pytest.approx(total)
    assert spread(told, "bar_rear") > 10 * 0.01 * total
    both_silent = mean(file(roll_stiffness_nmprad=0.9 * sum(PARTS)))
    assert both_silent["bar_front"] == 0.0
    assert both_silent["bar_rear"] == pytest.approx(-0.1 * sum(PARTS))


def test_what_a_silent_file_leaves_open() -> None:
    """Only live axles, and only until the base is stated."""
    assert spread(file(), "force_base_rear") > 0.05
    assert spread(file("SUV"), "force_base_rear") < 1e-9
    assert spread(file(spring_base_rear_m=BASE), "force_base_rear") == pytest.approx(0.01)
    assert spread(file(), "force_base_front") < 1e-9
    assert mean(file())["roll_center_rear"] > mean(file("SUV"))["roll_center_rear"]
    # a base without a track of its own axle goes by the other's; without any it means nothing
    assert narrowing(Vehicle(quantities={"spring_base_rear_m": Quantity(1.0, 0.01, "")}), "rear") == (
        1.0,
        0.0,
    )


def test_forces_reckoned_on_the_track_show_more_where_springs_stand_closer() -> None:
    found = mean(file("SUV")) | {"bar_front": 0.0, "bar_rear": 0.0}
    assert forces_lever(found) == 1.0
    closer = found | {"force_base_rear": 0.7}
    share = PARTS[1] / sum(PARTS)
    assert forces_lever(closer) == pytest.approx(1 - share + share / 0.7)
    assert roll_moment(closer) == pytest.approx(roll_moment(found))


def test_a_shaft_rolls_a_driven_live_axle_only() -> None:
    assert spread(file(drive_front_share=0.0), "shaft_roll") == pytest.approx(0.1, rel=0.05)
    assert spread(file(drive_front_share=1.0), "shaft_roll") < 0.01
    assert spread(file("SUV", drive_front_share=0.0), "shaft_roll") < 1e-9
    known = before_the_log(file(drive_front_share=0.0))
    at = known.at(np.zeros(len(known.names)))
    turned = at | {"shaft_roll": 0.08}
    body, speed, accel = body_of(at, None), 20.0, 1.5
    row = {"fx_drive": accel, "v2": speed**2, "v2_on": 0.0, "move": 1.0, "on_rolling": 0.0}

    def moment(values: dict[str, float], kind: str) -> float:
        terms = roll_terms(kind, known, None)(values)
        return sum(terms.get(name, 0.0) * value for name, value in row.items())

    force = body.mass * (accel + at["rolling"] * 9.80665)
    force += 0.5 * 1.204 * at["air"] * at["drag"] * speed**2
    assert moment(turned, "deflection") - moment(at, "deflection") == pytest.approx(0.08 * force, rel=1e-3)
    # on the road it is the axle's own business
    assert moment(turned, "tyre") == moment(at, "tyre")


def test_a_base_wider_than_the_wheels_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "vehicle.toml"
    path.write_text("[vehicle]\ntrack_rear_m = 1.5\nspring_base_rear_m = 1.9\n", encoding="utf-8")
    with pytest.raises(VehicleError, match=r"spring_base_rear_m: found 1.9: the wheels stand 1.5 m apart"):
        read_vehicle(path)


def test_a_live_axles_springs_of_which_nobody_says_where_they_stand_may_be_closer() -> None:
    """Stated bars alone do not make the roll stiffness known: leaf springs stand at 0.7 of the track."""
    bars = {"anti_roll_stiffness_front_nmprad": 30e3, "anti_roll_stiffness_rear_nmprad": 4e3}
    silent, ratio, std = file(**bars), *UNSAID
    assert float(roll_stiffness_of(mean(silent), empty=True)) == pytest.approx(
        PARTS[0] + ratio**2 * PARTS[1] + 34e3
    )
    assert spread(silent, "bar_rear") == pytest.approx(2 * ratio * std * PARTS[1], rel=0.01)
    assert abs(1 - ratio) < std
    assert abs(0.7 - ratio) < 2 * std
    # a car's springs are reckoned at its wheels, and a base that is stated is as known as it is stated
    for known in (file("SUV", **bars), file(**bars, spring_base_rear_m=1.62)):
        assert spread(known, "bar_rear") < 0.03 * PARTS[1]
    assert closer_springs(silent, "rear") == pytest.approx(
        ((1 - ratio**2) * PARTS[1], 2 * ratio * std * PARTS[1])
    )
    assert closer_springs(silent, "front") == (0.0, 0.0)


def test_a_file_that_agrees_with_its_spring_base_contradicts_nothing() -> None:
    bars = {"anti_roll_stiffness_front_nmprad": 30e3, "anti_roll_stiffness_rear_nmprad": 4e3}
    total = PARTS[0] + 0.5 * 40e3 * BASE**2 + 34e3
    record = logged({"speed": np.ones(10)}, np.random.default_rng(0)).record
    for more, said in (({"spring_base_rear_m": BASE}, False), ({}, True)):
        sentences = what_limits(record, (), {}, file(**bars, **more, roll_stiffness_nmprad=total))
        assert any("contradicts itself" in text for text in sentences) is said


@pytest.fixture(scope="module")
def leaf_sprung() -> tuple[Car, dict[str, FloatArray]]:
    """A pickup whose rear springs stand at 70 % of the track: its forces as load cells in the springs show them."""
    rng = np.random.default_rng(7)
    car = Car()
    ratio = BASE / car.track
    soft = 0.5 * car.spring_rear * (BASE**2 - car.track**2)
    columns = simulate(replace(car, bar_rear=soft), demand(300, rng), rng)
    left, right = (columns[f"suspension_force_r{side}"] for side in "lr")
    columns["suspension_force_rl"] = 0.5 * (left + right) + 0.5 / ratio * (left - right)
    columns["suspension_force_rr"] = 0.5 * (left + right) - 0.5 / ratio * (left - right)
    return replace(car, bar_rear=0.0), columns


def run(drive: Drive, vehicle: Vehicle) -> Estimate:
    estimator = LoadBalance()
    return estimator.estimate(estimator.prepare(drive, {}), vehicle, {}, np.random.default_rng(0))


def arm(found: Estimate) -> tuple[float, float]:
    answer = found.parameters["roll_arm_m"]
    assert answer.value is not None
    assert answer.std is not None
    return answer.value, answer.std


@pytest.mark.parametrize("dropped", ["suspension_force", "suspension_deflection"])
def test_a_leaf_sprung_pickup_is_told_right(
    leaf_sprung: tuple[Car, dict[str, FloatArray]], dropped: str
) -> None:
    """By deflections and by forces alike; without the base deflections tell it too high, and forces are as unsure as that."""
    car, columns = leaf_sprung
    drive = logged(columns, np.random.default_rng(3), dropped)
    silent = replace(vehicle_file(car, np.random.default_rng(4)), body="Pickup")
    base = Quantity(BASE, 0.01, "vehicle file")
    stated = replace(silent, quantities={**silent.quantities, "spring_base_rear_m": base})
    truth = car.truth()["sprung_cg_height_m"] - car.roll_center
    value, std = arm(run(at_the_wheels(drive, stated), stated))
    assert abs(value - truth) < 2.5 * std
    assert std < 0.06 * truth
    wrong, unsure = arm(run(at_the_wheels(drive, silent), silent))
    if dropped == "suspension_force":
        # by what the stiffness is too high, as the file has it
        assert truth + 3 * abs(value - truth) < wrong < 1.4 * truth
    else:
        assert abs(wrong - truth) < 2.5 * unsure
        assert unsure > 1.2 * std


def test_forces_in_the_springs_become_forces_at_the_wheels(
    leaf_sprung: tuple[Car, dict[str, FloatArray]],
) -> None:
    """The sum stays, the moment is that on the springs' own base; other stamps than the other side's are no matter."""
    car, columns = leaf_sprung
    drive = logged(columns, np.random.default_rng(3), noise=0.0)
    vehicle = Vehicle(quantities={"track_rear_m": Quantity(car.track, 0.0, ""), "spring_base_rear_m": Quantity(BASE, 0.0, "")})  # fmt: skip
    found = at_the_wheels(drive, vehicle)
    left, right = (drive.signals[f"suspension_force_r{side}"].values for side in "lr")
    made_left, made_right = (found.signals[f"suspension_force_r{side}"].values for side in "lr")
    np.testing.assert_allclose(made_left + made_right, left + right)
    np.testing.assert_allclose((made_left - made_right) * car.track, (left - right) * BASE, atol=1e-6)
    assert found.signals["suspension_force_fl"] is drive.signals["suspension_force_fl"]
    assert [d.signal for d in found.record.decisions] == ["suspension_force_rl", "suspension_force_rr"]
    assert at_the_wheels(drive, Vehicle()) is drive
    late = drive.signals["suspension_force_rr"]
    moved = replace(
        late, time_ns=late.time_ns[1:] - 5_000_000, values=0.5 * (late.values[1:] + late.values[:-1])
    )
    shifted = at_the_wheels(replace(drive, signals={**drive.signals, late.name: moved}), vehicle)
    off = shifted.signals["suspension_force_rl"].values[5:-5] - made_left[5:-5]
    assert float(np.sqrt(np.mean(off**2))) < 0.02 * float(np.std(made_left))
