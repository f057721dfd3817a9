"""One drive from log files to results: load, prepare, estimate, verdict, rollover, and what a report needs."""

from __future__ import annotations

import hashlib
import math
import time
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from parsers.drive import Drive
from parsers.errors import VehicleError
from parsers.load import LoadOptions, Progress, load_drive, quiet
from parsers.mapping import read_map
from parsers.signals import SIGNALS
from parsers.thin import thin_minmax
from parsers.timebase import NS
from parsers.units import SI_TEXT
from pipelines.drive_doubts import made_ready
from pipelines.drive_results import DriveResults, Inputs, Standing
from pipelines.estimators.against_file import held_against
from pipelines.estimators.base import Estimator, Settings, configured
from pipelines.estimators.registry import estimators
from pipelines.joint.kept import KeptRelations
from pipelines.limits import what_limits
from pipelines.needs import readiness
from pipelines.results import Assumption, Estimate, ParameterEstimate, Trace
from pipelines.rollover import assess_rollover
from pipelines.settings import choose, read_settings
from pipelines.vehicles.priors import standing
from pipelines.vehicles.vehicle import Vehicle
from pipelines.vehicles.vehicle_file import read_vehicle, with_suspension_map
from pipelines.vehicles.wheel_radius import wheel_radius
from pipelines.verdict.combine import verdict_of

TRACE_POINTS = 2000
"""Points a trace keeps for the report; extremes are kept when thinning."""


@dataclass(frozen=True)
class Request:
    """What to analyse and how. Paths as given; None where there is no such file.

    map_given: whether the user named the mapping file; one that was merely found may name channels of other logs.
    suspension_map: of the vehicle; before the one that the vehicle file names.
    """

    logs: tuple[Path, ...]
    vehicle: Path | None = None
    map: Path | None = None
    map_given: bool = True
    dbc: tuple[Path, ...] = ()
    dbc_given: bool = False
    settings: Path | None = None
    estimators: str | None = None
    seed: int = 0
    fix: bool = True
    command: str = ""
    version: str = ""
    suspension_map: Path | None = None


def _sha256(path: Path | None) -> str | None:
    """Of a file that was read just before. Raises VehicleError where it is gone since."""
    try:
        return None if path is None else hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        raise VehicleError(f"cannot be read ({error.strerror})", path=path) from error


SLOWEST_HZ = 0.8
"""Rows that come less often show no motion of a vehicle; what is logged once a second still tells its axle loads."""


LOOKED_AT = 2000
"""Samples of a signal that tell how often it comes: every estimator asks."""


def fastest_hz(drive: Drive) -> float:
    """How often the quickest signal is sampled; infinite where there is one sample of each."""
    begun = [s.time_ns[:LOOKED_AT] for s in drive.signals.values() if len(s.time_ns) > 1]
    steps = [float(np.median(np.diff(time_ns))) for time_ns in begun]
    return NS / min(steps) if steps and min(steps) > 0 else math.inf


def run_estimator(
    estimator: Estimator, drive: Drive, vehicle: Vehicle, settings: Settings, seed: int
) -> Estimate:
    """Run one estimator, or say exactly what it lacks. Its generator depends on the seed and its name alone."""
    estimator = configured(estimator, settings)
    ready = readiness(estimator, drive.signals.keys(), vehicle)
    if not ready.ready:
        lacks = "; ".join((*ready.missing_signals, *ready.missing_vehicle))
        return Estimate(estimator.name, "skipped", f"lacks {lacks}")
    if (rate := fastest_hz(drive)) < SLOWEST_HZ:
        return Estimate(
            estimator.name,
            "skipped",
            f"lacks a motion that is sampled: rows come every {1 / rate:.3g} s, at the quickest",
        )
    started = time.perf_counter()
    rng = np.random.default_rng([seed, zlib.crc32(estimator.name.encode())])
    try:
        prepared = estimator.prepare(drive, settings)
        estimate = estimator.estimate(prepared, vehicle, settings, rng)
    except (np.linalg.LinAlgError, FloatingPointError, ZeroDivisionError) as error:
        # one method's numerics must not cost the others their say; its failure is reported, not hidden
        estimate = Estimate(estimator.name, "failed", f"numerical failure: {error}")
    except ValueError as error:
        # libraries say so of figures that no step before had thought of
        estimate = Estimate(estimator.name, "failed", f"it cannot use this drive's figures: {error}")
    return replace(held_against(estimate, vehicle), runtime_s=time.perf_counter() - started)


def signal_traces(drive: Drive) -> tuple[Trace, ...]:
    """The drive's signals for the report, thinned; gaps stay gaps."""
    traces = []
    for signal in drive.signals.values():
        seconds = (signal.time_ns - drive.start_ns) / NS
        t, v = thin_minmax(seconds, signal.values, TRACE_POINTS)
        spec = SIGNALS[signal.name]
        traces.append(
            Trace(signal.name, t, {signal.name: v}, {signal.name: SI_TEXT[spec.quantity]}, signal.source)
        )
    return tuple(traces)


@dataclass(frozen=True)
class Analysis:
    """A drive's results, and what its relations told in the form in which a fleet's drives are joined."""

    results: DriveResults
    kept: KeptRelations | None


def analyze(request: Request, progress: Progress = quiet) -> DriveResults:
    """Analyse one drive. Raises as `analyze_whole`."""
    return analyze_whole(request, progress).results


def _placed(verdict: Mapping[str, ParameterEstimate], vehicle: Vehicle) -> Standing | None:
    """Where the vehicle stands among the measured ones; None where neither its body nor a height is known."""
    height, mass = verdict.get("cg_height_m"), vehicle.get("mass_kg")
    if vehicle.body is None and (height is None or height.value is None):
        return None
    learned = height is not None and height.status != "not_identifiable"
    return standing(
        vehicle.body, height.value if height is not None and learned else None, mass.value if mass else None
    )


def _inputs(request: Request, vehicle: Vehicle) -> Inputs:
    """What was asked, with the hashes of the vehicle's files as they are now; the log's hash and the time come when it is done.

    Raises VehicleError.
    """
    return Inputs(
        logs=tuple(str(path) for path in request.logs),
        log_sha256="",
        vehicle=str(request.vehicle) if request.vehicle else None,
        vehicle_sha256=_sha256(request.vehicle),
        map=str(request.map) if request.map else None,
        settings=str(request.settings) if request.settings else None,
        dbc=tuple(str(path) for path in request.dbc),
        seed=request.seed,
        command=request.command,
        version=request.version,
        suspension_map=str(vehicle.suspension_map_path) if vehicle.suspension_map_path else None,
        suspension_map_sha256=_sha256(vehicle.suspension_map_path),
        created_utc="",
    )


def analyze_whole(request: Request, progress: Progress = quiet) -> Analysis:
    """Analyse one drive.

    Raises LogError, MappingError, DatabaseError, VehicleError, SettingsError. A drive that cannot tell is no error.
    """
    known = estimators()
    chosen = choose(request.estimators, known)
    settings = read_settings(request.settings, known)
    vehicle = read_vehicle(request.vehicle) if request.vehicle else Vehicle()
    if request.suspension_map is not None:
        vehicle = with_suspension_map(vehicle, request.suspension_map)
    # at once: a file may be changed while the drive is analysed
    inputs = _inputs(request, vehicle)
    mapping = read_map(request.map, strict=request.map_given) if request.map else None
    drive = load_drive(
        request.logs,
        LoadOptions(mapping, request.dbc, request.fix, progress, request.dbc_given, wheel_radius(vehicle)),
    )
    drive, doubts = made_ready(drive, vehicle, fix=request.fix)
    vehicle = doubts.vehicle
    results: list[Estimate] = []
    for number, estimator in enumerate(chosen):
        progress(f"estimating: {estimator.title}", number / len(chosen))
        results.append(run_estimator(estimator, drive, vehicle, settings[estimator.name], request.seed))
    progress("weighing the evidence", 1.0)
    rng = np.random.default_rng([request.seed, zlib.crc32(b"verdict")])
    whole = verdict_of(results, vehicle, rng, drive.signals.keys())
    # before what predicts is taken out of them
    kept, verdict = doubts.kept(whole, results), doubts.verdict(whole, results)
    results = doubts.estimates(results)
    made = DriveResults(
        inputs=replace(
            inputs,
            # those that decoded something: of others lie some beside a log, and the record says what was given in vain
            dbc=tuple(str(path) for path in request.dbc if path.name in drive.record.databases),
            log_sha256=drive.record.sha256,
            created_utc=datetime.now(UTC).isoformat(timespec="seconds"),
        ),
        record=drive.record,
        vehicle_name=vehicle.name,
        verdict=verdict,
        estimates=tuple(results),
        rollover=assess_rollover(verdict, vehicle, drive, results),
        standing=_placed(verdict, vehicle),
        assumptions=_assumptions(results),
        limits=what_limits(
            drive.record, results, verdict, vehicle, whole.joint, file_given=request.vehicle is not None
        ),
        signals=signal_traces(drive),
        joint=doubts.joint(whole, verdict),
    )
    return Analysis(made, kept)


def _assumptions(results: Sequence[Estimate]) -> tuple[Assumption, ...]:
    """Every assumption of every estimator, once."""
    return tuple(dict.fromkeys(entry for estimate in results for entry in estimate.assumptions))
