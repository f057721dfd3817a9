"""The calibration study's own book-keeping: it must tell honest intervals from others before it judges a verdict."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.calibration_drives import (
    CAR_PAYLOAD,
    DRIVER_KG,
    LOADS,
    PAYLOAD,
    Plan,
    kept_drive,
    level_reading,
    median_plan,
    plan_loads,
    plan_vehicle,
    random_plan,
)
from benchmarks.calibration_tables import (
    Record,
    answers_of,
    coverage_table,
    far_table,
    medians_table,
    methods_table,
    narrower,
    save_reliability,
)
from benchmarks.vehicle_data import levelled
from benchmarks.wrong_figures import drawn_wrong, with_wrong
from pipelines.joint.doubts.stated_figures import OFTEN_WRONG
from pipelines.joint.doubts.weighed import WIDER
from pipelines.joint.file_check import STATED
from pipelines.simulation.sensors.errors import Drawn
from pipelines.simulation.sensors.truth import Mount
from pipelines.simulation.sensors.units import SensorLog
from pipelines.vehicles.vehicle import Quantity, Vehicle

NONE = Drawn(0.0, 0.0, 0.0)

TRUTH = {"cg_height_m": 0.65, "mass_kg": 1800.0, "cg_lateral_offset_m": 0.01}
SIZES = {"cg_lateral_offset_m": 1.6}


def records(factor: float, count: int = 400) -> list[Record]:
    """Drives whose errors are `factor` times what their intervals say, and a method with twice the verdict's error."""
    rng = np.random.default_rng(3)
    found = []
    for seed in range(count):
        verdict: dict[str, list[object]] = {}
        method: dict[str, list[object]] = {}
        for name, true in TRUTH.items():
            std = 0.01 * SIZES.get(name, true)
            draw = rng.standard_normal()
            for kind, size in ((verdict, 1.0), (method, 2.0)):
                value = true + factor * size * std * draw
                kind[name] = [value, std, value - 1.96 * std, value + 1.96 * std, "identified", 3 * std]
        plan = {"seed": seed, "sensors": "deflection"}
        answers = {"verdict": verdict, "other": method}
        found.append(
            {"plan": plan, "text": f"seed {seed}", "truth": TRUTH, "sizes": SIZES, "answers": answers}
        )
    return found


def cells(table: str, name: str) -> list[str]:
    """The cells of a parameter's first line."""
    line = next(line for line in table.splitlines() if line.startswith(f"| {name} |"))
    return [cell.strip() for cell in line.strip("|").split("|")]


def test_honest_intervals_are_called_honest_and_others_not() -> None:
    honest = coverage_table(answers_of(records(1.0)))
    for name in TRUTH:
        assert "*" not in "".join(cells(honest, name))
        shares = [float(cell) for cell in cells(honest, name)[5:8]]
        np.testing.assert_allclose(shares, [0.50, 0.80, 0.95], atol=0.05)
    sure, timid = (coverage_table(answers_of(records(factor))) for factor in (1.8, 0.5))
    assert all("*" in cell for cell in cells(sure, "mass_kg")[5:8])
    assert all("*" in cell for cell in cells(timid, "mass_kg")[5:7])


def test_what_is_confidently_wrong_is_named() -> None:
    some = records(1.0)
    some[7]["answers"]["verdict"]["mass_kg"][0] = 1800 + 5.5 * 18
    table = far_table(some)
    assert table.count("\n") == 2
    assert "seed 7" in table
    assert "+5.5" in table
    assert cells(coverage_table(answers_of(some)), "mass_kg")[-1] == "1"


def test_medians_are_in_the_issues_units() -> None:
    table = medians_table(records(1.0))
    height, lateral = cells(table, "cg_height_m"), cells(table, "cg_lateral_offset_m")
    assert float(height[2].split()[0]) == pytest.approx(0.674, abs=0.06)
    assert float(height[5].split()[0]) == pytest.approx(1.96, abs=0.01)
    assert lateral[2].endswith("mm")
    assert float(lateral[2].split()[0]) == pytest.approx(10.8, abs=1.0)


def test_a_method_with_twice_the_error_loses() -> None:
    table = methods_table(records(1.0))
    assert cells(table, "mass_kg")[5] == "0.50"
    assert "worse" not in table
    swapped = [
        {**r, "answers": {"verdict": r["answers"]["other"], "other": r["answers"]["verdict"]}}
        for r in records(1.0)
    ]
    assert cells(methods_table(swapped), "mass_kg")[-1] == "worse"
    assert narrower(records(1.0)) == ([], 1200)


def test_answers_are_judged_by_the_intervals_that_they_tell() -> None:
    """Half as wide inside as their spread says: 50 % of the truths lie in a 0.34 spread."""
    some = records(1.0)
    for record in some:
        entry = record["answers"]["verdict"]["mass_kg"]
        value, std = entry[0], entry[1]
        record["answers"]["verdict"]["mass_kg"] = [
            *entry, [value - 0.337 * std, value + 0.337 * std], [value - 0.64 * std, value + 0.64 * std],
        ]  # fmt: skip
    answers = [a for a in answers_of(some) if a.name == "mass_kg"]
    plain = [a for a in answers_of(records(1.0)) if a.name == "mass_kg"]
    near = [abs(a.z) < 0.337 for a in plain]
    assert [a.inside(0.5) for a in answers] == near
    assert [a.score < 0.6745 for a in answers] == near
    assert [a.score < 1.95996 for a in answers] == [a.inside(0.95) for a in answers]
    assert max(abs(a.score - abs(a.z)) for a in plain) == 0


def test_the_diagram_is_a_small_picture(tmp_path: Path) -> None:
    save_reliability(answers_of(records(1.0)), tmp_path / "reliability.png")
    assert (tmp_path / "reliability.png").read_bytes()[:4] == b"\x89PNG"
    assert (tmp_path / "reliability.png").stat().st_size < 80_000


def test_a_drive_is_simulated_once_and_comes_back_as_it_was(tmp_path: Path) -> None:
    plan = Plan(3, "step_steer", "imu", "seats", 150.0, 0.5)
    first, again = (kept_drive(plan, tmp_path, "today") for _ in range(2))
    assert len(list(tmp_path.glob("*.npz"))) == 1
    assert first.drive is not None
    assert again.drive is not None
    assert set(again.drive.signals) >= {"accel_y", "roll_rate", "speed"}
    assert all(
        np.array_equal(s.values, again.drive.signals[n].values) for n, s in first.drive.signals.items()
    )
    assert kept_drive(plan, tmp_path, "tomorrow").old
    vehicle = again.vehicle()
    assert vehicle.reference["mass_kg"] == pytest.approx(again.truth["mass_kg"])
    assert not vehicle.load_stated
    weighed = again.vehicle(0.003).quantities["mass_kg"]
    assert weighed.std == pytest.approx(0.003 * weighed.value)


def test_plans_repeat_and_loads_lie_on_either_side() -> None:
    plans = [random_plan(seed) for seed in range(300)]
    assert plans == [random_plan(seed) for seed in range(300)]
    assert {p.sensors for p in plans} == {"deflection", "production", "ins", "axle_load", "struts", "imu"}
    assert {p.load for p in plans} == {"none", "driver", "roof", "rear", "side", "seats", "full", "tail"}
    assert all(1 <= p.minutes <= 12 for p in plans)
    left, right = (
        Plan(1, "weave", "ins", "side", 120.0, 2.0),
        Plan(1, "weave", "ins", "side", 120.0, 2.0, mirrored=True),
    )
    vehicle = plan_vehicle(left)
    assert [load.left_m for load in plan_loads(left, vehicle)] == [
        -load.left_m for load in plan_loads(right, vehicle)
    ]
    assert plan_loads(Plan(1, "weave", "ins", "none", 0.0, 2.0), vehicle) == ()
    assert median_plan(4, "ins").minutes == 10.0


def test_loads_weigh_what_was_planned_and_no_more_than_a_vehicle_may_carry() -> None:
    for seed in range(24):
        vehicle = plan_vehicle(Plan(seed, "weave", "ins", "none", 0.0, 2.0))
        for load in LOADS:
            plan = Plan(seed, "weave", "ins", load, 300.0, 2.0)
            most = PAYLOAD.get(vehicle.body, CAR_PAYLOAD) * vehicle.mass_kg
            carried = 0.0 if load in ("none", "driver") else min(300.0, most)
            driver = 0.0 if load == "none" else DRIVER_KG
            loads = plan_loads(plan, vehicle)
            assert sum(part.mass_kg for part in loads) == pytest.approx(driver + carried, abs=2.0)


def test_a_wrong_figure_is_off_by_as_much_as_is_doubted_and_the_drive_stays_the_same() -> None:
    seeds = range(3000)
    titles = [drawn_wrong(seed) for seed in seeds]
    assert set(titles) == {"", *STATED}
    assert titles.count("stated mass") / len(seeds) == pytest.approx(OFTEN_WRONG["stated mass"], abs=0.012)
    file = Vehicle(quantities={key: Quantity(100.0, 1.0, "test") for keys in STATED.values() for key in keys})
    for title, keys in STATED.items():
        made = [with_wrong(file, title, seed) for seed in range(400)]
        for key, stated in file.quantities.items():
            off = np.array([m.quantities[key].value - stated.value for m in made])
            assert all(m.quantities[key].std == stated.std for m in made)
            # with what a file is off by anyhow, WIDER spreads
            assert np.hypot(off.std(), 1.0) == pytest.approx(WIDER if key in keys else 1.0, rel=0.15)
    pairs = np.array(
        [
            [m.quantities[key].value for key in STATED["stated spring rates"]]
            for m in (with_wrong(file, "stated spring rates", seed) for seed in range(400))
        ]
    )
    assert np.mean(pairs[:, 0] == pairs[:, 1]) == pytest.approx(0.5, abs=0.1)
    assert with_wrong(Vehicle(), "stated mass", 1).quantities == {}
    plain = Plan(1, "weave", "ins", "none", 0.0, 2.0)
    assert plain.key == Plan(1, "weave", "ins", "none", 0.0, 2.0, wrong="stated mass").key


def test_a_units_reading_on_level_ground_is_its_mounting_and_offset() -> None:
    mount = Mount(1.4, 0.0, 0.5, misalignment_rad=(math.radians(1.0), math.radians(-0.5), 0.3))
    straight = level_reading(SensorLog((), {"accel_x": NONE, "accel_y": NONE}, {"imu": mount}))
    assert straight == pytest.approx({"imu_roll_deg": 1.0, "imu_pitch_deg": -0.5}, abs=1e-3)
    off = {"accel_x": NONE, "accel_y": replace(NONE, offset=0.1)}
    leaning = level_reading(SensorLog((), off, {"imu": mount}))
    assert leaning["imu_roll_deg"] == pytest.approx(1.0 + math.degrees(0.1 / 9.81), abs=1e-3)
    told = levelled(Vehicle(), leaning, np.random.default_rng(0), errors=0.0)
    assert told.sensors["imu_roll_deg"].value == leaning["imu_roll_deg"]
    assert level_reading(SensorLog((), {}, {})) == {}
