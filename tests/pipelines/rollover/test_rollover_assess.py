"""Static figures with their intervals, what is missing said, and the figures that other programs read."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from roll_plane import Plane, drive, log_of, ride, slalom, vehicle, verdict

from pipelines.results import ParameterEstimate
from pipelines.rollover import assess_rollover
from pipelines.rollover.body import Body, draw_body
from pipelines.rollover.draws import from_interval
from pipelines.vehicles.vehicle import Quantity, Vehicle

PLANE = Plane()
HEIGHT = ParameterEstimate("cg_height_m", 0.66, 0.02, 0.62, 0.70, "identified", "", None, None, ("roll_map",))
TRACKS = {
    "track_front_m": Quantity(1.58, 0.005, "vehicle file"),
    "track_rear_m": Quantity(1.60, 0.005, "vehicle file"),
}


def test_static_figures_by_hand() -> None:
    car = Vehicle(quantities=TRACKS, reference={"cg_height_m": 0.65})
    found = assess_rollover({"cg_height_m": HEIGHT}, car, log_of(ride(PLANE, slalom(0.5)), forces=False))
    factor = found.static_stability_factor
    assert factor is not None
    assert factor.value == pytest.approx(1.59 / (2 * 0.66), rel=2e-3)
    assert factor.low == pytest.approx(1.59 / (2 * 0.70), rel=5e-3)
    assert factor.high == pytest.approx(1.59 / (2 * 0.62), rel=5e-3)
    assert factor.reference == pytest.approx(1.59 / 1.3)
    assert factor.sources == ("roll_map",)
    threshold = found.threshold_g
    assert threshold is not None
    assert threshold.name == "threshold_g"
    assert factor.value is not None
    assert threshold.value is not None
    # body roll, jacking and spinning wheels take 5 to 20 %
    assert 0.8 < threshold.value / factor.value < 0.95
    assert [limit.name for limit in found.limits] == ["rigid", "suspension", "contact", "quasi_static"]


def test_the_limit_of_the_rigid_vehicle_is_the_static_stability_factor() -> None:
    """Tracks that differ, and a CG that is not midway between the axles: one figure all the same."""
    tracks = {**TRACKS, "track_rear_m": Quantity(1.70, 0.005, ""), "wheelbase_m": Quantity(2.8, 0.005, "")}
    place = ParameterEstimate("cg_to_front_axle_m", 1.1, 0.02, 1.06, 1.14, "identified", "")
    known = {"cg_height_m": HEIGHT, place.name: place}
    found = assess_rollover(known, Vehicle(quantities=tracks), drive({"accel_y": np.zeros(1000)}))
    factor, rigid = found.static_stability_factor, found.limits[0]
    assert factor is not None
    assert factor.value == pytest.approx(1.64 / (2 * 0.66), rel=2e-3)
    for side, told in (("left", rigid.left), ("right", rigid.right)):
        assert told == replace(factor, name=f"rigid_{side}_g")


def test_the_threshold_of_the_plane_vehicle() -> None:
    """Stiff springs and tyres, no spin: (163) is exact, so the medians must be the plane vehicle's own limits."""
    found = assess_rollover(verdict(PLANE), vehicle(PLANE), drive({"accel_y": np.zeros(1000)}))
    contact = found.limits[2]
    lever = PLANE.sprung * PLANE.arm / PLANE.mass
    for side, told in ((1.0, contact.left), (-1.0, contact.right)):
        limit = 1.0
        for _ in range(100):
            roll = np.radians(PLANE.gradient_degpg) * limit
            for _ in range(50):
                roll = np.radians(PLANE.gradient_degpg) * (limit * np.cos(roll) + np.sin(roll))
            limit = (PLANE.track / 2 + side * PLANE.offset - lever * roll) / PLANE.height
        assert told.value == pytest.approx(limit, rel=0.004)
    assert contact.left.value is not None
    assert contact.right.value is not None
    assert contact.left.value > contact.right.value


def test_every_interval_follows_from_a_parameter() -> None:
    log = drive({"accel_y": np.zeros(1000)})
    base = assess_rollover(verdict(PLANE, 0.002), vehicle(PLANE), log).limits[2].left
    assert base.std is not None
    for name in ("cg_height_m", "roll_gradient_degpg", "cg_lateral_offset_m"):
        entry = verdict(PLANE)[name]
        assert entry.value is not None
        half = 0.03 if name == "cg_lateral_offset_m" else 0.2 * entry.value
        wide = replace(entry, std=half / 1.96, low=entry.value - half, high=entry.value + half)
        told = assess_rollover(verdict(PLANE, 0.002, **{name: wide}), vehicle(PLANE), log).limits[2].left
        assert told.std is not None
        assert told.std > 1.2 * base.std, name


def test_a_lopsided_interval_is_drawn_lopsided() -> None:
    z = np.random.default_rng(1).standard_normal(40_000)
    entry = ParameterEstimate("cg_height_m", 0.7, 0.03, 0.66, 0.82, "weak", "")
    low, middle, high = np.quantile(from_interval(entry, z, positive=True), (0.025, 0.5, 0.975))
    assert (low, middle, high) == pytest.approx((0.66, 0.7, 0.82), rel=0.01)
    below = replace(entry, low=None, high=None)
    assert from_interval(below, z, positive=True).min() > 0


def test_the_roll_gradient_of_the_drive_stands_in_for_a_missing_one() -> None:
    known = verdict(PLANE)
    del known["roll_gradient_degpg"]
    found = assess_rollover(known, vehicle(PLANE), log_of(ride(PLANE, slalom(0.6, hertz=0.2)), forces=False))
    told = next(a for a in found.assumptions if "roll gradient" in a.name and "line" in a.source)
    assert float(told.value.split()[0]) == pytest.approx(PLANE.gradient_degpg, rel=0.08)
    bare = assess_rollover(known, vehicle(PLANE), drive({"accel_y": np.zeros(1000)}))
    assert any("no roll gradient" in a.source for a in bare.assumptions)
    assert any("usual vehicle" in note for note in bare.notes)
    assert bare.threshold_g is not None
    assert found.threshold_g is not None
    assert bare.threshold_g.std is not None
    assert found.threshold_g.std is not None
    assert bare.threshold_g.std > 1.3 * found.threshold_g.std


def test_what_is_missing_is_said() -> None:
    log = log_of(ride(PLANE, slalom(0.5)), forces=False)
    none = ParameterEstimate("cg_height_m", None, None, None, None, "not_identifiable", "")
    found = assess_rollover({"cg_height_m": none}, Vehicle(quantities=TRACKS), log)
    assert found.static_stability_factor is None
    assert found.peak_rollover_coefficient is None
    assert found.turns == ()
    assert found.peak_lateral_acceleration_g is not None
    assert "CG height is not known" in found.notes[0]
    assert found.exceedance is not None
    assert found.exceedance.probability is None
    assert found.exceedance.text == "not known: the CG height is not known"
    assert found.lift_source.startswith("not known")
    found = assess_rollover({"cg_height_m": HEIGHT}, Vehicle(), drive({"speed": np.ones(500)}))
    assert "no track width" in found.notes[0]
    assert found.peak_lateral_acceleration_g is None
    assert "no peak" in found.notes[-1]
    found = assess_rollover(
        {"cg_height_m": HEIGHT}, Vehicle(quantities=TRACKS), drive({"speed": np.ones(500)})
    )
    assert found.static_stability_factor is not None
    assert found.exceedance is not None
    assert "no usable lateral acceleration" in found.exceedance.text


def test_a_height_of_other_vehicles_is_no_result() -> None:
    guess = replace(HEIGHT, status="not_identifiable", std=0.06, low=0.54, high=0.78)
    log = log_of(ride(PLANE, slalom(0.5)), forces=False)
    found = assess_rollover(verdict(PLANE, cg_height_m=guess), vehicle(PLANE), log)
    assert found.static_stability_factor is not None
    assert found.static_stability_factor.status == "not_identifiable"
    assert {turn.least_margin_g.status for turn in found.turns} == {"not_identifiable"}
    assert found.exceedance is not None
    assert "vehicles like this one" in found.exceedance.assumptions[0]


def test_draws_are_the_same_every_time_and_possible() -> None:
    first, second = (draw_body(verdict(PLANE, 0.05), vehicle(PLANE)) for _ in range(2))
    assert isinstance(first, Body)
    assert isinstance(second, Body)
    assert np.array_equal(first.height, second.height)
    for name in ("height", "track", "lever", "gradient", "inertia"):
        values = getattr(first, name)
        assert np.isfinite(values).all()
        assert values.min() > 0, name
    nominal = first.nominal()
    assert nominal.height.shape == (1,)
    assert nominal.inertia[0] == pytest.approx(PLANE.inertia / PLANE.mass + 0.0255, abs=0.03)


def test_an_hour_is_assessed() -> None:
    rng = np.random.default_rng(1)
    lateral = np.convolve(rng.standard_normal(360_000), np.ones(200) / 200, mode="same") * 20
    log = drive({"accel_y": lateral, "roll_rate": np.gradient(lateral) * 0.1})
    found = assess_rollover(verdict(PLANE), vehicle(PLANE), log)
    assert found.turns
    assert all(len(trace.time_s) < 1600 for trace in found.traces)
