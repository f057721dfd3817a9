"""A store's tables for other programs: rows chosen, and written as CSV, Parquet or JSON."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Collection, Sequence

import polars as pl

from parsers.errors import StoreError
from pipelines.fleet.tables import STATUSES, TABLES
from reports.layout import printable

FAILED = "failed"
"""As a status of drives: every one but "done"."""
LIST_MARK = "; "
"""Between the entries of a list in a cell of CSV."""
_NO_TEXT = r"[\p{Cc}\p{Cf}\p{Zl}\p{Zp}]"
"""Control characters, marks that turn writing round, line breaks of all kinds."""
_FORMULA = r"^\s*[=+\-@＝＋－＠]"
"""How a cell begins that a spreadsheet would take for a formula."""


def wanted_rows(
    name: str,
    *,
    vehicles: Sequence[str] = (),
    statuses: Sequence[str] = (),
    parameters: Sequence[str] = (),
) -> pl.Expr | None:
    """What `chosen` keeps of a table, to be asked of its file; None = all, or what `chosen` will complain of."""
    columns = TABLES[name]
    asked = {"vehicle_id": vehicles, "status": statuses, "parameter": parameters}
    named = {column: list(values) for column, values in asked.items() if values}
    if not named or any(column not in columns for column in named) or _odd(name, statuses):
        return None
    wanted = [
        _of_statuses(values)
        if column == "status"
        else _of_vehicles(values, columns)
        if column == "vehicle_id"
        else pl.col(column).is_in(values)
        for column, values in named.items()
    ]
    return pl.all_horizontal(wanted)


def _known_statuses(name: str) -> tuple[str, ...]:
    """What may be asked of a table's column `status`."""
    return (*STATUSES.get(name, ()), *((FAILED,) if name == "drives" else ()))


def _odd(name: str, statuses: Sequence[str]) -> list[str]:
    """The statuses asked for that no row of this table can have."""
    known = _known_statuses(name)
    return [status for status in statuses if status not in known]


def _of_statuses(statuses: Sequence[str]) -> pl.Expr:
    wanted = pl.col("status").is_in(list(statuses))
    return wanted | (pl.col("status") != "done") if FAILED in statuses else wanted


def _of_vehicles(vehicles: Sequence[str], columns: Collection[str]) -> pl.Expr:
    mine = pl.col("vehicle_id").is_in(list(vehicles))
    if "vehicle_name" in columns:
        mine |= pl.col("vehicle_name").is_in(list(vehicles)).fill_null(False)
    return mine


def chosen(
    table: pl.DataFrame,
    name: str,
    *,
    vehicles: Sequence[str] = (),
    statuses: Sequence[str] = (),
    parameters: Sequence[str] = (),
) -> pl.DataFrame:
    """The rows of these vehicles (by id or name), statuses and parameters; all where none are named.

    Raises StoreError where the table has no such column, or knows no such vehicle, status or parameter.
    """
    columns = set(table.columns)
    for asked, column in ((statuses, "status"), (parameters, "parameter")):
        if asked and column not in columns:
            raise StoreError(f"the table {name!r} has no column {column!r}", hint="leave that option out")
    if vehicles:
        table = _some(table, _of_vehicles(vehicles, columns), "vehicle", vehicles)
    if statuses:
        # a status that may be and that no row has is an answer: no rows
        if odd := _odd(name, statuses):
            known = ", ".join(_known_statuses(name))
            raise StoreError(
                f"no status {printable(odd[0])} in the table {name!r}", hint=f"there are {known}"
            )
        table = table.filter(_of_statuses(statuses))
    if parameters:
        table = _some(table, pl.col("parameter").is_in(list(parameters)), "parameter", parameters)
    return table


def _some(table: pl.DataFrame, wanted: pl.Expr, what: str, names: Sequence[str]) -> pl.DataFrame:
    found = table.filter(wanted)
    if found.is_empty() and not table.is_empty():
        known = sorted(set(table[f"{what}_id" if what == "vehicle" else what].drop_nulls().to_list()))
        more = ", …" if len(known) > 12 else ""
        asked = printable(", ".join(names))
        raise StoreError(f"no {what} {asked} in this table", hint=f"there are {', '.join(known[:12])}{more}")
    return found


def _harmless(column: str) -> pl.Expr:
    """Text that a spreadsheet shows and does not run: no control characters, an apostrophe before what begins a formula."""
    text = pl.col(column).str.replace_all(_NO_TEXT, " ")
    return (
        pl.when(text.str.contains(_FORMULA))
        .then(pl.concat_str(pl.lit("'"), text))
        .otherwise(text)
        .alias(column)
    )


def csv_bytes(table: pl.DataFrame) -> bytes:
    """CSV (UTF-8, RFC 4180): lists joined, nothing where there is no value, texts harmless in a spreadsheet."""
    lists = [name for name, kind in table.schema.items() if isinstance(kind, pl.List)]
    table = table.with_columns(pl.col(lists).list.join(LIST_MARK)) if lists else table
    texts = [name for name, kind in table.schema.items() if kind == pl.String]
    table = table.with_columns(_harmless(name) for name in texts)
    return table.write_csv().encode("utf-8")


def json_bytes(table: pl.DataFrame) -> bytes:
    """A JSON array with an object a row, in ASCII: no text in it can steer a terminal."""
    return re.sub(r"[^\x00-\x7e]", _escape, table.write_json()).encode("ascii") + b"\n"


def _escape(found: re.Match[str]) -> str:
    """A character as JSON's \\uXXXX, two of them beyond the first plane."""
    units = found[0].encode("utf-16-be").hex()
    return "".join(f"\\u{units[i : i + 4]}" for i in range(0, len(units), 4))


def parquet_bytes(table: pl.DataFrame) -> bytes:
    """Parquet with the store's own columns."""
    content = io.BytesIO()
    table.write_parquet(content)
    return content.getvalue()


EXPORTS: dict[str, Callable[[pl.DataFrame], bytes]] = {
    "csv": csv_bytes,
    "parquet": parquet_bytes,
    "json": json_bytes,
}
"""Form -> what writes it; also the file name's suffix."""
