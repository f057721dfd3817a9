"""Reading a Parquet table around pages that cannot be decoded: column by column, and in parts where a column has one."""

from __future__ import annotations

from collections.abc import Sequence

import polars as pl

from parsers.native_stderr import quiet_panics
from parsers.parquet_checksums import Spans
from parsers.parquet_group import FAILURES

_PARTS = 16
"""In so many parts a column is read that cannot be read at once: each of them goes through its group of rows again."""


def readable(frame: pl.LazyFrame, names: Sequence[str], rows: int) -> pl.DataFrame:
    """The first rows of those columns that can be decoded there."""
    found = [part for name in names if (part := _collect(frame.select(name), 0, rows)) is not None]
    return pl.concat(found, how="horizontal") if found else pl.DataFrame()


def collect_around(
    frame: pl.LazyFrame, start: int, rows: int, times: Sequence[str], columns: Sequence[str]
) -> tuple[pl.DataFrame, dict[str, Spans]]:
    """Rows from `start` on, and for the columns that cannot be decoded everywhere the rows of the file where they are empty.

    Raises FAILURES where the columns that tell the time cannot be decoded.
    """
    found, lost = frame.select(times).slice(start, rows).collect(), {}
    height = found.height
    for name in columns:
        part = _collect(frame.select(name), start, height)
        if part is None:
            part, lost[name] = _in_parts(frame.select(name), name, start, height)
        found = found.with_columns(part[name])
    return found, lost


def _in_parts(frame: pl.LazyFrame, name: str, start: int, rows: int) -> tuple[pl.DataFrame, Spans]:
    step = max(1, -(-rows // _PARTS))
    kind = frame.collect_schema()[name]
    parts, lost = [], []
    for at in range(start, start + rows, step):
        stop = min(at + step, start + rows)
        part = _collect(frame, at, stop - at)
        if part is None:
            lost.append((at, stop))
            part = pl.DataFrame({name: pl.Series([None] * (stop - at), dtype=kind)})
        parts.append(part)
    return pl.concat(parts), lost


def _collect(frame: pl.LazyFrame, start: int, rows: int) -> pl.DataFrame | None:
    try:
        with quiet_panics():
            return frame.slice(start, rows).collect()
    except FAILURES:
        return None
