"""The estimator: forces with intervals in its traces, words for what is missing, errors where the log measured them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from wheel_force_drives import Made, without

from parsers.signals import WHEELS
from pipelines.analyze import run_estimator
from pipelines.estimators.suspension_mapping.estimator import SuspensionMapping
from pipelines.results import Estimate
from pipelines.suspension_mapping.record import SuspensionMap
from pipelines.tire_forces import forces_of, measured_forces, tire_forces


def _run(made: Made, record: SuspensionMap | None, *missing: str) -> Estimate:
    vehicle = replace(made.vehicle, suspension_map=record)
    return run_estimator(SuspensionMapping(), without(made.drive, *missing), vehicle, {"band_hz": 10.0}, 0)


def test_gives_the_forces_over_the_drive(suspension_map: SuspensionMap, other: Made) -> None:
    estimate = _run(other, suspension_map)
    forces = forces_of(estimate)
    assert forces is not None
    assert not forces.measured
    for wheel in WHEELS:
        there = np.isfinite(forces.value[wheel])
        true = other.true_at(wheel, forces.time_s[there])
        inside = (forces.low[wheel][there] <= true) & (true <= forces.high[wheel][there])
        assert np.mean(inside) > 0.7
        parameter = estimate.parameters[f"tire_normal_force_{wheel}_n"]
        assert parameter.status == "identified"
        assert "static force" in parameter.reason
        assert parameter.value is not None
        # the drive begins and ends at rest
        assert parameter.value == pytest.approx(other.true[wheel][0], rel=0.03)
        least = estimate.diagnostics[f"least_force_{wheel}_n"]
        assert least == pytest.approx(float(np.nanmin(forces.value[wheel])))
    assert "against training" in estimate.reason
    assert "RMS error" in estimate.reason
    assert estimate.diagnostics["rms_error_fl_n"] < 80


def test_a_log_without_measuring_wheels_has_no_errors(suspension_map: SuspensionMap, other: Made) -> None:
    estimate = _run(other, suspension_map, "tire_normal_force")
    assert "rms_error_fl_n" not in estimate.diagnostics
    assert forces_of(estimate) is not None
    assert not any("residual" in name for trace in estimate.traces for name in trace.columns)


def test_without_a_map_it_is_skipped_and_says_how_to_get_one(other: Made) -> None:
    estimate = _run(other, None)
    assert estimate.status == "skipped"
    assert "suspension_map" in estimate.reason
    assert "cogest suspension-map" in estimate.reason


def test_a_map_that_does_not_fit_the_log(suspension_map: SuspensionMap, other: Made) -> None:
    struts = replace(suspension_map, parts={"struts": suspension_map.parts["struts"]})
    estimate = _run(other, struts, "suspension_force")
    assert estimate.status == "ran"
    assert {p.status for p in estimate.parameters.values()} == {"not_identifiable"}
    assert "suspension_force_fl" in estimate.reason
    assert forces_of(estimate) is None


def test_another_vehicle_is_said(suspension_map: SuspensionMap, other: Made) -> None:
    made = replace(other, vehicle=replace(other.vehicle, name="lorry"))
    assert "this vehicle is 'lorry'" in _run(made, suspension_map).reason


def test_measured_forces_come_first(suspension_map: SuspensionMap, other: Made) -> None:
    estimate = _run(other, suspension_map)
    measured = tire_forces([estimate], other.drive)
    assert measured is not None
    assert measured.measured
    mapped = tire_forces([estimate], without(other.drive, "tire_normal"))
    assert mapped is not None
    assert not mapped.measured
    assert tire_forces([], without(other.drive, "tire_normal")) is None
    own = measured_forces(other.drive)
    assert own is not None
    assert np.nanmean(own.high["fl"] - own.low["fl"]) > 100


def test_a_gap_stays_a_gap(suspension_map: SuspensionMap, other: Made) -> None:
    signal = other.drive.signals["accel_y"]
    seconds = (signal.time_ns - signal.time_ns[0]) / 1e9
    keep = (seconds < 20) | (seconds > 26)
    cut = replace(signal, time_ns=signal.time_ns[keep], values=signal.values[keep])
    made = replace(other, drive=replace(other.drive, signals={**other.drive.signals, "accel_y": cut}))
    forces = forces_of(_run(made, suspension_map))
    assert forces is not None
    inside = (forces.time_s > 21) & (forces.time_s < 25)
    assert np.isnan(forces.value["rl"][inside]).all()
    assert np.isfinite(forces.value["rl"][forces.time_s < 19]).all()
