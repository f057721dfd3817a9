"""Where the logs of one drive lie on one clock: by their stamps, or by the starts that their headers state."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from parsers.errors import LogError
from parsers.opened_log import OpenedLog
from parsers.pieces import OVERLAP_NS, Piece, overlap_ns, tell_different_things
from parsers.timebase import NS
from parsers.zones import zone_shifts

APART_NS = 48 * 3600 * NS
"""Logs further apart than this are of two drives."""

_DATE_STEP_NS = NS + NS // 2
"""Dates in headers are often whole seconds: closer than this they are equal."""

_ONE_BY_ONE = "analyse the logs one by one"


@dataclass(frozen=True)
class Placing:
    """shifts_ns: what is added to each log's stamps. by_date: the headers' dates say it. notes: sentences."""

    shifts_ns: tuple[int, ...]
    by_date: bool = False
    notes: tuple[str, ...] = ()


def place_logs(logs: Sequence[OpenedLog], held: Sequence[Mapping[str, Piece]]) -> Placing:
    """Bring several logs onto one clock. held: signal -> piece of each log. Raises LogError where their clocks have nothing
    in common."""
    used = [number for number, pieces in enumerate(held) if pieces]
    relative = [number for number in used if not logs[number].reader.absolute]
    if relative and len(relative) < len(used):
        raise LogError(
            "its stamps count from its own start, the other log's from 1970: they cannot be laid side by side",
            path=logs[relative[0]].path,
            hint=f"{_ONE_BY_ONE}, or record with one clock",
        )
    return _by_starts(logs, held, used) if relative else _by_zones(logs, held, used)


def _by_zones(logs: Sequence[OpenedLog], held: Sequence[Mapping[str, Piece]], used: Sequence[int]) -> Placing:
    """Of logs whose stamps all count from 1970."""
    shifts, notes = zone_shifts(logs, held, used)
    return Placing(shifts, notes=notes)


def _by_starts(
    logs: Sequence[OpenedLog], held: Sequence[Mapping[str, Piece]], used: Sequence[int]
) -> Placing:
    """Of logs whose stamps all count from a zero of their own."""
    words = "the logs' stamps are relative:"
    still = (0,) * len(logs)
    starts = {n: logs[n].log.local_start_ns for n in used}
    known = {n: start for n, start in starts.items() if start is not None}
    apart = max(known.values()) - min(known.values()) if known else 0
    if len(known) < len(used):
        if apart > _DATE_STEP_NS:
            raise LogError(
                "its stamps count from its own start and it does not say when that was; the other logs do, and began at "
                "different moments",
                path=next(logs[n].path for n in used if n not in known),
                hint=_ONE_BY_ONE,
            )
        return Placing(still, notes=(f"{words} their zeros are taken as one moment",))
    if _dates_of_first_stamps(known, held):
        run_on = "their zeros are taken as one moment, since their stamps run on as their headers' dates do"
        return Placing(still, by_date=True, notes=(f"{words} {run_on}",))
    if apart == 0:
        # equal dates are also what a recorder writes into each piece of a measurement
        return Placing(still, notes=(f"{words} their zeros are taken as one moment, their headers' date",))
    first = min(known, key=lambda n: known[n])
    shifts = tuple(known.get(n, known[first]) - known[first] for n in range(len(logs)))
    others = sorted((n for n in used if n != first), key=lambda n: shifts[n])
    laid = ", ".join(f"{logs[n].path.name} {shifts[n] / NS:g} s" for n in others[:6])
    more = ", …" if len(others) > 6 else ""
    text = f"{words} they are laid by the dates in their headers ({laid}{more} after {logs[first].path.name})"
    if all(start % NS == 0 for start in known.values()):
        text += (
            ", which are whole seconds: what is in one log may be early or late by as much against the other"
        )
    return Placing(shifts, by_date=apart > _DATE_STEP_NS, notes=(text,))


def _dates_of_first_stamps(known: Mapping[int, int], held: Sequence[Mapping[str, Piece]]) -> bool:
    """Whether the dates are those of each log's first stamp and not of its zero: the stamps then run on by as much."""
    firsts = {n: min(piece.span[0] for piece in held[n].values()) for n in known}
    zeros = [known[n] - firsts[n] for n in known]
    return (
        max(zeros) - min(zeros) <= _DATE_STEP_NS
        and max(firsts.values()) - min(firsts.values()) > _DATE_STEP_NS
    )


def refuse_other_moments(
    logs: Sequence[OpenedLog], held: Sequence[Mapping[str, Piece]], placing: Placing
) -> None:
    """Raise LogError where logs whose zeros are only taken as one moment hold the same channels over the same stamps, and
    these tell different things: pieces of a recorder that counts from zero in each. Which moment is when is unknown, and a
    drive of one's speed and the other's yaw rate would be none."""
    if placing.by_date:
        return
    for one, two in combinations([n for n, pieces in enumerate(held) if pieces], 2):
        if logs[one].reader.absolute or logs[one].importer.name != logs[two].importer.name:
            continue
        said = {name: _differ(piece, held[two].get(name)) for name, piece in held[one].items()}
        differ = [name for name, found in said.items() if found]
        if len(differ) > sum(found is False for found in said.values()):
            raise LogError(
                f"its stamps begin anew, as those of {logs[one].path.name} do, and nothing says how much later: the same "
                f"channels tell different things at the same stamps ({', '.join(differ[:4])}"
                f"{', …' if len(differ) > 4 else ''})",
                path=logs[two].path,
                hint=f"{_ONE_BY_ONE}; pieces of one drive need stamps that run on from piece to piece, or count from 1970",
            )


def _differ(one: Piece, two: Piece | None) -> bool | None:
    if two is None or one.source != two.source or overlap_ns(one.span, two.span) <= OVERLAP_NS:
        return None
    return tell_different_things(one, two)


def refuse_far_apart(logs: Sequence[OpenedLog], held: Sequence[Mapping[str, Piece]]) -> None:
    """Raise LogError where the logs cannot be of one drive."""
    spans = [piece.span for pieces in held for piece in pieces.values()]
    if spans and max(b for _, b in spans) - min(a for a, _ in spans) > APART_NS:
        raise LogError(
            "the logs lie more than two days apart: nothing overlaps",
            path=logs[0].path,
            hint="give only logs of one drive",
        )
