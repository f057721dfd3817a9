"""The verdict as a table for the terminal: plain text, at most 100 columns."""

from __future__ import annotations

import textwrap

from parsers.load import ODD_UNIT, UNUSED_DATABASE
from parsers.mapping.overlooked import SAID as OVERLOOKED
from parsers.mapping.unknown import SAID as UNRECOGNISED
from pipelines.drive_results import DriveResults
from pipelines.file_limits import OF_FILE
from reports.gap_text import LOST, gap_lines
from reports.method_names import with_titles
from reports.sections.joint_words import conflict_text, conflicts, next_line
from reports.sections.quality import LEFT_OUT
from reports.sections.values import (
    STATUS_WORDS,
    bracketed_text,
    deviation_text,
    has_result,
    interval_text,
    value_text,
)
from reports.sections.verdict import LEADING, Line, lines
from reports.text import DASH, NARROW, NO_BREAK, clean, gist, sentence, spec_of, with_unit

WIDTH = 100
MOST_REASONS = 2
MOST_LEADING = 400
"""Characters of the reason of the parameter that a reader looks for first: whole clauses of it."""
LEFT_OPEN = ("delay", "unit", "scale")
"""Faults of channels that are only reported: what a conflict that follows from one would blame on the file else."""

_STYLES = {"identified": "\x1b[32m", "weak": "\x1b[33m", "not_identifiable": "\x1b[2m"}
_RESET = "\x1b[0m"


def _spaced(text: str) -> str:
    return text.replace(NARROW, " ").replace(NO_BREAK, " ")


def _value(line: Line) -> str:
    if not has_result(line.estimate):
        return DASH
    deviation = deviation_text(line.estimate)
    figures = value_text(line.estimate, unit=False) + ("" if deviation == DASH else f" {deviation}")
    return _spaced(with_unit(figures, spec_of(line.estimate.name).unit))


def _reason(line: Line) -> list[str]:
    """The reason on one line; all of it for the parameter that a reader looks for first."""
    if line.estimate.name != LEADING:
        return [f"    {_spaced(gist(line.estimate.reason, WIDTH - 6))}"]
    return [
        f"    {piece}"
        for piece in textwrap.wrap(_spaced(gist(line.estimate.reason, MOST_LEADING)), WIDTH - 4)
    ] or [""]


LONG_PAUSE_S = 10.0
"""In all, from which on pauses of the whole drive are said."""


def _log(results: DriveResults) -> list[str]:
    """A log that is not whole, what of it is not used, and pauses of the whole drive; nothing where there is nothing of it."""
    record = results.record
    paused = sum(gap.end_s - gap.start_s for gap in record.gaps if gap.signal is None)
    lost = any(gap.signal == LOST for gap in record.gaps)
    gaps = [f"{line}." for line in gap_lines(record, signals=False)] if lost or paused > LONG_PAUSE_S else []
    if record.status == "complete":
        return gaps
    most = sorted(record.rejected.items(), key=lambda pair: -pair[1])[:MOST_REASONS]
    left = ", ".join(f"{count} × {clean(reason, 80)}" for reason, count in most)
    return [
        f"The log is {record.status}{': left out ' + left if left else ''} (report: data quality).",
        *gaps,
    ]


def _turned(results: DriveResults) -> list[str]:
    """Signals whose sign was turned: all that rests on them hangs on it."""
    names = results.record.turned
    return [f"Signs turned: {', '.join(names)} (report: data quality)."] if names else []


def _left_out(results: DriveResults) -> list[str]:
    """Signals that the log holds and the checks do not use, each reason once: else the next measurement would ask for what is there."""
    of: dict[tuple[str, str], list[str]] = {}
    for d in results.record.decisions:
        if d.applied and d.action.startswith(LEFT_OUT):
            reason = d.found.removeprefix(f"{d.signal} "), d.action.removeprefix(LEFT_OUT).lstrip(":; ")
            of.setdefault(reason, []).append(d.signal)
    return [
        f"Left out: {', '.join(names)}: {'; '.join(clean(text, 200) for text in reason if text)} (report: data quality)."
        for reason, names in of.items()
    ]


def _next_and_conflicts(results: DriveResults) -> list[str]:
    """A log that is not whole, signals turned or left out, a load that changed, what the drive speaks for, conflicts between relations, the measurement that would help most, and channels that nobody knows; nothing where there are none."""
    told = [*_log(results), *_turned(results), *_left_out(results)]
    told += [sentence(clean(note, 300)) for note in results.record.notes if ODD_UNIT in note]
    told += [
        f"{sentence(clean(note, 600)).rstrip('.')}."
        for note in results.record.notes
        if note.startswith((OVERLOOKED, UNUSED_DATABASE))
    ]
    told += [
        f"{sentence(clean(d.found, 200)).rstrip('.')}: split the drive there."
        for d in results.record.decisions
        if d.kind == "load"
    ]
    told += [
        f"{sentence(clean(d.found, 200)).rstrip('.')}: {clean(d.action, 200)}."
        for d in results.record.decisions
        if d.kind in ("zero", "mount")
    ]
    told += [
        f"{sentence(clean(d.found, 200)).rstrip('.')}: is the file this vehicle's?"
        for d in results.record.decisions
        if d.kind == "vehicle"
    ]
    told += [
        f"{sentence(clean(d.found, 200)).rstrip('.')}; {clean(d.action, 200)}."
        for d in results.record.decisions
        if d.kind in LEFT_OPEN and not d.applied
    ]
    told += [f"conflict: {conflict_text(check)}" for check in conflicts(results.joint)]
    if results.joint is not None:
        told += [sentence(clean(text, 300)) for text in results.joint.spoke_for]
    told += [sentence(text, 700) for text in results.limits if text.startswith(OF_FILE)]
    following = next_line(results)
    if following:
        told.append(f"next, most useful: {following}")
    told += [sentence(clean(note, 600)) for note in results.record.notes if note.startswith(UNRECOGNISED)]
    return [
        _spaced(line)
        # four springs that are put right alike are said once
        for text in dict.fromkeys(told)
        for line in textwrap.wrap(text, WIDTH, subsequent_indent="  ", break_on_hyphens=False)
    ]


def verdict_table(results: DriveResults, *, colour: bool = False) -> str:
    """Parameter, value ± standard deviation, 95 % interval, status; below each line the reason, if long in short.

    Behind the table: a log that is not whole, a load that changed, tyres or sensors that the drive speaks for, conflicts, and the measurement that would help most next.

    colour: paint the status; for a terminal only. Every text is free of control characters.
    """
    if not results.verdict:
        return "No parameter was asked for."
    results = with_titles(results)
    rows = [
        (
            line,
            clean(line.title, 2000),
            _value(line),
            _spaced(bracketed_text(line.estimate) or interval_text(line.estimate)),
            STATUS_WORDS[line.estimate.status],
        )
        for line in lines(results)
    ]
    heads = ("Parameter", "Value ± std", "95 % interval", "Status")
    title_width = min(36, max(len(heads[0]), *(len(r[1]) for r in rows)))
    value_width = max(len(heads[1]), *(len(r[2]) for r in rows))
    span_width = max(len(heads[2]), *(len(r[3]) for r in rows))
    out = [
        f"{heads[0]:<{title_width}}  {heads[1]:>{value_width}}  {heads[2]:>{span_width}}  {heads[3]}",
        "-" * min(WIDTH, title_width + value_width + span_width + 6 + len("not identifiable")),
    ]
    for line, title, value, interval, status in rows:
        pieces = textwrap.wrap(title, title_width) or [""]
        painted = f"{_STYLES[line.estimate.status]}{status}{_RESET}" if colour else status
        out.append(f"{pieces[0]:<{title_width}}  {value:>{value_width}}  {interval:>{span_width}}  {painted}")
        out += pieces[1:]
        out += _reason(line)
    if any(bracketed_text(row[0].estimate) for row in rows):
        out.append(
            "(in brackets: no result, but what was known before the log, or what the drive leaves of that)"
        )
    out += _next_and_conflicts(results)
    return "\n".join(row[: WIDTH + 16] if colour else row[:WIDTH] for row in out)
