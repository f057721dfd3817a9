"""Strut forces as evidence: lifting links, an accelerometer that is askew, and rolling wheels in the relations' predictions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipelines.estimators.load_transfer.answers import Standing
from pipelines.estimators.load_transfer.batch import ALONG, BRAKING, STATIC, fit
from pipelines.estimators.load_transfer.data import LEANING, OFFSET_STD, StrutData, known_of
from pipelines.estimators.load_transfer.evidence import evidence
from pipelines.evidence import Evidence
from pipelines.joint.vehicle.unknowns import before_the_log
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Quantity, Vehicle

G = 9.80665
SPRUNG, LENGTH, TRACK, BEHIND, HEIGHT = 1500.0, 2.8, 1.6, 1.3, 0.5
WEIGHT = 0.4
"""Of the wheels' motion against the sensor's own prior, in taking its offset off."""


def vehicle() -> Vehicle:
    figures = {
        "mass_kg": (1650.0, 16.0), "wheelbase_m": (LENGTH, 0.005), "track_front_m": (TRACK, 0.005),
        "track_rear_m": (TRACK, 0.005), "unsprung_mass_front_kg": (80.0, 2.0), "unsprung_mass_rear_kg": (70.0, 2.0),
        "wheel_radius_m": (0.33, 0.002), "cg_to_front_axle_m": (1.32, 0.01), "rolling_resistance": (0.012, 0.001),
    }  # fmt: skip
    return Vehicle("test", "SUV", {k: Quantity(v, s, "test") for k, (v, s) in figures.items()})


def struts(lift: float) -> StrutData:
    """A drive with brakes, launches and bends. lift: what the links lift of the body in braking over its mass, at its CG."""
    rng = np.random.default_rng(4)
    n = 6000
    time_s = np.arange(n) / 50.0
    along, across = 2 * np.sin(0.9 * time_s) + 0.3, 3 * np.sin(0.63 * time_s)
    braking = (along < -0.7).astype(float)
    share = BEHIND / LENGTH
    axles = np.array([1 - share, 1 - share, share, share])
    moved = HEIGHT * SPRUNG * along / (2 * LENGTH)
    rolled = 0.4 * SPRUNG * across / (2 * TRACK)
    forces = 0.5 * SPRUNG * G * axles + np.outer(moved, [-1, -1, 1, 1]) + np.outer(rolled, [-1, 1, -1, 1])
    forces = forces + np.outer(lift * SPRUNG * along * braking, 0.5 * axles)
    forces = forces + rng.normal(0, 5.0, (n, 4))
    zero = np.zeros(n)
    left = tuple(np.sqrt(1 - WEIGHT) * LEANING * OFFSET_STD[axis] for axis in "xy")
    starts = zero.copy()
    starts[0] = 1.0
    return StrutData(
        time_s, 50.0, forces, np.full((n, 4), G), np.full(n, G), along, across, (left[0], left[1]), 0.01 * across,
        -0.006 * along, np.full(n, 15.0), zero, zero, zero, braking, starts, np.arange(n), n, True, (),
    )  # fmt: skip


def relations_of(data: StrutData) -> dict[str, Evidence]:
    found = fit(data)
    known = known_of(vehicle())
    assert known is not None
    standing = Standing(found.coefficients[STATIC], np.eye(4), (0.0, 0.004), (0.0, 0.008))
    return {e.kind: e for e in evidence(found, data, known, standing, True)}


def predicted(entry: Evidence, **changes: float) -> FloatArray:
    prior = before_the_log(vehicle())
    values = prior.at(np.zeros(len(prior.names))) | {o.name: o.mean for o in entry.own}
    return entry.predict(values | {name: values[name] + change for name, change in changes.items()})


def test_what_links_lift_at_the_cg_has_no_pitch_moment() -> None:
    for lift in (0.0, 0.05, -0.05):
        pitch = relations_of(struts(lift))["pitch"]
        # at rest, braking, driving
        assert pitch.observed[0] == pytest.approx(SPRUNG * G * (BEHIND - LENGTH / 2), rel=0.01)
        np.testing.assert_allclose(pitch.observed[1:], SPRUNG * HEIGHT, rtol=0.01)


def test_the_lift_would_have_one_about_the_middle_of_the_wheelbase() -> None:
    found = fit(struts(0.05))
    middle = 0.5 * LENGTH * np.array([-1.0, -1.0, 1.0, 1.0])
    seen = float(middle @ (found.coefficients[ALONG] + found.coefficients[BRAKING]))
    assert abs(seen / (SPRUNG * HEIGHT) - 1) > 0.008


@pytest.mark.parametrize(("kind", "tilt"), [("pitch", "askew_pitch"), ("roll", "askew_roll")])
def test_a_tilted_accelerometer_moves_the_static_moment_as_in_the_other_balances(
    kind: str, tilt: str
) -> None:
    entry = relations_of(struts(0.0))[kind]
    assert tilt in entry.unknowns
    change = predicted(entry, **{tilt: 0.01}) - predicted(entry)
    # what is left of 0.01 rad of gravity after the wheels' motion had its weight, times the moment a m/s²
    assert change[0] == pytest.approx(0.01 * G * (1 - WEIGHT) * entry.observed[-1], rel=1e-3)
    # what it does to the diagonals is as small as what bends move from one to the other
    np.testing.assert_allclose(change[1:], 0.0, atol=1e-3 * abs(change[0]))


def test_the_offset_is_one_unknown_for_both_carriers_and_only_the_road_is_noise() -> None:
    def told(weight: float) -> dict[str, Evidence]:
        left = tuple(np.sqrt(1 - weight) * LEANING * OFFSET_STD[axis] for axis in "xy")
        return relations_of(replace(struts(0.0), offset_std=(left[0], left[1])))

    few, many = told(0.1), told(0.5)
    for kind, offset, arm in (("pitch", "offset_x", HEIGHT), ("roll", "offset_y", 0.4)):
        assert offset in many[kind].unknowns
        noise = many[kind].covariance[0, 0] - few[kind].covariance[0, 0]
        road = (0.5 * 0.5 - 0.1 * 0.9) * (LEANING * OFFSET_STD[offset[-1]] * SPRUNG * arm) ** 2
        assert noise == pytest.approx(road, rel=0.05)


def test_rolling_wheels_load_the_rear_struts() -> None:
    entry = relations_of(struts(0.0))["pitch"]
    change = predicted(entry, rolling=0.01) - predicted(entry)
    prior = before_the_log(vehicle())
    values = prior.at(np.zeros(len(prior.names)))
    mass = values["empty_mass"] + values["load"]
    assert change[0] == pytest.approx(mass * G * 0.01 * values["rolling_shift"] * values["radius"], rel=1e-6)


def test_without_an_accelerometer_nothing_is_shared() -> None:
    told = relations_of(replace(struts(0.0), offset_std=(0.5, 0.5)))
    assert set(told) == {"vertical", "pitch", "roll"}
    shared = {"offset_x", "offset_y", "askew_roll", "askew_pitch"}
    assert not any(shared & set(e.unknowns) for e in told.values())


def test_what_one_diagonal_carries_more_is_told_by_the_struts() -> None:
    data = struts(0.0)
    level = relations_of(data)["roll"]
    assert abs(level.observed[1]) < 5.0
    twisted = relations_of(replace(data, forces=data.forces + 10 * G * np.array([1.0, -1.0, -1.0, 1.0])))[
        "roll"
    ]
    assert twisted.observed[1] - level.observed[1] == pytest.approx(40 * G, rel=1e-4)
    np.testing.assert_allclose(np.delete(twisted.observed - level.observed, 1), 0.0, atol=0.05)
    # the same 10 kg a wheel as an unknown of the vehicle
    change = predicted(level, cross=10.0) - predicted(level)
    np.testing.assert_allclose(change, [0.0, 40 * G, 0.0], atol=1e-6)
    one = predicted(level, suspension_zero_fl=-30.0) - predicted(level)
    assert one[1] == pytest.approx(30.0)
