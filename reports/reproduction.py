"""A paper's tables and claims beside ours, as the report's page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pipelines.reproduce.base import (
    CRAMER_RAO,
    Agreement,
    Claim,
    ReproducedTable,
    Reproduction,
    StudyRow,
    TargetMet,
)
from pipelines.reproduce.base import Cell as TableCell
from pipelines.reproduce.base import Column as TableColumn
from pipelines.results import Scatter, Trace
from reports.blocks import (
    Block,
    Bullets,
    Cell,
    Column,
    Document,
    Fact,
    Heading,
    Item,
    Plot,
    Section,
    Table,
    Tone,
)
from reports.figures.fits import TracePanel, draw_lines
from reports.figures.grid import panels
from reports.figures.scatters import draw_scatter_panel
from reports.figures.series import make_series, unit_of
from reports.figures.style import styled
from reports.text import DASH, clean, number, sentence

if TYPE_CHECKING:
    from matplotlib.axes import Axes

NO_GAPS = np.zeros((0, 2))
TONES: dict[Agreement, Tone] = {"agrees": "good", "differs": "warn", "not shown": "quiet"}
LINES_A_PANEL = 6


def figures(value: TableCell, digits: int) -> str:
    """A cell's text: numbers with the column's digits, a dash where there is nothing."""
    if value is None:
        return DASH
    return clean(value, 300) if isinstance(value, str) else number(value, digits)


def _digits(unit_std: float) -> int:
    """Digits after the point that show two figures of a spread."""
    if not np.isfinite(unit_std) or unit_std <= 0:
        return 3
    return int(max(0, 1 - np.floor(np.log10(unit_std))))


def study_cells(row: StudyRow) -> tuple[str, ...]:
    """Method, parameter, truth, bias, RMSE, bound, ratio and coverage as text."""
    digits = _digits(row.bound if row.bound else row.rmse)
    unit = "" if row.unit in ("", "1") else f" {row.unit}"
    return (
        row.method,
        row.parameter,
        f"{number(row.truth, digits)}{unit}",
        number(row.bias, digits),
        number(row.rmse, digits),
        DASH if row.bound is None else number(row.bound, digits),
        ratio_text(row),
        DASH if row.coverage is None else number(row.coverage, 2),
    )


STUDY_HEADS = ("Method", "Parameter", "Truth", "Bias", "RMSE", "Bound", "RMSE/bound", "Coverage of 95 %")


MET_TONES: dict[TargetMet, Tone] = {"kept": "good", "open": "quiet", "missed": "warn"}


def target_words(row: StudyRow) -> str:
    """What is said of a target that is not kept; empty for one that is."""
    if row.target_met == "missed":
        return "target missed."
    if row.target_met == "open":
        return (
            f"not told by {row.runs} seeds: a method that keeps {row.target:g} may come out here by chance."
        )
    return ""


def ratio_text(row: StudyRow) -> str:
    """RMSE over the bound, beside a target with its sampling error."""
    if row.ratio is None:
        return DASH
    if row.target is None or row.ratio_std is None:
        return number(row.ratio, 2)
    return f"{number(row.ratio, 2)} ± {number(row.ratio_std, 2)} (≤ {row.target:g})"


def yardsticks(rows: Sequence[StudyRow]) -> str:
    """What the bounds of these rows are, in words."""
    used = dict.fromkeys(row.yardstick for row in rows if row.bound is not None)
    return " or ".join(used) or CRAMER_RAO


def study_table(rows: Sequence[StudyRow]) -> Table:
    """One table a set-up's rows; ratios beyond their target are marked."""
    columns = (
        Column(STUDY_HEADS[0], weight=2.4),
        Column(STUDY_HEADS[1], weight=1.8),
        *(Column(head, "right", 1.0) for head in STUDY_HEADS[2:]),
    )
    body = []
    for row in rows:
        texts = study_cells(row)
        tone: Tone = "plain" if row.target_met is None else MET_TONES[row.target_met]
        cells = [Cell(clean(text, 120)) for text in texts]
        cells[0] = Cell(clean(row.method, 120), sub=clean(f"{sentence(target_words(row))} {row.remark}", 300))
        if tone != "plain":
            cells[6] = Cell(texts[6], kind="badge", tone=tone)
        body.append(tuple(cells))
    runs = sorted({row.runs for row in rows})
    count = f"{runs[0]}" if len(runs) == 1 else f"{runs[0]} to {runs[-1]}"
    scatter = (
        " Behind ±: how far a ratio of so many seeds scatters." if any(r.target_met for r in rows) else ""
    )
    note = f"{count} noise seeds. Bias and RMSE of estimate minus truth; bound: {yardsticks(rows)}.{scatter}"
    return Table(columns, tuple(body), note=note)


def claim_table(claims: Sequence[Claim]) -> Table:
    """What the paper says, what ours and the companion give."""
    rows = []
    for claim in claims:
        rows.append(
            (
                Cell(clean(claim.published, 300), sub=clean(claim.place, 80)),
                Cell(clean(claim.ours, 300), sub=clean(claim.remark, 400)),
                Cell(clean(claim.companion, 200) or DASH),
                Cell(claim.agreement, kind="badge", tone=TONES[claim.agreement]),
            )
        )
    columns = (
        Column("Published", weight=2.2),
        Column("Ours", weight=2.6),
        Column("Companion", weight=1.6),
        Column("", weight=0),
    )
    return Table(columns, tuple(rows))


def heading_of(column: TableColumn) -> str:
    """A column's head with its unit."""
    return f"{column.heading}, {column.unit}" if column.unit else column.heading


def table_block(table: ReproducedTable) -> tuple[Block, ...]:
    """A published table beside ours, with its remark."""
    columns = tuple(
        Column(heading_of(column), "left" if place == 0 else "right", 1.8 if place == 0 else 1.0)
        for place, column in enumerate(table.columns)
    )
    rows = tuple(
        tuple(Cell(figures(value, column.digits)) for value, column in zip(row, table.columns, strict=True))
        for row in table.rows
    )
    title = f"{table.place}: {table.title}" if table.place else table.title
    return Heading(clean(title, 160)), Table(
        columns, rows, note=sentence(table.remark) if table.remark else ""
    )


def _trace_panels(traces: Sequence[Trace]) -> list[TracePanel]:
    found = []
    for trace in traces:
        by_unit: dict[str, list[tuple[str, np.ndarray[tuple[int], np.dtype[np.float64]]]]] = {}
        for column, values in trace.columns.items():
            by_unit.setdefault(unit_of(column, trace.units.get(column)), []).append((column, values))
        for unit, columns in by_unit.items():
            lines = tuple(
                make_series(name.replace("_", " "), unit, trace.time_s, values)
                for name, values in columns[:LINES_A_PANEL]
            )
            found.append(TracePanel(clean(trace.name, 100), lines[0].unit, lines, sentence(trace.note)))
    return found


def _draw_trace(axes: Axes, panel: TracePanel) -> None:
    # runs last differently long: each panel has its own time
    ends = [float(line.time_s[-1]) for line in panel.lines if line.time_s.size]
    draw_lines(axes, panel, NO_GAPS, max(ends, default=0.0))
    axes.set_xlabel("time, s")


def trace_plot(paper: str, traces: Sequence[Trace]) -> Plot | None:
    """The paper's figures over time, ours."""
    found = _trace_panels(traces)
    if not found:
        return None
    with styled():
        svgs = panels(
            f"{paper}-traces",
            "Estimates over time",
            found,
            _draw_trace,
            across=1,
            rows_a_piece=1,
            row_height=1.6,
            shared_x=None,
        )
    notes = " ".join(dict.fromkeys(panel.note for panel in found if panel.note))
    return Plot(f"{paper}-traces", "Over time", svgs, clean(notes, 2000), alt="Estimates over time")


def scatter_plot(paper: str, scatters: Sequence[Scatter]) -> Plot | None:
    """Relations between two quantities."""
    if not scatters:
        return None
    with styled():
        svgs = panels(
            f"{paper}-scatters",
            "Relations",
            list(scatters),
            draw_scatter_panel,
            rows_a_piece=1,
            row_height=2.2,
            shared_x=None,
        )
    notes = " ".join(dict.fromkeys(sentence(s.note) for s in scatters if s.note))
    return Plot(
        f"{paper}-scatters", "Relations", svgs, clean(notes, 2000), alt="Relations between two quantities"
    )


def by_setup(rows: Sequence[StudyRow]) -> dict[str, list[StudyRow]]:
    """The study's rows by their set-up, in order."""
    groups: dict[str, list[StudyRow]] = {}
    for row in rows:
        groups.setdefault(row.setup, []).append(row)
    return groups


def summary(reproduction: Reproduction) -> str:
    """How many claims agree, and how many targets are kept, in one sentence each."""
    agree = sum(claim.agreement == "agrees" for claim in reproduction.claims)
    parts = [f"{agree} of {len(reproduction.claims)} claims of the paper agree with ours."]
    judged = [row.target_met for row in reproduction.study if row.target_met is not None]
    if judged:
        still = judged.count("open")
        untold = f", {still} not told by so few seeds" if still else ""
        parts.append(
            f"{judged.count('kept')} of {len(judged)} targets against the {yardsticks(reproduction.study)} are kept{untold}."
        )
    return " ".join(parts)


def build_reproduction(reproduction: Reproduction, version: str) -> Document:
    """The page of one paper: claims first, then the study against the bound, the tables, the figures, the set-up."""
    sections: list[Section] = []
    if reproduction.study:
        blocks: list[Block] = []
        for setup, rows in by_setup(reproduction.study).items():
            blocks += [Heading(clean(setup, 200)), study_table(rows)]
        title = f"Against the {yardsticks(reproduction.study)}"
        sections.append(Section("study", title, "Bound", tuple(blocks)))
    if reproduction.tables:
        made = tuple(block for table in reproduction.tables for block in table_block(table))
        sections.append(Section("tables", "Published tables beside ours", "Tables", made))
    plots = (
        trace_plot(reproduction.paper, reproduction.traces),
        scatter_plot(reproduction.paper, reproduction.scatters),
    )
    drawn = tuple(plot for plot in plots if plot is not None)
    if drawn:
        sections.append(Section("figures", "Figures", "Figures", drawn))
    words = (*reproduction.setup, *reproduction.notes)
    items = tuple(Item(sentence(text, 1200)) for text in words)
    sections.append(Section("setup", "How it was done", "Set-up", (Bullets(items),)))
    return Document(
        title=clean(reproduction.title, 160),
        subtitle=f"cogest reproduce {reproduction.paper}",
        summary=summary(reproduction),
        verdict=claim_table(reproduction.claims),
        cards=(),
        lead=(),
        sections=tuple(sections),
        footer=clean(f"cogest {version} · {reproduction.citation}", 240),
        version=clean(version, 40),
        facts=(Fact("Source", clean(reproduction.citation, 300)),),
        verdict_title="What the paper claims, and what came out",
        claims=True,
    )
