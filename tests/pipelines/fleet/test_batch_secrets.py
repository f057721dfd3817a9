"""A fleet's URL with a password: the batch works with it, and shows it nowhere."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pipelines.fleet.batch import Batch, plan_of, run_batch
from pipelines.fleet.batch_log import FILE_NAME, BatchLog
from pipelines.fleet.events import Event, event_json
from pipelines.fleet.find import find_drives
from pipelines.fleet.records import Choices
from reports.dry_run_text import plan_dict

fsspec = pytest.importorskip("fsspec")
SECRET = "s3cret"


def test_the_password_of_a_fleets_url_is_in_no_log_event_or_plan(tmp_path: Path) -> None:
    place = f"user:{SECRET}@{tmp_path.name}/fleet"
    files = fsspec.filesystem("memory")
    # a drive that fails at once, and a file that is none
    files.pipe(f"/{place}/drive.csv", b"time_s,speed_mps\n")
    files.pipe(f"/{place}/notes.csv", b"a,b\n1,2\n")
    store = str(tmp_path / "store")
    found = find_drives(f"memory://{place}", store)
    batch = Batch(f"memory://{place}", store, Choices(formats=(), version="1"), engine="serial")
    told = [json.dumps(plan_dict(found, plan_of(batch, found).states))]
    with BatchLog(store, told.append) as log:

        def watch(event: Event) -> None:
            log(event)
            told.append(event_json(event))

        run_batch(batch, found, "reports.drive_job:run", watch)
    told.append((tmp_path / "store" / FILE_NAME).read_text())
    assert "memory://…@" in told[-1]
    assert not any(SECRET in text for text in told)
