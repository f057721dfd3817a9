"""A store's tables as text for the terminal: per vehicle its drives with values, intervals and failures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import polars as pl

from pipelines.results import Identification, ParameterEstimate
from pipelines.starts import is_local
from reports.layout import table, terminal_width
from reports.sections.values import STATUS_WORDS, has_result, interval_text, spread_value_text
from reports.text import DASH, NARROW, NO_BREAK, clean, count, percent, spec_of, with_unit

USUAL = ("cg_height_m", "mass_kg")
"""Parameters that are shown where none was asked for."""
_IDENTIFIED: dict[str, Identification] = {"identified": "identified", "weak": "weak"}

Row = Mapping[str, Any]


def _spaced(text: str) -> str:
    return text.replace(NARROW, " ").replace(NO_BREAK, " ")


def _estimate(row: Row) -> ParameterEstimate:
    status = _IDENTIFIED.get(row["status"], "not_identifiable")
    return ParameterEstimate(
        row["parameter"], row["value"], row["std"], row["low"], row["high"], status, row["reason"] or ""
    )


def _figures(row: Row | None, unit: str) -> str:
    """Value ± standard deviation (95 % interval), or —."""
    if row is None:
        return DASH
    estimate = _estimate(row)
    if not has_result(estimate):
        return DASH
    interval = interval_text(estimate)
    shown = with_unit(spread_value_text(estimate), unit)
    return _spaced(shown if interval == DASH else f"{shown} ({interval})")


def _chance(share: float | None) -> str:
    return "< 0.1 %" if share is not None and share < 1e-3 else _spaced(percent(share))


def _start(text: str | None) -> str:
    """To the minute; "local" where the log does not say of which time zone."""
    return DASH if not text else text[:16].replace("T", " ") + (" local" if is_local(text) else "")


def _ending(row: Row) -> str:
    """How the drive ended, with what must be known of it."""
    words = [row["status"] if row["status"] == "done" else f"{row['status']}: {clean(row['reason'] or '')}"]
    if row["gone"]:
        words.append("its logs are no longer in the folder")
    return "; ".join(words)


def _best(parameters: pl.DataFrame, names: Sequence[str]) -> dict[tuple[str, str], Row]:
    """(drive, parameter) -> its row: with all drives of its vehicle joined where there is one, else its own."""
    found = parameters.filter(pl.col("parameter").is_in(list(names)))
    order = {"drive": 0, "fleet": 1}
    rows = sorted(found.iter_rows(named=True), key=lambda row: order.get(row["source"], 0))
    return {(row["drive_id"], row["parameter"]): row for row in rows}


def _heads(names: Sequence[str]) -> list[str]:
    return [clean(spec_of(name).title, 40) for name in names]


def _summary(drives: pl.DataFrame, place: str) -> str:
    failed = drives.filter(pl.col("status") != "done").height
    gone = drives.filter(pl.col("gone").fill_null(False)).height
    told = [
        f"{count(drives.height, 'drive')} of {count(drives['vehicle_id'].n_unique(), 'vehicle')}",
        f"{drives.height - failed} done",
        *([f"{failed} failed"] if failed else []),
        *([f"{gone} of logs that are gone"] if gone else []),
    ]
    return _spaced(f"{clean(place)}: {', '.join(told)}")


def overview_text(
    drives: pl.DataFrame, parameters: pl.DataFrame, names: Sequence[str] = (), place: str = "", width: int = 0
) -> str:
    """Per vehicle its drives with the parameters of these names, and how each ended.

    drives, parameters: as in `pipelines.fleet.tables`. place: the store, for the first line. width: 0 = the terminal's.
    """
    names = tuple(names) or USUAL
    width = width or terminal_width()
    best = _best(parameters, names)
    lines = [_summary(drives, place)]
    if any(row["source"] == "fleet" for row in best.values()):
        lines.append(
            "values: with all drives of the vehicle joined; ± one standard deviation (95 % interval)"
        )
    for _, own in drives.group_by("vehicle_id", maintain_order=True):
        rows = list(own.iter_rows(named=True))
        title = clean(rows[0]["vehicle_id"], 80)
        if rows[0]["vehicle_name"]:
            title += f" ({clean(rows[0]['vehicle_name'], 80)})"
        cells = [["Drive", "Start (UTC)", *_heads(names), "Ended"]]
        for row in rows:
            figures = [_figures(best.get((row["drive_id"], name)), spec_of(name).unit) for name in names]
            cells.append([clean(row["drive"], 200), _start(row["start_utc"]), *figures, _ending(row)])
        lines += ["", f"Vehicle {title}", *table(cells, width, names=(0,))]
    return "\n".join(lines)


def _parameter_cells(row: Row) -> list[str]:
    spec = spec_of(row["parameter"])
    return [
        row["drive_id"], _start(row["start_utc"]), clean(spec.title, 60), row["source"] or "",
        _figures(row, spec.unit), f"{_status(row)}: {clean(row['reason'] or '')}",
    ]  # fmt: skip


def _status(row: Row) -> str:
    return STATUS_WORDS.get(row["status"], clean(row["status"] or DASH))


def _vehicle_cells(row: Row) -> list[str]:
    drives = count(row["drives"] or 0, "drive")
    title = clean(row["title"] or row["parameter"], 60)
    return [
        row["vehicle_id"], title, _figures(row, row["unit"] or ""), drives, f"{_status(row)}: {clean(row['reason'] or '')}"
    ]  # fmt: skip


def _change_cells(row: Row) -> list[str]:
    found = "yes" if row["detected"] else "no"
    return [
        row["vehicle_id"], row["drive_id"], _start(row["start_utc"]), found, _chance(row["probability"]), clean(row["text"] or "")
    ]  # fmt: skip


def _trend_cells(row: Row) -> list[str]:
    estimate = ParameterEstimate(
        row["parameter"], row["per_year"], row["std"], row["low"], row["high"], "identified", ""
    )
    figures = with_unit(spread_value_text(estimate), f"{row['unit']} a year" if row["unit"] else "")
    title = clean(row["title"] or row["parameter"], 60)
    return [row["vehicle_id"], title, figures, "yes" if row["detected"] else "no", clean(row["text"] or "")]


def _outlier_cells(row: Row) -> list[str]:
    score = DASH if row["score"] is None else f"{row['score']:.1f}"
    name = clean(row["vehicle_name"] or "", 60)
    return [
        str(row["rank"]),
        row["vehicle_id"],
        name,
        score,
        _chance(row["probability"]),
        clean(row["text"] or ""),
    ]


_TABLES: dict[str, tuple[list[str], Any]] = {
    "parameters": (["Drive", "Start (UTC)", "Parameter", "From", "Value", "Status"], _parameter_cells),
    "vehicles": (["Vehicle", "Parameter", "Value", "From", "Status"], _vehicle_cells),
    "load_changes": (["Vehicle", "Drive", "Start (UTC)", "Changed", "By chance", "What"], _change_cells),
    "trends": (["Vehicle", "Part", "Change", "Found", "What"], _trend_cells),
    "outliers": (["Rank", "Vehicle", "Name", "Score", "By chance", "What"], _outlier_cells),
}
"""Table -> its head, and one row's cells. The drives are told by `overview_text`."""


def table_text(name: str, rows: pl.DataFrame, width: int = 0) -> str:
    """One of the store's tables but the drives, a row a line. width: 0 = the terminal's."""
    head, cells_of = _TABLES[name]
    if rows.is_empty():
        return "no rows"
    cells = [[_spaced(clean(cell)) for cell in cells_of(row)] for row in rows.iter_rows(named=True)]
    return "\n".join(table([head, *cells], width or terminal_width(), names=(0,)))
