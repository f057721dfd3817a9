"""Which recordings of a folder are one drive: parts in a row, several recorders, copies. In doubt each is a drive of its own.

A name alone is never enough: the clocks (and for copies the content) must say the same.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from itertools import pairwise

from pipelines.fleet.clocks import NS
from pipelines.fleet.group_copies import without_copies, without_formats
from pipelines.fleet.group_recorders import join_recorders, join_same_names
from pipelines.fleet.logs import Log
from pipelines.fleet.names import follows, natural, numbered
from pipelines.fleet.together import Facts, Grouped, Together

JOIN_NS = NS
"""A part begins within this of the end of the part before it, either way."""

MOST_NS = 24 * 3600 * NS
"""Parts in a row are one drive up to this length."""


def group_folder(logs: Sequence[Log], facts: Facts) -> Grouped:
    """Bring together the recordings of one folder that belong together."""
    out = Grouped()
    kept = without_formats(without_copies(logs, out), facts, out)
    units = [_with_notes(unit, out) for unit in _rows(kept, facts)]
    out.drives = join_same_names(join_recorders(units, facts), facts)
    return out


def _with_notes(unit: Together, out: Grouped) -> Together:
    for log in unit.logs:
        for note in out.notes.get(log.place, ()):
            unit = unit.saying(note=note)
    return unit


def _rows(logs: Sequence[Log], facts: Facts) -> list[Together]:
    """Parts in a row, as their names and clocks say; the others alone."""
    rows: dict[tuple[str, str], list[Log]] = defaultdict(list)
    for log in logs:
        rows[(log.format, numbered(log.stem).row)].append(log)
    out = []
    for row in rows.values():
        row.sort(key=lambda log: natural(log.stem))
        chain = [row[0]]
        gaps: list[int] = []
        for before, after in pairwise(row):
            gap = _gap_ns(before, after, facts) if follows(before.stem, after.stem) else None
            if gap is not None and _span_ns(chain[0], after, facts) <= MOST_NS:
                chain.append(after)
                gaps.append(gap)
                continue
            out.append(_row(chain, gaps))
            chain, gaps = [after], []
        out.append(_row(chain, gaps))
    return sorted(out, key=lambda unit: natural(unit.logs[0].name))


def _gap_ns(before: Log, after: Log, facts: Facts) -> int | None:
    """Time between two parts (negative: they overlap) where the second goes on where the first ends, else None."""
    a, b = facts.clock(before), facts.clock(after)
    if a is None or b is None or a.absolute != b.absolute:
        return None
    # a clock that begins anew with every file shows nothing
    if not a.absolute and b.first_ns < NS:
        return None
    gap = b.first_ns - a.last_ns
    return gap if -JOIN_NS <= gap <= JOIN_NS and b.last_ns > a.last_ns and b.first_ns > a.first_ns else None


def _span_ns(first: Log, last: Log, facts: Facts) -> int:
    a, b = facts.clock(first), facts.clock(last)
    return b.last_ns - a.first_ns if a and b else 0


def _row(chain: Sequence[Log], gaps: Sequence[int]) -> Together:
    if len(chain) == 1:
        return Together((chain[0],))
    most = max(abs(gap) for gap in gaps) / 1e6
    note = (
        f"{len(chain)} files in a row ({chain[0].name} … {chain[-1].name}): each begins where the one before ends, "
        f"within {most:.0f} ms"
    )
    return Together(tuple(chain), (note,))
