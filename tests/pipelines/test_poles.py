"""Pitch centres that go along with the body: by arms' lengths that a rig's figures tell, and beside the plant's own equations."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from pipelines.joint.vehicle.poles import OF_REAR, USUAL_SINK, dip_levers, pitch_centres, pole_drop
from pipelines.joint.vehicle.unknowns import before_the_log, body_of
from pipelines.simulation.loads import Load, truth
from pipelines.simulation.logs.vehicle import sheet_values
from pipelines.simulation.plant.vehicle import PRESETS
from pipelines.vehicles.vehicle import Quantity, Vehicle

BOOT = Load(300.0, 2.8, 0.0, 0.9)


def file_of(figures: Mapping[str, float], **more: str) -> Vehicle:
    """A vehicle file with these figures, all of them known to half a per cent."""
    quantities = {key: Quantity(value, 0.005 * abs(value), "stated") for key, value in figures.items()}
    return Vehicle(quantities=quantities, **more)  # type: ignore[arg-type]


def at_mean(vehicle: Vehicle, **figures: float) -> dict[str, float]:
    known = before_the_log(vehicle)
    return dict(known.at(np.zeros(len(known.names)))) | figures


def test_a_rig_tells_the_arms_by_hubs_and_feet() -> None:
    """Arms of 2 m in front and 0.45 m behind, poles 0.28 and 0.25 m above ground: hubs and feet go as these have it."""
    ahead, behind, radius, braked = 1.2, 1.5, 0.31, 0.65
    slopes = (0.28 / 2.0, 0.25 / 0.45)
    hubs = ((0.28 - radius) / 2.0, (0.25 - radius) / 0.45)
    figures = {
        "mass_kg": 1500.0, "wheelbase_m": ahead + behind, "cg_to_front_axle_m": ahead, "wheel_radius_m": radius,
        "unsprung_mass_front_kg": 90.0, "unsprung_mass_rear_kg": 90.0,
        "pitch_center_height_m": braked * ahead * slopes[0] + (1 - braked) * behind * slopes[1],
        "wheel_recession_front": -hubs[0], "wheel_recession_rear": hubs[1],
    }  # fmt: skip
    told = at_mean(file_of(figures))["poles_sink"]
    assert told == pytest.approx(braked * ahead / 2.0 + (1 - braked) * behind / 0.45, rel=0.15)


def test_links_of_a_rigid_axle_move_the_pole_where_it_is_far_off() -> None:
    """A pickup's axle on links of 0.45 and 0.62 m, its pole 3.4 m ahead: its way turns by 1 a m (0.3 by that pole alone)."""
    ahead, behind, braked, length = 1.4, 1.9, 0.65, 3.4
    figures = {
        "mass_kg": 2000.0, "wheelbase_m": ahead + behind, "cg_to_front_axle_m": ahead, "wheel_radius_m": 0.36,
        "unsprung_mass_front_kg": 120.0, "unsprung_mass_rear_kg": 190.0, "pitch_center_height_m": 0.076,
        "wheel_recession_front": 0.08, "wheel_recession_rear": 0.0,
    }  # fmt: skip
    for body, held in (("Pickup", True), ("Sedan", False)):
        known = before_the_log(file_of(figures, body=body))
        row = known.index("poles_sink")
        turned = (1 - braked) * behind * 1.0
        assert turned > 2 * (1 - braked) * behind / length
        assert (abs(known.mean[row] - turned) < 2 * known.std[row]) == held


def test_silent_files_leave_it_open_and_say_so() -> None:
    known = before_the_log(file_of({"mass_kg": 1500.0}))
    row = known.index("poles_sink")
    assert (known.mean[row], known.std[row]) == USUAL_SINK
    assert any("pitch centre comes down" in a.name for a in known.assumptions)


def test_springs_that_level_themselves_keep_the_pole_up() -> None:
    figures = {"mass_kg": 1500.0, "spring_rate_front_npm": 25e3, "spring_rate_rear_npm": 25e3}
    loaded = {"load": 300.0, "load_x": 2.5, "poles_sink": 1.4}
    sinks = pole_drop(at_mean(file_of(figures), **loaded))
    assert sinks > 0.04
    assert pole_drop(at_mean(file_of(figures, self_levelling="both"), **loaded)) == 0.0


def test_the_pole_sinks_as_on_the_plant() -> None:
    """Trailing arms under a full boot: the pitch centre of the file's figures and of the plant at rest."""
    car = replace(
        PRESETS["suv"],
        side_slope_rear=-0.5,
        side_slope_drive_rear=0.2,
        pole_follow=1.0,
        spring_stiffening_pm2=0.0,
    )
    slopes = {"front": car.side_slope_drive_front, "rear": car.side_slope_drive_rear}
    recessions = {f"wheel_recession_{axle}": -slope for axle, slope in slopes.items()}
    vehicle = file_of(sheet_values(car) | recessions)
    load = {
        "load": BOOT.mass_kg,
        "load_x": BOOT.behind_front_axle_m,
        "load_y": 0.0,
        "load_h": BOOT.above_ground_m,
    }
    centres = []
    for values in (at_mean(vehicle, load=0.0), at_mean(vehicle, **load)):
        p = values | {"jack_brake": 0.0, "jack_drive": 0.0, "poles_rear": 0.85}
        centres.append(pitch_centres(p, body_of(p, None))[0])
    true = [t["sprung_cg_height_m"] - t["pitch_arm_m"] for t in (truth(car, ()), truth(car, (BOOT,)))]
    assert true[0] - true[1] > 0.03
    # a load moves the body's CG back as well, which the plant's brake shares turn into another height
    assert centres[0] - centres[1] == pytest.approx(true[0] - true[1], rel=0.25)


def test_a_tail_that_comes_up_takes_the_pole_along() -> None:
    p = {"wheelbase": 2.7, "drive_front": 1.0, "poles_sink": 1.4, "poles_rear": OF_REAR}
    still = p | {"poles_sink": 0.0}
    body = SimpleNamespace(x=1.2)
    more = [a - b for a, b in zip(dip_levers(p, body), dip_levers(still, body), strict=True)]
    assert more == pytest.approx([1.4 * (0.75 * 1.5 - 0.25 * 1.2)] * 2)
