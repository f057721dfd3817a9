"""The fleet's tables as Parquet: the same bytes for the same rows, and read with their columns checked."""

from __future__ import annotations

import io

import polars as pl

from parsers.errors import StoreError
from parsers.native_stderr import quiet_panics
from pipelines.fleet.tables import TABLES

AGAIN = "run `cogest batch` again"


def check_name(name: str) -> None:
    """Raises StoreError for a name that no table has."""
    if name not in TABLES:
        raise StoreError(f"unknown table {name!r}", hint=f"known are {', '.join(TABLES)}", wrong_usage=True)


def table_bytes(table: pl.DataFrame) -> bytes:
    """A table as Parquet."""
    content = io.BytesIO()
    table.write_parquet(content, compression="zstd", statistics=True)
    return content.getvalue()


def table_from(content: bytes, name: str, place: str, where: pl.Expr | None = None) -> pl.DataFrame:
    """The table again. where: only these rows; the others are hardly unpacked. Raises StoreError, which names the place."""
    try:
        with quiet_panics():
            lazy = pl.scan_parquet(io.BytesIO(content))
            schema = dict(lazy.collect_schema())
            table = (lazy if where is None or schema != TABLES[name] else lazy.filter(where)).collect()
    except (pl.exceptions.PolarsError, pl.exceptions.PanicException, OSError, ValueError) as error:
        reason = str(error).partition("\n")[0]
        raise StoreError(f"damaged ({reason})", path=place, hint=AGAIN) from error
    if schema != TABLES[name]:
        raise StoreError("not the columns of this table", path=place, hint=AGAIN)
    return table
