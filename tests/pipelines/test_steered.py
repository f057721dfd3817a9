"""Steering ratio times wheelbase by steering angle, yaw rate and speed: another vehicle's file is said, the own one is not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from parsers.drive import Drive, ImportRecord, Signal
from pipelines.limits import what_limits
from pipelines.prepare.steered import steered, steering_product
from pipelines.vehicles.vehicle import Quantity, Vehicle

HZ = 50.0


def _drive(
    product: float = 45.0, *, understeer: float = 0.003, bends: float = 1.0, off: float = 0.03
) -> Drive:
    """Three minutes of bends. understeer: rad at the wheels a m/s², times 16 at the steering wheel; off: its angle straight on."""
    rng = np.random.default_rng(3)
    t = np.arange(int(180 * HZ)) / HZ
    speed = 11 + 5 * np.sin(0.07 * t)
    yaw = bends * (0.15 * np.sin(0.3 * t) + 0.12 * np.sin(1.3 * t) * np.sin(0.11 * t))
    columns = {
        "speed": speed + 0.02 * rng.standard_normal(len(t)),
        "yaw_rate": yaw + 0.002 * rng.standard_normal(len(t)),
        "steering_wheel_angle": product * yaw / speed + 16 * understeer * speed * yaw + off,
    }
    stamps = (t * 1e9).astype(np.int64)
    record = ImportRecord("csv", (Path("a.csv"),), "", "complete", len(t), {}, (), "t", None, 180.0, ())
    return Drive({n: Signal(n, stamps, v, n) for n, v in columns.items()}, record)


def _file(ratio: float, length: float = 2.8, std: float = 0.01) -> Vehicle:
    return Vehicle(
        quantities={
            "steering_ratio": Quantity(ratio, std * ratio, "test"),
            "wheelbase_m": Quantity(length, 0.005, "test"),
        }
    )


@pytest.mark.parametrize("understeer", [-0.002, 0.0, 0.003, 0.006])
def test_the_product_is_that_of_the_vehicle_whatever_its_tyres(understeer: float) -> None:
    found = steering_product(_drive(44.0, understeer=understeer))
    assert found is not None
    assert found[0] == pytest.approx(44.0, rel=0.02)
    assert abs(found[0] - 44.0) < 4 * found[1]


@pytest.mark.parametrize("share", [0.87, 1.0, 1.13])
def test_a_variable_rack_is_no_other_vehicle(share: float) -> None:
    drive = _drive(share * 16 * 2.8)
    found, vehicle = steered(drive, _file(16.0))
    assert found is drive
    assert vehicle.turning == pytest.approx(share, rel=0.02)


@pytest.mark.parametrize("share", [0.7, 1.35, 57.3])
def test_another_vehicles_file_or_degrees_are_said_and_nothing_is_changed(share: float) -> None:
    drive = _drive(share * 16 * 2.8)
    found, vehicle = steered(drive, _file(16.0))
    assert vehicle.turning == pytest.approx(share, rel=0.02)
    (said,) = found.record.decisions
    assert found.signals == drive.signals
    assert not said.applied
    assert f"and {16 * 2.8:.1f} m in the vehicle file" in said.found
    limits = what_limits(found.record, (), {}, _file(16.0))
    assert any("is the file this vehicle's?" in text for text in limits)


def test_an_unsure_ratio_says_nothing() -> None:
    drive = _drive(1.5 * 16 * 2.8)
    file = _file(16.0, std=0.15)
    assert steered(drive, file) == (drive, file)


def test_what_is_not_stated_or_not_turned_is_not_asked() -> None:
    drive = _drive(90.0)
    assert steered(drive, Vehicle()) == (drive, Vehicle())
    straight = _drive(90.0, bends=0.01)
    assert steered(straight, _file(16.0)) == (straight, _file(16.0))
    lacking = Drive({n: s for n, s in drive.signals.items() if n != "yaw_rate"}, drive.record)
    assert steered(lacking, _file(16.0)) == (lacking, _file(16.0))
