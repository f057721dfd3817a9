"""Where a log has no samples, for the terminal: gaps of the whole drive, of single signals, and what damage took."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from parsers.drive import Gap, ImportRecord

LOST = "lost"
_MOST_SPANS = 5
_MOST_SIGNALS = 6


def gap_lines(record: ImportRecord, *, signals: bool = True) -> list[str]:
    """A line for each sort of gap that there is. signals: with those of single signals."""
    whole = [gap for gap in record.gaps if gap.signal is None]
    lost = [gap for gap in record.gaps if gap.signal == LOST]
    lines = []
    if whole:
        lines.append(f"Gaps of the whole drive: {len(whole)} ({_spans(whole, 1)})")
    if lost:
        lines.append(f"Lost to damage: {len(lost)} ({_spans(lost, 3)})")
    own = Counter(gap.signal for gap in record.gaps if gap.signal not in (None, LOST))
    if own and signals:
        named = ", ".join(f"{name} {count}" for name, count in list(own.items())[:_MOST_SIGNALS])
        lines.append(f"Gaps of single signals: {named}{', …' if len(own) > _MOST_SIGNALS else ''}")
    return lines


def _spans(gaps: Sequence[Gap], decimals: int) -> str:
    shown = ", ".join(f"{gap.start_s:.{decimals}f}-{gap.end_s:.{decimals}f} s" for gap in gaps[:_MOST_SPANS])
    return shown + (", …" if len(gaps) > _MOST_SPANS else "")
