"""Columns of a Parquet table as numbers, and its rows' times."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
import polars as pl

from parsers.channels import FloatArray, IntArray
from parsers.importer import ImportLog
from parsers.table_cells import is_missing
from parsers.table_numbers import MISSING_WORDS
from parsers.table_repeats import LEAST_SHARE
from parsers.table_stamps import BoolArray
from parsers.table_time_plan import TimePlan

SAMPLE_ROWS = 200
"""Rows by which a table is judged."""
ISO_CELL = re.compile(
    r"(?:19|20)[0-9]{2}-[0-9]{2}-[0-9]{2}[Tt ][0-9]{2}:[0-9]{2}:[0-9]{2}(?:[.,][0-9]{1,9})?\s*(?:[zZ]|UTC|[+-][0-9]{2}(?::?[0-9]{2})?)?"
)
"""A date and time of ISO 8601 in this century or the last."""
MOST_DIGITS = 38
"""Of a decimal that polars holds."""


def stamps_repeat(time_ns: IntArray) -> bool:
    """Whether the first rows share stamps with each other."""
    moved = np.diff(time_ns[:SAMPLE_ROWS])
    return len(moved) > 0 and float(np.mean(moved == 0)) > LEAST_SHARE


def is_number(kind: pl.DataType) -> bool:
    """Whether a column can be taken as numbers; true and false are 1 and 0."""
    return kind.is_numeric() or kind == pl.Boolean


def is_text(kind: pl.DataType) -> bool:
    """Whether a column holds texts, also as pandas' categories."""
    return kind == pl.String or isinstance(kind, (pl.Categorical, pl.Enum))


def _texts(column: pl.Series) -> pl.Series:
    """A column of texts without the blanks around them."""
    return column.cast(pl.String).str.strip_chars()


def floats(column: pl.Series) -> FloatArray:
    """A column as doubles, NaN where it has no value or an infinite one, also where its text is no number."""
    if not is_number(column.dtype) and not is_text(column.dtype):
        return np.full(len(column), np.nan)
    if is_text(column.dtype):
        column = _texts(column)
    values = column.cast(pl.Float64, strict=False).fill_null(float("nan")).to_numpy()
    return np.where(np.isinf(values), np.nan, values) if bool(np.isinf(values).any()) else values


def too_many_digits(schema: pl.Schema) -> tuple[frozenset[int], str | None]:
    """Places of the columns of decimals that polars cannot hold, and a sentence on them."""
    wide = {
        place: f'"{name}"'
        for place, (name, kind) in enumerate(schema.items())
        if isinstance(kind, pl.Decimal) and kind.precision is not None and kind.precision > MOST_DIGITS
    }
    if not wide:
        return frozenset(), None
    shown = ", ".join([*wide.values()][:6]) + (f" and {len(wide) - 6} more" if len(wide) > 6 else "")
    text = f"columns of decimals with more than {MOST_DIGITS} digits are not read: {shown}; write them as doubles"
    return frozenset(wide), text


def reject_cells(columns: pl.DataFrame, log: ImportLog) -> None:
    """Write down the cells that are words or infinite, where numbers were expected."""
    log.reject("cell with text where a number was expected", sum(map(text_cells, columns)))
    log.reject("cell with an infinite value", sum(map(_infinite_cells, columns)))


def _infinite_cells(column: pl.Series) -> int:
    if is_text(column.dtype):
        column = _texts(column).cast(pl.Float64, strict=False)
    return int(column.is_infinite().sum()) if column.dtype.is_float() else 0


def text_cells(column: pl.Series) -> int:
    """How many cells of a column of text are words, where numbers were expected."""
    if not is_text(column.dtype):
        return 0
    column = _texts(column)
    words = column.filter(column.cast(pl.Float64, strict=False).is_null())
    return int((~words.str.to_lowercase().is_in(["", *MISSING_WORDS])).sum())


def are_iso(cells: Sequence[str]) -> bool:
    """Whether the first cells of a column of texts are dates and times of ISO 8601, as pandas and Python write them."""
    kept = [text for cell in cells if not is_missing(text := cell.strip())]
    return bool(kept) and sum(ISO_CELL.fullmatch(text) is not None for text in kept) > 0.5 * len(kept)


def _iso_stamps(column: pl.Series) -> pl.Series:
    """Texts as ns since 1970, nothing where they are no such date and time; without a zone as UTC."""
    texts = _texts(column)
    # polars takes what is not of the form as nothing, and dates that no number of ns can hold as any
    spelt = pl.col("text").str.contains(f"^(?:{ISO_CELL.pattern})$")
    texts = texts.to_frame("text").select(pl.when(spelt).then(pl.col("text"))).to_series()
    # the zone first: "UTC" has a T as well
    texts = texts.str.replace(r"\s*(?:[zZ]|UTC)$", "+00:00").str.replace(r"\s+([+-])", "$1")
    texts = texts.str.replace("[Tt]", " ").str.replace(",", ".", literal=True)
    way = "%Y-%m-%d %H:%M:%S%.f"
    zoned = texts.str.to_datetime(f"{way}%#z", strict=False, time_unit="ns", exact=True).cast(pl.Int64)
    plain = texts.str.to_datetime(way, strict=False, time_unit="ns", exact=True).cast(pl.Int64)
    return zoned.fill_null(plain)


def time_of(part: pl.DataFrame, headers: list[str], plan: TimePlan) -> tuple[IntArray, BoolArray]:
    """time_ns and whether it is valid, each of shape (rows,)."""
    if plan.kind in ("calendar", "elapsed"):
        column = part[headers[0]]
        if is_text(column.dtype):
            stamps = _iso_stamps(column)
            return stamps.fill_null(0).to_numpy(), stamps.is_not_null().to_numpy()
        # a time of day has no unit: it is in nanoseconds
        stamps = (column if column.dtype == pl.Time else column.dt.cast_time_unit("ns")).cast(pl.Int64)
        return stamps.fill_null(0).to_numpy(), stamps.is_not_null().to_numpy()
    units = (plan.unit_ns,) if plan.kind == "decimal" else (1_000_000_000, 1)
    total = np.full(part.height, plan.origin_ns, dtype=np.int64)
    valid = np.ones(part.height, dtype=np.bool_)
    for header, unit_ns in zip(headers, units, strict=True):
        column = part[header]
        if column.dtype.is_integer():
            counted = column.cast(pl.Int64, strict=False) - plan.zero
            fits = (
                (counted.is_not_null() & (counted.abs() <= 2**63 // unit_ns - 1)).fill_null(False).to_numpy()
            )
            total += np.where(fits, counted.fill_null(0).to_numpy(), 0) * unit_ns
        else:
            scaled = (floats(column) - plan.zero) * unit_ns
            fits = np.abs(scaled) < 9.2e18
            total += np.rint(np.where(fits, scaled, 0.0)).astype(np.int64)
        valid &= fits
    return total, valid
