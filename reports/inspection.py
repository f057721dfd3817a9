"""`cogest inspect` in words and as JSON."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import asdict, replace
from itertools import groupby
from typing import Any

from parsers.drive import Decision, ImportRecord
from parsers.store_folder import record_dict
from pipelines.inspection import ChannelReport, Inspection
from pipelines.starts import is_local
from reports.gap_text import gap_lines
from reports.layout import printable, table, terminal_width, wrapped
from reports.text import MINUS, NARROW, significant

MOST_UNKNOWN = 120
"""Channels that became nothing, as lines in the terminal; `--json` has them all."""

MOST_LINES = 30
_ELEMENT = re.compile(r"^(.*)\[(\d+)\]$")


def _figure(value: float | None, figures: int = 5) -> str:
    """A number in plain figures, fit to be copied; few of them where it is small."""
    if value is None:
        return ""
    text = significant(value, figures if abs(value) >= 0.001 else 3).replace(NARROW, "").replace(MINUS, "-")
    return text.rstrip("0").rstrip(".") if "." in text and "×" not in text else text


def _stem(channel: ChannelReport) -> tuple[object, ...]:
    """Elements of one array that became nothing, for the same reason, have the same stem."""
    found = _ELEMENT.match(channel.name)
    if found is None or channel.signal is not None or channel.reason.startswith("could be"):
        return (channel.name, "alone")
    return (found[1], channel.unit, channel.kind, channel.rate_hz, channel.gaps, channel.reason)


def _folded(channels: Sequence[ChannelReport]) -> list[ChannelReport]:
    """Channels with the unused elements of an array as one line: covariance[0-35]."""
    out = []
    for _, run in groupby(channels, _stem):
        group = list(run)
        first = group[0]
        if len(group) == 1:
            out.append(first)
            continue
        ends = [_ELEMENT.match(c.name) for c in (first, group[-1])]
        low = [c.low for c in group if c.low is not None]
        high = [c.high for c in group if c.high is not None]
        numbers = "-".join(e[2] for e in ends if e)
        stem = ends[0][1] if ends[0] else first.name
        out.append(
            replace(
                first,
                name=f"{stem}[{numbers}]",
                samples=max(c.samples for c in group),
                low=min(low, default=None),
                high=max(high, default=None),
            )
        )
    return out


def _channel_lines(channels: Sequence[ChannelReport], width: int) -> list[str]:
    rows = [["channel", "unit", "samples", "rate Hz", "gaps", "least", "greatest", "became, or why not"]]
    unknown = 0
    for channel in _folded(channels):
        number = channel.kind == "number"
        if channel.signal is None:
            unknown += 1
            if unknown > MOST_UNKNOWN:
                continue
        rows.append(
            [
                channel.name,
                channel.unit or "",
                str(channel.samples) if number else "",
                _figure(channel.rate_hz, 4) if number and channel.rate_hz else "",
                str(channel.gaps) if number else "",
                _figure(channel.low),
                _figure(channel.high),
                f"-> {channel.signal}" if channel.signal else channel.reason,
            ]
        )
    lines = table(rows, width, right=(2, 3, 4, 5, 6), names=(0,))
    if unknown > MOST_UNKNOWN:
        lines.append(f"  … and {unknown - MOST_UNKNOWN} more that became nothing: --json lists every channel")
    return lines


def _joined(channel: str) -> str:
    """Channels of one source as in "/imu.orientation.x + .y + .z + .w"."""
    parts = channel.split(" + ")
    first, dot, _ = parts[0].rpartition(".")
    if len(parts) == 1 or not dot:
        return channel
    return " + ".join(
        (parts[0], *(p.removeprefix(first) if p.startswith(first + ".") else p for p in parts[1:]))
    )


def _decision(decision: Decision) -> str:
    lead = "" if decision.signal in decision.found else f"{decision.signal}: "
    evidence = f" ({decision.evidence})" if decision.evidence else ""
    return f"{lead}{decision.found}: {decision.action}{evidence}"


def _signal_lines(record: ImportRecord, width: int) -> list[str]:
    rows = [["signal", "from", "unit", "unit from", "rule"]]
    rows += [
        [m.signal, _joined(m.channel), m.unit, m.unit_from, m.rule.removeprefix("profile ")]
        for m in record.mapped
    ]
    lines = ["", "Signals", *table(rows, width, names=(1,))]
    # the channels above say how many gaps each has
    if gaps := gap_lines(record, signals=False):
        lines += ["", *gaps]
    if record.disorder:
        lines += ["", f"Put in order: {', '.join(record.disorder)}"]
    if record.decisions:
        lines += ["", "Checks against physics"]
        for decision in record.decisions:
            lines += wrapped(_decision(decision), width)
    return lines


def _some(title: str, texts: Sequence[str], width: int) -> list[str]:
    """A titled list of sentences, the first ones of very many."""
    if not texts:
        return []
    lines = ["", title]
    for text in texts[:MOST_LINES]:
        lines += wrapped(text, width)
    if len(texts) > MOST_LINES:
        lines.append(f"  … and {len(texts) - MOST_LINES} more: --json lists all")
    return lines


def inspection_text(inspection: Inspection, width: int | None = None) -> str:
    """The whole answer for a terminal of so many columns; those of the terminal itself unless given."""
    width = width or terminal_width()
    start = f"; start {inspection.start_utc}" if inspection.start_utc else ""
    start += " (time zone unknown)" if is_local(inspection.start_utc) else ""
    lines = [printable(f"{inspection.path}: {inspection.format}, {inspection.status}")]
    facts = (
        f"{inspection.messages} messages over {inspection.duration_s:.1f} s; clock: {inspection.clock}{start}"
    )
    lines += [*wrapped(facts, width), "", "Channels", *_channel_lines(inspection.channels, width)]
    if inspection.drive is not None:
        lines += _signal_lines(inspection.drive.record, width)
    else:
        lines += ["", *wrapped(f"Signals: none. {inspection.problem or ''}", width, indent=0)]
    lines += ["", "Estimators"]
    for ready in inspection.readiness:
        lacks = "; ".join((*ready.missing_signals, *ready.missing_vehicle))
        lines += wrapped(f"{ready.estimator}: {'can run' if ready.ready else 'lacks ' + lacks}", width)
    lines += _some("Rejected", [f"{n} x {reason}" for reason, n in inspection.rejected.items()], width)
    lines += _some("Notes", inspection.notes, width)
    return "\n".join(lines)


def inspection_dict(inspection: Inspection) -> dict[str, Any]:
    """The same as JSON can hold it: every channel, and nothing cut."""
    return {
        "log": str(inspection.path),
        "format": inspection.format,
        "status": inspection.status,
        "clock": inspection.clock,
        "messages": inspection.messages,
        "duration_s": inspection.duration_s,
        "start_utc": inspection.start_utc,
        "channels": [asdict(channel) for channel in inspection.channels],
        "import": record_dict(inspection.drive.record) if inspection.drive else None,
        "problem": inspection.problem,
        "estimators": [asdict(ready) for ready in inspection.readiness],
        "rejected": dict(inspection.rejected),
        "notes": list(inspection.notes),
    }
