"""Drives for the store's tests: as found, as worked out, and what their relations told; made by hand, no log needed."""

from __future__ import annotations

import random
import time
from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np

from pipelines.drive_results import DriveResults
from pipelines.fleet.gather import gather
from pipelines.fleet.records import Facts, FoundDrive, FoundFleet
from pipelines.fleet.store import open_store
from pipelines.hierarchy.records import DriveTold, LoadChange, Trend, VehicleKnowledge, VehicleParameter
from pipelines.joint.kept import KeptRelations
from tests.reports.sample_results import rich

FOLDER = "/data/fleet"


def found_drive(number: int, vehicle: str = "v1", **others: object) -> FoundDrive:
    """A drive of a vehicle."""
    name = f"{vehicle}/drive_{number:03d}.csv"
    known = FoundDrive(
        drive_id=f"{vehicle}-drive-{number:03d}", name=name, logs=(f"{FOLDER}/{name}",), vehicle=f"{FOLDER}/{vehicle}/vehicle.toml",
        vehicle_id=vehicle, vehicle_name=f"Van {vehicle}", map=None, settings=None, dbc=(), formats=("CSV",), size=1000 + number,
    )  # fmt: skip
    return replace(known, **others)  # type: ignore[arg-type]


def fleet_of(*drives: FoundDrive) -> FoundFleet:
    """A folder with these drives."""
    return FoundFleet(FOLDER, drives)


def facts_of_drive(number: int) -> dict[str, Facts]:
    """What the drive's log was."""
    return {f"{FOLDER}/{number}": Facts(1000 + number, f"17{number:03d}", f"{number:064x}")}


@cache
def _rich() -> DriveResults:
    return rich()


def results_of_drive(number: int, start: str | None = "2024-05-01T08:00:00.000+00:00") -> DriveResults:
    """Results that differ from drive to drive."""
    whole = _rich()
    verdict = {
        name: estimate
        if estimate.value is None
        else replace(estimate, value=estimate.value * (1 + 1e-3 * number))
        for name, estimate in whole.verdict.items()
    }
    if start is not None:
        start = start.replace("05-01", f"05-{number % 28 + 1:02d}")
    inputs = replace(whole.inputs, log_sha256=f"{number:064x}")
    return replace(whole, verdict=verdict, inputs=inputs, record=replace(whole.record, start_utc=start))


def kept_of_drive(number: int, unknowns: int = 6, relations: int = 9) -> KeptRelations:
    """Relations, most entries nought."""
    rng = np.random.default_rng(number)
    rows = rng.normal(size=(relations, unknowns)) * (rng.random((relations, unknowns)) < 0.3) + 0.0
    titles = tuple(f"relation {i % 3}" for i in range(relations))
    return KeptRelations(
        names=tuple(f"unknown_{i}" for i in range(unknowns)), mean=rng.normal(size=unknowns), std=rng.random(unknowns) + 0.1,
        mode=rng.normal(size=unknowns), rows=rows, observed=rng.normal(size=relations), relation=titles,
        kind=tuple("roll" for _ in titles), source=tuple("roll_map" for _ in titles), given={"sag": 0.25},
        widened={"relation 1": 1.75}, inflation=1.125, normal=bool(number % 2),
    )  # fmt: skip


def join_plainly(vehicle_id: str, drives: list[DriveTold]) -> VehicleKnowledge:
    """A stand-in for joining: it moves each drive's answers by a bit that depends on all drives."""
    mean = float(np.mean([told.verdict["mass_kg"].value for told in drives]))
    count = len(drives)
    changes = tuple(
        LoadChange(b.drive_id, a.drive_id, 0.25, False, {"mass_kg": (mean / 7, 3.0)}, "no change")
        for a, b in pairwise(drives)
    )
    trend = Trend(
        "damper_rate_rear_nspm",
        "Damper",
        "N·s/m",
        -1 / 3,
        0.1,
        -0.5,
        -0.1,
        0.01,
        True,
        "",
        "",
        count,
        "falls",
    )
    return VehicleKnowledge(
        vehicle_id,
        {"empty_mass_kg": VehicleParameter(replace(drives[0].verdict["mass_kg"], name="empty_mass_kg", value=mean), "Empty mass", "kg", 3.0, count)},
        {told.drive_id: {n: replace(e, reason="joined") for n, e in told.verdict.items()} for told in drives},
        changes, (trend,), ("one note",),
    )  # fmt: skip


def work(place: str, count: int) -> None:
    """A batch without an engine: every drive that is not stored yet, in any order, and the tables."""
    store = open_store(place, create=True)
    found = {n: found_drive(n, f"v{n % 3}") for n in range(count)}
    for number in random.Random(time.time_ns()).sample(range(count), count):
        stored = store.stored(found[number].drive_id)
        if stored is None or not stored.fresh(f"key {number}"):
            files = {"report.html": b"x" * 30_000}
            results, kept = results_of_drive(number), kept_of_drive(number)
            store.put(found[number], f"key {number}", facts_of_drive(number), results, kept, files)
    store.write_tables(gather(store, fleet_of(*found.values()), join_plainly, lambda *_: ()))
