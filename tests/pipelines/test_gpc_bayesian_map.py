"""gpc_bayesian_map on drives: what was planted comes back, what cannot be told is said, uncertainty goes through."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from parsers.drive import Drive, ImportRecord, Signal
from parsers.signals import WHEELS
from pipelines.analyze import run_estimator
from pipelines.estimators.base import FullSettings
from pipelines.estimators.gpc_bayesian_map.estimator import DEFAULTS, GpcBayesianMap
from pipelines.models.registry import model
from pipelines.reproduce.gpc_map.plant import Car
from pipelines.reproduce.gpc_map.setup import RATE_HZ, Bench, bench
from pipelines.results import Estimate
from pipelines.vehicles.vehicle import Quantity, Vehicle

METHOD = GpcBayesianMap()
QUICK = {"intervals": 2.0, "most_blocks": 8.0}
CAR = Car()


def vehicle(spring_std: float = 0.0, **more: Quantity) -> Vehicle:
    """The bench's car as a vehicle file has it; no bushes, no roll centre: springs are what they are."""
    figures = {
        "mass_kg": 1900.0, "wheelbase_m": CAR.wheelbase_m, "track_front_m": CAR.track_m, "track_rear_m": CAR.track_m,
        "damper_rate_front_nspm": 2100.0, "damper_rate_rear_nspm": 2100.0, "cg_to_front_axle_m": 1.35,
        "unsprung_mass_front_kg": 90.0, "unsprung_mass_rear_kg": 90.0,
    }  # fmt: skip
    known = {key: Quantity(value, 0.0, "made") for key, value in figures.items()}
    for axle, spring in (("front", CAR.spring_front_npm), ("rear", CAR.spring_rear_npm)):
        known[f"spring_rate_{axle}_npm"] = Quantity(spring, spring_std * spring, "made")
        known[f"roll_center_height_{axle}_m"] = Quantity(0.0, 0.0, "made")
        known[f"anti_roll_stiffness_{axle}_nmprad"] = Quantity(0.0, 0.0, "made")
    return Vehicle(quantities={**known, **more}, reference={"sprung_mass_kg": CAR.mass_kg})


def drive(place: Bench, *, scale: float = 1.0, gap: bool = False, swap: bool = False) -> Drive:
    """The seven-degree-of-freedom car's accelerometers, with noise, offsets and gravity."""
    rng = np.random.default_rng(5)
    rows = len(place.hubs)
    time = (np.arange(rows) / RATE_HZ * 1e9).astype(np.int64)
    keep = np.ones(rows, dtype=bool)
    if gap:
        keep[2000:2300] = False
    signals = {}
    for i, wheel in enumerate(WHEELS):
        hub, body = scale * place.hubs[:, i], scale * place.seven[:, i if not swap else 3 - i]
        for name, column, noise in (
            (f"accel_z_unsprung_{wheel}", hub, 0.2), (f"accel_z_sprung_{wheel}", body, 0.05),
        ):  # fmt: skip
            read = column + noise * rng.standard_normal(rows) + 9.81 + 0.1 * rng.standard_normal()
            signals[name] = Signal(name, time[keep], read[keep], "made")
    record = ImportRecord("made", (), "", "complete", 0, {}, (), "made", None, rows / RATE_HZ, ())
    return Drive(signals, record)


def run(drive: Drive, car: Vehicle, **numbers: float) -> Estimate:
    settings = FullSettings({**DEFAULTS, **QUICK, **numbers}, {"model": "base_excitation_3dof"})
    return run_estimator(METHOD, drive, car, settings, 0)


@pytest.fixture(scope="module")
def place() -> Bench:
    return bench(np.random.default_rng(3))


@pytest.fixture(scope="module")
def usual(place: Bench) -> Estimate:
    return run(drive(place, gap=True), vehicle())


def test_what_was_planted_comes_back(usual: Estimate) -> None:
    assert usual.status == "ran"
    assert usual.witness
    mass = usual.parameters["sprung_mass_kg"]
    assert mass.value is not None
    assert mass.low is not None
    assert mass.high is not None
    assert mass.low <= CAR.mass_kg <= mass.high
    assert mass.value == pytest.approx(CAR.mass_kg, rel=0.04)
    pitch = usual.diagnostics["sprung_pitch_inertia_kgm2_map"]
    assert pitch == pytest.approx(CAR.pitch_kgm2, rel=0.04)
    assert usual.diagnostics["sprung_roll_inertia_kgm2_map"] == pytest.approx(CAR.roll_kgm2, rel=0.06)
    assert usual.diagnostics["explained_share"] > 0.95
    whole = usual.parameters["mass_kg"]
    assert whole.value == pytest.approx(mass.value + 180, abs=1)
    assert usual.parameters["pitch_inertia_kgm2"].value == pytest.approx(pitch + 180 * 1.4**2, rel=0.03)


def test_the_roll_inertia_is_not_told_from_the_roll_axis(usual: Estimate) -> None:
    roll = usual.parameters["roll_inertia_kgm2"]
    assert roll.status == "not_identifiable"
    assert "roll axis" in roll.reason


def test_the_report_has_its_figures(usual: Estimate) -> None:
    assert [t.parameter for t in usual.tracks] == ["sprung_mass_kg"]
    assert len(usual.tracks[0].value) == 2
    assert {t.name for t in usual.traces} == {f"fit of accel_z_sprung_{w}" for w in WHEELS}
    assert len(usual.scatters) == len(model("base_excitation_3dof").parameters)
    assert any(a.name == "spring_rate_front_npm" for a in usual.assumptions)
    assert 0 < usual.used_fraction <= 1


def test_unsure_springs_widen_the_interval(place: Bench, usual: Estimate) -> None:
    sure, unsure = (
        usual.parameters["sprung_mass_kg"],
        run(drive(place), vehicle(0.08)).parameters["sprung_mass_kg"],
    )
    assert sure.std is not None
    assert unsure.std is not None
    assert unsure.std > 0.05 * CAR.mass_kg
    assert unsure.std > 1.3 * sure.std


def test_a_quiet_road_tells_nothing(place: Bench) -> None:
    found = run(drive(place, scale=0.01), vehicle())
    assert "hardly move" in found.reason
    assert all(p.status == "not_identifiable" for p in found.parameters.values())


def test_wheels_mixed_up_are_noticed(place: Bench) -> None:
    found = run(drive(place, swap=True), vehicle())
    assert "check channels" in found.reason
    assert all(p.status == "not_identifiable" for p in found.parameters.values())


def test_what_is_missing_is_named(place: Bench) -> None:
    car = vehicle()
    springless = {k: q for k, q in car.quantities.items() if not k.startswith("spring_rate_rear")}
    found = run(drive(place), replace(car, quantities=springless))
    assert (found.status, "spring_rate_rear_npm" in found.reason) == ("skipped", True)
    whole = drive(place)
    fewer = Drive({k: s for k, s in whole.signals.items() if k != "accel_z_unsprung_rr"}, whole.record)
    assert "accel_z_unsprung_rr" in run(fewer, car).reason


def test_an_expansion_beyond_all_measure_is_refused_in_words(place: Bench) -> None:
    found = run(drive(place), vehicle(), order=12.0, points_per_term=20.0)
    assert found.status == "ran"
    assert "order" in found.reason
    assert found.parameters["sprung_mass_kg"].status == "not_identifiable"
