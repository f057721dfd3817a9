"""The batch: which drives are to do, handing them to an engine, and what became of each."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Literal

from parsers.errors import LogError
from parsers.places_text import is_url, masked
from pipelines.engines.base import Done, Limits, Task
from pipelines.engines.registry import engine_named
from pipelines.fleet.claims import Claim, Claims
from pipelines.fleet.events import DriveEnded, Found, Joining, Kept, Started, Watcher, no_watcher
from pipelines.fleet.gather import gather, prune
from pipelines.fleet.job_text import job_text
from pipelines.fleet.keys import Keys
from pipelines.fleet.moved import Lost, lost
from pipelines.fleet.records import BatchSummary, Choices, Ended, Facts, FoundDrive, FoundFleet, Job
from pipelines.fleet.storage_at import storage_at
from pipelines.fleet.store import STORE_FILE, Catalogue, Store, StoredDrive, open_store

if TYPE_CHECKING:
    import polars as pl

State = Literal["new", "changed", "kept", "failed before", "again"]
"""new: not in the store. changed: something that it depends on has. kept: nothing has. failed before: neither, and it
failed by an error of its own. again: its worker crashed, hung or took too much memory; or it is damaged."""

LEFT_OUT_TOLD = 5
"""So many of the files that are left out are named when a batch begins."""

WAIT_S = 0.5
"""Between two looks at drives that another batch is working on, or at its writing of the tables."""

TABLES = "tables"
"""The claim under which a batch joins drives and writes tables and report: no drive's id is a bare word. Of two that wrote them at once
tables would be of the one and their seals of the other, or older than what the store holds."""

Finish = Callable[[Store, BatchSummary], None]


@dataclass(frozen=True)
class Batch:
    """What is asked for. folder, store: a path or a URL. formats: of the fleet's report. retry: do drives again that failed
    though nothing has changed; fresh: all drives. prune: drop drives whose logs are gone."""

    folder: str
    store: str
    choices: Choices
    engine: str = "local"
    workers: int | None = None
    scheduler: str | None = None
    limits: Limits = field(default_factory=Limits)
    fresh: bool = False
    retry: bool = False
    prune: bool = False
    formats: tuple[str, ...] = ("html", "pdf")
    command: str = ""


@dataclass(frozen=True)
class Ran:
    """How a batch ended, and the fleet's tables (`pipelines.fleet.tables`)."""

    summary: BatchSummary
    tables: Mapping[str, pl.DataFrame]


@dataclass(frozen=True)
class _Look:
    """What is to be done about a drive, and what its inputs are now where they were looked at."""

    state: State
    facts: Mapping[str, Facts] = field(default_factory=dict)


def _look(batch: Batch, stored: StoredDrive | None, drive: FoundDrive, keys: Keys) -> _Look:
    """Compare a drive with the store. An input that cannot be read now is for a worker to complain of."""
    if stored is None:
        return _Look("new")
    if batch.fresh:
        return _Look("changed")
    try:
        key, facts = keys.key_of(drive, stored.facts)
    except LogError:
        return _Look("changed")
    if stored.fresh(key, batch.choices.formats):
        return _Look("kept", facts)
    if stored.status == "error" and stored.key == key:
        return _Look("again" if batch.retry else "failed before", facts)
    return _Look("changed" if stored.key else "again")


def _looks(batch: Batch, found: FoundFleet, catalogue: Catalogue) -> dict[str, _Look]:
    keys = Keys(batch.choices)
    return {
        drive.drive_id: _Look("again")
        if drive.drive_id in catalogue.damaged
        else _look(batch, catalogue.drives.get(drive.drive_id), drive, keys)
        for drive in found.drives
    }


def existing_store(place: str) -> Store | None:
    """The store at a place, None where none has been made yet. Raises StoreError where the place holds something else."""
    storage = storage_at(place)
    return Store(storage) if storage.read(STORE_FILE) is not None or storage.names("") else None


@dataclass(frozen=True)
class Absent:
    """A stored drive that is no longer where it was. name, vehicle_id: as it was stored; "" of one that is damaged.

    moved_to: the drive of the folder that has its logs now, None where none has.
    """

    drive_id: str
    name: str = ""
    vehicle_id: str = ""
    moved_to: str | None = None


@dataclass(frozen=True)
class Plan:
    """What a batch would do. states: by drive_id. absent: stored drives that are no longer where they were."""

    states: Mapping[str, State]
    absent: tuple[Absent, ...] = ()


def plan_of(batch: Batch, found: FoundFleet) -> Plan:
    """What a batch would do about each drive. A store that is not there yet is not made. Raises StoreError."""
    store = existing_store(batch.store)
    catalogue = store.all() if store is not None else Catalogue({}, {})
    states = {drive_id: look.state for drive_id, look in _looks(batch, found, catalogue).items()}
    return Plan(states, _absent(catalogue, lost(catalogue, found)))


def _absent(catalogue: Catalogue, known: Lost) -> tuple[Absent, ...]:
    made = []
    for drive_id in sorted({*known.gone, *known.moved}):
        stored, now = catalogue.drives.get(drive_id), known.moved.get(drive_id)
        name, vehicle = (stored.drive.name, stored.drive.vehicle_id) if stored is not None else ("", "")
        made.append(Absent(drive_id, name, vehicle, None if now is None else now.name))
    return tuple(made)


def _absolute(place: str) -> str:
    """A place as it is called from anywhere: a worker may run in another folder."""
    return place if is_url(place) else os.path.abspath(place)


class _Work:
    """The drives that are left to do, as tasks; and how each ended."""

    def __init__(
        self,
        batch: Batch,
        store: Store,
        before: Mapping[str, StoredDrive],
        claims: Claims,
        watch: Watcher,
        total: int,
    ) -> None:
        self.batch, self.store, self.claims, self.watch = batch, store, claims, watch
        self.before, self.total = before, total
        self.drives: dict[str, FoundDrive] = {}
        self.held: dict[str, Claim] = {}
        self.ended: list[Ended] = []
        self.later: list[FoundDrive] = []

    def tasks(self, drives: Sequence[FoundDrive]) -> Iterator[Task]:
        """Each drive that can be claimed; the others are `later` then, but for those that another batch has ended.

        It never waits: while it did, no drive of this batch could be given back, and two batches would wait for each other.
        """
        self.later = []
        for drive in drives:
            claim = self.claims.claim(drive.drive_id)
            if claim is None:
                self.later.append(drive)
            elif self._done_elsewhere(drive):
                self.claims.release(claim)
            else:
                yield self._handed(drive, claim)

    def _done_elsewhere(self, drive: FoundDrive) -> bool:
        """Whether another batch has ended the drive since this one began, with what this one would have come to."""
        stored = self.store.stored(drive.drive_id)
        if stored is None or stored == self.before.get(drive.drive_id):
            return False
        state = _look(
            replace(self.batch, fresh=False, retry=False), stored, drive, Keys(self.batch.choices)
        ).state
        if state not in ("kept", "failed before"):
            return False
        status = "kept" if state == "kept" else stored.status
        self._end(Ended(drive, status, stored.reason, worker="another batch"))
        return True

    def _handed(self, drive: FoundDrive, claim: Claim) -> Task:
        self.held[drive.drive_id], self.drives[drive.drive_id] = claim, drive
        self.watch(Started(drive.drive_id, drive.name, drive.size))
        batch = self.batch
        job = Job(drive, batch.choices, _absolute(batch.store), "", batch.command)
        return Task(drive.drive_id, job_text(job))

    def take(self, done: Done) -> None:
        """Write down how a drive ended; a failure that its worker could not store is stored here."""
        drive = self.drives.pop(done.key)
        if done.status != "done":
            stored = self.store.stored(drive.drive_id) if done.status == "error" else None
            if stored is None or stored.status != "error" or stored.reason != done.reason:
                # without a key, so that it is tried again the next time
                self.store.put_failure(drive, "", {}, done.status, done.reason)
        self.claims.release(self.held.pop(done.key))
        self._end(Ended(drive, done.status, done.reason, done.seconds, done.worker))

    def _end(self, ended: Ended) -> None:
        self.ended.append(ended)
        drive = ended.drive
        self.watch(
            DriveEnded(
                drive.drive_id, drive.name, drive.vehicle_id, ended.status, ended.reason, ended.seconds,
                ended.worker, len(self.ended), self.total, drive.size,
            )
        )  # fmt: skip


def _nothing_more(store: Store, summary: BatchSummary) -> None:
    """The tables alone."""


@contextlib.contextmanager
def _alone(claims: Claims) -> Iterator[None]:
    """While no other batch writes the store's tables; it waits for one that does, and takes over from one that was killed."""
    while (claim := claims.claim(TABLES)) is None:
        time.sleep(WAIT_S)
    try:
        yield
    finally:
        claims.release(claim)


def run_batch(
    batch: Batch,
    found: FoundFleet,
    function: str,
    watch: Watcher = no_watcher,
    finish: Finish = _nothing_more,
) -> Ran:
    """Do what is to be done of a fleet, join what its drives say, and write the store's tables.

    function: what a worker runs for a drive ("module:name", a `Job` as JSON in). finish: what else is made of the tables, before another
    batch may write its own. Raises StoreError, EngineError.
    """
    from pipelines.hierarchy.vehicle import join_vehicle

    started = time.perf_counter()
    engine = engine_named(batch.engine, batch.workers, batch.scheduler)
    store = open_store(batch.store, create=True)
    if batch.prune:
        prune(store, found)
    catalogue = store.all()
    plan = _looks(batch, found, catalogue)
    # the largest first: the last ones then are small, and no worker is left with a long drive alone
    work = sorted(
        (d for d in found.drives if plan[d.drive_id].state not in ("kept", "failed before")),
        key=lambda d: (-d.size, d.name),
    )
    kept, before = _left_alone(store, found, plan, catalogue.drives)
    watch(
        Found(
            len(found.drives), len(work), len(kept) + len(before), len(found.left_out),
            sum(d.size for d in work), masked(found.folder), masked(batch.store), batch.engine, batch.workers or 0,
            batch.choices.version, found.left_out_below()[:LEFT_OUT_TOLD],
        )
    )  # fmt: skip
    for drive in kept:
        watch(Kept(drive.drive_id, drive.name, drive.vehicle_id))
    for ended in before:
        drive = ended.drive
        watch(Kept(drive.drive_id, drive.name, drive.vehicle_id, ended.status, ended.reason))
    with Claims(store.storage) as claims:
        doing = _Work(batch, store, catalogue.drives, claims, watch, len(work))
        waiting = work
        while waiting:
            # an error or Ctrl-C here must end the workers at once
            with contextlib.closing(engine.map(function, doing.tasks(waiting), batch.limits)) as ends:
                for done in ends:
                    doing.take(done)
            if len(doing.later) == len(waiting):
                time.sleep(WAIT_S)
            waiting = doing.later
        watch(Joining(len({drive.vehicle_id for drive in found.drives})))
        with _alone(claims):
            began = catalogue.drives.keys() | catalogue.damaged.keys()
            tables = gather(store, found, join_vehicle, began=began)
            store.write_tables(tables)
            absent = lost(catalogue, found)
            summary = _summary(found, (len(kept), before), doing.ended, absent, started)
            finish(store, summary)
    return Ran(replace(summary, seconds=time.perf_counter() - started), tables)


def _summary(
    found: FoundFleet, left_alone: tuple[int, Sequence[Ended]], ended: Sequence[Ended], absent: Lost, started: float
) -> BatchSummary:  # fmt: skip
    """left_alone: how many were kept, and those that failed before."""
    kept, before = left_alone
    return BatchSummary(
        found=len(found.drives),
        kept=kept + sum(e.status == "kept" for e in ended),
        done=sum(e.status == "done" for e in ended),
        failed=(*before, *(e for e in ended if e.status not in ("done", "kept"))),
        gone=len(absent.gone),
        moved=len(absent.moved),
        seconds=time.perf_counter() - started,
    )


def _left_alone(
    store: Store, found: FoundFleet, plan: Mapping[str, _Look], stored: Mapping[str, StoredDrive]
) -> tuple[list[FoundDrive], list[Ended]]:
    """The drives that are kept, and those that failed before and are not tried again; what was found of them now is noted,
    so that a log that was touched but is equal is not looked into every time."""
    kept, before = [], []
    for drive in found.drives:
        look = plan[drive.drive_id]
        if look.state not in ("kept", "failed before"):
            continue
        known = stored[drive.drive_id]
        store.note(known, drive, look.facts)
        if look.state == "kept":
            kept.append(drive)
        else:
            before.append(Ended(drive, known.status, known.reason))
    return kept, before
