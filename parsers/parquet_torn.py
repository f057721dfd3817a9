"""What the torn pages of a Parquet file (`parsers.parquet_checksums`) cost: the values in them, which are left out, counted and dated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import polars as pl

from parsers.channels import FloatArray, IntArray
from parsers.errors import LogError
from parsers.importer import ImportLog
from parsers.native_stderr import quiet_panics
from parsers.parquet_around import collect_around
from parsers.parquet_checksums import Spans, torn_rows
from parsers.parquet_group import FAILURES, ParquetGroup
from parsers.table_stamps import BoolArray


class TornPages:
    """The torn pages of one file, as its rows are gone through. times: the columns that tell the time; columns: names -> those
    that are wanted, both by the file's own names. Raises OSError."""

    def __init__(
        self, group: ParquetGroup, times: Sequence[str], columns: Mapping[str, str], log: ImportLog
    ) -> None:
        self._log = log
        self._last_ns: int | None = None
        self._name = group.path.name
        self._columns = columns
        torn = torn_rows(group.far.path if group.far else group.path, {*times, *columns.values()})
        self._times: Spans = [span for header in times for span in torn.get(header, [])]
        self._cells = {name: torn[header] for name, header in columns.items() if header in torn}
        if torn:
            pages = sum(map(len, torn.values()))
            what = "a page is" if pages == 1 else f"{pages} pages are"
            log.worsen(
                "malformed",
                f"{self._name} is damaged: {what} not what the checksum says; what stands there is left out",
            )

    def add(self, lost: Mapping[str, Spans]) -> None:
        """Know of rows where a column cannot be decoded. lost: by the file's own names."""
        for name, header in self._columns.items():
            if header in lost:
                self._cells[name] = _joined([*self._cells.get(name, []), *lost[header]])
                self._log.worsen(
                    "malformed",
                    f'{self._name} is damaged: column "{header}" cannot be decoded in some rows, which have no value there',
                )

    def take_out(
        self, start: int, valid: BoolArray, values: dict[str, FloatArray]
    ) -> tuple[BoolArray, dict[str, FloatArray]]:
        """Rows from `start` on less what is torn. valid: (rows,) whether their time is; values: (rows,) each, NaN where empty."""
        for a, b in _inside(self._times, start, len(valid)):
            valid = valid.copy()
            self._log.reject("row in a damaged page", int(valid[a:b].sum()))
            valid[a:b] = False
        for name, spans in self._cells.items():
            for a, b in _inside(spans, start, len(valid)):
                self._log.reject("cell in a damaged page", b - a)
                values[name] = values[name].copy()
                values[name][a:b] = np.nan
        return valid, values

    def write_spans(self, start: int, rows: IntArray, time_ns: IntArray) -> None:
        """Write down which time is lost. rows: those that are kept, counted from `start`, and their stamps; (n,), n > 0."""
        spans = {*self._times, *(span for each in self._cells.values() for span in each)}
        for a, b in sorted(_inside(sorted(spans), start, int(rows[-1]) + 1)):
            before, after = int(np.searchsorted(rows, a)) - 1, int(np.searchsorted(rows, b))
            since = self._last_ns if before < 0 else int(time_ns[before])
            until = int(time_ns[min(after, len(rows) - 1)])
            self._log.lost_spans_ns.append((int(time_ns[0]) if since is None else since, until))
        self._last_ns = int(time_ns[-1])


def _joined(spans: Spans) -> Spans:
    """The same rows, each once."""
    out: Spans = []
    for a, b in sorted(spans):
        if out and a <= out[-1][1]:
            out[-1] = (out[-1][0], max(b, out[-1][1]))
        else:
            out.append((a, b))
    return out


def _inside(spans: Spans, start: int, rows: int) -> list[tuple[int, int]]:
    """What of the spans lies in `rows` rows from `start` on, counted from there."""
    cut = ((max(a - start, 0), min(b - start, rows)) for a, b in spans)
    return [(a, b) for a, b in cut if a < b]


def torn_pages(
    group: ParquetGroup, times: Sequence[str], columns: Mapping[str, str], log: ImportLog
) -> TornPages:
    """What is known of a file's damaged pages. Raises LogError where it cannot be read."""
    try:
        return TornPages(group, times, columns, log)
    except OSError as error:
        raise LogError(f"cannot be read ({error.strerror})", path=group.path) from error


def read_slice(
    frame: pl.LazyFrame,
    start: int,
    rows: int,
    times: Sequence[str],
    columns: Mapping[str, str],
    torn: TornPages,
) -> pl.DataFrame:
    """Rows from `start` on; what cannot be decoded is empty. Raises FAILURES where the time cannot be."""
    with quiet_panics():
        try:
            return frame.slice(start, rows).collect()
        except FAILURES:
            part, lost = collect_around(frame, start, rows, times, [*columns.values()])
    torn.add(lost)
    return part
