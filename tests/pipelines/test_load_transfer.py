"""LTM, MLTM, HFLTM and the batch companion on simulated drives: truth found, diagonal shift survived, honest refusals."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from parsers.drive import Drive, Signal
from parsers.signals import WHEELS
from pipelines.estimators.base import Estimator
from pipelines.estimators.load_transfer.answers import Standing, whole_vehicle
from pipelines.estimators.load_transfer.companion import LoadTransferBatch
from pipelines.estimators.load_transfer.data import collect, known_of
from pipelines.estimators.load_transfer.kernels import HFLTM, MLTM
from pipelines.estimators.load_transfer.published import (
    HighFrequencyLoadTransfer,
    LoadTransfer,
    ModifiedLoadTransfer,
    calm_limit,
)
from pipelines.results import Estimate
from pipelines.simulation.loads import Load
from pipelines.simulation.logs.as_drive import drive_of
from pipelines.simulation.logs.drive import Choice, SimulatedLog, simulate_log
from pipelines.simulation.manoeuvres.base import Options
from pipelines.simulation.plant.vehicle import PRESETS
from pipelines.vehicles.vehicle import Quantity, Vehicle
from pipelines.vehicles.vehicle_file import parse_vehicle

G = 9.80665
BATCH = LoadTransferBatch()
PUBLISHED: tuple[Estimator, ...] = (LoadTransfer(), ModifiedLoadTransfer(), HighFrequencyLoadTransfer())
PLACE = ("mass_kg", "cg_to_front_axle_m", "cg_lateral_offset_m")


@cache
def simulated(manoeuvre: str = "rural", cross: float = 0.0, sensors: str = "struts") -> SimulatedLog:
    vehicle = replace(PRESETS["suv"], cross_weight_kg=cross)
    load = (Load(75.0, 1.33, 0.37, 0.8), Load(90.0, 2.6, -0.2, 0.9))
    return simulate_log(Choice(manoeuvre, vehicle, load, Options(), sensors, seed=7))


def vehicle_of(made: SimulatedLog) -> Vehicle:
    return parse_vehicle(made.sheet, Path("simulated.toml"))


def estimate(method: Estimator, drive: Drive, vehicle: Vehicle) -> Estimate:
    return method.estimate(method.prepare(drive, {}), vehicle, {}, np.random.default_rng(0))


def changed(drive: Drive, **signals: Signal | None) -> Drive:
    """The drive with signals replaced, or taken out (None)."""
    kept = {n: s for n, s in drive.signals.items() if n not in signals}
    return replace(drive, signals=kept | {n: s for n, s in signals.items() if s is not None})


def errors(found: Estimate, made: SimulatedLog) -> list[float]:
    """Of mass (relative), a over wheelbase, y over track."""
    sizes = (made.run.truth["mass_kg"], 2.78, 1.6)
    values = [found.parameters[n].value for n in PLACE]
    assert all(v is not None for v in values)
    return [
        abs(v - made.run.truth[n]) / size
        for v, n, size in zip(values, PLACE, sizes, strict=True)
        if v is not None
    ]


def test_unsprung_masses_are_added_at_the_axles() -> None:
    file = vehicle_of(simulated())
    quantities = dict(file.quantities) | {
        "unsprung_mass_front_kg": Quantity(100.0, 0.0, "x"), "unsprung_mass_rear_kg": Quantity(80.0, 0.0, "x"),
        "wheelbase_m": Quantity(2.5, 0.0, "x"), "track_front_m": Quantity(1.6, 0.0, "x"), "track_rear_m": Quantity(1.6, 0.0, "x"),
    }  # fmt: skip
    known = known_of(replace(file, quantities=quantities))
    assert known is not None
    loads = G * np.array([450.0, 400.0, 420.0, 380.0])
    found = whole_vehicle(Standing(loads, np.zeros((4, 4)), (0.0, 0.0), (0.0, 0.0)), known)
    assert found["sprung_mass_kg"][0] == pytest.approx(1650)
    assert found["mass_kg"][0] == pytest.approx(1830)
    assert found["cg_to_front_axle_m"][0] == pytest.approx((800 + 80) * 2.5 / 1830)
    assert found["cg_lateral_offset_m"][0] == pytest.approx(0.8 * (870 - 780) / 1830)
    assert found["corner_mass_rr_kg"][0] == pytest.approx(420)


@pytest.mark.parametrize("cross", [0.0, 30.0])
def test_the_companion_finds_mass_and_place(cross: float) -> None:
    made = simulated(cross=cross)
    found = estimate(BATCH, drive_of(made.log), vehicle_of(made))
    assert max(errors(found, made)) < 0.012
    for name, entry in found.parameters.items():
        assert entry.low is not None, name
        assert entry.high is not None, name
        assert entry.low < made.run.truth[name] < entry.high, name
    assert found.parameters["mass_kg"].status == "identified"
    assert found.parameters["drag_area_m2"].status != "identified"
    assert not found.witness


@pytest.mark.parametrize("method", PUBLISHED, ids=lambda m: m.name)
def test_the_published_methods_are_honest_witnesses(method: Estimator) -> None:
    made = simulated()
    found = estimate(method, drive_of(made.log), vehicle_of(made))
    assert found.witness
    assert max(errors(found, made)) < 0.03
    for name in (*PLACE, "sprung_mass_kg"):
        entry = found.parameters[name]
        assert entry.low is not None
        assert entry.high is not None
        assert entry.low < made.run.truth[name] < entry.high, name
    assert {t.name.split(": ")[1] for t in found.traces} >= {"arms", "strut force fl"}


def test_masses_held_in_turns_stay_within_a_per_cent_under_a_diagonal_shift() -> None:
    """At 0.6 g the links carry some per cent of the weight; gate_g = 0 is the published form."""
    made = simulated("handling_track", cross=30.0)
    drive, file, method = drive_of(made.log), vehicle_of(made), PUBLISHED[1]
    gated = estimate(method, drive, file)
    published = method.estimate(method.prepare(drive, {}), file, {"gate_g": 0.0}, np.random.default_rng(0))
    assert max(errors(gated, made)) < 0.5 * errors(published, made)[0]
    rural = simulated(cross=30.0)
    assert max(errors(estimate(method, drive_of(rural.log), vehicle_of(rural)), rural)) < 0.01


def test_a_vehicle_that_only_turns_has_no_calm_rows_to_hold_out_for() -> None:
    made = simulated()
    known = known_of(vehicle_of(made))
    assert known is not None
    data = collect(PUBLISHED[1].prepare(drive_of(made.log), {}), known)
    assert data is not None
    circling = replace(data, across=np.full(data.size, 4.0))
    assert calm_limit(MLTM, data, 0.1) == 0.1
    assert calm_limit(MLTM, circling, 0.1) == np.inf
    assert calm_limit(MLTM, data, 0.0) == np.inf
    assert calm_limit(HFLTM, data, 0.1) == np.inf


def test_a_diagonal_shift_biases_the_ltms_forces_and_not_the_mltms() -> None:
    made = simulated(cross=30.0)
    drive, file = drive_of(made.log), vehicle_of(made)
    lumped, modified = (estimate(m, drive, file) for m in PUBLISHED[:2])
    bias = [max(abs(f.diagnostics[f"late_mean_error_{w}_n"]) for w in WHEELS) for f in (lumped, modified)]
    assert bias[0] > 200
    assert bias[1] < 40
    spreads = [f.parameters["cg_to_front_axle_m"].std for f in (lumped, modified)]
    assert spreads[0] is not None
    assert spreads[1] is not None
    assert spreads[0] > 2 * spreads[1]


def test_hfltm_predicts_a_strut_one_step_ahead_on_the_handling_track() -> None:
    made = simulated("handling_track")
    found = estimate(PUBLISHED[2], drive_of(made.log), vehicle_of(made))
    assert found.diagnostics["one_step_rms_fl_n"] < 116


def test_missing_optional_signals_widen_and_do_not_break() -> None:
    made = simulated()
    drive, file = drive_of(made.log), vehicle_of(made)
    full = estimate(BATCH, drive, file)
    gone = [n for n in drive.signals if not n.startswith("suspension_force") and n != "accel_z"]
    bare = estimate(BATCH, changed(drive, **dict.fromkeys(gone)), file)
    assert bare.status == "ran"
    without = estimate(BATCH, changed(drive, **{f"accel_z_sprung_{w}": None for w in WHEELS}), file)
    assert max(errors(without, made)) < 0.015
    for found in (bare, without):
        for name in ("mass_kg", "cg_to_front_axle_m"):
            a, b = found.parameters[name].std, full.parameters[name].std
            assert a is not None
            assert b is not None
            assert a >= 0.99 * b


def test_wrong_inputs_are_refused_in_words() -> None:
    made = simulated()
    drive, file = drive_of(made.log), vehicle_of(made)
    force = drive.signals["suspension_force_fl"]
    dead = changed(drive, suspension_force_fl=replace(force, values=np.full(len(force.values), 4000.0)))
    turned = changed(drive, suspension_force_fl=replace(force, values=-force.values))
    for spoiled, words in ((dead, "dead sensor"), (turned, "signs")):
        found = estimate(BATCH, spoiled, file)
        assert found.parameters["mass_kg"].status == "not_identifiable"
        assert words in found.parameters["mass_kg"].reason
    heavy = replace(file, quantities=dict(file.quantities) | {"mass_kg": Quantity(9000.0, 90.0, "x")})
    assert "units" in estimate(BATCH, drive, heavy).reason
    missing = estimate(BATCH, changed(drive, suspension_force_rr=None), file)
    assert "suspension_force_rr" in missing.reason


def test_a_standing_vehicle_gives_static_loads_alone() -> None:
    n = 3000
    time_ns = np.arange(n, dtype=np.int64) * 10_000_000
    loads = dict(zip(WHEELS, (4300.0, 4200.0, 4000.0, 3900.0), strict=True))
    values = {f"suspension_force_{w}": f for w, f in loads.items()} | {"accel_z": G, "speed": 0.0}
    made = drive_of(simulated().log)
    signals = {k: Signal(k, time_ns, np.full(n, v), "made") for k, v in values.items()}
    file = vehicle_of(simulated())
    found = estimate(BATCH, replace(made, signals=signals), file)
    assert found.parameters["sprung_mass_kg"].value == pytest.approx(sum(loads.values()) / G, rel=1e-6)
    assert found.parameters["roll_arm_m"].status == "not_identifiable"
    assert "cornering" in found.parameters["roll_arm_m"].reason
    filtered = estimate(PUBLISHED[1], replace(made, signals=signals), file)
    assert filtered.parameters["mass_kg"].value is None
    assert "30 s" in filtered.reason
