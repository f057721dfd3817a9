"""What every method says beside the verdict: side by side as intervals, and in figures, by parameter."""

from __future__ import annotations

from pipelines.drive_results import DriveResults
from pipelines.results import Estimate, ParameterEstimate
from reports.blocks import Block, Cell, Column, Folded, Table
from reports.sections.contract import Plots
from reports.sections.values import (
    SINGLE_WHEELS,
    deviation_text,
    has_result,
    interval_cell,
    interval_text,
    status_cell,
    value_text,
)
from reports.sections.verdict import ordered
from reports.text import DASH, MINUS, clean, gist, number, sentence, spec_of

INTRO = (
    "The verdict is the answer; the methods beside it show where it comes from and how far apart single methods are. Published methods run as "
    "printed and are witnesses: they speak only where nobody else does."
)
COLUMNS = (
    Column("Parameter", weight=1.7),
    Column("Method", weight=1.7),
    Column("Value ± std", "right", 0),
    Column("95 % interval", "right", 0),
    Column("From the verdict, std", "right", 0),
    Column("Status", "left", 0),
)
REASON_COLUMNS = (
    Column("Parameter", weight=1.4),
    Column("Method", weight=1.0),
    Column("95 % interval", "right", 0),
    Column("Status", "left", 0),
    Column("Why", weight=3.4),
)


def _told(results: DriveResults, name: str) -> list[tuple[Estimate, ParameterEstimate]]:
    """Every method's answer for a parameter, published methods behind."""
    return [
        (method, method.parameters[name])
        for method in sorted(results.estimates, key=lambda e: e.witness)
        if name in method.parameters
    ]


def names_of(results: DriveResults) -> list[str]:
    """Parameters that a method gave, in the verdict's order; those that the verdict does not hold behind."""
    given = {name: p for method in results.estimates for name, p in method.parameters.items()}
    return [estimate.name for estimate in ordered(given.values())]


def _apart(told: ParameterEstimate, verdict: ParameterEstimate | None) -> str:
    """Distance from the verdict in the method's own standard deviations."""
    if (
        verdict is None
        or not has_result(verdict)
        or verdict.value is None
        or told.value is None
        or not told.std
    ):
        return DASH
    text = number((told.value - verdict.value) / told.std, 1)
    return text if text.startswith(MINUS) or text == DASH else f"+{text}"


def _method_name(method: Estimate) -> Cell:
    name = clean(method.estimator, 60)
    return Cell(f"{name} (published)" if method.witness else name, tone="quiet")


def _rows(results: DriveResults, name: str) -> list[tuple[Cell, ...]]:
    """The methods that tell a parameter, a line each; those that cannot, all in one."""
    told = _told(results, name)
    verdict = results.verdict.get(name)
    title = spec_of(name).title
    rows: list[tuple[Cell, ...]] = []
    for method, estimate in told:
        if not has_result(estimate):
            continue
        deviation = deviation_text(estimate)
        figures = (
            value_text(estimate) if deviation == DASH else f"{value_text(estimate, unit=False)} {deviation}"
        )
        rows.append(
            (
                Cell("" if rows else title), _method_name(method), Cell(figures), Cell(interval_text(estimate)),
                Cell(_apart(estimate, verdict)), status_cell(estimate),
            )
        )  # fmt: skip
    silent = [clean(method.estimator, 60) for method, estimate in told if not has_result(estimate)]
    if silent:
        none = Cell(DASH, tone="quiet")
        who = Cell(", ".join(silent), tone="quiet")
        rows.append(
            (
                Cell("" if rows else title),
                who,
                none,
                none,
                none,
                Cell("not identifiable", kind="badge", tone="quiet"),
            )
        )
    return rows


def _table(results: DriveResults, names: list[str]) -> Table | None:
    rows = [row for name in names for row in _rows(results, name)]
    return Table(COLUMNS, tuple(rows), dense=True) if rows else None


def _reasons(results: DriveResults) -> Table | None:
    rows = [
        (
            Cell(spec_of(name).title), _method_name(method), interval_cell(estimate), status_cell(estimate),
            Cell(sentence(gist(estimate.reason, 400))),
        )
        for name in names_of(results)
        for method, estimate in _told(results, name)
    ]  # fmt: skip
    return Table(REASON_COLUMNS, tuple(rows), dense=True) if rows else None


def build(results: DriveResults, plots: Plots) -> tuple[Block, ...]:
    """The chapter; nothing where no method gave anything."""
    names = names_of(results)
    wheels = [name for name in names if name.startswith(SINGLE_WHEELS)]
    vehicle = _table(results, [name for name in names if name not in wheels])
    folded = (
        ("Methods on single wheels", _table(results, wheels)),
        ("Every method's reason for its status", _reasons(results)),
    )
    if not names:
        return ()
    blocks: list[Block] = [plot for plot in plots.get("methods", ()) if plot.svgs]
    if vehicle is not None:
        blocks.append(vehicle)
    blocks += [Folded(title, (table,)) for title, table in folded if table is not None]
    return tuple(blocks)
