"""`cogest batch`: a folder of logs in, a results store and a fleet report out."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from cogest_cli.options import Estimators, NoFix, Seed, command_line

if TYPE_CHECKING:
    from collections.abc import Sequence

    from pipelines.estimators.base import Estimator
    from pipelines.fleet.batch import Batch
    from pipelines.fleet.records import BatchSummary, FoundFleet
    from pipelines.fleet.store import Store

FAILED = 3
"""Exit code of a batch that went to its end with some drives failed."""

Folder = Annotated[
    str,
    typer.Argument(metavar="FOLDER", help="The fleet's folder, or a URL (s3://…).", show_default=False),
]
Out = Annotated[str, typer.Option("--out", help="The results store: a folder or a URL.")]
Workers = Annotated[
    int | None,
    typer.Option(help="Drives at a time; default: one for each core.", min=1, show_default=False),
]
Engine = Annotated[
    str, typer.Option(help="What does the work: serial, local (processes of this machine) or dask.")
]
Scheduler = Annotated[
    str | None,
    typer.Option(help="A running Dask cluster's scheduler (tcp://host:port).", show_default=False),
]
Fresh = Annotated[bool, typer.Option("--fresh", help="Do every drive again.")]
Retry = Annotated[
    bool, typer.Option("--retry", help="Try drives again that failed, though nothing has changed.")
]
Prune = Annotated[bool, typer.Option("--prune", help="Take drives out of the store whose logs are no more.")]
DryRun = Annotated[bool, typer.Option("--dry-run", help="Only list what would be done, and what lacks what.")]
Events = Annotated[bool, typer.Option("--json", help="Events as JSON lines on stdout, for scripts.")]
TimeLimit = Annotated[float, typer.Option(help="Seconds that one drive may take; 0: no limit.", min=0.0)]
MemoryLimit = Annotated[
    float | None,
    typer.Option(help="GiB that one drive may take; default: no limit.", min=0.1, show_default=False),
]
Reports = Annotated[
    str, typer.Option(help="Reports of each drive: html, pdf, html,pdf, or none (results are always kept).")
]
Formats = Annotated[str, typer.Option("--format", help="Of the fleet's report.")]


def batch(
    folder: Folder,
    out: Out = "store",
    workers: Workers = None,
    engine: Engine = "local",
    scheduler: Scheduler = None,
    fresh: Fresh = False,
    retry: Retry = False,
    prune: Prune = False,
    dry_run: DryRun = False,
    events: Events = False,
    time_limit: TimeLimit = 3600.0,
    memory_limit: MemoryLimit = None,
    estimators: Estimators = None,
    reports: Reports = "html",
    formats: Formats = "html,pdf",
    seed: Seed = 0,
    no_fix: NoFix = False,
) -> None:
    """Analyse a folder of drives: a results store, one verdict a drive and a vehicle, and a fleet report."""
    from cogest_cli.version import version
    from parsers.errors import EngineError
    from pipelines.engines.base import Limits
    from pipelines.engines.registry import engine_named
    from pipelines.estimators.registry import estimators as known
    from pipelines.fleet.batch import Batch
    from pipelines.fleet.find import find_drives
    from pipelines.fleet.records import Choices
    from pipelines.settings import choose
    from reports.fleet.stored import check_fleet_formats
    from reports.write import check_drive_reports

    chosen = choose(estimators, known())
    wanted = check_drive_reports(reports)
    if scheduler is not None and engine != "dask":
        raise EngineError(
            "--scheduler goes with --engine dask", hint="give both, or neither", wrong_usage=True
        )
    engine_named(engine, workers, scheduler)  # what cannot be is said before the folder is walked
    asked = Batch(
        folder=folder,
        store=out,
        choices=Choices(estimators, seed, not no_fix, wanted, version()),
        engine=engine,
        workers=workers,
        scheduler=scheduler,
        limits=Limits(time_limit or None, None if memory_limit is None else round(memory_limit * 2**30)),
        fresh=fresh,
        retry=retry,
        prune=prune,
        formats=check_fleet_formats(formats),
        command=command_line(),
    )
    found = find_drives(folder, out)
    if dry_run:
        _tell_plan(asked, found, chosen, events)
        return
    summary = _run(asked, found, events)
    if summary.failed:
        raise typer.Exit(FAILED)


def _tell_plan(batch: Batch, found: FoundFleet, chosen: Sequence[Estimator], as_json: bool) -> None:
    """Print what would be done, and what each drive lacks for the estimators that are chosen."""
    import json

    from cogest_cli.output import show
    from cogest_cli.progress import ProgressLine
    from pipelines.fleet.batch import plan_of
    from pipelines.fleet.outlook import outlook
    from reports.dry_run_text import plan_dict, text

    plan = plan_of(batch, found)
    outlooks = {}
    with ProgressLine() as progress:
        for number, drive in enumerate(found.drives):
            progress(f"looking into {drive.name}", number / len(found.drives))
            outlooks[drive.drive_id] = outlook(drive, chosen=chosen)
    if as_json:
        print(json.dumps(plan_dict(found, plan.states, outlooks, plan.absent), indent=1))
    else:
        show(text(found, plan.states, outlooks, absent=plan.absent))


def _run(batch: Batch, found: FoundFleet, as_json: bool) -> BatchSummary:
    """Do the work, watched; print what was written and what failed."""
    from cogest_cli.batch_progress import watching
    from pipelines.fleet.batch import run_batch
    from pipelines.fleet.events import Finished, Reported
    from reports.drive_job import FUNCTION
    from reports.fleet.stored import keep_facts, put_fleet_report

    written: list[str] = []

    def finish(store: Store, summary: BatchSummary) -> None:
        keep_facts(store, found, summary, batch.choices.version)
        written.extend(put_fleet_report(store, batch.formats))
        watch(Reported(tuple(written)))

    with watching(batch.store, as_json=as_json) as watch:
        ran = run_batch(batch, found, FUNCTION, watch, finish)
        watch(Finished(ran.summary))
    if not as_json:
        _tell(ran.summary, written)
    return ran.summary


def _tell(summary: BatchSummary, written: list[str]) -> None:
    from cogest_cli.batch_progress import counted
    from cogest_cli.output import show_line

    parts = [f"{summary.done} done", f"{summary.kept} kept", f"{len(summary.failed)} failed"]
    if summary.gone:
        parts.append(f"{summary.gone} in the store whose logs are gone")
    if summary.moved:
        parts.append(f"{summary.moved} moved since (the old place no longer counts)")
    show_line(f"{counted(summary.found, 'drive')}: {', '.join(parts)}")
    for ended in summary.failed:
        show_line(f"  {ended.drive.name}: {ended.status}: {ended.reason}")
    for place in written:
        show_line(place)
