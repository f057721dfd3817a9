"""One drive from log to results: each estimator has its say, fails alone, and repeats itself."""

from __future__ import annotations

import hashlib

import numpy as np
import pytest

import pipelines.analyze
from parsers.drive import Drive, Gap, ImportRecord, Signal
from parsers.errors import SettingsError, VehicleError
from parsers.timebase import MAX_GAPS, NS
from pipelines.analyze import Request, analyze, run_estimator, signal_traces
from pipelines.estimators.base import Need
from pipelines.limits import what_limits
from pipelines.results import Estimate
from pipelines.vehicles.vehicle import Quantity, Vehicle
from pipelines.vehicles.vehicle_file import parse_vehicle

RECORD = ImportRecord("CSV table", (), "0", "complete", 1, {}, (), "clock", None, 10.0, ())


class Method:
    """An estimator for tests: gives a draw of its generator, or fails as told."""

    title, source, parameters, settings = "Method", "none", ("mass_kg",), ()
    signal_needs = (Need(("accel_y", "roll"), "it moves"),)
    vehicle_needs = (Need(("track_front_m",), "it leans"),)

    def __init__(self, name="method", error=None):
        self.name, self.error = name, error

    def prepare(self, drive, settings):
        return drive

    def estimate(self, prepared, vehicle, settings, rng):
        if self.error:
            raise self.error
        return Estimate(self.name, "ran", "", diagnostics={"draw": float(rng.random())})


def drive_of(*names, count=100):
    time_ns = np.arange(count, dtype=np.int64) * NS // 50 + 5 * NS
    return Drive({n: Signal(n, time_ns, np.sin(time_ns / NS), n) for n in names}, RECORD, start_ns=5 * NS)


VEHICLE = parse_vehicle("[vehicle]\ntrack_front_m = 1.5\n", None)


def test_what_an_estimator_lacks_is_named():
    skipped = run_estimator(Method(), drive_of("speed"), Vehicle(), {}, 0)
    assert skipped.status == "skipped"
    assert skipped.reason == "lacks accel_y or roll (it moves); track_front_m (it leans)"
    assert run_estimator(Method(), drive_of("roll"), VEHICLE, {}, 0).status == "ran"


def test_the_generator_depends_on_the_seed_and_the_name_alone():
    def draw(name, seed):
        return run_estimator(Method(name), drive_of("roll"), VEHICLE, {}, seed).diagnostics["draw"]

    assert draw("a", 1) == draw("a", 1)
    assert len({draw("a", 1), draw("a", 2), draw("b", 1)}) == 3


@pytest.mark.parametrize(
    "error",
    [np.linalg.LinAlgError("singular"), FloatingPointError("x"), ZeroDivisionError("y"), ValueError("infs")],
)
def test_a_method_whose_numerics_fail_says_so(error):
    failed = run_estimator(Method(error=error), drive_of("roll"), VEHICLE, {}, 0)
    assert (failed.status, failed.parameters) == ("failed", {})
    assert str(error) in failed.reason
    assert failed.runtime_s >= 0
    with pytest.raises(KeyError):
        run_estimator(Method(error=KeyError("a bug")), drive_of("roll"), VEHICLE, {}, 0)


def test_one_failure_does_not_cost_the_others_their_say(samples, monkeypatch):
    broken, sound = Method("broken", np.linalg.LinAlgError("singular")), Method("sound")
    for method in (broken, sound):
        method.vehicle_needs = ()
    monkeypatch.setattr(pipelines.analyze, "estimators", lambda: (broken, sound))
    results = analyze(Request((samples / "csv" / "drive.csv",)))
    assert [e.status for e in results.estimates] == ["failed", "ran"]
    assert "broken failed: numerical failure: singular." in results.limits
    assert all(p.status == "not_identifiable" for p in results.verdict.values())


def test_what_is_wrong_with_the_request_is_said_before_the_log_is_read(samples, tmp_path, monkeypatch):
    monkeypatch.setattr(pipelines.analyze, "load_drive", lambda *_: pytest.fail("the log was read"))
    log = samples / "csv" / "drive.csv"
    with pytest.raises(SettingsError):
        analyze(Request((log,), estimators="nobody"))
    with pytest.raises(SettingsError):
        analyze(Request((log,), settings=tmp_path / "none.toml"))
    with pytest.raises(VehicleError):
        analyze(Request((log,), vehicle=tmp_path / "none.toml"))


def test_traces_are_bounded_and_begin_at_the_drives_start():
    (trace,) = signal_traces(drive_of("roll", count=50_000))
    assert len(trace.time_s) <= 2100
    assert trace.time_s[0] == 0
    assert trace.time_s[-1] == pytest.approx(49_999 / 50)
    assert trace.units == {"roll": "rad"}
    assert np.abs(trace.columns["roll"]).max() == pytest.approx(1, abs=1e-4)


def test_limits_count_gaps_and_jumps_in_words():
    def limits(**changes):
        record = ImportRecord(**{**vars(RECORD), **changes})
        return " ".join(what_limits(record, (), {}, Vehicle()))

    assert "1 gap in the log, 2.0 s of 10.0 s" in limits(gaps=(Gap(1, 3), Gap(5, 6, "roll")))
    assert "At least 1000 gaps in the log" in limits(gaps=(Gap(1, 2),) * MAX_GAPS)
    assert "The clock jumped 1 time:" in limits(clock_jumps=1)
    assert "The clock jumped 2 times:" in limits(clock_jumps=2)
    assert "The log is truncated" in limits(status="truncated")


@pytest.mark.parametrize(("total", "said"), [(115_000, False), (223_000, True)])
def test_a_file_whose_roll_stiffness_is_not_that_of_its_springs_and_bars(total: float, said: bool):
    figures = {
        "roll_stiffness_nmprad": (total, 2000.0), "spring_rate_front_npm": (30e3, 600.0), "spring_rate_rear_npm": (28e3, 600.0),
        "anti_roll_stiffness_front_nmprad": (25e3, 1000.0), "anti_roll_stiffness_rear_nmprad": (15e3, 600.0),
        "track_front_m": (1.6, 0.005), "track_rear_m": (1.6, 0.005),
    }  # fmt: skip
    vehicle = Vehicle(quantities={name: Quantity(*known, "vehicle file") for name, known in figures.items()})
    told = " ".join(what_limits(RECORD, (), {}, vehicle))
    assert ("contradicts itself" in told) is said
    assert ("springs and bars make 114240" in told) is said


def test_a_vehicle_file_that_goes_while_its_drive_is_analysed_is_told_as_it_was_read(
    samples, tmp_path, monkeypatch
):
    vehicle = tmp_path / "vehicle.toml"
    vehicle.write_text("[vehicle]\nmass_kg = 1500\n")
    read = hashlib.sha256(vehicle.read_bytes()).hexdigest()
    load = pipelines.analyze.load_drive

    def load_and_lose(*given):
        vehicle.unlink()
        return load(*given)

    monkeypatch.setattr(pipelines.analyze, "load_drive", load_and_lose)
    results = analyze(
        Request((samples / "csv" / "drive.csv",), vehicle=vehicle, estimators="suspension_mapping")
    )
    assert results.inputs.vehicle_sha256 == read
