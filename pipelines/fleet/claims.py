"""Which drives a batch is working on: two batches on one store, also of two machines, share the work.

A claim is a file, made by whoever comes first, with its owner and a beat that the owner changes every few seconds. A claim
is stale when its owner's process is dead on this very machine: at once; else when its beat has not changed for `LEASE_S` by
the clock of the one who looks (machines' clocks are not compared). Of many who find a claim stale one takes it over. At
worst, where a machine was cut off and comes back, a drive is worked on twice: a drive's folder is written whole all the same.
"""

from __future__ import annotations

import json
import threading
import time
import uuid
from collections.abc import Callable
from dataclasses import dataclass
from types import TracebackType
from typing import Any

from parsers.errors import StoreError
from pipelines.fleet.owner import Owner, alive, this_process
from pipelines.fleet.storage import Storage

CLAIMS = "claims"
TAKEN = ".taken"
BEAT_S = 15.0
LEASE_S = 120.0
"""How long the beat of a claim of another machine must stand still before it is taken over."""


@dataclass(frozen=True)
class Claim:
    """A drive that is this batch's to work on. token: this very claim's."""

    drive_id: str
    token: str


@dataclass(frozen=True)
class _Held:
    """A claim as its file tells it. owner: None where the file does not say."""

    token: str
    beat: int
    owner: Owner | None


def _name(drive_id: str) -> str:
    return f"{CLAIMS}/{drive_id}.json"


def _content(token: str, beat: int) -> bytes:
    owner = this_process()
    told = {"token": token, "beat": beat, "host": owner.host, "pid": owner.pid, "started": owner.started}
    return json.dumps(told).encode()


def _held(content: bytes) -> _Held:
    """What a claim's file says; a damaged one is someone's who cannot be asked: it ages like any other."""
    try:
        raw: Any = json.loads(content)
        owner = Owner(str(raw["host"]), int(raw["pid"]), int(raw["started"]))
        return _Held(str(raw["token"]), int(raw["beat"]), owner)
    except (ValueError, TypeError, KeyError, RecursionError):
        return _Held("?", 0, None)


class Claims:
    """The claims of one batch. A thread keeps them alive; leaving the block gives all back."""

    def __init__(
        self, storage: Storage, lease_s: float = LEASE_S, clock: Callable[[], float] = time.monotonic
    ) -> None:
        """storage: the store's. lease_s: see `LEASE_S`; all batches of a store must use the same."""
        self._storage = storage
        self._lease_s = lease_s
        self._clock = clock
        self._mine: dict[str, Claim] = {}
        self._watched: dict[str, tuple[_Held, float]] = {}
        self._lock = threading.Lock()
        self._end = threading.Event()
        self._thread: threading.Thread | None = None
        self._beat = 0

    def __enter__(self) -> Claims:
        """Tidy up, and start the beat."""
        self.sweep()
        self._thread = threading.Thread(target=self._beats, daemon=True, name="claims")
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop the beat, and give back what is still claimed."""
        self._end.set()
        if self._thread is not None:
            self._thread.join()
        for claim in list(self._mine.values()):
            self.release(claim)

    def claim(self, drive_id: str) -> Claim | None:
        """The drive as this batch's own, or None while another batch works on it: look at the store, and ask again later.

        With a claim in hand look at the store once more: the other batch may have ended the drive just before.
        """
        name = _name(drive_id)
        claim = Claim(drive_id, uuid.uuid4().hex)
        with self._lock:
            if drive_id in self._mine:
                return None
            if not self._storage.create(name, _content(claim.token, 0)) and not self._take_over(name, claim):
                return None
            self._mine[drive_id] = claim
            self._watched.pop(name, None)
        return claim

    def release(self, claim: Claim) -> None:
        """Give a claim back; one that another batch has taken over meanwhile stays."""
        with self._lock:
            self._mine.pop(claim.drive_id, None)
            name = _name(claim.drive_id)
            content = self._storage.read(name)
            if content is not None and _held(content).token == claim.token:
                self._storage.remove(name)

    def sweep(self) -> None:
        """Take away what batches left that were killed on this machine: nobody may ask for those drives again."""
        # one who died while taking over a claim stands in the way of whoever wants it
        for name in sorted(self._storage.tree(CLAIMS), key=lambda name: not name.endswith(TAKEN)):
            content = self._storage.read(name)
            owner = None if content is None else _held(content).owner
            if owner is None or alive(owner) is not False:
                continue
            if name.endswith(TAKEN):
                self._storage.remove(name)
            # as anyone who wants the drive would: another batch may be taking it over just now
            elif claim := self.claim(name.removeprefix(f"{CLAIMS}/").removesuffix(".json")):
                self.release(claim)

    def _stale(self, name: str, held: _Held) -> bool:
        """Whether the claim's owner is gone; remembers since when its beat stands still."""
        if held.owner is not None:
            lives = alive(held.owner)
            if lives is not None:
                return not lives
        now = self._clock()
        known, since = self._watched.setdefault(name, (held, now))
        if known != held:
            self._watched[name] = (held, now)
            return False
        return now - since > self._lease_s

    def _take_over(self, name: str, claim: Claim) -> bool:
        """Take a stale claim. Of several who try, the one that makes the file `….taken` of this very claim goes on."""
        content = self._storage.read(name)
        if content is None:
            # given back just now
            return self._storage.create(name, _content(claim.token, 0))
        held = _held(content)
        if not self._stale(name, held):
            return False
        taken = f"{name}.{held.token[:40] if held.token.isalnum() else 'damaged'}{TAKEN}"
        if not self._storage.create(taken, _content(claim.token, 0)):
            self._drop_dead(taken)
            return False
        try:
            again = self._storage.read(name)
            if again is None or _held(again).token != held.token:
                return False
            self._storage.write(name, _content(claim.token, 0))
            return True
        finally:
            self._storage.remove(taken)

    def _drop_dead(self, taken: str) -> None:
        """One who was taking over a claim may have died on it."""
        content = self._storage.read(taken)
        if content is not None and self._stale(taken, _held(content)):
            self._storage.remove(taken)

    def _beats(self) -> None:
        while not self._end.wait(min(BEAT_S, self._lease_s / 6)):
            with self._lock:
                self._beat += 1
                claims = list(self._mine.values())
            for claim in claims:
                self._renew(claim)

    def _renew(self, claim: Claim) -> None:
        with self._lock:
            if claim.drive_id not in self._mine:
                return
            name = _name(claim.drive_id)
            try:
                content = self._storage.read(name)
                if content is not None and _held(content).token == claim.token:
                    self._storage.write(name, _content(claim.token, self._beat))
            except StoreError:
                # a network that is away for a moment; the next beat tries again
                return
