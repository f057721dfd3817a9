"""A job as text, and back: what goes to a worker, which may run on another machine."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, fields
from typing import Any

from pipelines.fleet.records import Choices, Facts, FoundDrive, Job


def drive_dict(drive: FoundDrive) -> dict[str, Any]:
    """A found drive as JSON can hold it."""
    return asdict(drive)


def drive_from(raw: Mapping[str, Any]) -> FoundDrive:
    """A found drive again. Raises TypeError where the names are not its own."""
    return FoundDrive(**{key: tuple(v) if isinstance(v, list) else v for key, v in raw.items()})


def job_text(job: Job) -> str:
    """A job as JSON, one line. A file's name that is no text (odd bytes) survives as it is."""
    return json.dumps(asdict(job), ensure_ascii=True)


def job_from(text: str) -> Job:
    """The job again."""
    raw = json.loads(text)
    choices = raw["choices"]
    given = {f.name: raw[f.name] for f in fields(Job) if f.name not in ("drive", "choices", "facts")}
    return Job(
        drive=drive_from(raw["drive"]),
        choices=Choices(**{**choices, "formats": tuple(choices["formats"])}),
        facts={place: Facts(**known) for place, known in raw["facts"].items()},
        **given,
    )
