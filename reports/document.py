"""From results to a `Document`: the one content that every printed form of the report shares."""

from __future__ import annotations

from datetime import datetime, timedelta
from pathlib import PurePath

from pipelines.drive_results import DriveResults
from reports.blocks import Card, Document, Fact, Plot, Section
from reports.figures.drawing import FigureSpec, Missing
from reports.figures.registry import FIGURES
from reports.method_names import with_titles
from reports.reduce import reduce_results
from reports.sections import limits, quality, rollover, taught, verdict
from reports.sections.registry import SECTIONS
from reports.text import clean, seconds


def draw_plot(spec: FigureSpec, results: DriveResults) -> Plot:
    """Draw one figure; one that cannot be drawn says why. A fault in one figure does not cost the report."""
    try:
        drawn = spec.draw(results)
    except (ValueError, TypeError, IndexError, KeyError, ArithmeticError, RuntimeError) as error:
        return Plot(
            spec.name, spec.title, (), missing=f"Not drawn: {clean(f'{type(error).__name__}: {error}', 200)}"
        )
    if isinstance(drawn, Missing):
        return Plot(spec.name, spec.title, (), missing=clean(drawn.reason))
    title = clean(drawn.title) or spec.title
    return Plot(spec.name, title, drawn.svgs, clean(drawn.caption), alt=clean(drawn.alt))


def build_document(results: DriveResults) -> Document:
    """Build the report's content. Draws every figure (about a second)."""
    results = with_titles(reduce_results(results))
    plots: dict[str, tuple[Plot, ...]] = {}
    for spec in FIGURES:
        plots[spec.place] = (*plots.get(spec.place, ()), draw_plot(spec, results))
    sections = []
    for section in SECTIONS:
        blocks = section.build(results, plots)
        if blocks:
            sections.append(Section(section.anchor, section.title, section.short, blocks, section.intro))
    name = log_name(results)
    cards = (
        Card("Rollover", rollover.build(results)),
        Card("What limited the result", limits.build(results)),
        Card("Signs, units and spikes", quality.checks_card(results)),
        Card("Data quality", quality.card(results)),
    )
    return Document(
        title=clean(results.vehicle_name, 120) if results.vehicle_name else f"Vehicle not described ({name})",
        subtitle=name,
        summary=verdict.summary(results),
        verdict=verdict.table(results),
        cards=cards,
        lead=plots.get("lead", ()),
        sections=tuple(sections),
        footer=clean(f"cogest {results.inputs.version} · log {results.inputs.log_sha256[:12]}", 120),
        version=clean(results.inputs.version, 40),
        facts=_facts(results),
        alerts=taught.alerts(results),
    )


def log_name(results: DriveResults) -> str:
    """The log's file name, and how many parts where there are several."""
    logs = results.inputs.logs or tuple(str(p) for p in results.record.paths)
    if not logs:
        return "no log"
    first = clean(PurePath(logs[0].replace("\\", "/")).name or logs[0], 120)
    return first if len(logs) == 1 else f"{first} and {len(logs) - 1} more"


def _moment(stamp: str) -> str:
    """An ISO 8601 stamp to the second; as it is where it is none."""
    try:
        moment = datetime.fromisoformat(stamp)
    except ValueError:
        return clean(stamp, 60)
    shown = moment.strftime("%Y-%m-%d %H:%M:%S")
    if moment.tzinfo is None:
        return f"{shown}, time zone unknown"
    return (
        f"{shown} UTC" if moment.utcoffset() == timedelta(0) else f"{shown} {moment.strftime('%z')}".strip()
    )


def _facts(results: DriveResults) -> tuple[Fact, ...]:
    record = results.record
    start = record.start_utc
    facts = [Fact("Log", log_name(results))]
    if start:
        facts.append(Fact("Driven", _moment(start)))
    facts.append(Fact("Duration", seconds(record.duration_s)))
    standing = results.standing
    if standing is not None and standing.body:
        facts.append(Fact("Body", clean(standing.body, 40)))
    return tuple(facts)
