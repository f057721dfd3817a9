"""Bindings that ask for the sum over several axles, made into rows of their own before signals are made of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Protocol

from parsers.axle_rows import PLACES, RARE, AxlePlan, AxleSum, AxleSurvey
from parsers.channels import ChannelInfo, FloatArray, IntArray
from parsers.importer import ImportLog
from parsers.intake import Group
from parsers.mapping import Binding
from parsers.timebase import order

RowPiece = tuple[IntArray, Mapping[str, FloatArray]]
"""Stamps and columns of some rows of a group, (n,) each."""


class Rows(Protocol):
    """The rows of a log's groups, wherever they are."""

    def pieces(self, group: str, columns: tuple[str, ...]) -> Iterable[RowPiece]:
        """The rows of a group with some of its columns, piece by piece in order of time; nothing where it lacks one."""
        ...

    def logged(self, group: str) -> int:
        """How many usable rows the log has of a group, those that share a stamp with another included."""
        ...

    def keep(self, group: str, column: str, parts: Iterator[tuple[IntArray, FloatArray]]) -> None:
        """Keep stamps and values, piece by piece, as a new group with one column."""
        ...


@dataclass(frozen=True)
class HeldRows:
    """Rows in memory; a new group is put beside the others."""

    groups: dict[str, Group]

    def pieces(self, group: str, columns: tuple[str, ...]) -> list[RowPiece]:
        """All at once, if the group has the columns."""
        held = self.groups.get(group)
        whole = held is not None and all(column in held.columns for column in columns)
        return [(held.time_ns, held.columns)] if held is not None and whole else []

    def logged(self, group: str) -> int:
        """As `Rows` says it."""
        held = self.groups.get(group)
        return 0 if held is None else len(held.time_ns) + held.ordered.duplicates

    def keep(self, group: str, column: str, parts: Iterator[tuple[IntArray, FloatArray]]) -> None:
        """Take the one piece that there is."""
        ((time_ns, values),) = parts
        self.groups[group] = Group({column: values}, order(time_ns), frozenset())


Proposals = Mapping[str, tuple[Binding, ...]]


def with_axle_sums(
    proposals: Proposals, infos: Mapping[str, ChannelInfo], rows: Rows, log: ImportLog
) -> Proposals:
    """The proposals with each sum over axles bound to rows that hold it, and a note on what was summed."""
    made = {
        signal: [_bound(each, infos, rows, log) if each.sum_axles else each for each in bindings]
        for signal, bindings in proposals.items()
    }
    left = {signal: tuple(each for each in found if each is not None) for signal, found in made.items()}
    return {signal: bindings for signal, bindings in left.items() if bindings}


def _bound(binding: Binding, infos: Mapping[str, ChannelInfo], rows: Rows, log: ImportLog) -> Binding | None:
    """A binding without a sum to be made, or None where its loads cannot be summed."""
    if binding.where is None:
        return replace(binding, sum_axles=False)
    (channel, (place, low, high)) = binding.channels[0], binding.where
    group = infos[channel].group

    def pieces() -> Iterator[tuple[IntArray, FloatArray, FloatArray]]:
        for time_ns, columns in rows.pieces(group, (channel, place)):
            yield time_ns, columns[place], columns[channel]

    survey, seen = AxleSurvey(low, high), 0
    for piece in pieces():
        survey.add(*piece)
        seen += len(piece[0])
    plan = survey.plan()
    shared = rows.logged(group) - seen
    if seen and shared > RARE * seen:
        log.note(
            f"{channel} is not taken for {binding.signal}: {shared} of its rows share a stamp with another and are lost, "
            "perhaps always the same axle's: record stamps that tell frames apart"
        )
        return None
    if not plan.one_a_place:
        log.note(_several(binding, plan))
        return None
    if plan.rare:
        log.note(f"{channel}: {_codes(plan.rare)} in {place} come too seldom to be an axle's: left out")
    if len(plan.axles) < 2:
        # the range may be of many axles; of the rows of a damaged frame none are taken
        low, high = (plan.places[0], plan.places[0]) if plan.places else (low, high)
        return replace(binding, where=(place, low, high), sum_axles=False)
    total = AxleSum(plan, low, high)
    own = f"{group}/{binding.signal}"
    rows.keep(own, channel, (total.add(*piece) for piece in pieces()))
    log.note(_summed(binding, plan))
    return replace(
        binding,
        where=None,
        sum_axles=False,
        group=own,
        offset=binding.offset * len(plan.axles),
        rule=f"{binding.rule}, sum of axles {_numbers(plan)}",
    )


def _summed(binding: Binding, plan: AxlePlan) -> str:
    place = "" if binding.where is None else f", {binding.where[0]} {_codes(plan.places)}"
    text = f"{binding.signal} is the sum of axles {_numbers(plan)} ({binding.channels[0]}{place}), each with its latest load"
    if binding.signal == "axle_load_rear" and 1 in plan.axles:
        text += (
            ": all behind the first axle are taken as rear ones; where the second one steers as well, a mapping file says so "
            "(where, sum_axles)"
        )
    return text


def _several(binding: Binding, plan: AxlePlan) -> str:
    double = next(n for n in plan.axles if sum(code // PLACES == n for code in plan.places) > 1)
    codes = _codes(tuple(code for code in plan.places if code // PLACES == double))
    return (
        f"{binding.channels[0]} is not taken for {binding.signal}: axle {double + 1} has loads at several places ({codes}), "
        "and whether each is a part or the whole is not known: say in a mapping file which is to be taken (where)"
    )


def _numbers(plan: AxlePlan) -> str:
    return " + ".join(str(number + 1) for number in plan.axles)


def _codes(places: tuple[int, ...]) -> str:
    return ", ".join(f"0x{code:02X}" for code in places)
