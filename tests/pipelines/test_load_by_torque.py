"""A load that comes at a stop of a log in which nothing but torques shows it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import polars as pl
import pytest
from typer.testing import CliRunner

from cogest_cli.main import app
from parsers.drive import Drive, ImportRecord, Signal
from parsers.load import LoadOptions, load_drive
from pipelines.prepare.load_by_torque import changes_by_torque
from pipelines.prepare.load_change import LoadStep
from pipelines.prepare.load_step import load_step, with_load_step
from pipelines.results import ParameterEstimate
from pipelines.vehicles.vehicle import Quantity, Vehicle
from pipelines.verdict.two_loads import holding_both_loads

HZ, G, MASS, RADIUS = 20.0, 9.80665, 1600.0, 0.31
CAR = Vehicle(quantities={"wheel_radius_m": Quantity(RADIUS, 0.003, "vehicle file")})


def _driven(
    masses: tuple[float, ...],
    *,
    seed: int = 1,
    leg_s: float = 50.0,
    brakes: str | None = "brake_torque",
    engine_by_leg: tuple[float, ...] = (),
    brake_by_leg: tuple[float, ...] = (),
    rests: bool = True,
) -> Drive:
    """Legs between stops of 8 s, each with a mass of its own, on hills, with another wind in each. *_by_leg: what the torque is told too large by."""
    rng = np.random.default_rng(seed)
    n = int(leg_s * HZ)
    t = np.arange(n) / HZ
    rows: dict[str, list[np.ndarray]] = {
        k: [] for k in ("speed", "accel_x", "accel_y", "drive_torque", "brake_torque")
    }
    for leg, mass in enumerate(masses):
        moving = (t > 8) | (not rests)
        phase = rng.uniform(0, 6, 3)
        pedal = 1.3 * np.sin(0.5 * t + phase[0]) + 0.9 * np.sin(1.1 * t + phase[1])
        speed = np.where(moving, 13 + np.cumsum(pedal - pedal.mean()) / HZ, 0.0)
        change = np.where(moving, np.gradient(speed) * HZ, 0.0)
        change[np.abs(change) > 4] = 0.0
        felt = change + np.where(moving, G * 0.04 * np.sin(0.06 * t + phase[2]), 0.0)
        wind = rng.uniform(-5, 5)
        pull = RADIUS * (mass * (felt + 0.012 * G) + 0.5 * 1.2 * 0.7 * (speed + wind) ** 2)
        engine = np.where(moving, np.maximum(pull, 0.0), 0.0)
        braked = np.where(moving, np.maximum(-pull, 0.0), 0.0)
        rows["speed"].append(speed)
        rows["accel_x"].append(felt + 0.12 + 0.15 * rng.standard_normal(n))
        rows["accel_y"].append(0.8 * np.sin(0.2 * t) + 0.1 * rng.standard_normal(n))
        rows["drive_torque"].append(1.05 * engine * (engine_by_leg[leg] if engine_by_leg else 1.0))
        rows["brake_torque"].append(0.94 * braked * (brake_by_leg[leg] if brake_by_leg else 1.0))
    columns = {name: np.concatenate(parts) for name, parts in rows.items()}
    braking = columns.pop("brake_torque")
    if brakes == "brake_pressure":
        columns[brakes] = braking / 350e-6
    elif brakes:
        columns[brakes] = braking
    count = len(columns["speed"])
    stamps = (np.arange(count) / HZ * 1e9).astype(np.int64)
    record = ImportRecord("csv", (Path("a.csv"),), "", "complete", count, {}, (), "t", None, count / HZ, ())
    return Drive({k: Signal(k, stamps, v, k) for k, v in columns.items()}, record)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize("brakes", ["brake_torque", "brake_pressure", None])
def test_a_load_that_comes_at_a_stop_is_found_and_sized(brakes: str | None, seed: int) -> None:
    drive = _driven((MASS, MASS, MASS + 250, MASS + 250), seed=seed, brakes=brakes)
    (step,) = changes_by_torque(drive, CAR)
    assert step.change_kg == pytest.approx(250, abs=2 * step.std_kg)
    assert step.std_kg < 60
    assert step.after_s < 100.5 < 107 < step.before_s + 1
    assert (step.rear, step.left) == (None, None)
    said = with_load_step(drive, load_step(drive, CAR)).record.decisions
    assert [d.kind for d in said] == ["load"]
    assert "more at" not in said[0].found
    assert "torque" in said[0].evidence


def test_who_rides_along_for_a_part_of_the_drive() -> None:
    came, went = changes_by_torque(_driven((MASS, MASS, MASS + 320, MASS + 320, MASS, MASS)), CAR)
    assert (came.change_kg > 0, went.change_kg < 0) == (True, True)
    largest = load_step(_driven((MASS, MASS, MASS + 320, MASS + 320, MASS, MASS)), CAR)
    assert largest is not None
    assert largest.most_kg == pytest.approx(320, rel=0.2)


@pytest.mark.parametrize("seed", range(6))
def test_hills_wind_and_scales_are_no_load(seed: int) -> None:
    assert changes_by_torque(_driven((MASS,) * 5, seed=seed), CAR) == ()


def test_one_torque_that_changes_is_no_load() -> None:
    four = (MASS,) * 4
    assert changes_by_torque(_driven(four, brake_by_leg=(1, 1, 0.75, 0.75)), CAR) == ()
    assert changes_by_torque(_driven(four, engine_by_leg=(0.8, 0.8, 1, 1)), CAR) == ()


def test_without_stops_or_a_drive_torque_nothing_is_said() -> None:
    assert changes_by_torque(_driven((MASS, MASS, MASS + 400, MASS + 400), rests=False), CAR) == ()
    drive = _driven((MASS, MASS, MASS + 400, MASS + 400))
    without = {n: s for n, s in drive.signals.items() if n != "drive_torque"}
    assert changes_by_torque(Drive(without, drive.record), CAR) == ()
    assert changes_by_torque(Drive({}, drive.record), CAR) == ()


def test_where_it_lies_is_open() -> None:
    """What nobody measured may lie above either axle: the spreads hold both."""
    sound = {
        "mass_kg": 1700.0,
        "cg_to_front_axle_m": 1.2,
        "corner_mass_fl_kg": 440.0,
        "corner_mass_rl_kg": 410.0,
    }
    verdict = {
        name: ParameterEstimate(name, value, 1e-3 * value, 0.99 * value, 1.01 * value, "identified", "")
        for name, value in sound.items()
    }
    vehicle = Vehicle(quantities={"wheelbase_m": Quantity(2.7, 0.003, "vehicle file")})
    step = LoadStep(100.0, 108.0, 240.0, 30.0, None, None, "drive and brake torques")
    told = holding_both_loads(verdict, step, vehicle)
    assert all(entry.status != "identified" for entry in told.values())
    stds = {name: entry.std or 0.0 for name, entry in told.items()}
    assert stds["mass_kg"] == pytest.approx(120, rel=0.01)
    assert stds["cg_to_front_axle_m"] == pytest.approx(240 / 3400 * 1.5, rel=0.01)
    assert min(stds["corner_mass_fl_kg"], stds["corner_mass_rl_kg"]) >= 119


@pytest.mark.parametrize("load", [("--load", "rear:300"), ()])
def test_two_drives_of_the_rich_plant_in_one_log(load: tuple[str, ...], tmp_path: Path) -> None:
    """Urban legs of an empty vehicle, and then of one that is loaded, or is not."""
    parts = []
    for name, more in (("a", ()), ("b", load)):
        out = tmp_path / f"{name}.csv"
        options = ("--sensors", "ins", "--rate", "50", "--duration", "150", "--out", str(out))
        done = CliRunner().invoke(app, ["simulate", "urban", *options, *more])
        assert done.exit_code == 0, done.output
        parts.append(pl.read_csv(out))
    time = parts[0].columns[0]
    later = parts[1].with_columns(pl.col(time) + parts[0][time][-1] + 0.02)
    pl.concat([parts[0], later]).write_csv(tmp_path / "both.csv")
    drive = load_drive((tmp_path / "both.csv",), LoadOptions())
    step = load_step(drive, Vehicle())
    if not load:
        assert step is None
    else:
        assert step is not None
        assert step.change_kg == pytest.approx(300, abs=2.5 * step.std_kg)
        assert step.after_s < 150 < step.before_s
        assert "between" in step.found
