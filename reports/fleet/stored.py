"""The fleet report in its store: made from the tables and a few facts, and made again from these alone."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

from parsers.errors import ReportError, StoreError
from parsers.places_text import is_url, masked
from pipelines.fleet.plain import read_json
from pipelines.fleet.records import BatchSummary, FoundFleet
from pipelines.fleet.store import Store
from pipelines.fleet.tables import TABLES
from pipelines.hierarchy.changes import CHANCE
from pipelines.hierarchy.trends import CHANCE as DRIFT_CHANCE
from reports.files import make_folder, write_whole
from reports.fleet.facts import FleetFacts
from reports.fleet.write import FORMATS, fleet_pages

if TYPE_CHECKING:
    import polars as pl

FACTS_FILE = "fleet.json"
"""What the last batch on the store found, beside the tables."""


def check_fleet_formats(formats: str) -> tuple[str, ...]:
    """Formats of the fleet's report, each once; "none" = (). Raises ReportError."""
    asked = [part.strip().lower() for part in formats.split(",") if part.strip()]
    if asked == ["none"]:
        return ()
    # results.json is a drive's; asking for it along is no mistake worth stopping for
    unknown = [name for name in asked if name not in FORMATS and name != "json"]
    if unknown or not asked:
        found = f"unknown format {unknown[0]!r}" if unknown else "no format was asked for"
        raise ReportError(found, hint=f"a fleet's report comes as {', '.join(FORMATS)}", wrong_usage=True)
    return tuple(name for name in FORMATS if name in asked)


def keep_facts(store: Store, found: FoundFleet, summary: BatchSummary, version: str) -> None:
    """Write down what the report says besides the tables."""
    told = {
        "folder": masked(found.folder),
        "version": version,
        "left_out": [[name, why] for name, why in found.left_out_below()],
        "gone": summary.gone,
    }
    text = json.dumps(told, ensure_ascii=False, indent=1) + "\n"
    content = text.encode("utf-8", "replace")
    if store.storage.read(FACTS_FILE) != content:
        store.storage.write(FACTS_FILE, content)


def facts_in(store: Store) -> FleetFacts:
    """The facts of the last batch; bare ones where the file is not there or is damaged."""
    try:
        raw = read_json(store.storage.read(FACTS_FILE) or b"{}")
    except StoreError:
        raw = {}
    left_out, gone = raw.get("left_out"), raw.get("gone")
    return FleetFacts(
        folder=str(raw.get("folder", "")),
        store=masked(store.place),
        version=str(raw.get("version", "")),
        created=datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC"),
        false_alarm_rate=CHANCE,
        trend_false_alarm_rate=DRIFT_CHANCE,
        left_out=len(left_out) if isinstance(left_out, list) else 0,
        left_out_named=_pairs(left_out),
        gone=gone if isinstance(gone, int) else 0,
    )


def _pairs(raw: object) -> tuple[tuple[str, str], ...]:
    """What was left out, as it was kept; nothing of what is damaged."""
    rows = raw if isinstance(raw, list) else []
    return tuple((str(row[0]), str(row[1])) for row in rows if isinstance(row, list) and len(row) == 2)


def led_back(drives: pl.DataFrame, place: str, out: Path) -> pl.DataFrame:
    """The drives with links to their reports as they are seen from another folder. place: the store's."""
    import polars as pl

    back = place if is_url(place) else os.path.relpath(place, out).replace(os.sep, "/")
    led = pl.lit(f"{masked(back).rstrip('/')}/") + pl.col("report")
    return drives.with_columns(led.alias("report"))


def put_fleet_report(store: Store, formats: Sequence[str], out: Path | None = None) -> list[str]:
    """Make the fleet's report from the store alone and put it there, or into a folder; its places.

    In another folder the links to the drives' reports lead back to the store. Raises StoreError, ReportError.
    """
    if not formats:
        return []
    tables = {name: store.read_table(name) for name in TABLES}
    if out is not None:
        tables["drives"] = led_back(tables["drives"], store.place, out)
    pages = fleet_pages(tables, facts_in(store), formats)
    written = []
    if out is not None:
        make_folder(out)
    for name, content in pages.items():
        if out is not None:
            write_whole(out / name, content)
            written.append(str(out / name))
        else:
            if store.storage.read(name) != content:
                store.storage.write(name, content)
            written.append(store.storage.at(name))
    return written
