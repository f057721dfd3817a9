"""What a worker does for one drive of a batch: analyse it, make its files, and put them into the store."""

from __future__ import annotations

import json
from pathlib import Path

from parsers.errors import CogestError
from parsers.places import as_path
from pipelines.analyze import Analysis, Request, analyze_whole
from pipelines.fleet.job_text import job_from
from pipelines.fleet.keys import key_of
from pipelines.fleet.records import Facts, FoundDrive, Job
from pipelines.fleet.store import Store, open_store
from reports.tire_force_file import FILE_NAME as FORCES
from reports.tire_force_file import tire_force_bytes
from reports.write import report_files

FUNCTION = "reports.drive_job:run"
"""How an engine names `run`."""


def _path(place: str | None) -> Path | None:
    return None if place is None else as_path(place)


def request_of(job: Job) -> Request:
    """The drive's analysis, as `cogest analyze` would have been asked for it."""
    drive, choices = job.drive, job.choices
    return Request(
        logs=tuple(as_path(place) for place in drive.logs),
        vehicle=_path(drive.vehicle),
        map=_path(drive.map),
        map_given=False,
        dbc=tuple(as_path(place) for place in drive.dbc),
        settings=_path(drive.settings),
        estimators=choices.estimators,
        seed=choices.seed,
        fix=choices.fix,
        command=job.command,
        version=choices.version,
    )


def files_of(analysis: Analysis, formats: tuple[str, ...]) -> dict[str, bytes]:
    """Every file of the drive's folder, by name: results, archive, reports, tyre forces where there are any."""
    files = report_files(analysis.results, (*formats, "json"))
    forces = tire_force_bytes(analysis.results)
    return files if forces is None else {**files, FORCES: forces}


def run(payload: str) -> str:
    """Do one drive: `Job` as JSON in; how it went as JSON out ("key").

    A known error (CogestError) is stored with the key of what failed, so that only a change makes it be tried again, and
    raised. Whatever else is raised leaves the store as it was.
    """
    job = job_from(payload)
    store = open_store(job.store)
    key, facts = key_of(job.drive, job.choices, {})
    try:
        analysis = analyze_whole(request_of(job))
        files = files_of(analysis, job.choices.formats)
    except CogestError as error:
        said = _of_drive(error, job.drive)
        _failed(store, job.drive, key, facts, said)
        raise said from error
    store.put(job.drive, key, facts, analysis.results, analysis.kept, files)
    return json.dumps({"key": key})


def _of_drive(error: CogestError, drive: FoundDrive) -> CogestError:
    """The error without its path where that is the drive's one log, which stands beside it wherever it is read."""
    if len(drive.logs) != 1 or error.path is None or error.path != as_path(drive.logs[0]):
        return error
    return type(error)(error.problem, place=error.place, hint=error.hint)


def _failed(store: Store, drive: FoundDrive, key: str, facts: dict[str, Facts], error: CogestError) -> None:
    store.put_failure(drive, key, facts, "error", str(error))
