"""Make the view of a fleet from the tables of its store: missing tables, nulls and odd values are taken as not known."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from urllib.parse import quote

import numpy as np
import polars as pl

from pipelines.fleet.tables import TABLES
from pipelines.joint.vehicle.empty import FIGURES
from pipelines.parameters import PARAMETERS
from pipelines.starts import is_local
from reports.fleet.facts import FleetFacts
from reports.fleet.records import (
    LOAD,
    NEAR_G,
    NEAR_PROBABILITY,
    Answers,
    DriveView,
    FleetView,
    Row,
    VehicleView,
)
from reports.text import clean

MOST_PARAMETERS = 12
"""Parameters that are drawn a drive: those of the load, then those with most answers."""

STATUS_CODES = {"identified": 1, "weak": 2, "not_identifiable": 3}
NAME_LIMIT = 160
NOTES_A_DRIVE = 20


def moment(stamp: object) -> int | None:
    """Seconds since 1970 UTC of an ISO 8601 text (UTC where it names no zone); None where it is none."""
    if not isinstance(stamp, str):
        return None
    try:
        when = datetime.fromisoformat(stamp.strip())
    except ValueError:
        return None
    try:
        return int((when if when.tzinfo else when.replace(tzinfo=UTC)).timestamp())
    except (OverflowError, ValueError):
        return None


def finite(value: object) -> float | None:
    """A usable figure, or None."""
    return float(value) if isinstance(value, int | float) and math.isfinite(value) else None


def href(path: object) -> str | None:
    """A path below the store as a relative link, a web address as it is; None for what a browser cannot open (s3://…).

    Percent-encoded: no text of a log can make it another kind of link.
    """
    if not isinstance(path, str) or not path.strip("/"):
        return None
    if "://" in path:
        web = path.startswith(("https://", "http://"))
        return quote(path, safe=":/", errors="replace") if web else None
    return quote(path.replace("\\", "/").lstrip("/"), safe="/", errors="replace")


def _text(value: object, limit: int = NAME_LIMIT) -> str:
    return "" if value is None else clean(value, limit)


def title_of(row: Row) -> str:
    """A parameter's title, with a capital; its name where it has none."""
    title = _text(row["title"] or row["parameter"], 80)
    return title[:1].upper() + title[1:]


def _rows(tables: Mapping[str, pl.DataFrame], name: str) -> list[dict[str, object]]:
    """The rows of a table with all columns of the contract, null where the table lacks one."""
    frame = tables.get(name)
    if frame is None:
        return []
    lacking = [pl.lit(None).alias(c) for c in TABLES[name] if c not in frame.columns]
    return frame.with_columns(lacking).to_dicts()


def _by_vehicle(rows: Iterable[Row]) -> dict[object, list[Row]]:
    out: dict[object, list[Row]] = {}
    for row in rows:
        out.setdefault(row["vehicle_id"], []).append(row)
    return out


_ORDER = {figure.name: k for k, figure in enumerate(FIGURES)}


def _listed(row: Row) -> tuple[int, str]:
    """Where a vehicle's parameter stands in its list."""
    name = str(row["parameter"])
    return _ORDER.get(name, len(_ORDER)), name


def _near(row: Row) -> bool:
    margin, chance, lifts = (
        finite(row[k]) for k in ("least_margin_g", "exceedance_probability", "wheel_lifts")
    )
    return (margin is not None and margin <= NEAR_G) or (chance or 0.0) >= NEAR_PROBABILITY or bool(lifts)


def _drive(row: Row, vehicle: int, changed: bool) -> DriveView:
    lifts = finite(row["wheel_lifts"])
    notes = row["notes"] if isinstance(row["notes"], list) else []
    return DriveView(
        drive_id=_text(row["drive_id"]),
        name=_text(row["drive"]) or _text(row["drive_id"]) or "unnamed",
        vehicle=vehicle,
        status=_text(row["status"], 40) or "unknown",
        reason=_text(row["reason"], 400),
        start=moment(row["start_utc"]),
        local=is_local(_text(row["start_utc"])),
        duration_s=finite(row["duration_s"]),
        format=_text(row["format"], 40),
        factor=finite(row["static_stability_factor"]),
        threshold_g=finite(row["rollover_threshold_g"]),
        margin_g=finite(row["least_margin_g"]),
        exceedance=finite(row["exceedance_probability"]),
        lifts=None if lifts is None else int(lifts),
        near=_near(row),
        changed=changed,
        gone=bool(row["gone"]),
        apart=_text(row["apart"], 20),
        href=href(row["report"]),
        notes=tuple(_text(n, 300) for n in notes[:NOTES_A_DRIVE]),
    )


def _labels(rows: list[dict[str, object]], extra: list[dict[str, object]]) -> dict[object, str]:
    """vehicle_id -> what to call it: its name where no other vehicle has the same."""
    names: dict[object, str] = {}
    for row in (*rows, *extra):
        names[row["vehicle_id"]] = names.get(row["vehicle_id"]) or _text(row["vehicle_name"], 80)
    often = Counter(names.values())
    out = {}
    for vehicle, name in names.items():
        shown = _text(vehicle, 80) or "vehicle not named"
        out[vehicle] = name if name and often[name] == 1 else (f"{name} ({shown})" if name else shown)
    return out


def _answers(frame: pl.DataFrame, count: int) -> Answers:
    """One parameter and source, aligned with the drives (column "at")."""
    arrays = {name: np.full(count, np.nan) for name in ("value", "low", "high")}
    status = np.zeros(count, dtype=np.int64)
    at = frame.get_column("at").to_numpy()
    code = frame.get_column("status").replace_strict(STATUS_CODES, default=0, return_dtype=pl.Int64)
    status[at] = code.fill_null(0).to_numpy()
    for name, array in arrays.items():
        array[at] = frame.get_column(name).cast(pl.Float64).fill_null(math.nan).to_numpy()
    unknown = (status == 3) | ~np.isfinite(arrays["value"])
    for array in arrays.values():
        array[unknown | ~np.isfinite(array)] = np.nan
    return Answers(arrays["value"], arrays["low"], arrays["high"], tuple(status.tolist()))


def _series(
    tables: Mapping[str, pl.DataFrame], ids: list[object]
) -> tuple[dict[str, Answers], dict[str, Answers]]:
    """Parameter -> answers, of single drives and joined."""
    frame = tables.get("parameters")
    out: tuple[dict[str, Answers], dict[str, Answers]] = ({}, {})
    if frame is None or frame.is_empty():
        return out
    places = pl.DataFrame({"drive_id": [str(i) for i in ids], "at": range(len(ids))}).unique(
        "drive_id", keep="first"
    )
    frame = frame.join(places, on="drive_id", how="inner")
    useful = frame.filter((pl.col("status") != "not_identifiable") & pl.col("value").is_finite())
    often = useful.group_by("parameter").len().sort(["len", "parameter"], descending=[True, False])
    # forces and masses of single wheels are the drive's report's business
    others = [
        p
        for p in often["parameter"].to_list()
        if p not in LOAD and not str(p).startswith(("corner_", "tire_"))
    ]
    wanted = [*LOAD, *others[: MOST_PARAMETERS - len(LOAD)]]
    parts = frame.filter(pl.col("parameter").is_in(wanted)).partition_by(
        ["parameter", "source"], as_dict=True
    )
    for name in wanted:
        for k, source in enumerate(("drive", "fleet")):
            if (name, source) in parts:
                out[k][name] = _answers(parts[name, source], len(ids))
    return out


def _titles(tables: Mapping[str, pl.DataFrame], names: Iterable[str]) -> dict[str, tuple[str, str]]:
    """Parameter -> (title, unit): as every report names it, else as the tables do."""
    out: dict[str, tuple[str, str]] = {}
    for table in ("trends", "vehicles"):
        for row in _rows(tables, table):
            out[str(row["parameter"])] = (title_of(row), _text(row["unit"], 20))
    # a drive's parameter is that of the loaded vehicle, whatever the tables call the empty one's
    out |= {name: (spec.title, spec.unit) for name, spec in PARAMETERS.items()}
    for name in names:
        out.setdefault(name, (_text(name, 60), ""))
    return out


def view_of(tables: Mapping[str, pl.DataFrame], facts: FleetFacts) -> FleetView:
    """The view of a store's tables; a table that is missing counts as empty."""
    rows, shared = _rows(tables, "drives"), _rows(tables, "vehicles")
    labels = _labels(rows, shared)
    order = sorted(labels, key=lambda v: (labels[v].casefold(), str(v)))
    place = {vehicle: k for k, vehicle in enumerate(order)}
    changes = _rows(tables, "load_changes")
    changed = {row["drive_id"] for row in changes if row["detected"]}
    drives = tuple(_drive(row, place[row["vehicle_id"]], row["drive_id"] in changed) for row in rows)
    own, joined = _series(tables, [row["drive_id"] for row in rows])
    of_shared, of_changes = _by_vehicle(shared), _by_vehicle(changes)
    of_trends = _by_vehicle(_rows(tables, "trends"))
    outliers = _rows(tables, "outliers")
    of_outliers = {row["vehicle_id"]: row for row in reversed(outliers)}
    members: list[list[int]] = [[] for _ in order]
    for k, drive in enumerate(drives):
        members[drive.vehicle].append(k)
    vehicles = tuple(
        VehicleView(
            vehicle_id=_text(v),
            label=labels[v],
            drives=tuple(members[k]),
            failed=sum(drives[i].status != "done" for i in members[k]),
            shared=tuple(sorted(of_shared.get(v, ()), key=_listed)),
            changes=tuple(of_changes.get(v, ())),
            trends=tuple(of_trends.get(v, ())),
            outlier=of_outliers.get(v),
            notes=tuple(_text(n, 400) for n in facts.vehicle_notes.get(str(v), ())),
        )
        for k, v in enumerate(order)
    )
    return FleetView(facts, drives, vehicles, own, joined, _titles(tables, {*own, *joined}), tuple(outliers))
