"""relations.parquet: what a drive told, as one long table that any reader of Parquet understands.

Column `entry` says what a row is:
- unknown: `name`, `mean`, `std` before the log, `value` at the mode; `column`: its number.
- relation: row `row` of the relations: `name` of the relation, `kind`, `source`, `value` observed.
- slope: what a unit of unknown `column` (`name`) adds to row `row`: `value`; what is not there is 0.
- given: a measured figure `name`. widened: factor `value` of relation `name`.
- inflation, normal: the drive's own, `value` (normal: 1 or 0).
- told, empty: parameter `name` of the drive, figure `name` of the vehicle: `value` and `std` that the drive leaves of it with all doubts.
  Files of earlier versions have none.
So row i says: the sum of slope x unknown = observed, with an error of 1.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any

import numpy as np
import polars as pl

from parsers.errors import StoreError
from pipelines.joint.kept import KeptRelations
from pipelines.results import FloatArray

FILE_NAME = "relations.parquet"
PAIRS = ("told", "empty")
MOST_BYTES = 64 * 2**20
MOST_UNKNOWNS = 2_000
MOST_RELATIONS = 50_000
MOST_ENTRIES = 4_000_000
MOST_FIGURES = 100_000_000
"""Of the full matrix (rows x unknowns); no drive comes near any of these limits."""

SCHEMA: dict[str, pl.DataType] = {
    "entry": pl.String(),
    "row": pl.Int32(),
    "column": pl.Int32(),
    "name": pl.String(),
    "kind": pl.String(),
    "source": pl.String(),
    "value": pl.Float64(),
    "mean": pl.Float64(),
    "std": pl.Float64(),
}


def _block(entry: str, **columns: Any) -> pl.DataFrame:
    """Rows of one kind; columns that they lack are null."""
    made = pl.DataFrame(columns, schema={name: SCHEMA[name] for name in columns})
    lacking = [pl.lit(None, dtype=SCHEMA[n]).alias(n) for n in SCHEMA if n not in columns and n != "entry"]
    return made.with_columns(pl.lit(entry).alias("entry"), *lacking).select(list(SCHEMA))


def _pairs(entry: str, pairs: Mapping[str, tuple[float, float]]) -> pl.DataFrame:
    """Rows of values with standard deviations."""
    values, stds = ([float(pair[i]) for pair in pairs.values()] for i in (0, 1))
    return _block(entry, name=list(pairs), value=values, std=stds)


def _paired(table: pl.DataFrame) -> dict[str, tuple[float, float]]:
    """The same, read."""
    pairs = zip(_figures(table, "value").tolist(), _figures(table, "std").tolist(), strict=True)
    return dict(zip(_texts(table, "name"), pairs, strict=True))


def relations_bytes(kept: KeptRelations) -> bytes:
    """The file's content; the same for the same relations."""
    # a zero with a sign is kept, so that what is read back is what was written, to the bit
    row, column = np.nonzero((kept.rows != 0) | np.signbit(kept.rows))
    names = np.array(kept.names, dtype=object)
    table = pl.concat(
        [
            _block(
                "unknown",
                column=np.arange(len(names)),
                name=list(kept.names),
                value=kept.mode,
                mean=kept.mean,
                std=kept.std,
            ),
            _block(
                "relation",
                row=np.arange(len(kept.observed)),
                name=list(kept.relation),
                kind=list(kept.kind),
                source=list(kept.source),
                value=kept.observed,
            ),
            _block("slope", row=row, column=column, name=list(names[column]), value=kept.rows[row, column]),
            _block("given", name=list(kept.given), value=[float(v) for v in kept.given.values()]),
            _block("widened", name=list(kept.widened), value=[float(v) for v in kept.widened.values()]),
            _block("inflation", value=[float(kept.inflation)]),
            _block("normal", value=[float(kept.normal)]),
            _pairs("told", kept.told),
            _pairs("empty", kept.empty),
        ]
    )
    content = io.BytesIO()
    table.write_parquet(content, compression="zstd", statistics=False)
    return content.getvalue()


def _read_table(content: bytes) -> pl.DataFrame:
    """The table, its size checked before anything is unpacked. Raises StoreError.

    Damaged Parquet can end the whole process in polars: a store compares the file's hash before it comes here.
    """
    if len(content) > MOST_BYTES:
        raise StoreError(f"larger than {MOST_BYTES // 2**20} MiB, no drive's relations are")
    try:
        lazy = pl.scan_parquet(io.BytesIO(content))
        if dict(lazy.collect_schema()) != SCHEMA:
            raise StoreError("not the columns of a drive's relations")
        entries = int(lazy.select(pl.len()).collect().item())
        if entries > MOST_ENTRIES:
            raise StoreError(f"{entries} entries, a drive's relations have at most {MOST_ENTRIES}")
        return pl.read_parquet(io.BytesIO(content))
    except (pl.exceptions.PolarsError, pl.exceptions.PanicException, OSError, ValueError) as error:
        raise StoreError(
            f"not whole Parquet ({str(error).splitlines()[0] if str(error) else error!r})"
        ) from error


def _numbered(table: pl.DataFrame, column: str, what: str, most: int) -> None:
    """Raises StoreError where rows are not numbered 0, 1, …"""
    if table.height > most:
        raise StoreError(f"{table.height} {what}, at most {most} are read")
    if table[column].to_list() != list(range(table.height)):
        raise StoreError(f"the {what} are not numbered in order")


def _texts(table: pl.DataFrame, column: str) -> tuple[str, ...]:
    if table[column].null_count():
        raise StoreError(f"{column!r} is empty where it must not be")
    return tuple(table[column].to_list())


def _figures(table: pl.DataFrame, column: str) -> FloatArray:
    if table[column].null_count():
        raise StoreError(f"{column!r} is empty where it must not be")
    return table[column].to_numpy().astype(np.float64)


def _single(table: pl.DataFrame, entry: str) -> float:
    if table.height != 1:
        raise StoreError(f"{table.height} entries {entry!r}, expected one")
    return float(_figures(table, "value")[0])


def relations_from(content: bytes) -> KeptRelations:
    """The relations of such a file. Raises StoreError for anything that is none."""
    table = _read_table(content)
    parts = {
        entry: table.filter(pl.col("entry") == entry)
        for entry in ("unknown", "relation", "slope", "given", "widened", "inflation", "normal", *PAIRS)
    }
    unknown, relation, slope = parts["unknown"], parts["relation"], parts["slope"]
    _numbered(unknown, "column", "unknowns", MOST_UNKNOWNS)
    _numbered(relation, "row", "relations", MOST_RELATIONS)
    if relation.height * unknown.height > MOST_FIGURES:
        raise StoreError(f"a matrix of {relation.height} x {unknown.height} figures")
    rows = np.zeros((relation.height, unknown.height))
    if slope.height:
        at, of = _figures(slope, "row").astype(np.int64), _figures(slope, "column").astype(np.int64)
        if at.min() < 0 or of.min() < 0 or at.max() >= rows.shape[0] or of.max() >= rows.shape[1]:
            raise StoreError("a slope of a relation or an unknown that is not there")
        rows[at, of] = _figures(slope, "value")
    given, widened = parts["given"], parts["widened"]
    return KeptRelations(
        names=_texts(unknown, "name"),
        mean=_figures(unknown, "mean"),
        std=_figures(unknown, "std"),
        mode=_figures(unknown, "value"),
        rows=rows,
        observed=_figures(relation, "value"),
        relation=_texts(relation, "name"),
        kind=_texts(relation, "kind"),
        source=_texts(relation, "source"),
        given=dict(zip(_texts(given, "name"), _figures(given, "value").tolist(), strict=True)),
        widened=dict(zip(_texts(widened, "name"), _figures(widened, "value").tolist(), strict=True)),
        inflation=_single(parts["inflation"], "inflation"),
        normal=bool(_single(parts["normal"], "normal")),
        told=_paired(parts["told"]),
        empty=_paired(parts["empty"]),
    )
