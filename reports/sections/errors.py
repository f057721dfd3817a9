"""Errors against the vehicle file's [reference], for the verdict and for every method."""

from __future__ import annotations

from pipelines.drive_results import DriveResults
from pipelines.results import ParameterEstimate
from reports.blocks import Block, Cell, Column, Folded, Table
from reports.sections.contract import Plots
from reports.sections.values import decimals_of, has_result, interval_text
from reports.sections.verdict import ordered
from reports.text import DASH, MINUS, clean, number, spec_of, with_unit

INTRO = "The reference is the vehicle file's [reference]: cogest reads it for this table only, never for an estimate."

COLUMNS = (
    Column("Parameter", weight=2),
    Column("Method", weight=1.2),
    Column("Value", "right", 0),
    Column("Reference", "right", 0),
    Column("Error", "right", 0),
    Column("Error, %", "right", 0),
    Column("95 % interval", "right", 0),
    Column("Reference inside?", "left", 0),
    Column("Error, std", "right", 0),
)

FROM = 1
"""The column that says whose value it is: not needed where all are the verdict's."""


def _signed(value: float | None, decimals: int) -> str:
    text = number(value, decimals)
    return text if text.startswith((MINUS, DASH)) else f"+{text}"


def _row(estimate: ParameterEstimate, reference: float, source: str) -> tuple[Cell, ...]:
    spec = spec_of(estimate.name)
    decimals = max(decimals_of(estimate), 0)
    head = (Cell(spec.title), Cell(clean(source, 60), tone="quiet"))
    truth = Cell(with_unit(number(reference, max(decimals, spec.digits)), spec.unit))
    if estimate.value is None or not has_result(estimate):
        none = Cell(DASH, tone="quiet")
        return (*head, none, truth, none, none, none, Cell("no value", kind="badge", tone="quiet"), none)
    error = estimate.value - reference
    inside = (
        estimate.low is not None and estimate.high is not None and estimate.low <= reference <= estimate.high
    )
    known = estimate.low is not None and estimate.high is not None
    verdict = (
        Cell("inside" if inside else "outside", kind="badge", tone="good" if inside else "bad")
        if known
        else Cell(DASH)
    )
    return (
        *head,
        Cell(with_unit(number(estimate.value, decimals), spec.unit)),
        truth,
        Cell(_signed(error, decimals)),
        Cell(_signed(100 * error / abs(reference), 1) if reference else DASH),
        Cell(interval_text(estimate)),
        verdict,
        Cell(_signed(error / estimate.std, 1) if estimate.std else DASH),
    )


def build(results: DriveResults, plots: Plots) -> tuple[Block, ...]:
    """One row a parameter with a reference, and behind a fold every method that estimates it; nothing without a reference."""
    rows: list[tuple[Cell, ...]] = []
    of_methods: list[tuple[Cell, ...]] = []
    for estimate in ordered(results.verdict.values()):
        if estimate.reference is None:
            continue
        rows.append(_row(estimate, estimate.reference, "verdict"))
        for method in results.estimates:
            other = method.parameters.get(estimate.name)
            if other is not None and has_result(other):
                of_methods.append(_row(other, estimate.reference, method.estimator))
    if not rows:
        return ()
    table = Table(
        tuple(c for i, c in enumerate(COLUMNS) if i != FROM),
        tuple(tuple(c for i, c in enumerate(row) if i != FROM) for row in rows),
        dense=True,
    )
    if not of_methods:
        return (table,)
    single = Table(COLUMNS, tuple(of_methods), dense=True)
    return (table, Folded("Every single method against the reference", (single,)))
