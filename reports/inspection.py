"""`cogest inspect` in words and as JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from parsers.store import record_dict
from pipelines.inspection import ChannelReport, Inspection

NAME_WIDTH = 46


def _figure(value: float | None) -> str:
    return "" if value is None else f"{value:.5g}"


def _printable(text: str) -> str:
    """A log's text without control characters: a terminal must not be steered by a file."""
    return "".join(c if c.isprintable() else "?" for c in text)


def _table(rows: Sequence[Sequence[str]], widths: Sequence[int]) -> list[str]:
    lines = []
    for row in rows:
        cells = [_printable(cell) for cell in row]
        line = "  ".join(cell.ljust(width) for cell, width in zip(cells, widths, strict=True))
        lines.append("  " + line.rstrip())
    return lines


def _channel_rows(channels: Sequence[ChannelReport]) -> list[list[str]]:
    rows = [["channel", "unit", "samples", "rate Hz", "gaps", "least", "greatest", "signal or reason"]]
    for channel in channels:
        number = channel.kind == "number"
        rows.append(
            [
                channel.name,
                channel.unit or "",
                str(channel.samples) if number else "",
                f"{channel.rate_hz:.4g}" if number and channel.rate_hz else "",
                str(channel.gaps) if number else "",
                _figure(channel.low),
                _figure(channel.high),
                f"-> {channel.signal} ({channel.reason})" if channel.signal else channel.reason,
            ]
        )
    return rows


def inspection_text(inspection: Inspection) -> str:
    """The whole answer for a terminal."""
    lines = [
        f"{inspection.path}: {inspection.format}, {inspection.status}",
        f"  {inspection.messages} messages over {inspection.duration_s:.1f} s; clock: {inspection.clock}"
        + (f"; start {inspection.start_utc}" if inspection.start_utc else ""),
    ]
    rows = _channel_rows(inspection.channels)
    widths = [min(max(len(row[i]) for row in rows), NAME_WIDTH) for i in range(len(rows[0]) - 1)] + [0]
    lines += ["", "Channels", *_table(rows, widths)]
    if inspection.drive is not None:
        record = inspection.drive.record
        lines += ["", "Signals"]
        signals = [["signal", "from", "unit", "unit from", "samples", "rate Hz", "rule"]]
        signals += [
            [m.signal, m.channel, m.unit, m.unit_from, str(m.samples), f"{m.rate_hz:.4g}", m.rule]
            for m in record.mapped
        ]
        lines += _table(signals, [*(max(len(row[i]) for row in signals) for i in range(6)), 0])
        whole = [gap for gap in record.gaps if gap.signal is None]
        if whole:
            spans = ", ".join(f"{g.start_s:.1f}-{g.end_s:.1f} s" for g in whole[:5])
            lines += ["", f"Gaps of the whole drive: {len(whole)} ({spans}{', …' if len(whole) > 5 else ''})"]
        if record.decisions:
            lines += ["", "Checks against physics"]
            lines += [f"  {d.signal}: {d.found}; {d.action} ({d.evidence})" for d in record.decisions]
    else:
        lines += ["", f"Signals: none. {_printable(inspection.problem or '')}"]
    lines += ["", "Estimators"]
    for ready in inspection.readiness:
        if ready.ready:
            lines.append(f"  {ready.estimator}: can run")
        else:
            lines.append(
                f"  {ready.estimator}: lacks " + "; ".join((*ready.missing_signals, *ready.missing_vehicle))
            )
    if inspection.rejected:
        lines += [
            "",
            "Rejected",
            *(f"  {count} x {_printable(reason)}" for reason, count in inspection.rejected.items()),
        ]
    if inspection.notes:
        lines += ["", "Notes", *(f"  {_printable(note)}" for note in inspection.notes)]
    return "\n".join(lines)


def inspection_dict(inspection: Inspection) -> dict[str, Any]:
    """The same as JSON can hold it."""
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
