"""Circuits that lean into one direction all the way round, and yaw that a pitching body turns into its roll gyro."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from parsers.signals import WHEELS
from pipelines.estimators.load_balance.levelled import levelled
from pipelines.models.roll import GRAVITY
from pipelines.prepare.banked import banked_all_round, pressed_on
from pipelines.prepare.prepared import Prepared, Segment
from pipelines.prepare.roll_rate import off_pitch
from pipelines.results import FloatArray
from pipelines.vehicles.vehicle import Vehicle
from pipelines.vehicles.vehicle_file import parse_vehicle

N, HZ, RADIUS = 6000, 50.0, 90.0


def prepared(**columns: FloatArray) -> Prepared:
    n = len(next(iter(columns.values())))
    return Prepared(
        HZ, 5.0, np.arange(n) / HZ, columns, (Segment(0, n),), {}, frozenset(columns), np.zeros(n, dtype=bool)
    )


def circuit(bank: float, lean: float = 0.0, way: int = 1) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Speed times yaw rate, lateral and upright specific force of a body that leans outwards by `lean` rad a m/s² of the felt."""
    speed = 14 + 2 * np.sin(np.arange(N) / HZ / 9)
    curve = way * speed**2 / RADIUS
    angle = np.full(N, -way * bank)
    for _ in range(50):
        angle = -way * bank + lean * (curve * np.cos(angle) + GRAVITY * np.sin(angle))
    side = curve * np.cos(angle) + GRAVITY * np.sin(angle)
    return curve, side, GRAVITY * np.cos(angle) - curve * np.sin(angle)


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize(("bank", "lean", "told"), [(0.2, 0.01, True), (0.12, 0.0, True), (0.0, 0.02, False)])
def test_a_circuit_that_leans_all_round_is_told(bank: float, lean: float, told: bool, way: int) -> None:
    curve, side, up = circuit(bank, lean, way)
    assert banked_all_round(curve, side) is told
    assert pressed_on(curve, side) == pytest.approx(float(up.mean()), rel=1e-9)


def test_bends_to_both_sides_are_no_such_circuit() -> None:
    both = np.where(np.arange(N) % 800 < 400, 1, -1)
    curve, side, _ = circuit(0.2)
    assert not banked_all_round(both * curve, both * side)
    assert not banked_all_round(np.zeros(0), np.zeros(0))


@pytest.mark.parametrize("bank", [0.0, 0.2])
def test_the_upright_force_is_gravity_and_the_bends(bank: float) -> None:
    """An accelerometer's offset is taken out, and what presses the vehicle onto the circuit is left."""
    curve, side, up = circuit(bank)
    speed = np.sqrt(np.abs(curve) * RADIUS)
    drive = prepared(accel_y=side, accel_z=up + 0.15, yaw_rate=curve / speed)
    found = levelled(drive, (np.zeros(N), np.zeros(N)), speed)
    assert found == pytest.approx(up, abs=0.02)


@pytest.mark.parametrize("base", [2.7, 3.2])
def test_a_pitching_body_puts_no_yaw_into_its_roll(base: float) -> None:
    t = np.arange(N) / HZ
    roll, pitch, yaw = 0.04 * np.sin(0.8 * t), 0.02 * np.sin(np.pi * t / 6), 0.3 + 0.05 * np.sin(0.2 * t)
    change = np.gradient(roll, 1 / HZ)
    travel = {f"suspension_deflection_{w}": (0.5 if w[0] == "f" else -0.5) * base * pitch for w in WHEELS}
    read = change - yaw * np.sin(pitch)
    vehicle = (
        parse_vehicle(f"[vehicle]\nwheelbase_m = {base}\n", Path("car.toml")) if base != 2.7 else Vehicle()
    )
    drive = prepared(roll_rate=read, yaw_rate=yaw, **travel)
    assert off_pitch(drive, vehicle).columns["roll_rate"] == pytest.approx(change, abs=2e-4)
    # a standing pitch is a leak of the yaw rate that the fit knows; a hole leaves the gyro as it is there
    loaded = {n: v + (0.03 if n[-2] == "r" else 0.0) for n, v in travel.items()}
    loaded["suspension_deflection_fl"] = np.where(t > 100, np.nan, loaded["suspension_deflection_fl"])
    found = off_pitch(prepared(roll_rate=read, yaw_rate=yaw, **loaded), vehicle).columns["roll_rate"]
    assert found[t <= 100] == pytest.approx(change[t <= 100], abs=1e-3)
    assert found[t > 100] == pytest.approx(read[t > 100])


def test_without_deflections_of_all_wheels_the_gyro_is_left() -> None:
    drive = prepared(roll_rate=np.ones(N), yaw_rate=np.ones(N), suspension_deflection_fl=np.ones(N))
    assert off_pitch(drive, Vehicle()) is drive
    nothing = {f"suspension_deflection_{w}": np.full(N, np.nan) for w in WHEELS}
    empty = replace(drive, columns={**drive.columns, **nothing})
    assert off_pitch(empty, Vehicle()) is empty
