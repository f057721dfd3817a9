"""The roll estimator, judged on a plant that is richer than its model, and on a recorded slalom."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import plant_roll as plant
import pytest

from parsers.drive import Drive
from pipelines.estimators.roll_map.estimator import RollMap
from pipelines.estimators.roll_map.fit import UNCHOSEN
from pipelines.estimators.roll_map.posterior import KNEE
from pipelines.results import Estimate
from pipelines.vehicles.vehicle import Quantity, Vehicle
from pipelines.vehicles.vehicle_file import parse_vehicle

ESTIMATOR = RollMap()
FEW = {"draws": 30_000.0}
LOGS = Path(__file__).parents[3] / "shared" / "real_logs"
DEG = float(np.radians(1.0))


def analyse(drive: Drive, vehicle: Vehicle, seed: int = 1) -> Estimate:
    prepared = ESTIMATOR.prepare(drive, FEW)
    return ESTIMATOR.estimate(prepared, vehicle, FEW, np.random.default_rng(seed))


def rough_car(rng: np.random.Generator) -> plant.Car:
    """A car out of the family, with curved springs and dampers with two slopes."""
    return plant.Car(
        sprung_height=rng.uniform(0.6, 0.75),
        roll_axis=rng.uniform(0.04, 0.14),
        stiffness=rng.uniform(55e3, 80e3),
        damping=rng.uniform(4500, 6500),
        body_inertia=rng.uniform(420, 560),
        cubic=3.0,
        rebound=1.4,
    )


ROUGH = plant.Sensors(roll_delay=0.02, colour_s=0.05, roll_step=1e-4, accel_step=0.01)


@pytest.fixture(scope="module")
def slalom() -> tuple[plant.Car, plant.Drive]:
    rng = np.random.default_rng(11)
    car = plant.Car()
    accel = plant.slalom(4.0)
    motion = plant.simulate(car, accel, plant.wavy_bank(len(accel), 0.3 * DEG, rng))
    return car, plant.record(motion, car, ROUGH, rng)


def test_height_with_known_springs_over_twelve_rough_cars() -> None:
    """Springs known to 2 %, roll centres to 1 cm, everything else as a data sheet leaves it."""
    errors, priors, inside, inside_gradient = [], [], 0, 0
    for seed in range(12):
        rng = np.random.default_rng(300 + seed)
        car = rough_car(rng)
        accel = plant.slalom(4.0, seconds=30) if seed % 2 else plant.sine_with_dwell(5.0, 3)
        bank = plant.wavy_bank(len(accel), 0.3 * DEG if seed % 2 else 0.0, rng)
        drive = plant.without(plant.record(plant.simulate(car, accel, bank), car, ROUGH, rng), "suspension")
        guess = car.cg_height + 0.03 * rng.standard_normal()
        vehicle = plant.vehicle_of(car, plant.Knowledge(height=(guess, 0.03), inertia=0.1), rng)
        found = analyse(drive, vehicle).parameters
        height, gradient = found["cg_height_m"], found["roll_gradient_degpg"]
        assert height.value is not None
        assert height.low is not None
        assert height.high is not None
        assert height.std is not None
        assert height.status in ("identified", "weak")
        errors.append(height.value - car.cg_height)
        priors.append(guess - car.cg_height)
        inside += height.low <= car.cg_height <= height.high
        assert gradient.low is not None
        assert gradient.high is not None
        inside_gradient += gradient.low <= car.gradient(road=True) <= gradient.high
        # friction and banked bends, of which the likelihood knows nothing, are part of it
        assert height.std < 0.03
    assert inside >= 10
    assert inside_gradient >= 10
    assert np.std(errors) < 0.75 * np.std(priors)
    assert abs(np.mean(errors)) < 0.010


def test_coefficients_reach_the_bound_on_a_plant_like_the_model() -> None:
    """Rigid tyres, straight springs: a, b, c miss by what the white-noise bound allows, delays and offsets too."""
    rng = np.random.default_rng(5)
    car = plant.Car(tyre_npm=3e6, unsprung_kg=1e-3, hub_height=0.3)
    motion = plant.simulate(car, plant.sine_with_dwell(5.0, 3))
    moment = car.sprung_kg * car.arm
    wanted = {
        "a": np.degrees(9.80665) / car.gradient(road=True),
        "b": car.damping / moment * (1 - 0.018),
        "c": car.body_inertia / moment + car.sprung_height - car.imu_height,
    }
    scaled = []
    for seed in range(4):
        drive = plant.without(
            plant.record(motion, car, plant.Sensors(roll_delay=0.03, rate_delay=0.015), rng), "suspension"
        )
        figures = analyse(drive, Vehicle(), seed).diagnostics
        scaled += [(figures[name] - value) / figures[f"{name}_std"] for name, value in wanted.items()]
        scaled.append((figures["roll_delay_s"] - 0.030) / figures["roll_delay_std_s"])
        assert figures["roll_delay_std_s"] < 0.005
        assert figures["rate_lag_s"] == pytest.approx(-0.015, abs=0.002)
        assert figures["rate_offset_degps"] == pytest.approx(0.36, abs=0.03)
    assert np.sqrt(np.mean(np.square(scaled))) < 1.8


@pytest.mark.parametrize(
    "kept", ["roll roll_rate", "roll", "roll_rate", "suspension", "suspension roll_rate"]
)
def test_any_roll_channel_gives_the_gradient(slalom: tuple[plant.Car, plant.Drive], kept: str) -> None:
    car, drive = slalom
    names = kept.split()
    roll_like = ("roll", "roll_rate", "suspension")
    signals = {
        n: s
        for n, s in drive.signals.items()
        if not n.startswith(roll_like) or n in names or ("suspension" in names and n.startswith("suspension"))
    }
    vehicle = plant.vehicle_of(car, plant.Knowledge(), np.random.default_rng(2))
    found = analyse(replace(drive, signals=signals), vehicle)
    road = "suspension" not in names
    gradient = found.parameters["roll_gradient_degpg"]
    assert gradient.low is not None
    assert gradient.high is not None
    # of an angle against the axles the tyres' part is added: the parameter has one meaning whatever was measured
    assert gradient.low <= car.gradient(road=True) <= gradient.high
    assert ("axles" in gradient.reason) is not road
    height = found.parameters["cg_height_m"]
    assert height.low is not None
    assert height.high is not None
    assert height.low <= car.cg_height <= height.high
    assert found.scatters


def test_without_springs_the_height_is_the_priors(slalom: tuple[plant.Car, plant.Drive]) -> None:
    car, drive = slalom
    know = plant.Knowledge(stiffness=None, tyre=None, roll_axis=None, imu=None, load=False)
    vehicle = plant.vehicle_of(car, know, np.random.default_rng(2))
    found = analyse(plant.without(drive, "suspension"), vehicle)
    height = found.parameters["cg_height_m"]
    assert height.status == "not_identifiable"
    assert "roll_stiffness_nmprad" in height.reason
    assert height.prior is not None
    assert height.std == pytest.approx(height.prior.std, rel=0.1)
    assert found.parameters["roll_gradient_degpg"].status == "identified"
    said = {a.name: a for a in found.assumptions}
    assert "driver" in said["load mass"].value
    assert "usual" in said["tire_vertical_rate_npm (a tyre, four in all)"].source
    assert found.parameters["mass_kg"].status == "not_identifiable"


def test_dampers_with_knees_are_never_told_to_a_few_per_cent(slalom: tuple[plant.Car, plant.Drive]) -> None:
    """However quiet the sensors: the drive's own speeds are not those at which a damper's rate is stated."""
    car, drive = slalom
    found = analyse(drive, plant.vehicle_of(car, plant.Knowledge(damping=0.5), np.random.default_rng(2)))
    damping = found.parameters["roll_damping_nmsprad"]
    assert damping.value is not None
    assert damping.std is not None
    assert damping.std >= 0.9 * KNEE * damping.value
    assert damping.std < 0.4 * damping.value
    assert "knees" in damping.reason


def test_nothing_known_leaves_the_log_alone(slalom: tuple[plant.Car, plant.Drive]) -> None:
    car, drive = slalom
    found = analyse(drive, Vehicle()).parameters
    assert found["roll_gradient_degpg"].value == pytest.approx(car.gradient(road=True), rel=0.04)
    for name in ("cg_height_m", "mass_kg", "roll_stiffness_nmprad"):
        assert found[name].value is None
        assert found[name].low is None
        assert "mass_kg" in found[name].reason


def test_a_straight_drive_says_that_it_cannot_tell() -> None:
    rng = np.random.default_rng(3)
    car = plant.Car()
    drive = plant.record(plant.simulate(car, np.zeros(int(30 * plant.RATE))), car, plant.Sensors(), rng)
    found = analyse(drive, Vehicle())
    assert found.status == "ran"
    assert "slalom" in found.reason
    assert all(p.status == "not_identifiable" and p.value is None for p in found.parameters.values())
    body = analyse(drive, Vehicle(body="SUV", quantities={"mass_kg": Quantity(1800, 20, "vehicle file")}))
    height = body.parameters["cg_height_m"]
    assert height.prior is not None
    assert height.value == height.prior.value


def test_no_roll_signal_and_no_signal_at_all() -> None:
    rng = np.random.default_rng(3)
    car = plant.Car()
    drive = plant.record(plant.simulate(car, plant.circle(4.0, 20)), car, plant.Sensors(), rng)
    for prefix in (("roll", "suspension"), ("accel", "roll", "suspension", "yaw", "speed")):
        found = analyse(plant.without(drive, *prefix), Vehicle())
        assert found.status == "ran"
        assert "not in the log" in found.reason
        assert found.parameters["roll_gradient_degpg"].value is None


@pytest.mark.parametrize("fault", ["inverted", "noise", "dead"])
def test_roll_that_does_not_follow_is_said(slalom: tuple[plant.Car, plant.Drive], fault: str) -> None:
    car, drive = slalom
    roll = drive.signals["roll"]
    noise = 0.05 * np.random.default_rng(1).standard_normal(len(roll.values))
    values = {"inverted": -roll.values, "noise": noise, "dead": 0 * noise}[fault]
    broken = plant.without(drive, "suspension", "roll_rate")
    broken = replace(broken, signals={**broken.signals, "roll": replace(roll, values=values)})
    found = analyse(broken, plant.vehicle_of(car, plant.Knowledge(), np.random.default_rng(2)))
    assert "does not follow the lateral acceleration" in found.reason
    assert found.parameters["roll_gradient_degpg"].value is None
    assert all(p.status == "not_identifiable" for p in found.parameters.values())


def test_a_road_that_banks_into_its_bends_is_not_taken_for_a_wrong_channel() -> None:
    """The bank outweighs the slow part of the lean; what is quick still follows, and says that the channel is right."""
    car, rng = plant.Car(), np.random.default_rng(3)
    t = np.arange(0, 240, 1 / plant.RATE)
    bends, quick = (
        1.3 * np.sin(2 * np.pi * t / 40) * np.sin(2 * np.pi * t / 170),
        0.35 * np.sin(2 * np.pi * 0.3 * t),
    )
    drive = plant.record(plant.simulate(car, bends + quick), car, plant.Sensors(), rng)
    stamps = drive.signals["roll"].time_ns * 1e-9
    bank = np.interp(stamps, t, -0.04 * bends) + 0.01 * np.sin(2 * np.pi * stamps / 23)
    turned = {"roll": bank, "accel_y": plant.G * bank}
    banked = {n: replace(s, values=s.values + turned.get(n, 0.0)) for n, s in drive.signals.items()}
    found = analyse(
        plant.without(replace(drive, signals=banked), "suspension"),
        plant.vehicle_of(car, plant.Knowledge(), rng),
    )
    assert found.parameters["roll_gradient_degpg"].status == "not_identifiable"
    assert "the road's bank turns the roll angle" in found.reason


def test_what_a_banked_road_takes_from_an_angle_the_springs_tell() -> None:
    """An angle against the horizon beside deflections took their roll gradient away."""
    car, rng = plant.Car(), np.random.default_rng(3)
    t = np.arange(0, 240, 1 / plant.RATE)
    bends = 1.3 * np.sin(2 * np.pi * t / 40) * np.sin(2 * np.pi * t / 170)
    bank = -0.04 * bends + 0.01 * np.sin(2 * np.pi * t / 23)
    moved = plant.simulate(car, bends + 0.35 * np.sin(2 * np.pi * 0.3 * t), bank)
    drive = plant.record(moved, car, plant.Sensors(), rng)
    vehicle = plant.vehicle_of(car, plant.Knowledge(), rng)
    by_horizon = analyse(plant.without(drive, "suspension"), vehicle)
    assert by_horizon.parameters["roll_gradient_degpg"].status == "not_identifiable"
    found = analyse(drive, vehicle)
    gradient = found.parameters["roll_gradient_degpg"]
    assert gradient.status != "not_identifiable"
    assert gradient.low is not None
    assert gradient.high is not None
    assert gradient.low <= car.gradient(road=True) <= gradient.high
    assert "by the springs' angle, since by the one against the horizon" in found.reason
    assert found.scatters


def test_a_wrong_unit_is_said(slalom: tuple[plant.Car, plant.Drive]) -> None:
    _, drive = slalom
    accel = drive.signals["accel_y"]
    wrong = replace(drive, signals={**drive.signals, "accel_y": replace(accel, values=9.81 * accel.values)})
    assert "is not a road vehicle's: check the units" in analyse(wrong, Vehicle()).reason


def test_spikes_do_not_steer(slalom: tuple[plant.Car, plant.Drive]) -> None:
    car, drive = slalom
    roll = drive.signals["roll"]
    values = roll.values.copy()
    values[[900, 901, 1700, 2900]] += 0.12
    spiky = replace(drive, signals={**drive.signals, "roll": replace(roll, values=values)})
    vehicle = plant.vehicle_of(car, plant.Knowledge(), np.random.default_rng(2))
    clean, dirty = (analyse(d, vehicle).parameters["roll_gradient_degpg"] for d in (drive, spiky))
    assert clean.value is not None
    assert clean.std is not None
    assert dirty.value == pytest.approx(clean.value, abs=clean.std)


def test_a_motion_too_short_to_choose_the_models_parts_is_not_told_sharply() -> None:
    rng = np.random.default_rng(12)
    car = plant.Car()
    spreads = []
    for seconds in (8, 40):
        motion = plant.simulate(car, plant.slalom(4.0, seconds=seconds))
        drive = plant.record(motion, car, ROUGH, rng)
        gradient = analyse(drive, plant.vehicle_of(car, plant.Knowledge(), rng)).parameters[
            "roll_gradient_degpg"
        ]
        assert gradient.value is not None
        assert gradient.std is not None
        assert abs(gradient.value - car.gradient(road=True)) < 3 * gradient.std
        spreads.append(gradient.std / gradient.value)
    assert spreads[0] > UNCHOSEN
    assert spreads[1] < spreads[0]


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_scattered_holes_in_every_channel(slalom: tuple[plant.Car, plant.Drive], seed: int) -> None:
    car, drive = slalom
    rng = np.random.default_rng(seed)
    signals = {}
    for name, signal in drive.signals.items():
        kept = rng.random(len(signal.values)) > 0.2
        signals[name] = replace(signal, time_ns=signal.time_ns[kept], values=signal.values[kept])
    gradient = analyse(
        replace(drive, signals=signals), plant.vehicle_of(car, plant.Knowledge(), rng)
    ).parameters["roll_gradient_degpg"]
    assert gradient.value is not None
    assert gradient.std is not None
    assert abs(gradient.value - car.gradient(road=True)) < 3 * gradient.std


@pytest.mark.parametrize("late_s", [0.08, 0.45])
def test_a_late_roll_channel_is_said_and_allowed_for(late_s: float) -> None:
    """By a filter's lag, and by the way through another unit."""
    rng = np.random.default_rng(4)
    car = plant.Car()
    motion = plant.simulate(car, plant.sine_with_dwell(5.0, 3))
    drive = plant.without(plant.record(motion, car, plant.Sensors(roll_delay=late_s), rng), "suspension")
    found = analyse(drive, plant.vehicle_of(car, plant.Knowledge(), rng))
    assert "ms after the lateral acceleration" in found.reason
    assert "ms before the angle's rate" in found.reason
    gradient = found.parameters["roll_gradient_degpg"]
    assert "ms before the angle's rate" in gradient.reason
    assert gradient.value is not None
    assert gradient.std is not None
    assert abs(gradient.value - car.gradient(road=True)) < 3 * gradient.std


def test_tracks_narrow_and_end_at_the_estimate(slalom: tuple[plant.Car, plant.Drive]) -> None:
    car, drive = slalom
    vehicle = plant.vehicle_of(car, plant.Knowledge(), np.random.default_rng(2))
    found = analyse(plant.without(drive, "suspension"), vehicle)
    tracks = {t.parameter: t for t in found.tracks}
    gradient = tracks["roll_gradient_degpg"]
    assert len(gradient.time_s) <= 300
    assert gradient.value[-1] == pytest.approx(found.parameters["roll_gradient_degpg"].value, rel=0.02)
    assert gradient.high[-1] - gradient.low[-1] < 0.5 * (gradient.high[5] - gradient.low[5])
    assert tracks["cg_height_m"].value[-1] == pytest.approx(found.parameters["cg_height_m"].value, abs=0.006)
    (scatter,) = found.scatters
    assert len(scatter.x) <= 3000
    assert (scatter.band_low <= scatter.fit_y).all()
    names = [trace.name for trace in found.traces]
    assert names == ["roll fit", "roll rate fit", "innovations"]


def test_same_seed_same_answer(slalom: tuple[plant.Car, plant.Drive]) -> None:
    car, drive = slalom
    vehicle = plant.vehicle_of(car, plant.Knowledge(), np.random.default_rng(2))
    assert analyse(drive, vehicle).parameters == analyse(drive, vehicle).parameters


VOLVO = """
[vehicle]
name = "V40"
body = "Hatchback"
mass_kg = 1355
wheelbase_m = 2.55
track_front_m = 1.565
track_rear_m = 1.565
"""


@pytest.mark.skipif(
    not (LOGS / "volvo_v40_slalom_35kph.vbo").exists(), reason="the recorded logs are not here"
)
def test_recorded_slalom() -> None:
    load = pytest.importorskip("parsers.load")
    drive = load.load_drive([LOGS / "volvo_v40_slalom_35kph.vbo"], load.LoadOptions())
    found = analyse(drive, parse_vehicle(VOLVO, Path("vehicle.toml"))).parameters
    height, gradient = found["cg_height_m"], found["roll_gradient_degpg"]
    assert height.status in ("weak", "not_identifiable")
    assert height.low is not None
    assert height.high is not None
    assert height.low <= 0.50
    assert height.high >= 0.60
    assert gradient.value == pytest.approx(6.75, abs=0.35)
    assert found["roll_natural_frequency_hz"].status == "not_identifiable"
    assert found["roll_damping_ratio"].status == "not_identifiable"
