"""Tables in which each raster has a time column of its own, as CANape, MDA, imc and DIAdem export them side by side.

A row of such a table is no moment: its n-th samples of 50 Hz and of 10 Hz stand beside each other.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from parsers.errors import LogError
from parsers.importer import ReadOptions
from parsers.quantiles import quantile
from parsers.table_cells import NumberStyle
from parsers.table_names import ColumnName
from parsers.table_time import find_time, shape_of
from parsers.table_time_plan import TimePlan

_TIMES = frozenset(("t", "time", "timestamp", "zeit", "zeitstempel", "temps", "tiempo", "tempo"))
_TOKENS = re.compile(r"[^0-9a-zäöüß]+|(?<=[a-zäöüß])(?=\d)")
_CAMEL = re.compile(r"(?<=[a-zäöüß])(?=[A-ZÄÖÜ])")
_NUMBERED = re.compile(r"[a-z]|\d+|\d+(?:ms|us|s|hz)|ms|hz|raster|group|gruppe")
"""What tells rasters apart and says nothing of a clock: a letter, a number, a rate."""
_CLOCKS = frozenset((
    "gps", "utc", "gnss", "lap", "left", "raw", "bus", "ecu", "host", "pc", "system", "sys", "device",
    "sensor", "log", "logger", "received", "receive", "recv", "rx", "arrival", "unix", "epoch", "local",
    "start", "end", "trigger", "rel", "abs", "relative", "absolute", "total", "elapsed", "session", "run",
    "stint", "sector", "best", "last", "delta", "track", "race", "video", "frame",
))  # fmt: skip
"""What names another clock of the same rows, or no clock: words beside "time"."""

_PACE = 1.1
_LEAST_ROWS = 3
_TOGETHER = 50
"""Rows within which the rasters of a table begin."""


@dataclass(frozen=True)
class Raster:
    """Columns that share their stamps. plan: how their time column is read; columns: places, without it."""

    plan: TimePlan
    columns: frozenset[int]


@dataclass(frozen=True)
class Columns:
    """A table's columns: their names, and the first cells of each as text."""

    names: tuple[ColumnName, ...]
    samples: tuple[tuple[str, ...], ...]
    style: NumberStyle

    def rising(self, place: int) -> np.ndarray:
        """The numbers of a column's first cells in which it rises from cell to cell, NaN where there is none, (rows,); empty
        where it does not rise."""
        values = np.array([np.nan if (v := self.style.value(c)) is None else v for c in self.samples[place]])
        held = values[np.isfinite(values)]
        rises = len(held) >= _LEAST_ROWS and bool((np.diff(held) > 0).all())
        return values if rises else values[:0]


def find_rasters(
    columns: Columns, plan: TimePlan, options: ReadOptions, path: Path
) -> tuple[tuple[Raster, ...], str]:
    """The rasters of a table, the one of `plan` among them, in the order of their time columns; and what is to be said of
    them. One raster with all columns where the table has one time. Raises LogError where there are several, and nothing
    tells which columns belong to which."""
    every = frozenset(range(len(columns.names)))
    one = (Raster(plan, every - set(plan.columns)),)
    if plan.kind not in ("decimal", "calendar", "elapsed") or len(plan.columns) > 1:
        return one, ""
    main = plan.columns[0]
    found = {k: twin for k in every - {main} if (twin := _twin(columns, k, plan, options, path)) is not None}
    # in a table of rasters every time column that begins with the others is one, however alike their paces are
    of_rasters = any(not twin.near for twin in found.values())
    twins = {k: twin for k, twin in found.items() if of_rasters or twin.beside}
    if not twins:
        return one, ""
    plans = {main: plan, **{k: twins[k].plan for k in sorted(twins)}}
    own, how = _owners(columns.names, sorted(plans))
    if own is None:
        if options.time_channel is not None or not any(twin.differs for twin in twins.values()):
            return one, ""
        raise LogError(
            f"several time columns of different pace ({_listed(columns.names, plans)}), and nothing tells which columns "
            "belong to which",
            path=path,
            hint="export each raster into a file of its own, or name one time column in the map file ([time] channel) and "
            "map only the columns that belong to it",
        )
    rasters = tuple(Raster(plans[k], frozenset(own[k])) for k in sorted(plans))
    return (
        rasters,
        f"several time columns ({_listed(columns.names, plans)}): each column has the stamps of {how}",
    )


def without_other_rasters(
    columns: Columns, plan: TimePlan, options: ReadOptions, path: Path
) -> tuple[frozenset[int], str]:
    """The columns that do not have the stamps of `plan`'s time column, for tables of which one raster is read; and what is to
    be said of them."""
    rasters, said = find_rasters(columns, plan, options, path)
    if not said:
        return frozenset(), ""
    others = [raster for raster in rasters if raster.plan.columns != plan.columns]
    places = frozenset(k for raster in others for k in (*raster.columns, *raster.plan.columns))
    named = ", ".join(f'"{columns.names[k].name}"' for k in sorted(places)[:6]) + (
        ", …" if len(places) > 6 else ""
    )
    return places, f"{said}; of this format only the first is read: {named} left out"


def _listed(names: Sequence[ColumnName], plans: dict[int, TimePlan]) -> str:
    shown = [f'"{names[k].name}"' for k in sorted(plans)]
    return ", ".join(shown[:6]) + (", …" if len(shown) > 6 else "")


def _tokens(column: ColumnName) -> list[str]:
    return [token for token in _TOKENS.split(_CAMEL.sub(" ", column.name).lower()) if token]


@dataclass(frozen=True)
class _Twin:
    """Another time column of the same kind. differs: it goes at another pace. near: neither its name nor its pace tells that it is a raster's,
    but it begins with the first one. beside: it begins within a row of the first one, so that stamps by it could do little harm."""

    plan: TimePlan
    differs: bool
    near: bool
    beside: bool


def _twin(columns: Columns, place: int, plan: TimePlan, options: ReadOptions, path: Path) -> _Twin | None:
    """Another time column of the same kind as `plan`'s that may be a raster's; None for others.

    A second clock of the same rows (GPS time, the time of a lap) goes at the first one's pace, and is none.
    """
    main = plan.columns[0]
    first, second = columns.names[main], columns.names[place]
    same = first.header.strip().lower() == second.header.strip().lower()
    a, b = _tokens(first), _tokens(second)
    at = next((k for k in (0, -1) if a and b and a[k] == b[k] and a[k] in _TIMES), None)
    if at is None and not same:
        return None
    here, there = columns.rising(main), columns.rising(place)
    numbers = plan.kind == "decimal"
    if columns.samples[main] == columns.samples[place] or (numbers and not (len(here) and len(there))):
        return None
    if not numbers and shape_of(columns.samples[main], columns.style) != shape_of(
        columns.samples[place], columns.style
    ):
        return None
    own = find_time(
        columns.names,
        columns.samples,
        columns.style,
        replace(options, time_channel=second.name),
        path,
    )
    if own.two_ways:
        # what the whole file told of the first clock's dates holds for this one's
        own = replace(own, order=plan.order)
    if (own.kind, own.absolute, own.unit_ns, own.guessed) != (
        plan.kind,
        plan.absolute,
        plan.unit_ns,
        plan.guessed,
    ):
        return None
    differs = numbers and _other_pace(here, there)
    # "Time_IMU_Dyn1" and "Time_IMU_Dyn2" differ by their numbers
    rest = (set(a) ^ set(b)) - _TIMES
    numbered = all(_NUMBERED.fullmatch(token) for token in rest)
    if same or numbered or differs:
        return _Twin(own, differs, near=False, beside=True)
    if not numbers or _CLOCKS & rest:
        return None
    apart, step = _beginning(here, there)
    return _Twin(own, differs, near=True, beside=apart <= step) if apart <= _TOGETHER * step else None


def _beginning(here: np.ndarray, there: np.ndarray) -> tuple[float, float]:
    """How far apart two columns begin, and the usual step of the first."""
    first, second = here[np.isfinite(here)], there[np.isfinite(there)]
    return abs(float(second[0] - first[0])), quantile(np.diff(first), 0.5)


def _other_pace(here: np.ndarray, there: np.ndarray) -> bool:
    """Whether two columns advance by different amounts over the rows that both fill, as a whole and in the usual step."""
    both = np.isfinite(here) & np.isfinite(there)
    if np.count_nonzero(both) < _LEAST_ROWS:
        return False
    a, b = here[both], there[both]
    ratios = np.array(
        [(b[-1] - b[0]) / (a[-1] - a[0]), quantile(np.diff(b), 0.5) / quantile(np.diff(a), 0.5)]
    )
    return bool((ratios > _PACE).all() or (ratios < 1 / _PACE).all())


def _owners(names: Sequence[ColumnName], times: Sequence[int]) -> tuple[dict[int, list[int]] | None, str]:
    """Time column -> its columns, and how they were told; None where that cannot be told."""
    others = [k for k in range(len(names)) if k not in times]
    marks = {k: _tokens(names[k])[-1] for k in times}
    if len(set(marks.values())) == len(times):
        of = {mark: k for k, mark in marks.items()}
        told = {k: of.get((_tokens(names[k]) or [""])[-1]) for k in others}
        if others and None not in told.values() and set(told.values()) == set(times):
            return {
                t: [k for k in others if told[k] == t] for t in times
            }, "the time column that ends as its name does"
    # the time column stands before its columns; in a few exports behind them
    behind = times[-1] == len(names) - 1 and times[0] > 0
    own: dict[int, list[int]] = {t: [] for t in times}
    for k in others:
        near = [t for t in times if (t > k) == behind]
        own[(near[0] if behind else near[-1]) if near else times[0]].append(k)
    if not all(own.values()):
        return None, ""
    return own, f"the time column {'behind' if behind else 'before'} it"
