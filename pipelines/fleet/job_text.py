"""A job as text, and back: what goes to a worker, which may run on another machine."""

from __future__ import annotations

from pipelines.fleet.plain import from_plain, json_bytes, read_json
from pipelines.fleet.records import Job


def job_text(job: Job) -> str:
    """A job as JSON, one line. A file's name that is no text (odd bytes) survives as it is."""
    return json_bytes(job).decode("ascii")


def job_from(text: str) -> Job:
    """The job again. Raises StoreError where the text is no job."""
    return from_plain(Job, read_json(text.encode("ascii")))
