"""`cogest results`: what a store holds, as a table on the terminal or as a file for other programs."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from collections.abc import Sequence

    import polars as pl

    from pipelines.fleet.store import Store

FORMS = ("csv", "parquet", "json")
TEXT = ("", "txt")
"""Endings of a file for the table to read."""


def results(
    store: Annotated[
        str,
        typer.Argument(
            metavar="STORE", help="A results store: a folder or a URL (s3://…).", show_default=False
        ),
    ],
    csv: Annotated[bool, typer.Option("--csv", help="CSV instead of a table to read.")] = False,
    parquet: Annotated[bool, typer.Option("--parquet", help="Parquet; with --out or into a pipe.")] = False,
    json: Annotated[bool, typer.Option("--json", help="A JSON array with an object a row.")] = False,
    out: Annotated[
        Path | None,
        typer.Option(
            help="File to write; its ending may say the form: .csv, .parquet, .json, or .txt for the table to read.",
            show_default=False,
        ),
    ] = None,
    table: Annotated[
        str | None,
        typer.Option(
            help="drives, parameters, vehicles, load_changes, trends or outliers; default: an overview of the drives.",
            show_default=False,
        ),
    ] = None,
    vehicle: Annotated[
        list[str] | None,
        typer.Option(help="Only this vehicle, by id or name; may be repeated.", show_default=False),
    ] = None,
    status: Annotated[
        list[str] | None,
        typer.Option(
            help="Only this status (done, error … of drives, identified, weak … of parameters); may be repeated; "
            "`failed` = every drive that is not done.",
            show_default=False,
        ),
    ] = None,
    parameter: Annotated[
        list[str] | None,
        typer.Option(help="Only this parameter (cg_height_m …); may be repeated.", show_default=False),
    ] = None,
) -> None:
    """Print what a results store holds, or export it: drives, parameters with intervals, failures with reasons."""
    form = _form({"csv": csv, "parquet": parquet, "json": json}, out)
    from pipelines.fleet.store import open_store
    from reports.results_export import EXPORTS

    opened = open_store(store)
    options = {"vehicles": vehicle or (), "statuses": status or ()}
    if form is None and table in (None, "drives"):
        _overview(opened, vehicle or [], status or [], parameter or [], out)
        return
    name = table or ("parameters" if parameter else "drives")
    rows = _rows(opened, name, parameters=parameter or (), **options)
    if form is None:
        from reports.results_text import table_text

        _text(table_text(name, rows), out)
        return
    _send(EXPORTS[form](rows), form, out)


def _rows(store: Store, name: str, **options: Sequence[str]) -> pl.DataFrame:
    """The rows asked for. Raises StoreError as `chosen`, for which the whole table is read only where none is found."""
    from pipelines.fleet.table_files import check_name
    from reports.results_export import chosen, wanted_rows

    check_name(name)
    where = wanted_rows(name, **options)
    rows = store.read_table(name, where)
    if where is not None and rows.is_empty():
        rows = store.read_table(name)
    return chosen(rows, name, **options)


def _form(asked: dict[str, bool], out: Path | None) -> str | None:
    """The form asked for, by option or by the file's ending; None = text.

    Raises typer.BadParameter, and ReportError for an ending that says another form.
    """
    forms = [form for form, wanted in asked.items() if wanted]
    if len(forms) > 1:
        raise typer.BadParameter(f"--{forms[0]} and --{forms[1]}: choose one")
    suffix = "" if out is None else out.suffix.lower().lstrip(".")
    if forms:
        if suffix in {*FORMS, *TEXT} - {"", forms[0]}:
            raise typer.BadParameter(f"--{forms[0]} and --out ending in .{suffix}: choose one")
        return forms[0]
    if suffix in FORMS:
        return suffix
    if suffix not in TEXT:
        from parsers.errors import ReportError

        raise ReportError(
            f"results cannot be written as {f'.{suffix}'!r}",
            path=out,
            hint="choose .csv, .parquet, .json or .txt, or say --csv, --parquet or --json",
        )
    return None


def _overview(
    store: Store, vehicles: list[str], statuses: list[str], names: list[str], out: Path | None
) -> None:
    from parsers.errors import StoreError
    from reports.results_export import wanted_rows
    from reports.results_text import USUAL, overview_text

    drives = _rows(store, "drives", vehicles=vehicles, statuses=statuses)
    mine = drives["vehicle_id"].unique().to_list() if vehicles or statuses else ()
    where = wanted_rows("parameters", vehicles=mine, parameters=names or USUAL)
    parameters = store.read_table("parameters", where)
    if any(name not in parameters["parameter"] for name in names):
        known = set(store.read_table("parameters")["parameter"].unique().to_list())
        if unknown := [name for name in names if name not in known]:
            raise StoreError(
                f"no parameter {unknown[0]!r} in this store", hint=f"there are {', '.join(sorted(known))}"
            )
    _text(overview_text(drives, parameters, names, store.place), out)


def _text(text: str, out: Path | None) -> None:
    from cogest_cli.output import show
    from reports.files import write_whole

    if out is None:
        show(text)
    else:
        write_whole(out, f"{text}\n".encode())


def _send(content: bytes, form: str, out: Path | None) -> None:
    """To the file, or to standard output. Raises typer.BadParameter for Parquet on a terminal."""
    from cogest_cli.output import show_line
    from reports.files import write_whole

    if out is not None:
        write_whole(out, content)
        show_line(out)
        return
    if form == "parquet" and sys.stdout.isatty():
        raise typer.BadParameter("Parquet is no text: give a file with --out")
    sys.stdout.flush()
    sys.stdout.buffer.write(content)
