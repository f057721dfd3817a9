"""The folder of a stored drive: its files' names, the import record, and how new tables take the place of old ones."""

from __future__ import annotations

import json
import re
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path

from parsers.drive import ImportRecord
from parsers.errors import LogError

RECORD_FILE = "import_record.json"
SUFFIX = ".parquet"
_RATES = re.compile(r"(?:(?:^|_)(?:[0-9]+hz|once)(?:_[0-9]+)?)+$")


def _file_name(group: str, period_s: float, taken: set[str]) -> str:
    """A name that tells the rate and the group, safe on every file system."""
    rate = f"{1 / period_s:.0f}hz" if period_s > 0 else "once"
    group = re.sub(r"[^A-Za-z0-9]+", "_", group).strip("_").lower()[:60]
    # the name that an earlier run gave it, or a topic's own
    group = _RATES.sub("", group)
    base = f"{group}_{rate}" if group else rate
    name, number = base, 2
    while name in taken:
        name, number = f"{base}_{number}", number + 1
    taken.add(name)
    return f"{name}{SUFFIX}"


def record_dict(record: ImportRecord) -> dict[str, object]:
    """The import record as JSON can hold it."""
    return {**asdict(record), "paths": [str(path) for path in record.paths]}


def _previous(folder: Path) -> set[Path]:
    """The tables that an earlier run wrote here, by the record that it left. Names only: a record leads nowhere else."""
    try:
        names = json.loads((folder / RECORD_FILE).read_text(encoding="utf-8")).get("files", [])
    except (OSError, ValueError, AttributeError, RecursionError):
        return set()
    texts = [name for name in names if isinstance(name, str)] if isinstance(names, list) else []
    return {folder / name for name in texts if name == Path(name).name and name.endswith(SUFFIX)}


def refuse_strangers(folder: Path) -> set[Path]:
    """The tables that an earlier run wrote into a folder. Raises LogError where tables of others lie there too: it would
    no longer read as one drive."""
    ours = _previous(folder)
    strangers = sorted(
        p.name for p in folder.iterdir() if p.suffix.lower() in (SUFFIX, ".pq") and p not in ours
    )
    if strangers:
        raise LogError(
            f"holds Parquet files that `cogest convert` did not write ({', '.join(strangers[:3])})",
            path=folder,
            hint="choose an empty folder with --out: all tables of a folder are read as one drive",
        )
    return ours


def _write_record(record: ImportRecord, folder: Path, files: Collection[str]) -> Path:
    path = folder / RECORD_FILE
    text = json.dumps({"files": sorted(files), **record_dict(record)}, indent=1, ensure_ascii=False)
    # the name of a log may hold bytes that are no text
    path.write_bytes(text.encode("utf-8", "replace"))
    return path


class Replacement:
    """Tables that take the place of those that an earlier run wrote into a folder, all at once: until then nothing there
    changes, and after an error nothing is left behind."""

    def __init__(self, folder: Path) -> None:
        """Raises LogError where the folder holds tables of others, OSError where it cannot be made."""
        folder.mkdir(parents=True, exist_ok=True)
        self._folder = folder
        self._ours = refuse_strangers(folder)
        self._parts: list[Path] = []
        self._made: dict[Path, Path] = {}
        self._taken: set[str] = set()

    def __enter__(self) -> Replacement:
        """Start."""
        return self

    def __exit__(self, *_: object) -> None:
        """Take away what did not find its place."""
        for part in self._parts:
            part.unlink(missing_ok=True)

    def part(self) -> Path:
        """A hidden file to write the next table into."""
        self._parts.append(self._folder / f".table{len(self._parts)}.part")
        return self._parts[-1]

    def name(self, part: Path, group: str, period_s: float) -> None:
        """Say what a part is called in the end. period_s: the usual step of its longest signal."""
        self._made[self._folder / _file_name(group, period_s, self._taken)] = part

    def commit(self, record: ImportRecord) -> list[Path]:
        """Put the tables in their places, and write the record; the files written."""
        made, ours = self._made, self._ours
        # a run that is killed in the middle still leaves a record of all that it may have written
        _write_record(record, self._folder, {path.name for path in ours | made.keys()})
        for stale in ours - made.keys():
            stale.unlink(missing_ok=True)
        for path, part in made.items():
            part.replace(path)
        return [*made, _write_record(record, self._folder, {path.name for path in made})]


@contextmanager
def write_errors(folder: Path) -> Iterator[None]:
    """Turn what goes wrong on the way to the disk into a LogError."""
    try:
        yield
    except Exception as error:
        # polars is heavy, and wherever it raised it is loaded already
        if not isinstance(error, OSError) and type(error).__module__.partition(".")[0] != "polars":
            raise
        reason = getattr(error, "strerror", None) or str(error).partition("\n")[0]
        raise LogError(
            f"cannot be written ({reason})", path=folder, hint="choose another folder with --out"
        ) from error
