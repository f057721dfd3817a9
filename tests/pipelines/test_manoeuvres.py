"""Every manoeuvre, for any seed and options: shapes, beginnings and ends, durations, repeatability."""

from __future__ import annotations

import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import pipelines.simulation.manoeuvres.registry as registry
from parsers.errors import SettingsError
from pipelines.simulation.manoeuvres.base import Options, Scenario, VehicleFigures, figures_of
from pipelines.simulation.manoeuvres.registry import MANOEUVRES, make_scenario, title_of
from pipelines.simulation.plant.vehicle import PRESETS

NAMES = sorted(MANOEUVRES)
ROLLING = {"truck_flat", "truck_slope"}
SUV = VehicleFigures()
TWO_TURNS = 4 * np.pi


def made(name, options=None, seed=1, vehicle=SUV):
    return make_scenario(name, vehicle, options or Options(), np.random.default_rng(seed))


def planned_distance(scenario):
    """Over-estimate of the way: the demand's speeds, the last one going on where both feet are off."""
    speed = scenario.demand.target_speed_mps
    known = np.flatnonzero(np.isfinite(speed))
    return np.interp(np.arange(len(speed)), known, speed[known]).sum() * scenario.demand.step_s


def check(scenario: Scenario, name: str) -> None:
    """What holds for every scenario."""
    demand, road = scenario.demand, scenario.road
    assert scenario.name == name
    assert scenario.title
    columns = [v for v in vars(demand).values() if isinstance(v, np.ndarray)]
    assert len(columns) == 4
    assert {c.shape for c in columns} == {columns[0].shape}
    for key, column in vars(demand).items():
        if isinstance(column, np.ndarray):
            assert np.isfinite(column).all() or key == "target_speed_mps", key
    assert not np.isinf(demand.target_speed_mps).any()
    assert np.nanmin(demand.target_speed_mps) >= 0
    assert demand.brake_pressure_pa.min() >= 0
    surfaces = [v for v in vars(road).values() if isinstance(v, np.ndarray)]
    assert len(surfaces) == 7
    assert {c.shape for c in surfaces} == {surfaces[0].shape}
    assert all(np.isfinite(c).all() for c in surfaces)
    assert road.left_m[0] == road.right_m[0] == road.grade_rad[0] == 0
    assert abs(road.curvature_1pm[0]) < 1e-8
    assert 0.04 < road.friction_left.min() <= road.friction_left.max() < 1.6
    assert np.abs(road.grade_rad).max() < 0.25
    assert np.abs(road.bank_rad).max() < 0.15
    # the road is not at its end before the drive is
    assert road.step_m * (len(road.left_m) - 1) > planned_distance(scenario) - 1
    first, last = demand.target_speed_mps[0], demand.target_speed_mps[-1]
    if name in ROLLING:
        assert first > 0
    else:
        assert first == 0
        assert last < 1e-9
        seconds = np.flatnonzero(demand.target_speed_mps > 1e-6)[0] * demand.step_s
        assert 2.8 < seconds < 5.5
        assert demand.brake_pressure_pa[:280].max() == 0
    assert demand.steering_wheel_angle_rad[0] == 0


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("preset", ["suv", "sedan", "van", "truck", "off_road"])
def test_every_manoeuvre_builds_for_every_vehicle(name, preset):
    scenario = made(name, vehicle=figures_of(PRESETS[preset]))
    check(scenario, name)
    assert np.abs(scenario.demand.steering_wheel_angle_rad).max() < TWO_TURNS


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(
    st.sampled_from(NAMES),
    st.integers(0, 2**32),
    st.builds(
        Options,
        speed_mps=st.none() | st.floats(3.0, 40.0),
        severity=st.floats(0.2, 1.5),
        duration_s=st.none() | st.floats(5.0, 200.0),
        friction=st.none() | st.floats(0.2, 1.0),
        direction=st.sampled_from(["left", "right", "both"]),
        surface=st.none() | st.sampled_from("ABCDEF"),
    ),
)
def test_any_options_and_seed(name, seed, options):
    scenario = made(name, options, seed)
    check(scenario, name)
    assert np.abs(scenario.demand.steering_wheel_angle_rad).max() < TWO_TURNS


@pytest.mark.parametrize("name", NAMES)
def test_the_same_seed_gives_the_same_drive(name):
    first, second = made(name, seed=4), made(name, seed=4)
    for a, b in ((first.demand, second.demand), (first.road, second.road)):
        for key, value in vars(a).items():
            assert np.array_equal(value, getattr(b, key), equal_nan=True), key


def test_seeds_give_different_roads():
    drives = [made("public_road", seed=k) for k in range(8)]
    for a, b in pairwise(drives):
        assert not np.array_equal(a.demand.target_speed_mps, b.demand.target_speed_mps)
        assert len(a.road.left_m) != len(b.road.left_m) or not np.array_equal(a.road.left_m, b.road.left_m)


@pytest.mark.parametrize("name", ["public_road", "urban", "rural", "hills"])
@pytest.mark.parametrize("seconds", [45.0, 300.0, 900.0])
def test_public_roads_last_as_long_as_asked(name, seconds):
    scenario = made(name, Options(duration_s=seconds))
    assert scenario.demand.duration_s == pytest.approx(seconds, abs=0.011)
    assert np.all(scenario.demand.target_speed_mps[-150:] < 1e-6)


@pytest.mark.parametrize("name", sorted(set(NAMES) - ROLLING))
def test_a_longer_run_repeats_and_rests_to_the_end(name):
    one = made(name, Options(duration_s=5.0)) if name != "handling_track" else made(name)
    seconds = one.demand.duration_s * 2.6
    longer = made(name, Options(duration_s=seconds))
    assert longer.demand.duration_s == pytest.approx(seconds, abs=0.02)
    assert np.isfinite(longer.demand.target_speed_mps[-1])


def test_the_public_road_has_all_its_parts():
    """Over a few seeds: standstills, town and motorway speeds, hard and soft stops, both sides, up and down."""
    for seed in range(6):
        scenario = made("public_road", seed=seed)
        speed, road = scenario.demand.target_speed_mps, scenario.road
        still = speed < 1e-3
        assert np.count_nonzero(np.diff(still.astype(int)) == 1) >= 4
        assert 80 / 3.6 < speed.max() < 125 / 3.6
        accel = np.diff(speed) / 0.01
        assert accel.min() < -3.3
        assert accel.max() < 2.6
        place = np.cumsum(speed) * 0.01
        lateral = np.interp(place, road.step_m * np.arange(len(road.left_m)), road.curvature_1pm) * speed**2
        assert lateral.max() > 1.0
        assert lateral.min() < -1.0
        assert np.abs(lateral).max() < 0.5 * 9.81
        assert road.grade_rad.max() > 0.03
        assert road.grade_rad.min() < -0.03
        assert 0.001 < road.left_m.std() < 0.03


def test_names_and_titles():
    for name in NAMES:
        assert 10 < len(title_of(name)) < 120
        assert not title_of(name).endswith(".")
    with pytest.raises(SettingsError, match="did you mean 'sine_with_dwell'"):
        made("sine_with_dwel")
    with pytest.raises(SettingsError, match=r"known are .*slalom"):
        made("nope")  # like none of them


def test_every_manoeuvre_is_documented():
    page = (Path(__file__).resolve().parents[2] / "docs" / "simulation.md").read_text(encoding="utf-8")
    table = [line for line in page.splitlines() if line.startswith("| `")]
    assert {name for name in NAMES if not any(f"`{name}`" in line for line in table)} == set()


@pytest.mark.parametrize(
    "wrong",
    [
        {"speed_mps": 0.0},
        {"severity": -1.0},
        {"duration_s": 1.0},
        {"friction": 0.0},
        {"friction": float("nan")},
        {"direction": "up"},
        {"surface": "Z"},
    ],
)
def test_options_that_cannot_be_are_named(wrong):
    with pytest.raises(ValueError, match=next(iter(wrong))):
        Options(**wrong)


MODULE = '''
from pipelines.simulation.manoeuvres.base import Scenario
from pipelines.simulation.manoeuvres.script import Script, fitted, proving_ground


def pull_away(vehicle, options, rng):
    """Pull away once, to 30 km/h."""

    def write(repeats):
        script = Script(vehicle, options.grip(0.9))
        script.rest(4.0)
        for _ in range(repeats):
            script.reach(options.speed(30 / 3.6), 2.0 * options.severity)
            script.hold(3.0)
            script.reach(0.0, 2.0)
            script.rest(4.0)
        return script

    script = fitted(write, options, repeats=1)
    road = proving_ground(script.distance_m, 0.9, options, vehicle, rng)
    return Scenario("pull_away", "Pull away", "", script.demand(), road)
'''


def test_a_manoeuvre_is_one_file_and_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "pull_away.py").write_text(MODULE, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(registry, "MANOEUVRES", {**MANOEUVRES, "pull_away": "pull_away:pull_away"})
    assert title_of("pull_away") == "Pull away once, to 30 km/h"
    scenario = made("pull_away", Options(speed_mps=6.0, duration_s=60.0))
    check(scenario, "pull_away")
    assert scenario.demand.target_speed_mps.max() == pytest.approx(6.0)
    assert scenario.demand.duration_s == pytest.approx(60.0)
    sys.modules.pop("pull_away", None)


def test_a_mixed_minute_at_a_walking_pace_stays_within_the_lock() -> None:
    scenario = made("mixed_minute", Options(speed_mps=3.0))
    assert np.abs(scenario.demand.steering_wheel_angle_rad).max() <= 9.0
