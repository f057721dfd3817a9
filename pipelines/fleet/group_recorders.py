"""Several recorders of one drive (can.blf, gps.vbo, imu.csv): names say so, and clocks that run together."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence

from pipelines.fleet.logs import Log
from pipelines.fleet.names import natural
from pipelines.fleet.together import Facts, Together, run_together, united, words_of


def join_recorders(units: Sequence[Together], facts: Facts) -> list[Together]:
    """Several recorders of one drive, as names that tell which recorder it is, and clocks that run together, say."""
    named = [(words_of(unit), unit) for unit in units]
    rows: dict[tuple[str, ...], list[tuple[tuple[str, ...], Together]]] = defaultdict(list)
    for (drive, kinds, _), unit in named:
        rows[drive].append((kinds, unit))
    out: list[Together] = []
    for drive, members in rows.items():
        different = {kind for kind, _ in members}
        # without words of its own only recorders' words can say that it is one drive
        able = [m for m in members if drive or m[0]]
        if len(different) < 2 or len(able) < 2:
            out += [unit for _, unit in members]
            continue
        out += [unit for kind, unit in members if not drive and not kind]
        out += _together(able, facts)
    return sorted(out, key=lambda unit: natural(unit.logs[0].name))


def _together(members: Sequence[tuple[tuple[str, ...], Together]], facts: Facts) -> list[Together]:
    """Unite those whose clocks run together, where each is another kind of recorder."""
    clusters: list[list[int]] = []
    for k, (_, unit) in enumerate(members):
        hits = [c for c in clusters if any(run_together(unit, members[j][1], facts) for j in c)]
        clusters = [c for c in clusters if not any(c is hit for hit in hits)] + [
            [*(j for hit in hits for j in hit), k]
        ]
    out = []
    for cluster in clusters:
        found = [members[k] for k in sorted(cluster)]
        kinds = [kind for kind, _ in found]
        pairs = all(run_together(a[1], b[1], facts) for i, a in enumerate(found) for b in found[:i])
        if len(found) > 1 and (len(set(kinds)) < len(kinds) or not pairs):
            out += [unit.saying(lack=_UNSURE.format(_names(found, unit))) for _, unit in found]
        elif len(found) > 1:
            out.append(united([unit for _, unit in found], "recorders of one drive: names and clocks agree"))
        else:
            out.append(found[0][1])
    return out


_CAN = frozenset(("blf", "asc", "trc", "candump"))
_UNSURE = (
    "it may be of one drive with {}, which ran at the same time, but it is not certain which belong together: "
    "say it in a drive.toml"
)


def _names(found: Sequence[tuple[tuple[str, ...], Together]], but: Together) -> str:
    names = [unit.logs[0].name for _, unit in found if unit is not but]
    return f"{', '.join(names[:3])}{' …' if len(names) > 3 else ''}"


def join_same_names(units: Sequence[Together], facts: Facts) -> list[Together]:
    """Files of one name in several formats: recorders of one drive where their clocks and signals say so."""
    rows: dict[str, list[Together]] = defaultdict(list)
    for unit in units:
        rows[words_of(unit)[2]].append(unit)
    found: list[Together] = []
    for row in rows.values():
        several = len(row) > 1 and len({unit.logs[0].format for unit in row}) == len(row)
        found += _one_name(row, facts) if several else row
    return sorted(found, key=lambda unit: natural(unit.logs[0].name))


def _one_name(row: Sequence[Together], facts: Facts) -> list[Together]:
    found: list[Together] = []
    for unit in row:
        for k, other in enumerate(found):
            if run_together(unit, other, facts) and _add_to_each_other(unit.logs[0], other.logs[0], facts):
                found[k] = united(
                    [other, unit], "recorders of one drive: one name, and clocks that run together"
                )
                break
        else:
            found.append(unit)
    names = [unit.logs[0].name for unit in found]
    if len(found) == 1:
        return found
    return [
        unit.saying(
            lack=f"{', '.join(n for n in names if n != unit.logs[0].name)} has the same name, but nothing shows that "
            "it is of the same drive: say it in a drive.toml if it is"
        )
        for unit in found
    ]


def _add_to_each_other(log: Log, other: Log, facts: Facts) -> bool:
    """Whether each has signals that the other has not; of what is too large to be read, a bus is no GPS log."""
    one, two = facts.content(log), facts.content(other)
    if one is None or two is None:
        return (log.format in _CAN) != (other.format in _CAN)
    return bool(one.keys() - two.keys()) and bool(two.keys() - one.keys())
