"""The chapter on tyre normal forces: what each wheel carried at rest and at least, and how good the map is on this drive."""

from __future__ import annotations

from parsers.signals import WHEELS
from pipelines.drive_results import DriveResults
from pipelines.results import Estimate
from pipelines.tire_forces import forces_of
from reports.blocks import Block, Cell, Column, Paragraph, Table
from reports.sections.contract import Plots
from reports.sections.values import interval_cell, value_text
from reports.text import DASH, number, percent, seconds, sentence, with_unit

INTRO = (
    "What the suspension map of this vehicle, learned from a drive with measuring wheels, makes of this drive's struts or deflections. "
    "The file tire_normal_forces.parquet holds the forces and their intervals at every instant."
)


def _force(figures: Estimate, name: str) -> str:
    value = figures.diagnostics.get(name)
    return DASH if value is None else with_unit(number(value, 0), "N")


def _row(estimate: Estimate, wheel: str) -> tuple[Cell, ...]:
    told, get = estimate.parameters.get(f"tire_normal_force_{wheel}_n"), estimate.diagnostics.get
    at, inside = get(f"least_force_time_{wheel}_s"), get(f"inside_interval_{wheel}")
    between = f"{_force(estimate, f'least_force_low_{wheel}_n')} to {_force(estimate, f'least_force_high_{wheel}_n')}"
    peak_at = get(f"peak_error_time_{wheel}_s")
    return (
        Cell(wheel),
        Cell(DASH if told is None else value_text(told)),
        Cell(DASH) if told is None else interval_cell(told),
        Cell(_force(estimate, f"least_force_{wheel}_n"), sub=between),
        Cell(DASH if at is None else seconds(at)),
        Cell(_force(estimate, f"rms_error_{wheel}_n")),
        Cell(
            _force(estimate, f"peak_error_{wheel}_n"), sub="" if peak_at is None else f"at {seconds(peak_at)}"
        ),
        Cell(DASH if inside is None else percent(inside)),
    )


HEAD = (
    Column("Wheel", weight=0),
    Column("At rest", "right", 1),
    Column("95 % interval", "right", 1),
    Column("Least on the drive", "right", 1.4),
    Column("When", "right", 0),
    Column("RMS error", "right", 1),
    Column("Peak error", "right", 1),
    Column("Inside 95 %", "right", 1),
)


def build(results: DriveResults, plots: Plots) -> tuple[Block, ...]:
    """Table, words and figure; nothing at all where no map gave forces."""
    estimate = next((e for e in results.estimates if forces_of(e) is not None), None)
    if estimate is None:
        return ()
    table = Table(
        HEAD,
        tuple(_row(estimate, wheel) for wheel in WHEELS),
        note="Errors against the log's own measuring wheels, where it has them.",
    )
    return (Paragraph(sentence(estimate.reason, 800)), table, *plots.get("tire_forces", ()))
