"""Forces in another unit than newtons, told by the mass in the vehicle file: named and left out; right ones never, whatever is loaded."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import polars as pl
import pytest

from parsers.drive import Drive, ImportRecord, Signal
from parsers.signals import WHEELS
from pipelines.analyze import Request, analyze
from pipelines.prepare.force_units import forces_in_newtons
from pipelines.vehicles.vehicle import Quantity, Vehicle

G = 9.80665
STRUTS = tuple(f"suspension_force_{wheel}" for wheel in WHEELS)
TYRES = tuple(f"tire_normal_force_{wheel}" for wheel in WHEELS)
AXLES = ("axle_load_front", "axle_load_rear")


def _drive(names: tuple[str, ...], kilos: float, newtons: float = 1.0, sway: float = 0.1) -> Drive:
    """A minute in which `kilos` rest on these signals and sway by a share of that. newtons: of the unit in which they are written."""
    rng = np.random.default_rng(5)
    t = np.arange(3000) / 50
    each = kilos * G / len(names) / newtons
    columns = {name: each * (1 + sway * np.sin(t) + 0.02 * rng.standard_normal(len(t))) for name in names}
    columns["accel_x"] = np.sin(t)
    stamps = (t * 1e9).astype(np.int64)
    record = ImportRecord("csv", (Path("a.csv"),), "", "complete", len(t), {}, (), "t", None, 60.0, ())
    return Drive({name: Signal(name, stamps, v, name) for name, v in columns.items()}, record)


def _vehicle(kilos: float = 1500.0, std: float = 20.0, body: str | None = "Passenger Car") -> Vehicle:
    return Vehicle(body=body, quantities={"mass_kg": Quantity(kilos, std, "sheet")})


@pytest.mark.parametrize(
    ("newtons", "unit"), [(G, "kgf or daN"), (10.0, "kgf or daN"), (1000.0, "kN"), (4.448, "lbf")]
)
@pytest.mark.parametrize(
    ("names", "share"),
    [
        (STRUTS, 0.88),
        (TYRES, 1.1),
        (AXLES, 1.2),
        (("axle_load_rear",), 0.42),
        (STRUTS[2:], 0.35),
        (TYRES[:2], 0.5),
    ],
)
def test_another_unit_is_named_and_the_forces_left_out(
    names: tuple[str, ...], share: float, newtons: float, unit: str
) -> None:
    read = forces_in_newtons(_drive(names, share * 1500, newtons), _vehicle())
    assert set(read.signals) == {"accel_x"}
    assert {each.signal for each in read.record.decisions} == set(names)
    for each in read.record.decisions:
        assert each.applied
        told = each.found.split(" is in ")[1].split(", not in N")[0].split(" or ")
        # a load leaves open which of two that are near each other it is
        assert set(unit.split(" or ")) <= set(told)
        assert ("kN" in told) == (unit == "kN")
        assert f"{share * 1500 / newtons:.3g}"[:2] in each.evidence


def test_newtons_under_a_header_of_kilonewtons() -> None:
    read = forces_in_newtons(_drive(AXLES, 1600, 1 / 1000), _vehicle())
    assert "is in N, not in kN" in read.record.decisions[0].found


@pytest.mark.parametrize(
    ("vehicle", "kilos"),
    [
        (_vehicle(), 1500.0), (_vehicle(), 2100.0), (_vehicle(1900, body="Pickup"), 3900.0),
        (_vehicle(7000, body="Truck"), 26000.0), (_vehicle(1500, 400), 1000.0),
        (_vehicle(2000, 0.0), 1200.0),  # a gross mass for an empty one
        (_vehicle(3000, 0.0), 1500.0),  # twice the mass: wrong, but no unit
    ],
)  # fmt: skip
@pytest.mark.parametrize(
    ("names", "share"), [(STRUTS, 0.86), (TYRES, 1.0), (AXLES, 1.0), (AXLES[:1], 0.3), (AXLES[1:], 0.75)]
)
def test_newtons_stay_whatever_is_loaded(
    vehicle: Vehicle, kilos: float, names: tuple[str, ...], share: float
) -> None:
    drive = _drive(names, share * kilos)
    assert forces_in_newtons(drive, vehicle) is drive


@pytest.mark.parametrize(
    ("kilos", "sway"), [(0.0, 0.0), (0.02, 5000.0), (25.0, 5.0), (-30.0, 4.0), (150.0, 1.0)]
)
def test_zeroed_struts_are_no_unit(kilos: float, sway: float) -> None:
    drive = _drive(STRUTS, kilos, sway=sway)
    assert forces_in_newtons(drive, _vehicle()) is drive


def test_without_a_mass_nothing_is_told() -> None:
    drive = _drive(STRUTS, 1400, G)
    assert forces_in_newtons(drive, Vehicle()) is drive


def test_no_fix_leaves_them_and_says_so() -> None:
    read = forces_in_newtons(_drive(AXLES, 1600, G), _vehicle(), fix=False)
    assert set(AXLES) <= set(read.signals)
    assert all(
        not each.applied and each.action.startswith("left as it is (--no-fix)")
        for each in read.record.decisions
    )


def test_analyze_says_so_and_tells_no_mass(tmp_path: Path) -> None:
    """Axle loads of level driving and braking, by the rigid body's balance alone."""
    t = np.arange(0, 120, 0.02)
    along = 2.0 * np.sin(0.5 * t) * (np.sin(0.06 * t) > -0.5)
    moved = 1600 * 0.6 / 2.7 * along
    rng = np.random.default_rng(2)
    table = pl.DataFrame(
        {
            "time_s": t,
            "speed_mps": 20 + np.cumsum(along) * 0.02,
            "accel_x_mps2": along + 0.02 * rng.standard_normal(len(t)),
            "axle_load_front_n": (1600 * G * 0.55 - moved + 20 * rng.standard_normal(len(t))) / G,
            "axle_load_rear_n": (1600 * G * 0.45 + moved + 20 * rng.standard_normal(len(t))) / G,
        }
    )
    table.write_csv(tmp_path / "drive.csv")
    (tmp_path / "vehicle.toml").write_text(
        "[vehicle]\nmass_kg = {value = 1500, std = 20}\nwheelbase_m = {value = 2.7, std = 0.01}\n",
        encoding="utf-8",
    )
    results = analyze(Request((tmp_path / "drive.csv",), tmp_path / "vehicle.toml"))
    assert sum("is in kgf or daN, not in N" in each.found for each in results.record.decisions) == 2
    masses = [e.parameters["mass_kg"] for e in results.estimates if "mass_kg" in e.parameters]
    told = [each for each in (*masses, results.verdict["mass_kg"]) if each.status != "not_identifiable"]
    assert told == []
