"""What a load does to springs, tracks and the body's lean, against the plant's own equilibrium, whose geometry is another."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from benchmarks.vehicle_data import upright
from pipelines.joint.vehicle.body import SOFTEST, body_of, hub_height
from pipelines.joint.vehicle.laden import (
    axis_lever,
    leans,
    mean_widening,
    pressed,
    rate_under_load,
    roll_center,
    side_moment,
    widened,
)
from pipelines.joint.vehicle.outputs import at_rest, roll_stiffness_of
from pipelines.models.roll import GRAVITY
from pipelines.simulation.loads import Load, loaded, truth
from pipelines.simulation.plant import layout as at
from pipelines.simulation.plant.random_vehicle import random_vehicle
from pipelines.simulation.plant.static import posture, rotation, spring_forces
from pipelines.simulation.plant.vehicle import PlantVehicle


def plain(seed: int) -> PlantVehicle:
    """A random vehicle whose springs neither stiffen nor meet their stops, and whose loads stay under their wheels."""
    made = random_vehicle(np.random.default_rng(seed))
    return replace(
        made, spring_stiffening_pm2=0.0, bump_clearance_m=1.0, rebound_clearance_m=1.0, patch_give=0.0
    )


def values_of(plant: PlantVehicle, load: Load | None) -> dict[str, Any]:
    """The plant's figures as unknowns. Places count from the front wheels' hubs, over which the body pitches."""
    empty = truth(plant, ())
    values: dict[str, Any] = {
        "empty_mass": empty["mass_kg"], "empty_x": empty["cg_to_front_axle_m"], "empty_y": empty["cg_lateral_offset_m"],
        "empty_h": empty["cg_height_m"], "wheelbase": plant.wheelbase_m, "radius": plant.wheel_radius_front_m,
        "hub_low": plant.wheel_radius_front_m - float(np.mean(plant.hub_heights_m)), "camber": upright(plant),
        "tyre_rate": 0.5 * (plant.tire_vertical_rate_front_npm + plant.tire_vertical_rate_rear_npm),
        "load": 0.0, "load_x": 1.0, "load_y": 0.0, "load_h": 1.0, "pitch_path": float(np.mean(plant.hub_heights_m)), "track_grows": 1.0, "axis_sinks": 0.0,
        "sinks_front": plant.roll_center_drop_front, "sinks_rear": plant.roll_center_drop_rear, "paths_told": 0.0, "path_front": 0.0, "path_rear": 0.0, "lean_path": 0.0,
    }  # fmt: skip
    for axle in ("front", "rear"):
        values |= {
            f"spring_{axle}": getattr(plant, f"spring_rate_{axle}_npm"), f"square_{axle}": 0.0, f"cube_{axle}": 0.0, f"spring_base_{axle}": 1.0,
            f"free_{axle}": 10.0, f"stop_{axle}": 0.0,
            f"track_{axle}": getattr(plant, f"track_{axle}_m"),
            f"bar_{axle}": getattr(plant, f"anti_roll_stiffness_{axle}_nmprad"),
            f"roll_center_{axle}": getattr(plant, f"roll_center_height_{axle}_m"),
            f"unsprung_{axle}": 2 * getattr(plant, f"unsprung_mass_{axle}_kg"),
        }  # fmt: skip
    if load is not None:
        values |= {
            "load": load.mass_kg, "load_x": load.behind_front_axle_m, "load_y": load.left_m, "load_h": load.above_ground_m,
        }  # fmt: skip
    return values


def test_known_answers() -> None:
    p = {
        "empty_mass": 1500.0, "load": 400.0, "load_x": 2.6, "wheelbase": 2.6, "spring_rear": 25e3, "spring_front": 25e3, "square_rear": 0.0,
        "cube_rear": 25e3 * 8, "square_front": 0.0, "cube_front": 0.0, "free_front": 10.0, "free_rear": 10.0, "stop_front": 0.0, "stop_rear": 0.0, "track_rear": 1.5, "track_front": 1.5, "roll_center_rear": 0.2, "roll_center_front": 0.1,
        "track_grows": 1.0, "axis_sinks": 0.0, "sinks_front": 0.0, "sinks_rear": 0.0, "paths_told": 0.0, "path_front": 0.0, "path_rear": 0.0, "bar_front": 0.0, "bar_rear": 0.0,
    }  # fmt: skip
    # a cubic's real root by Cardano: d + 8 d³ = straight
    straight = 200 * GRAVITY / 25e3
    root = np.sqrt(straight**2 / 256 + 1 / 24**3)
    d = np.cbrt(straight / 16 + root) + np.cbrt(straight / 16 - root)
    assert pressed(p | {"cube_rear": 0.0}, "rear") == pytest.approx(straight)
    assert pressed(p, "rear") == pytest.approx(d)
    assert pressed(p, "front") == 0
    assert rate_under_load(p, "rear") == pytest.approx(25e3 * (1 + 24 * d**2))
    assert widened(p, "rear") == pytest.approx(1 + 0.2 * d / 0.75**2)
    assert mean_widening(p) == pytest.approx(1 + 0.1 * d / 0.75**2)
    assert axis_lever(p, 0.5) == pytest.approx(0.05 + 0.1 * widened(p, "rear"))
    assert axis_lever(p | {"load": 0.0}, 0.25) == pytest.approx(0.125)
    sunk = p | {"axis_sinks": 1.5}
    assert roll_center(sunk, "rear") == pytest.approx(0.2 - 1.5 * d)
    assert axis_lever(sunk, 0.5) == pytest.approx(0.05 + 0.5 * (0.2 - 1.5 * d) * widened(p, "rear"))


def test_a_load_stands_where_the_spring_s_curve_and_its_stop_hold_it() -> None:
    """Springs that soften and that treble, stops at hand and far, loads that press and lift: against a search for the equilibrium."""
    rng = np.random.default_rng(0)
    for _ in range(300):
        rate, free = rng.uniform(15e3, 60e3), rng.choice([10.0, rng.uniform(0.0, 0.09)])
        square, cube = rate * rng.uniform(-0.3, 3.0), rate * rng.uniform(-7.0, 80.0)
        stop, force = rate * rng.uniform(0.0, 60.0), rate * rng.uniform(-0.05, 0.14)

        def left(
            d: float,
            r: float = rate,
            q: float = square,
            c: float = cube,
            f: float = free,
            s: float = stop,
            n: float = force,
        ) -> float:
            return r * d + q * d**2 + c * d**3 + s * max(d - f, 0.0) ** 1.5 - n

        p = {
            "empty_mass": 1500.0, "load": 2 * force / GRAVITY, "load_x": 2.6, "wheelbase": 2.6, "spring_rear": rate,
            "square_rear": square, "cube_rear": cube, "free_rear": free, "stop_rear": stop,
        }  # fmt: skip
        assert float(pressed(p, "rear")) == pytest.approx(brentq(left, -0.1, 0.25, xtol=1e-12), abs=1e-5)


def test_springs_of_next_to_no_rate_sink_no_further_than_they_can() -> None:
    p = {
        "empty_mass": 1500.0,
        "load": 400.0,
        "load_x": 2.0,
        "wheelbase": 2.6,
        "spring_rear": np.array([1e-9, -50.0, 1e9]),
        "square_rear": 0.0,
        "cube_rear": 0.0,
        "free_rear": 10.0,
        "stop_rear": 0.0,
    }
    softest = 0.25 * SOFTEST * 1500.0
    down = 0.5 * GRAVITY * 400.0 * 2.0 / 2.6 / softest
    assert pressed(p, "rear") == pytest.approx([down, down, 0.0], abs=1e-5)
    heavy = {**p, "load": 2000.0}
    assert pressed(heavy, "rear") == pytest.approx([0.25, 0.25, 0.0], abs=1e-5)


def test_a_body_on_springs_of_next_to_no_rate_sinks_and_leans_no_further_than_vehicles_do() -> None:
    """Of a file without springs some draws have none, or less: heights of such drives were told with ± 10 m."""
    p = values_of(plain(1), Load(300.0, 1.2, 0.2, 0.8)) | {"pitch_path": 0.2}
    usual = body_of(p, None)
    stiff = roll_stiffness_of(p)
    for rate in (1e-9, -1e3, -0.999 * p["spring_rear"]):
        soft = body_of(p | {"spring_front": rate, "spring_rear": 1e-3}, None)
        assert 0 < usual.h - soft.h < 0.12
    axis = 0.1
    for stiffness in (-1e5, -1.0, 0.0, 1.0, GRAVITY * usual.sprung * (usual.h - axis)):
        assert abs(leans(p, usual, axis, stiffness)[1]) < 0.2
    assert leans(p, usual, axis, stiff)[1] > 0


def test_a_stop_takes_its_share_of_the_load_and_is_in_the_rate() -> None:
    loads = np.linspace(0.0, 900.0, 19)
    p = {
        "empty_mass": 1500.0, "load": loads, "load_x": 2.6, "wheelbase": 2.6, "spring_rear": 25e3, "square_rear": 0.0, "cube_rear": 0.0,
        "free_rear": 0.06, "stop_rear": 25.0 * 25e3,
    }  # fmt: skip
    d = pressed(p, "rear")
    into = np.maximum(d - 0.06, 0.0)
    assert 25e3 * d + 25.0 * 25e3 * into**1.5 == pytest.approx(0.5 * GRAVITY * loads)
    assert 0.005 < into.max() < 0.06
    rate, before = rate_under_load(p, "rear"), rate_under_load({**p, "stop_rear": 0.0}, "rear")
    assert before == pytest.approx(np.full(19, 25e3))
    deep, far = into > 0.01, d < 0.045
    assert deep.any()
    assert far.any()
    assert rate[deep] == pytest.approx(25e3 * (1 + 37.5 * np.sqrt(into[deep])), rel=1e-3)
    assert rate[far] == pytest.approx(25e3, rel=0.02)
    assert (np.diff(rate) > 0).all()


@pytest.mark.parametrize("seed", range(6))
def test_a_load_on_the_stops_stands_where_the_plants_equilibrium_has_it(seed: int) -> None:
    plant = replace(plain(seed), bump_clearance_m=0.03)
    load = Load(0.3 * plant.mass_kg, 0.95 * plant.wheelbase_m, 0.0, 0.8)
    rear = float(posture(loaded(plant, [load])).coordinates[5:].mean())
    assert rear > 0.031
    p = values_of(plant, load) | {"free_rear": 0.03, "stop_rear": 25.0 * plant.spring_rate_rear_npm}
    # the plant's stops are linear ones
    assert float(pressed(p, "rear")) == pytest.approx(rear, rel=0.25)
    assert float(pressed({**p, "stop_rear": 0.0}, "rear")) > 1.15 * rear


def test_what_a_rig_says_of_the_loads_paths_takes_the_place_of_geometry() -> None:
    plant = plain(2)
    p = values_of(plant, None) | {"side_path": 0.3, "wheel_plane": 0.9, "camber": 0.6}
    body = body_of(p, None)
    weight = GRAVITY * body.sprung * body.x / plant.wheelbase_m
    told = p | {"paths_told": 1.0, "path_rear": 0.07, "sinks_front": 0.0, "sinks_rear": 0.0}
    assert side_moment(told, body, "rear") == pytest.approx(0.07 * weight)
    # discs that lean, and the hub's own weight
    height, hubs = float(np.mean(plant.hub_heights_m)), GRAVITY * 2 * plant.unsprung_mass_rear_kg
    geometry = (
        0.3 * plant.roll_center_height_rear_m
        - 0.9 * 0.36 * height
        + 0.6 * (1 - 0.9 * 0.6) * height * hubs / weight
    )
    assert side_moment(p, body, "rear") == pytest.approx(geometry * weight)
    # and it sinks with the roll centre
    laden = told | {"load": 300.0, "load_x": 2.0, "axis_sinks": 1.5}
    down = 1.5 * float(pressed(laden, "rear"))
    assert side_moment(laden, body, "rear") == pytest.approx((0.07 - down) * weight)


@pytest.mark.parametrize("seed", range(6))
def test_the_cg_stands_where_the_plants_equilibrium_has_it(seed: int) -> None:
    plant = plain(seed)
    load = Load(0.2 * plant.mass_kg, 0.95 * plant.wheelbase_m, 0.3, 0.8)
    p = values_of(plant, load)
    body = body_of(p, None)
    true, rest = truth(plant, [load]), posture(loaded(plant, [load]))
    x, y = at_rest(p, body)
    shift = true["cg_to_front_axle_m"] - body.whole_x, true["cg_lateral_offset_m"] - body.whole_y
    # without the lean a full boot's place, and that of a load to one side, would be off by several mm
    assert shift[0] > 0.005
    assert shift[1] > 0.003
    assert x - true["cg_to_front_axle_m"] == pytest.approx(0, abs=0.25 * shift[0])
    assert y - true["cg_lateral_offset_m"] == pytest.approx(0, abs=0.35 * shift[1])
    back, left = leans(p, body, true["roll_center_height_m"], roll_stiffness_of(p))
    assert back == pytest.approx(-rest.coordinates[2], rel=0.12)
    assert left == pytest.approx(-rest.coordinates[1], rel=0.2)


def straight(plant: PlantVehicle) -> PlantVehicle:
    """The same with roll centres that stay where they are."""
    return replace(plant, roll_center_drop_front=0.0, roll_center_drop_rear=0.0)


BEND = 1.0
"""m/s²: in quicker bends outer feet, which are nearer to the CG, take more of the side force, half a percent of the moment at 3."""


def held(plant: PlantVehicle, carried: list[Load], side_path: float, track_grows: float) -> float:
    """The springs' moment in a slow bend, with what the feet's paths ease, over what the roll balance expects of it."""
    full = loaded(plant, carried)
    pack, wheels = at.pack(full)
    rest, turn = posture(full).coordinates, posture(full, BEND).coordinates
    # what a CG beside the middle has them carry at rest is no roll moment
    force = spring_forces(turn[3:], pack, wheels) - spring_forces(rest[3:], pack, wheels)
    lateral = float((rotation(float(turn[1]), float(turn[2])).T @ [0.0, BEND, GRAVITY])[1])
    p = values_of(plant, carried[0] if carried else None)
    # the plant's feet are below its hubs
    p |= {"side_path": side_path, "track_grows": track_grows, "wheel_plane": 0.0}
    body, true, moment = body_of(p, None), truth(plant, carried), 0.0
    for axle, first in (("front", 0), ("rear", 2)):
        moment += 0.5 * p[f"track_{axle}"] * widened(p, axle) * float(force[first] - force[first + 1])
        lean = float(turn[3 + first] - turn[4 + first]) / p[f"track_{axle}"]
        moment += side_moment(p, body, axle) * lean
    share = true["cg_to_front_axle_m"] / plant.wheelbase_m
    arm = true["sprung_mass_kg"] * (true["sprung_cg_height_m"] - axis_lever(p, share))
    spin = 2 * (plant.wheel_inertia_front_kgm2 + plant.wheel_inertia_rear_kgm2) / plant.wheel_radius_front_m
    lean = 1 - upright(plant)
    hubs = lean * (p["unsprung_front"] + p["unsprung_rear"]) * hub_height(p)
    return abs(moment) / ((arm + hubs) * abs(lateral) + lean * spin * BEND) - 1


def test_the_roll_balance_is_the_plants_with_a_load_and_without() -> None:
    found = []
    for seed in range(12):
        bent = plain(seed)
        load = Load(0.25 * bent.mass_kg, 0.95 * bent.wheelbase_m, 0.0, 0.8)
        # paths that bend add what is of second order in the travel
        assert np.abs([held(bent, [], 1.0, 1.0), held(bent, [load], 1.0, 1.0)]) == pytest.approx(0, abs=0.011)
        plant = straight(bent)
        whole = held(plant, [], 1.0, 1.0), held(plant, [load], 1.0, 1.0)
        found.append((*whole, held(plant, [], 0.0, 0.0), held(plant, [load], 0.0, 0.0)))
        assert np.abs(whole) == pytest.approx(0, abs=0.01)
    empty, laden, plain_empty, plain_laden = np.array(found).mean(axis=0)
    assert empty == pytest.approx(0, abs=0.003)
    assert laden == pytest.approx(0, abs=0.003)
    # a body that merely turns about an axis between the roll centres would lean 1 to 3 % more than this
    assert plain_empty < -0.008
    assert plain_laden < -0.02
