"""The fleet report as PDF: the same findings and tables as on the screen, the vehicles and drives that matter most."""

from __future__ import annotations

from collections import Counter

import numpy as np

from reports.blocks import Block, Cell, Column, Document, Fact, Facts, Paragraph, Section, Table, filled
from reports.fleet import overview
from reports.fleet.distributions import best_of, plots
from reports.fleet.findings import findings_of
from reports.fleet.records import WIDTH_95, Answers, FleetView, Row, VehicleView
from reports.fleet.sections import MOST_PRINTED, shared_sections
from reports.fleet.vehicle_figure import vehicle_plot
from reports.fleet.view import finite, title_of
from reports.fleet.words import date_text, spread_text
from reports.sections.values import STATUS_TONES, STATUS_WORDS
from reports.text import DASH, clean, count, number, seconds, spec_of

MOST_VEHICLES = 10
"""Vehicles with a page of their own."""

MOST_LISTED = 100
"""Vehicles in the overview."""

MOST_NOTES = 5
"""Notes of a vehicle."""

MOST_DRIVES = 150
"""Drives in the list; a larger fleet's list is on the screen and in the store's table."""


def importance(view: FleetView, vehicle: VehicleView) -> float:
    """How much a vehicle asks for attention: near rollover, outlying, drifts, load changes, failures."""
    near = sum(view.drives[d].near for d in vehicle.drives)
    return (
        1000.0 * near
        + 300.0 * vehicle.outlying
        + 100.0 * vehicle.drifts
        + 5.0 * vehicle.changed
        + vehicle.failed
    )


def by_importance(view: FleetView) -> list[VehicleView]:
    """Vehicles with drives, those that ask for attention first."""
    return sorted((v for v in view.vehicles if v.drives), key=lambda v: (-importance(view, v), v.label))


def _findings(view: FleetView) -> Table:
    rows = tuple((Cell(f.badge, kind="badge", tone=f.tone), Cell(f.text)) for f in findings_of(view))
    return Table((Column("", weight=0), Column("", weight=1)), rows)


def _range(values: list[float], digits: int) -> Cell:
    if not values:
        return Cell(DASH)
    low, high = number(min(values), digits), number(max(values), digits)
    return Cell(number(float(np.median(values)), digits), sub="" if low == high else f"{low} to {high}")


def _overview(view: FleetView, vehicles: list[VehicleView]) -> tuple[Block, ...]:
    heights, masses = best_of(view, "cg_height_m"), best_of(view, "mass_kg")
    rows = []
    for v in vehicles[:MOST_LISTED]:
        drives = [view.drives[d] for d in v.drives]
        margins = [d.margin_g for d in drives if d.margin_g is not None]
        factors = [d.factor for d in drives if d.factor is not None]
        rows.append(
            (
                Cell(v.label),
                Cell(number(len(drives), 0), sub=f"{v.failed} failed" if v.failed else ""),
                _range([float(heights[d]) for d in v.drives if np.isfinite(heights[d])], spec_of("cg_height_m").digits),
                _range([float(masses[d]) for d in v.drives if np.isfinite(masses[d])], 0),
                Cell(number(min(factors), 2) if factors else DASH),
                Cell(number(min(margins), 2) if margins else DASH),
                Cell(number(v.changed, 0) if v.changes else DASH),
                Cell(number(v.drifts, 0) if v.trends else DASH),
                Cell("outlier", kind="badge", tone="warn") if v.outlying else Cell(DASH),
            )
        )  # fmt: skip
    columns = (
        Column("Vehicle", weight=1.5), Column("Drives", "right", 0), Column("CG height, m", "right", 0), Column("Mass, kg", "right", 0),
        Column("Lowest SSF", "right", 0), Column("Least margin, g", "right", 0), Column("Load changes", "right", 0), Column("Drifts", "right", 0), Column("", weight=0),
    )  # fmt: skip
    left = len(vehicles) - len(rows)
    note = "Median of its drives, and the range." + (
        f" {count(left, 'further vehicle')}: in the HTML page." if left else ""
    )
    return (Table(columns, tuple(rows), note=note, dense=True),)


def _told(vehicle: VehicleView) -> list[Row]:
    """What its drives tell of the vehicle itself."""
    return [row for row in vehicle.shared if row["status"] in ("identified", "weak")]


def _shared(vehicle: VehicleView) -> Table:
    trends = {row["parameter"]: row for row in vehicle.trends}
    rows = []
    for row in _told(vehicle):
        status = str(row["status"])
        unit, std = clean(row["unit"] or "", 20), row["std"]
        single, spread = finite(row["single_std"]), finite(std)
        trend = trends.get(row["parameter"])
        sharper = f"{single / spread:.1f}×" if single and spread else DASH
        rows.append(
            (
                Cell(title_of(row)),
                Cell(spread_text(row["value"], std, unit)),
                Cell(f"{spread_text(row['low'], None, '', std)} to {spread_text(row['high'], None, '', std)}"),
                Cell(STATUS_WORDS.get(status, "nothing told"), kind="badge", tone=STATUS_TONES.get(status, "quiet")),
                Cell(spread_text(row["prior"], row["prior_std"], unit), tone="quiet"),
                Cell(sharper),
                Cell(DASH if trend is None else spread_text(trend["per_year"], trend["std"]), sub="drift" if trend and trend["detected"] else ""),
            )
        )  # fmt: skip
    columns = (
        Column("What its drives share", weight=1.6), Column("Value ± std", "right", 0), Column("95 % interval", "right", 0), Column("", weight=0),
        Column("Known before", "right", 0), Column("Sharper", "right", 0), Column("Change a year", "right", 0),
    )  # fmt: skip
    return filled(Table(columns, tuple(rows), dense=True))


def _notes(view: FleetView, vehicle: VehicleView) -> tuple[str, ...]:
    """What is said of all drives first: it is about the vehicle."""
    said = Counter(note for d in vehicle.drives for note in view.drives[d].notes)
    return (*vehicle.notes, *(note for note, _ in said.most_common(MOST_NOTES)))[:MOST_NOTES]


def _vehicle(view: FleetView, vehicle: VehicleView, k: int) -> list[Block]:
    drives = len(vehicle.drives)
    title = f"{vehicle.label}: {count(drives - vehicle.failed, 'drive')} analysed"
    if vehicle.failed:
        title += f", {vehicle.failed} failed"
    out: list[Block] = [vehicle_plot(view, vehicle, f"vehicle{k}", title)]
    told = _told(vehicle)
    if told:
        out.append(_shared(vehicle))
    said = {
        "Drifts": [f"{title_of(t)}: {clean(t['text'] or '', 300)}" for t in vehicle.trends if t["detected"]],
        "Cannot be told": [title_of(row) for row in vehicle.shared if row not in told],
        "Notes": list(_notes(view, vehicle)),
    }
    facts = tuple(Fact(label, f"{'; '.join(texts)}.") for label, texts in said.items() if texts)
    if facts:
        out.append(Facts(facts, prose=True))
    return out


def _figure(answers: tuple[Answers | None, ...], drive: int, digits: int) -> Cell:
    for source in answers:
        if source is None or not source.status[drive]:
            continue
        if not np.isfinite(source.value[drive]):
            return Cell("not identifiable", tone="quiet")
        spread = (source.high[drive] - source.low[drive]) / WIDTH_95
        text = number(float(source.value[drive]), digits)
        return Cell(f"{text} ± {number(float(spread), digits)}" if np.isfinite(spread) else text)
    return Cell(DASH)


def _drives(view: FleetView) -> tuple[Block, ...]:
    """All drives of a small fleet; of a large one those near rollover, failed or with another load."""
    every = range(len(view.drives))
    shown, intro = list(every), ""
    if len(view.drives) > MOST_DRIVES:
        shown = [
            k
            for k in every
            if view.drives[k].near or view.drives[k].changed or view.drives[k].status != "done"
        ]
        shown.sort(key=lambda k: (not view.drives[k].near, view.drives[k].status == "done", k))
        shown = sorted(shown[:MOST_DRIVES])
        intro = (
            f"{number(len(shown), 0)} of {count(len(view.drives), 'drive')}: those near rollover, failed, or with another load than before. "
            "All are in the HTML page and in the store's drives.parquet."
        )
    rows = []
    for k in shown:
        d = view.drives[k]
        marks = (
            "near rollover" if d.near else "",
            "load changed" if d.changed else "",
            "does not fit" if d.apart == "misfit" else "",
            "copy" if d.apart == "copy" else "",
            "log gone" if d.gone else "",
        )
        done = d.status == "done"
        rows.append(
            (
                Cell(view.vehicles[d.vehicle].label),
                Cell(d.name),
                Cell(date_text(d.start, time=True, local=d.local)),
                Cell(seconds(d.duration_s)),
                _figure((view.joined.get("cg_height_m"), view.own.get("cg_height_m")), k, 3),
                _figure((view.joined.get("mass_kg"), view.own.get("mass_kg")), k, 0),
                Cell(number(d.factor, 2)),
                Cell(number(d.margin_g, 2)),
                Cell("failed", kind="badge", tone="bad", sub=clean(d.reason, 120)) if not done else Cell(", ".join(m for m in marks if m)),
            )
        )  # fmt: skip
    columns = (
        Column("Vehicle", weight=1.1), Column("Drive", weight=1.7), Column("Start (UTC)", weight=0), Column("Duration", "right", 0), Column("CG height, m", "right", 0),
        Column("Mass, kg", "right", 0), Column("SSF", "right", 0), Column("Margin, g", "right", 0), Column("", weight=2),
    )  # fmt: skip
    blocks: list[Block] = [Paragraph(intro, "quiet")] if intro else []
    return (*blocks, filled(Table(columns, tuple(rows), note="± is one standard deviation.", dense=True)))


def document_of(view: FleetView) -> Document:
    """The report as a document for `reports.pdf.pdf_of`."""
    vehicles = by_importance(view)
    sections: list[Section] = []
    if vehicles:
        sections.append(Section("vehicles", "Vehicles", "Vehicles", _overview(view, vehicles)))
    shared = shared_sections(view, MOST_PRINTED)
    sections += shared[:-1]
    chosen = vehicles[:MOST_VEHICLES]
    pages: list[Block] = [block for k, v in enumerate(chosen) for block in _vehicle(view, v, k)]
    if pages:
        left = len(vehicles) - len(chosen)
        intro = (
            f"The {len(chosen)} that ask for attention most; {count(left, 'other')} in the HTML page."
            if left
            else ""
        )
        sections.append(
            Section("each-vehicle", "Each vehicle over time", "Each vehicle", tuple(pages), intro)
        )
    if view.drives:
        sections.append(Section("drives", "Drives", "Drives", _drives(view)))
    sections.append(shared[-1])
    return Document(
        title=overview.title(view),
        subtitle=overview.dates(view),
        summary=overview.summary(view),
        verdict=_findings(view),
        cards=(),
        lead=plots(view),
        sections=tuple(sections),
        footer=overview.footer(view),
        version=clean(view.facts.version, 40),
        facts=overview.facts_line(view),
        verdict_title="Findings",
        claims=True,
    )
