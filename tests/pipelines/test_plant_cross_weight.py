"""Spring seats that warp: corner weights move over a diagonal, the CG stays, and energy still closes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from full_plant import demand, free_motion, without_losses

from parsers.signals import WHEELS
from pipelines.simulation.loads import Load, loaded, truth
from pipelines.simulation.plant import layout as at
from pipelines.simulation.plant.run import simulate
from pipelines.simulation.plant.vehicle import PRESETS
from pipelines.simulation.records import GRAVITY, straight_road

LOAD = Load(180.0, 2.3, 0.3, 0.9)


@pytest.mark.parametrize("name", ["suv", "truck"])
@pytest.mark.parametrize("loads", [(), (LOAD,)])
def test_corner_weights_move_and_the_cg_stays(name: str, loads: tuple[Load, ...]) -> None:
    level, warped = PRESETS[name], replace(PRESETS[name], cross_weight_kg=30.0)
    before, after = truth(level, loads), truth(warped, loads)
    rear = 30 * level.track_front_m / level.track_rear_m
    for wheel, moved in zip(WHEELS, (-30.0, 30.0, rear, -rear), strict=True):
        key = f"corner_mass_{wheel}_kg"
        assert after[key] - before[key] == pytest.approx(moved, abs=0.2)
    for key in ("mass_kg", "cg_to_front_axle_m", "cg_lateral_offset_m", "cg_height_m"):
        assert after[key] == pytest.approx(before[key], abs=1e-4), key


def test_the_warped_vehicle_rests_where_its_truth_says() -> None:
    vehicle = replace(PRESETS["suv"], cross_weight_kg=-30.0)
    run = simulate(vehicle, demand(2.0), straight_road(10), loads=[LOAD])
    for wheel, under in zip(WHEELS, vehicle.unsprung_masses_kg, strict=True):
        corner = run.truth[f"corner_mass_{wheel}_kg"]
        assert run.columns[f"tire_normal_force_{wheel}_n"] / GRAVITY == pytest.approx(corner, rel=1e-4)
        # the loaded body leans a little, and the struts with it
        assert run.columns[f"suspension_force_{wheel}_n"] / GRAVITY == pytest.approx(corner - under, rel=2e-3)


def test_without_losses_its_energy_stays() -> None:
    vehicle = loaded(without_losses(replace(PRESETS["suv"], cross_weight_kg=30.0)), [LOAD])
    motion = free_motion(vehicle, {at.ROLL: 0.05, at.HEIGHT: 0.03, at.P: 0.4}, step_s=0.00025)
    moved = np.ptp(motion.states[:, at.HEIGHT]) * vehicle.sprung_mass_kg * GRAVITY
    assert moved > 300
    assert np.abs(motion.energy - motion.energy[0]).max() < 1e-3 * moved


def test_no_warp_changes_no_bit_and_too_much_is_refused() -> None:
    assert replace(PRESETS["van"], cross_weight_kg=0.0).preloads_n == PRESETS["van"].preloads_n
    with pytest.raises(ValueError, match="cross_weight_kg"):
        replace(PRESETS["sedan"], cross_weight_kg=500.0)
