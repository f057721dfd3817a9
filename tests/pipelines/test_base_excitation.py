"""Both base-excitation estimators on logs: four corners, one, two; refusals; faults of sensors. The plant is its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import plant_ride as plant
import pytest
from numpy.typing import NDArray

from parsers.drive import Drive, Signal
from pipelines.estimators.base_excitation.companion import BaseExcitationBatch
from pipelines.estimators.base_excitation.estimator import BaseExcitation
from pipelines.estimators.base_excitation.rls import other_directions
from pipelines.needs import readiness
from pipelines.results import Estimate
from pipelines.simulation.quarter_car import QuarterCar, drive_quarter_car, off_road_terrain, scaled_terrain
from pipelines.vehicles.vehicle import Quantity, Vehicle

Array = NDArray[np.float64]
RLS, BATCH = BaseExcitation(), BaseExcitationBatch()
CAR = plant.RideCar(friction=40.0, left=0.03)
RATE = 400.0


@pytest.fixture(scope="module")
def ride() -> tuple[Array, Array]:
    return plant.simulate(CAR, np.random.default_rng(1), rate_hz=RATE, seconds=100.0, moments=(500.0, 1500.0))


def recorded(ride: tuple[Array, Array], seed: int = 2, **faults: object) -> Drive:
    noise = {"noise": 0.15, "offset": 0.05, "gravity": 9.81, **faults}
    return plant.record(*ride, np.random.default_rng(seed), rate_hz=RATE, **noise)  # type: ignore[arg-type]


def run(
    estimator: BaseExcitation | BaseExcitationBatch, drive: Drive, vehicle: Vehicle, **settings: float
) -> Estimate:
    prepared = estimator.prepare(drive, settings)
    return estimator.estimate(prepared, vehicle, settings, np.random.default_rng(0))


def of(found: Estimate, name: str, truth: float) -> float:
    """The value; its interval must hold the truth."""
    p = found.parameters[name]
    assert p.value is not None
    assert p.low is not None
    assert p.high is not None
    assert p.low <= truth <= p.high, (name, p, truth)
    return p.value


def unidentified(found: Estimate, name: str = "sprung_mass_kg") -> str:
    p = found.parameters[name]
    assert found.status == "ran"
    assert p.status == "not_identifiable"
    return p.reason


@pytest.mark.parametrize("estimator", [RLS, BATCH])
def test_four_corners_give_mass_and_place(
    ride: tuple[Array, Array], estimator: BaseExcitation | BaseExcitationBatch
) -> None:
    found = run(estimator, recorded(ride), plant.vehicle_of(CAR, 0.01))
    sprung = of(found, "sprung_mass_kg", CAR.sprung)
    assert abs(sprung / CAR.sprung - 1) < 0.06
    assert of(found, "mass_kg", CAR.mass) == pytest.approx(sprung + 174, abs=1e-6)
    assert abs(of(found, "cg_to_front_axle_m", CAR.cg_to_front_axle) - CAR.cg_to_front_axle) < 0.03
    front = CAR.sprung * (1 - CAR.behind / CAR.wheelbase)
    of(found, "corner_mass_fl_kg", front * (0.5 + CAR.left / CAR.track) + 45)
    of(found, "suspension_damping_nspm", 1950.0)
    assert found.witness is (estimator is RLS)
    assert found.tracks[0].value[-1] == pytest.approx(sprung, rel=0.02)
    assert found.traces


def test_lateral_place_and_that_inertia_and_bars_do_not_matter(ride: tuple[Array, Array]) -> None:
    found = run(BATCH, recorded(ride), plant.vehicle_of(CAR, 0.01))
    offset = CAR.sprung * CAR.left / CAR.mass
    assert abs(of(found, "cg_lateral_offset_m", offset) - offset) < 0.006
    other = replace(CAR, pitch_inertia=1700.0, roll_inertia=450.0, bar_front=0.0, bar_rear=30e3)
    again = run(BATCH, recorded(plant.simulate(other, np.random.default_rng(1), rate_hz=RATE, seconds=100.0)),
                plant.vehicle_of(other, 0.01))  # fmt: skip
    assert of(again, "sprung_mass_kg", CAR.sprung) == pytest.approx(
        of(found, "sprung_mass_kg", CAR.sprung), rel=0.02
    )


def test_single_corners_are_wrong_where_the_heave_is_right(ride: tuple[Array, Array]) -> None:
    """Why four corners are summed: anti-roll bars make each one seem a fifth lighter."""
    figures = run(RLS, recorded(ride), plant.vehicle_of(CAR, 0.01)).diagnostics
    assert figures["corner_sum_sprung_mass_kg"] < 0.88 * CAR.sprung


def test_mass_scales_with_the_springs_and_their_doubt_goes_into_the_interval(
    ride: tuple[Array, Array],
) -> None:
    drive = recorded(ride)
    sure, doubtful = plant.vehicle_of(CAR, 0.001), plant.vehicle_of(CAR, 0.04)
    stiff = replace(
        sure,
        quantities={
            k: replace(q, value=1.05 * q.value) if "spring" in k else q for k, q in sure.quantities.items()
        },
    )
    for estimator in (RLS, BATCH):
        usual = run(estimator, drive, sure).parameters["sprung_mass_kg"]
        other = run(estimator, drive, stiff).parameters["sprung_mass_kg"]
        wide = run(estimator, drive, doubtful).parameters["sprung_mass_kg"]
        assert usual.value is not None
        assert other.value is not None
        assert usual.std is not None
        assert wide.std is not None
        assert other.value / usual.value == pytest.approx(1.05, abs=0.012)
        assert wide.std > usual.std
        extra = np.sqrt(wide.std**2 - usual.std**2) / usual.value
        assert extra == pytest.approx(0.04 / np.sqrt(2), rel=0.15)


def test_faulty_sensors_stay_inside_the_interval(ride: tuple[Array, Array]) -> None:
    """Scale errors of 0.5 %, wild samples and a hole in the log."""
    drive = recorded(ride, seed=5, gains=0.005)
    signals = dict(drive.signals)
    rng = np.random.default_rng(6)
    for name, s in drive.signals.items():
        values = s.values.copy()
        values[rng.integers(0, len(values), 10)] += 300.0
        keep = (s.time_ns < 40e9) | (s.time_ns > 43e9)
        signals[name] = Signal(name, s.time_ns[keep], values[keep], s.source)
    found = run(BATCH, replace(drive, signals=signals), plant.vehicle_of(CAR, 0.01))
    for name, truth in (("sprung_mass_kg", CAR.sprung), ("cg_to_front_axle_m", CAR.cg_to_front_axle)):
        assert found.parameters[name].status == "identified"
        assert of(found, name, truth) == pytest.approx(truth, rel=0.06)


@pytest.fixture(scope="module")
def rig() -> tuple[Drive, Vehicle]:
    """A quarter-car bench as a log of one wheel."""
    rng = np.random.default_rng(3)
    car = QuarterCar()
    terrain = scaled_terrain(off_road_terrain(900, rng), car, 8.0, 100.0, 6.6)
    motion = drive_quarter_car(car, terrain, 8.0, 100.0)
    time_ns = (np.arange(len(motion.accel_sprung)) * 5_000_000).astype(np.int64)
    drive = plant.record(np.zeros((10, 4)), np.zeros((10, 4)), rng)
    readings = (("accel_z_sprung_fl", motion.accel_sprung), ("accel_z_unsprung_fl", motion.accel_unsprung))
    signals = {
        name: Signal(name, time_ns, values + 9.81 + 0.37 * rng.standard_normal(len(values)), "bench")
        for name, values in readings
    }
    quantities = {
        "spring_rate_front_npm": Quantity(car.spring_npm, 0.0, "bench"),
        "unsprung_mass_front_kg": Quantity(196.0, 0.0, "bench"),
        "unsprung_mass_rear_kg": Quantity(196.0, 0.0, "bench"),
    }
    return replace(drive, signals=signals), Vehicle(quantities=quantities)


def test_one_wheel_on_a_bench(rig: tuple[Drive, Vehicle]) -> None:
    batch = run(BATCH, *rig, coupling=0.0, friction_std_n=0.0)
    assert of(batch, "corner_mass_fl_kg", 901.0) == pytest.approx(901, rel=0.005)
    assert of(batch, "suspension_damping_nspm", 7000.0) == pytest.approx(7000, rel=0.02)
    assert unidentified(batch).startswith("it needs body and hub accelerations at all four")
    published = run(RLS, *rig, coupling=0.0)
    assert of(published, "corner_mass_fl_kg", 901.0) < 901
    assert published.witness


def test_on_a_vehicle_a_single_wheel_promises_less(rig: tuple[Drive, Vehicle]) -> None:
    bench = run(BATCH, *rig, coupling=0.0).parameters["corner_mass_fl_kg"]
    vehicle = run(BATCH, *rig).parameters["corner_mass_fl_kg"]
    assert bench.std is not None
    assert vehicle.std is not None
    assert vehicle.std > 10 * bench.std
    assert vehicle.status == "weak"


def test_a_whole_axle_goes_as_one(ride: tuple[Array, Array]) -> None:
    found = run(BATCH, recorded(ride, wheels=("fl", "fr")), plant.vehicle_of(CAR, 0.01))
    front = CAR.sprung * (1 - CAR.behind / CAR.wheelbase)
    assert of(found, "corner_mass_fl_kg", front * (0.5 + CAR.left / CAR.track) + 45) == pytest.approx(
        front / 2 + 45, rel=0.15
    )
    unidentified(found, "corner_mass_rl_kg")


def test_an_axle_alone_knows_that_friction_may_stick(ride: tuple[Array, Array]) -> None:
    vehicle = plant.vehicle_of(CAR, 0.01)
    smooth = (0.1 * ride[0], 0.1 * ride[1])
    small = run(BATCH, recorded(smooth, wheels=("fl", "fr")), vehicle, least_excitation=0.0)
    assert "friction that sticks" in unidentified(small, "corner_mass_fl_kg")
    rough = run(BATCH, recorded(ride, wheels=("fl", "fr")), vehicle)
    slippery = run(BATCH, recorded(ride, wheels=("fl", "fr")), vehicle, friction_std_n=0.0)
    # friction is a spring beside the springs: what the axle carries may be more than they say
    one, other = (found.parameters["corner_mass_fl_kg"] for found in (rough, slippery))
    assert one.value is not None
    assert other.value is not None
    assert one.std is not None
    assert other.std is not None
    assert one.value > other.value
    assert one.std > other.std


def test_an_axle_alone_needs_a_drive_that_is_rough_throughout(ride: tuple[Array, Array]) -> None:
    calm = tuple(np.concatenate((part, 0.01 * np.tile(part, (2, 1)))) for part in ride)
    found = run(BATCH, recorded((calm[0], calm[1]), wheels=("fl", "fr")), plant.vehicle_of(CAR, 0.01))
    assert "of the drive is rough" in unidentified(found, "corner_mass_fl_kg")


@pytest.mark.parametrize("estimator", [RLS, BATCH])
def test_refusals(estimator: BaseExcitation | BaseExcitationBatch) -> None:
    rng = np.random.default_rng(4)
    vehicle = plant.vehicle_of(CAR)
    still = np.zeros((20_000, 4))
    assert "hardly move" in unidentified(run(estimator, plant.record(still, still, rng), vehicle))
    # noise that is louder than the gate, and nothing else
    loud = run(estimator, plant.record(still, still, rng, noise=1.0), vehicle)
    assert loud.parameters["sprung_mass_kg"].status == "not_identifiable"
    nothing = run(estimator, plant.record(still, still, rng), Vehicle())
    assert "spring rate" in unidentified(nothing)
    short = run(estimator, plant.record(still[:300], still[:300], rng), vehicle)
    unidentified(short)


@pytest.mark.parametrize("estimator", [RLS, BATCH])
def test_swapped_sign_and_wrong_wheels_are_not_believed(
    ride: tuple[Array, Array], estimator: BaseExcitation | BaseExcitationBatch
) -> None:
    body, hubs = ride
    vehicle = plant.vehicle_of(CAR)
    turned = run(estimator, recorded((body, -hubs)), vehicle).parameters["sprung_mass_kg"]
    assert turned.status == "not_identifiable" or (turned.std or 0) > 0.2 * CAR.sprung
    unrelated = run(estimator, recorded((body, np.roll(hubs, 7000, axis=0))), vehicle)
    unidentified(unrelated)


def test_high_roll_centres_leave_the_mass_open(ride: tuple[Array, Array]) -> None:
    vehicle = plant.vehicle_of(CAR, roll_center_height_front_m=0.5, roll_center_height_rear_m=0.5)
    for estimator in (RLS, BATCH):
        assert "stiffer than its springs" in unidentified(run(estimator, recorded(ride), vehicle))


def test_needs_are_told() -> None:
    ready = readiness(BATCH, ["accel_z_sprung_fl"], Vehicle())
    assert not ready.ready
    assert "hub" in ready.missing_signals[0]
    assert "spring_rate_front_npm" in ready.missing_vehicle[0]


def test_other_directions_bracket_the_truth() -> None:
    """Noise in all columns: the truth lies between least squares and the regression on a column."""
    rng = np.random.default_rng(5)
    clean = rng.standard_normal((50_000, 2)) @ np.array([[1.0, 0.3], [0.0, 1.0]])
    y = clean @ [2.0, 3.0]
    phi = clean + 0.2 * rng.standard_normal(clean.shape)
    y = y + 0.5 * rng.standard_normal(len(y))
    direct = np.linalg.lstsq(phi, y, rcond=None)[0]
    others = other_directions(phi, y)
    for i, truth in enumerate((2.0, 3.0)):
        ends = [direct[i], *others[:, i]]
        assert min(ends) < truth < max(ends)
    np.testing.assert_allclose(other_directions(clean, clean @ [2.0, 3.0]), [[2, 3], [2, 3]], rtol=1e-6)
