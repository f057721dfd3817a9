"""The plant's vehicle at rest: loads, corner weights, truth, small motion, and figures that cannot be."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from full_plant import demand, free_motion, without_losses

from parsers.signals import WHEELS
from pipelines.parameters import PARAMETERS
from pipelines.simulation.loads import Load, loaded, truth
from pipelines.simulation.plant import layout as at
from pipelines.simulation.plant.linear import modes, small_motion
from pipelines.simulation.plant.run import simulate
from pipelines.simulation.plant.static import posture, standing_stiffness
from pipelines.simulation.plant.vehicle import PRESETS, PlantVehicle
from pipelines.simulation.records import GRAVITY, straight_road

ROOF = Load(120.0, 1.7, 0.0, 1.85)
SIDE = Load(180.0, 1.9, 0.5, 0.8)
REAR = Load(250.0, 2.9, -0.1, 0.9)
RIDES = pytest.mark.parametrize("loads", [(), (ROOF,), (SIDE, REAR)])


@RIDES
@pytest.mark.parametrize("name", list(PRESETS))
def test_corner_weights_carry_the_vehicle(name: str, loads: tuple[Load, ...]) -> None:
    vehicle = PRESETS[name]
    known = truth(vehicle, loads)
    corners = np.array([known[f"corner_mass_{w}_kg"] for w in WHEELS])
    assert corners.sum() == pytest.approx(known["mass_kg"], rel=1e-9)
    # level ground: the CG stands over the corners' centre, along and across (sag moves the feet by fractions of a mm)
    rear_share = corners[2:].sum() / corners.sum()
    assert rear_share * vehicle.wheelbase_m == pytest.approx(known["cg_to_front_axle_m"], abs=0.004)
    half = (
        np.array([1, -1, 0, 0]) * vehicle.track_front_m / 2
        + np.array([0, 0, 1, -1]) * vehicle.track_rear_m / 2
    )
    assert corners @ half / corners.sum() == pytest.approx(known["cg_lateral_offset_m"], abs=0.004)


@RIDES
def test_the_plant_rests_where_the_truth_says(loads: tuple[Load, ...]) -> None:
    run = simulate(PRESETS["van"], demand(2.0), straight_road(10), loads=loads)
    for wheel in WHEELS:
        load = run.columns[f"tire_normal_force_{wheel}_n"]
        assert load / GRAVITY == pytest.approx(run.truth[f"corner_mass_{wheel}_kg"], rel=1e-4)
    assert np.abs(run.columns["heave_m"]).max() < 1e-5
    assert run.sprung_cg_m[2] == pytest.approx(run.truth["sprung_cg_height_m"])
    if not loads:
        assert max(np.abs(run.columns[f"suspension_deflection_{w}_m"]).max() for w in WHEELS) < 1e-5


def test_a_load_moves_mass_cg_and_inertia_by_the_parallel_axes() -> None:
    vehicle = PRESETS["suv"]
    empty, full = truth(vehicle, []), truth(vehicle, [ROOF])
    sag = full["sprung_cg_height_m"] - loaded(vehicle, [ROOF]).sprung_cg_height_m
    assert -0.02 < sag < -0.005
    mass = empty["mass_kg"] + 120
    level = (empty["mass_kg"] * empty["cg_height_m"] + 120 * 1.85) / mass
    # the sprung mass sags, the wheels a little
    assert full["cg_height_m"] == pytest.approx(level + sag, abs=0.002)
    along = (empty["mass_kg"] * empty["cg_to_front_axle_m"] + 120 * 1.7) / mass
    assert full["cg_to_front_axle_m"] == pytest.approx(along, abs=0.003)
    reduced = empty["mass_kg"] * 120 / mass
    box = 120 / 12 * (0.6**2 + 0.3**2)
    inertia = empty["roll_inertia_kgm2"] + box + reduced * (1.85 - empty["cg_height_m"]) ** 2
    assert full["roll_inertia_kgm2"] == pytest.approx(inertia, rel=0.02)


def test_two_loads_are_one_load_of_both() -> None:
    """A box of two halves is the sum of its halves."""
    halves = [Load(50, 1.5 + x, 0.2, 1.5, 0.5, 0.6, 0.3) for x in (-0.25, 0.25)]
    one, two = (
        loaded(PRESETS["suv"], [Load(100, 1.5, 0.2, 1.5, 1.0, 0.6, 0.3)]),
        loaded(PRESETS["suv"], halves),
    )
    for item in fields(PlantVehicle):
        if isinstance(getattr(one, item.name), float):
            assert getattr(one, item.name) == pytest.approx(getattr(two, item.name))


def test_a_load_high_in_front_turns_the_axes_of_inertia_forward() -> None:
    """The product of inertia of masses ahead and above is positive in axes forward and up."""
    base = replace(PRESETS["suv"], sprung_product_xz_kgm2=0.0)
    ahead, behind = 0.3, 2.6
    point = {"length_m": 0.0, "width_m": 0.0, "height_m": 0.0}
    for place, sign in ((ahead, 1), (behind, -1)):
        full = loaded(base, [Load(100.0, place, 0.0, 1.7, **point)])
        x, z = base.sprung_cg_behind_front_axle_m - place, 1.7 - base.sprung_cg_height_m
        reduced = 100 * base.sprung_mass_kg / (100 + base.sprung_mass_kg)
        assert full.sprung_product_xz_kgm2 == pytest.approx(reduced * x * z)
        assert full.sprung_product_xz_kgm2 * sign > 0


def test_truth_speaks_the_parameters_names() -> None:
    known = truth(PRESETS["truck"], [])
    assert set(known) <= set(PARAMETERS)
    assert known["cg_height_m"] == pytest.approx(1.03, abs=0.005)
    assert known["cg_to_front_axle_m"] == pytest.approx(1.5, abs=0.005)
    assert known["mass_kg"] == 5762
    assert known["roll_arm_m"] == known["sprung_cg_height_m"] - known["roll_center_height_m"]


@pytest.mark.parametrize("name", list(PRESETS))
def test_presets_are_plausible(name: str) -> None:
    vehicle = PRESETS[name]
    known = truth(vehicle, [])
    stability = (vehicle.track_front_m + vehicle.track_rear_m) / 4 / known["cg_height_m"]
    assert (0.75 if "truck" in name else 1.0) < stability < 1.6
    assert 1.0 < known["roll_natural_frequency_hz"] < 2.5
    assert 3.0 < known["roll_gradient_degpg"] < 8.0
    mass, damping, stiffness = small_motion(vehicle)
    frequency, shapes = modes(mass, stiffness)
    # the bounce modes are those that lift all wheels or the body together
    both = [
        f for f, s in zip(frequency, shapes.T, strict=True)
        if min(s[3] * s[4], s[5] * s[6]) > 0 and abs(s[1]) < 0.01 * np.abs(s[3:]).max()
    ]  # fmt: skip
    assert all(1.0 < f < 2.3 or 9.0 < f < 15.0 for f in both)
    assert known["cg_height_m"] == pytest.approx(vehicle.cg_height_m, abs=1e-6)
    assert known["cg_to_front_axle_m"] == pytest.approx(vehicle.cg_to_front_axle_m, abs=1e-6)
    ratio = damping[0, 0] / 1.0
    assert ratio > 0


def _swing_hz(roll: np.ndarray) -> float:
    """Frequency of a decaying swing sampled at 100 Hz."""
    spectrum = np.abs(np.fft.rfft(roll * np.hanning(len(roll)), 1 << 18))
    return float(np.argmax(spectrum)) * 100 / (1 << 18)


def _roll_mode_hz(vehicle: PlantVehicle, feet_held: bool) -> float:
    """Of the linear model, with gravity's part."""
    mass, _, _ = small_motion(vehicle, feet_held=feet_held)
    frequency, shapes = modes(mass, standing_stiffness(vehicle))
    bodily = np.argsort(frequency)[:3]
    return float(frequency[bodily[np.argmax(np.abs(shapes[1, bodily]) / np.abs(shapes[0, bodily]))]])


def test_small_roll_swings_at_the_linear_models_frequency() -> None:
    """Without losses, on ice and on feet that hold: the kernel's period against the separate linear model's."""
    vehicle = without_losses(replace(PRESETS["suv"], sprung_cg_left_m=0.0))
    ice = free_motion(vehicle, {at.ROLL: 1e-4}, duration_s=20.0)
    assert _swing_hz(ice.states[:, at.ROLL]) == pytest.approx(_roll_mode_hz(vehicle, False), rel=2e-3)
    stiff = {f"cornering_stiffness_{axle}_prad": 60.0 for axle in ("front", "rear")}
    held = replace(vehicle, relaxation_lateral_m=0.1, **stiff)
    swing = free_motion(held, {at.ROLL: 1e-4}, friction=0.9, duration_s=20.0, step_s=0.00025)
    assert _swing_hz(swing.states[:, at.ROLL]) == pytest.approx(_roll_mode_hz(held, True), rel=3e-3)


def test_natural_frequency_is_the_mode_without_gravity() -> None:
    """K / J of springs and tyres: the mode's own stiffness less gravity's part m g h is what swings at rest."""
    vehicle = without_losses(PRESETS["suv"])
    known = truth(vehicle, [])
    pull = known["sprung_mass_kg"] * GRAVITY * known["roll_arm_m"]
    stiffness = pull / np.radians(known["roll_gradient_degpg"])
    expected = _roll_mode_hz(vehicle, True) / np.sqrt(1 - pull / stiffness)
    assert known["roll_natural_frequency_hz"] == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("speed", [12.0, 25.0])
def test_steady_roll_is_that_of_the_linear_truth(speed: float) -> None:
    """Left less right in gentle steady turns: degrees a g of sensed acceleration."""
    vehicle = replace(PRESETS["suv"], friction_n=0.0)
    left, right = (
        simulate(vehicle, demand(8.0, steer=angle, speed=speed), straight_road(300)).columns
        for angle in (0.05, -0.05)
    )
    lean, sensed = (left[name][-1] - right[name][-1] for name in ("roll_rad", "accel_y_mps2"))
    gradient = np.degrees(lean) / sensed * GRAVITY
    assert gradient == pytest.approx(truth(vehicle, [])["roll_gradient_degpg"], rel=2e-3)


def test_what_cannot_be_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="sprung_mass_kg"):
        replace(PRESETS["suv"], sprung_mass_kg=-1.0)
    with pytest.raises(ValueError, match="brake_front_share"):
        replace(PRESETS["suv"], brake_front_share=1.2)
    with pytest.raises(ValueError, match="track_rear_m"):
        replace(PRESETS["suv"], track_rear_m=float("nan"))
    with pytest.raises(ValueError, match="mass_kg"):
        Load(-1.0, 1.0, 0.0, 1.0)
    with pytest.raises(ValueError, match=r"stand on its four wheels|find its rest"):
        posture(loaded(PRESETS["sedan"], [Load(3000.0, 1.2, 0.7, 2.5)]))
