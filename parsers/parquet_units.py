"""Units that a Parquet file states beside its columns' names: in the fields' metadata, the file's, or pandas' `attrs`."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import polars as pl

from parsers.arrow_schema import field_metadata
from parsers.table_names import ColumnName
from parsers.unit_words import is_unit, plain_unit, says_unit
from parsers.units import find_unit, quantities_of

_KEYS = ("unit", "units")
_SHOWN = 6
_MOST_TEXT = 4 << 20


@dataclass(frozen=True)
class StatedUnits:
    """Columns' names with the units that are stated for them, and sentences on those that were not, or not only, taken."""

    names: tuple[ColumnName, ...]
    notes: tuple[str, ...]


def with_stated_units(
    names: Sequence[ColumnName], headers: Sequence[str], metadata: Mapping[str, str]
) -> StatedUnits:
    """The columns with the units of a file's metadata. headers: the file's own names of the columns.

    What stands beside a column comes before what its name seems to say.
    """
    stated = dict(_stated(metadata))
    found, unknown, other = [], [], []
    for column, header in zip(names, headers, strict=True):
        unit = plain_unit(stated.get(header))
        if unit is None or not says_unit(unit):
            found.append(column)
        elif not is_unit(unit):
            unknown.append(f'"{header}" {unit[:20]!r}')
            found.append(column)
        else:
            if column.unit is not None and not same_unit(column.unit, unit):
                other.append(f'"{header}" {unit}')
            found.append(replace(column, unit=unit))
    notes = []
    if unknown:
        notes.append(
            f"units in the file's metadata that cogest does not know are passed over: {_some(unknown)}"
        )
    if other:
        notes.append(
            f"the file's metadata state other units than the columns' names, and are taken: {_some(other)}"
        )
    return StatedUnits(tuple(found), tuple(notes))


def file_metadata(path: Path) -> dict[str, str]:
    """What a Parquet file says about itself, key by key. Raises what polars does."""
    # younger than the oldest polars that is taken
    read = getattr(pl, "read_parquet_metadata", None)
    return dict(read(path)) if read is not None else {}


def _stated(metadata: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """Column and unit, as the text has them; what comes later counts."""
    attrs = _object(metadata.get("PANDAS_ATTRS"))
    yield from _by_column(attrs)
    for key, value in attrs.items():
        # {"speed": {"unit": "km/h"}}
        if isinstance(value, dict) and key.lower() not in _KEYS:
            yield from ((key, unit) for name, unit in _texts(value) if name.lower() in _KEYS)
    yield from _by_column({key: _object(value) for key, value in metadata.items() if key.lower() in _KEYS})
    for column, said in field_metadata(metadata.get("ARROW:schema", "")).items():
        yield from ((column, unit) for key, unit in said.items() if key.lower() in _KEYS)


def _by_column(said: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """{"units": {"speed": "km/h"}}."""
    for key, value in said.items():
        if key.lower() in _KEYS and isinstance(value, dict):
            yield from _texts(value)


def _texts(said: Mapping[Any, Any]) -> Iterator[tuple[str, str]]:
    return ((key, value) for key, value in said.items() if isinstance(value, str))


def _object(text: str | None) -> dict[str, Any]:
    """A JSON object; empty where the text is none."""
    if not text or len(text) > _MOST_TEXT:
        return {}
    try:
        found = json.loads(text)
    except (ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


def same_unit(one: str, other: str) -> bool:
    """Whether two texts are one unit as far as that can be told."""
    if one.strip().lower() == other.strip().lower():
        return True
    both = quantities_of(one) & quantities_of(other)
    pairs = [(find_unit(one, quantity), find_unit(other, quantity)) for quantity in both]
    return any(a is not None and b is not None and a.scale == b.scale for a, b in pairs)


def _some(items: Sequence[str]) -> str:
    return ", ".join(items[:_SHOWN]) + (f" and {len(items) - _SHOWN} more" if len(items) > _SHOWN else "")
