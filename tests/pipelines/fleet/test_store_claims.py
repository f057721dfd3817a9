"""Claims: a drive is one batch's at a time; what a killed batch claimed is taken over, by one alone."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from pipelines.fleet.claims import Claims
from pipelines.fleet.storage_local import LocalStorage

ROOT = Path(__file__).resolve().parents[3]

CLAIMER = """
import sys, time
from pipelines.fleet.claims import Claims
from pipelines.fleet.storage_local import LocalStorage
with Claims(LocalStorage(sys.argv[1])) as claims:
    print(claims.claim("drive") is not None, flush=True)
    time.sleep(600)
"""

SHARER = """
import os, sys
from pathlib import Path
from pipelines.fleet.claims import Claims
from pipelines.fleet.storage_local import LocalStorage
root = Path(sys.argv[1])
with Claims(LocalStorage(root)) as claims:
    left = [f"drive-{n}" for n in range(60)]
    while left:
        for drive in list(left):
            claim = claims.claim(drive)
            if claim is None:
                if (root / f"{drive}.done").exists():
                    left.remove(drive)
                continue
            if not (root / f"{drive}.done").exists():
                with (root / "work.log").open("a") as log:
                    log.write(f"{drive}\\n")
                (root / f"{drive}.done").touch()
            claims.release(claim)
            left.remove(drive)
"""


class Clock:
    """A clock that goes when it is told to."""

    def __init__(self) -> None:
        self.now = 1000.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def storage(tmp_path: Path) -> LocalStorage:
    return LocalStorage(tmp_path)


def claim_file(storage: LocalStorage, **changes: object) -> dict[str, object]:
    """Change what the claim of "drive" says."""
    raw: dict[str, object] = json.loads(storage.read("claims/drive.json") or b"{}")
    raw.update(changes)
    storage.write("claims/drive.json", json.dumps(raw).encode())
    return raw


def test_a_drive_is_one_batchs_at_a_time(storage: LocalStorage) -> None:
    one, two = Claims(storage), Claims(storage)
    claim = one.claim("drive")
    assert claim is not None
    assert two.claim("drive") is None
    assert one.claim("drive") is None
    assert two.claim("other") is not None
    one.release(claim)
    again = two.claim("drive")
    assert again is not None
    one.release(claim)
    assert one.claim("drive") is None


def test_leaving_gives_all_back(storage: LocalStorage) -> None:
    with Claims(storage) as claims:
        assert claims.claim("a") is not None
        assert claims.claim("b") is not None
    assert storage.tree("claims") == {}


@pytest.fixture
def claimer(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """Another batch, which has claimed "drive"."""
    process = subprocess.Popen(
        [sys.executable, "-c", CLAIMER, str(tmp_path)], stdout=subprocess.PIPE, text=True, cwd=ROOT
    )
    assert process.stdout is not None
    assert process.stdout.readline().strip() == "True"
    yield process
    process.kill()
    process.wait()
    process.stdout.close()


def test_a_killed_batch_loses_its_claims_at_once(
    storage: LocalStorage, claimer: subprocess.Popen[str]
) -> None:
    claims = Claims(storage)
    assert claims.claim("drive") is None
    claimer.kill()
    claimer.wait()
    assert claims.claim("drive") is not None
    assert list(storage.tree("claims")) == ["claims/drive.json"]


def test_another_machines_claim_ends_with_its_lease(storage: LocalStorage) -> None:
    clock = Clock()
    Claims(storage).claim("drive")
    claim_file(storage, host="elsewhere")
    claims = Claims(storage, lease_s=60.0, clock=clock)
    assert claims.claim("drive") is None
    clock.now += 59.0
    assert claims.claim("drive") is None
    claim_file(storage, beat=1)
    clock.now += 59.0
    assert claims.claim("drive") is None
    clock.now += 59.0
    assert claims.claim("drive") is None
    clock.now += 2.0
    assert claims.claim("drive") is not None


@pytest.mark.parametrize("content", [b"", b"{}", b"[1]", b"\xff\xfe", b'{"token": "a/../b"}'])
def test_a_damaged_claim_ends_with_its_lease(storage: LocalStorage, content: bytes) -> None:
    clock = Clock()
    storage.write("claims/drive.json", content)
    claims = Claims(storage, lease_s=60.0, clock=clock)
    assert claims.claim("drive") is None
    clock.now += 61.0
    assert claims.claim("drive") is not None


def test_one_takes_a_stale_claim_over(storage: LocalStorage) -> None:
    Claims(storage).claim("drive")
    claim_file(storage, pid=2**22 + 5)
    start, won = threading.Barrier(6), []

    def take() -> None:
        claims = Claims(storage)
        start.wait()
        for _ in range(20):
            if claims.claim("drive") is not None:
                won.append(claims)

    threads = [threading.Thread(target=take) for _ in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(won) == 1
    assert list(storage.tree("claims")) == ["claims/drive.json"]


def test_one_who_died_while_taking_over_does_not_block(storage: LocalStorage) -> None:
    Claims(storage).claim("drive")
    raw = claim_file(storage, pid=2**22 + 5)
    storage.write(f"claims/drive.json.{raw['token']}.taken", json.dumps({**raw, "token": "b"}).encode())
    claims = Claims(storage)
    assert claims.claim("drive") is None
    assert claims.claim("drive") is not None


def test_a_new_batch_tidies_up_after_killed_ones(storage: LocalStorage) -> None:
    Claims(storage).claim("drive")
    raw = claim_file(storage, pid=2**22 + 5)
    dead = json.dumps(raw).encode()
    storage.write(f"claims/drive.json.{raw['token']}.taken", dead)
    storage.write("claims/far.json", json.dumps({**raw, "host": "elsewhere"}).encode())
    mine = Claims(storage)
    assert mine.claim("mine") is not None
    with Claims(storage):
        pass
    assert list(storage.tree("claims")) == ["claims/far.json", "claims/mine.json"]


def test_a_beat_keeps_claims_alive_and_lost_ones_alone(storage: LocalStorage) -> None:
    with Claims(storage, lease_s=0.12) as claims:
        assert claims.claim("drive") is not None
        assert claims.claim("lost") is not None
        taken = json.dumps(
            {"token": "other", "beat": 7, "host": "elsewhere", "pid": 1, "started": 1}
        ).encode()
        deadline = time.monotonic() + 5.0

        def beats() -> int:
            return int(json.loads(storage.read("claims/drive.json") or b"{}")["beat"])

        def wait_for(beat: int) -> None:
            while beats() < beat:
                assert time.monotonic() < deadline
                time.sleep(0.01)

        # another takes a claim over after its lease, not within a beat: one that was being written is taken again
        while storage.read("claims/lost.json") != taken:
            storage.write("claims/lost.json", taken)
            wait_for(beats() + 2)
        wait_for(beats() + 3)
    assert storage.tree("claims") == {"claims/lost.json": len(taken)}
    assert storage.read("claims/lost.json") == taken


def test_two_batches_share_the_work(tmp_path: Path) -> None:
    running = [subprocess.Popen([sys.executable, "-c", SHARER, str(tmp_path)], cwd=ROOT) for _ in range(2)]
    assert [process.wait(timeout=60) for process in running] == [0, 0]
    worked = (tmp_path / "work.log").read_text().split()
    assert sorted(worked) == sorted(f"drive-{n}" for n in range(60))
    assert LocalStorage(tmp_path).tree("claims") == {}
