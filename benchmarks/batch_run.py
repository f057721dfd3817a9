"""One run of a program, watched: its events with the moment they came, and the memory of it and of its workers."""

from __future__ import annotations

import json
import resource
import subprocess
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import Any

import psutil

MIB = 2**20
SAMPLE_S = 0.25


@dataclass(frozen=True)
class Memory:
    """Resident MiB at one moment. ended: drives that had ended; children: of each worker process."""

    ended: int
    parent: float
    children: tuple[float, ...]


@dataclass
class Run:
    """What came of a run. events: (seconds since the start, event). wall_s: of the whole program; cpu_s: with its workers."""

    code: int = 0
    wall_s: float = 0.0
    cpu_s: float = 0.0
    events: list[tuple[float, dict[str, Any]]] = field(default_factory=list)
    memory: list[Memory] = field(default_factory=list)
    errors: str = ""

    def at(self, kind: str) -> float:
        """When the first event of a kind came, s. Raises RuntimeError where there was none."""
        for moment, event in self.events:
            if event["event"] == kind:
                return moment
        raise RuntimeError(f"no event {kind!r}; exit code {self.code}\n{self.errors[-2000:]}")

    @property
    def loop_s(self) -> float:
        """From the moment that the work was known to the end of its last drive."""
        return max(moment for moment, event in self.events if event["event"] == "ended") - self.at("found")

    @property
    def drives(self) -> list[float]:
        """Seconds of each drive of its own."""
        return [event["seconds"] for _, event in self.events if event["event"] == "ended"]

    @property
    def done(self) -> int:
        """Drives that were done."""
        return sum(event["event"] == "ended" and event["status"] == "done" for _, event in self.events)

    def overhead(self, workers: int) -> float:
        """Share of the workers' time in which no drive was worked on: start-up, waiting, handing over."""
        return 1.0 - sum(self.drives) / (workers * self.loop_s)

    def held(self, first: int, last: int) -> tuple[float, float]:
        """Median MiB of the parent, and of a worker, while drives `first` to `last` ended."""
        taken = [m for m in self.memory if first <= m.ended < last]
        if not taken:
            return float("nan"), float("nan")
        workers = [mib for m in taken for mib in m.children]
        return median(m.parent for m in taken), median(workers) if workers else float("nan")

    @property
    def peak(self) -> tuple[float, float, float]:
        """Most MiB of the parent, of one worker, and of all together."""
        return (
            max((m.parent for m in self.memory), default=0.0),
            max((max(m.children, default=0.0) for m in self.memory), default=0.0),
            max((m.parent + sum(m.children) for m in self.memory), default=0.0),
        )


def _sample(program: psutil.Process, run: Run, over: threading.Event) -> None:
    while not over.wait(SAMPLE_S):
        try:
            children = []
            for child in program.children(recursive=True):
                try:
                    children.append(child.memory_info().rss / MIB)
                except psutil.NoSuchProcess:
                    continue
            ended = (
                sum(event["event"] == "ended" for _, event in run.events[-1:]) and run.events[-1][1]["number"]
            )
            ended = ended or (run.memory[-1].ended if run.memory else 0)
            # a helper of a few MiB (that tidies up shared things) is no worker
            large = tuple(mib for mib in children if mib > 60)
            run.memory.append(Memory(ended, program.memory_info().rss / MIB, large))
        except psutil.NoSuchProcess:
            return


def watched(command: list[str], errors: Path) -> Run:
    """Run a program that prints events (`--json`), to its end. errors: a file for what it says on stderr."""
    run, over = Run(), threading.Event()
    began, before = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    with errors.open("w", encoding="utf-8") as said:
        program = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=said, text=True)
        sampler = threading.Thread(target=_sample, args=(psutil.Process(program.pid), run, over), daemon=True)
        sampler.start()
        assert program.stdout is not None
        for line in program.stdout:
            run.events.append((time.perf_counter() - began, json.loads(line)))
        run.code = program.wait()
    run.wall_s = time.perf_counter() - began
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    run.cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    over.set()
    sampler.join()
    run.errors = errors.read_text(encoding="utf-8")
    return run
