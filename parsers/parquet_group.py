"""One opened file of a Parquet log."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import polars as pl

from parsers.errors import LogError
from parsers.table_names import ColumnName
from parsers.table_time_plan import TimePlan

if TYPE_CHECKING:
    from parsers.parquet_parts import PartlyFilled

FAILURES = (pl.exceptions.PolarsError, pl.exceptions.PanicException, OSError, ValueError)
"""What polars raises over a file that is damaged."""


@dataclass(frozen=True)
class ParquetGroup:
    """One file. names: channel name of each column, unique in the whole log; the file's own in `headers`. rows.

    table: which of the log's tables it is a part of. far: what was fetched of a file behind a URL. left_out: places of columns whose stamps are not `time`'s, or that cannot be read.
    """

    path: Path
    name: str
    names: tuple[ColumnName, ...]
    headers: tuple[str, ...]
    types: tuple[pl.DataType, ...]
    time: TimePlan
    rows: int
    table: int = 0
    far: PartlyFilled | None = None
    left_out: frozenset[int] = frozenset()

    def frame(self, columns: Sequence[str]) -> pl.LazyFrame:
        """These columns of the table. Raises OSError, LogError where they cannot be fetched."""
        if self.far is not None:
            self.far.fill(columns)
        return pl.scan_parquet(self.far.path if self.far else self.path, glob=False).select(columns)


def damaged(path: Path, error: BaseException) -> LogError:
    """The error for a file that polars cannot read."""
    first_line = str(error).splitlines()[0] if str(error) else type(error).__name__
    if isinstance(error, pl.exceptions.PanicException):
        first_line = "a page of it cannot be decoded"
    return LogError(f"the Parquet file is damaged ({first_line})", path=path, hint="copy or convert it again")
