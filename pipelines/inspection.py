"""What is in a log: channels with rates, gaps and ranges, what maps to what, and which estimators could run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from parsers.channels import ChannelInfo, Chunk, FloatArray, IntArray
from parsers.drive import Drive, MappedChannel
from parsers.errors import LogError
from parsers.load import LoadOptions, load_drive, open_log, read_chunks
from parsers.mapping import Binding, propose, reasons_beside, starter_map, unmapped_reason
from parsers.timebase import GAP_PERIODS, JUMP_AHEAD_NS, JUMP_BACK_NS, MIN_GAP_S, NS
from pipelines.estimators.registry import estimators
from pipelines.needs import Readiness, readiness
from pipelines.vehicles.vehicle import Vehicle

_Fate = tuple[str | None, str]


@dataclass(frozen=True)
class ChannelReport:
    """One channel: samples with a value, their mean rate while the log runs, gaps (steps of over five usual periods), range in its own unit.

    signal: the canonical signal that it became, None where it became none; `reason` says why, either way.
    """

    name: str
    unit: str | None
    kind: str
    samples: int
    rate_hz: float
    gaps: int
    low: float | None
    high: float | None
    signal: str | None
    reason: str


@dataclass(frozen=True)
class Inspection:
    """What `cogest inspect` shows. drive: None where nothing maps to a signal, `problem` then says why."""

    path: Path
    format: str
    status: str
    clock: str
    messages: int
    duration_s: float
    start_utc: str | None
    channels: tuple[ChannelReport, ...]
    drive: Drive | None
    problem: str | None
    readiness: tuple[Readiness, ...]
    starter_map: str
    rejected: Mapping[str, int]
    notes: tuple[str, ...]


@dataclass
class _Clock:
    """Running facts of one group's stamps."""

    first: int = 0
    last: int = 0
    last_row: int = 0
    rows: int = 0
    gaps: int = 0
    gap_ns: int = 0
    period_ns: float = 0.0
    running_ns: int = 0
    jumped: bool = False

    @property
    def span_s(self) -> float:
        """How long the stamps run; a clock that was set counts only while it ran."""
        return (self.running_ns if self.jumped else self.last - self.first) / NS

    def rate_hz(self, samples: int) -> float:
        """How often a channel with a value in so many of the rows has one, gaps aside."""
        running = self.span_s - self.gap_ns / NS
        if running <= 0 or self.rows <= 1 + self.gaps:
            return 0.0
        return (self.rows - 1 - self.gaps) / running * (samples / self.rows)

    def add(self, time_ns: IntArray) -> None:
        """Take in the next stamps."""
        if len(time_ns) == 0:
            return
        step = np.diff(time_ns)
        if self.period_ns == 0 and len(step) > 0:
            # the usual step of the first chunk stands for all: memory stays bounded
            self.period_ns = float(np.median(step))
        if self.rows:
            step = np.append(step, time_ns[0] - self.last_row)
        # a difference of stamps that no clock shows may not fit: it then has the wrong sign, and counts as a jump
        runs = (step > 0) & (step < JUMP_AHEAD_NS)
        self.running_ns += int(step[runs].sum())
        self.jumped |= bool(((step >= JUMP_AHEAD_NS) | (step < -JUMP_BACK_NS)).any())
        limit = max(GAP_PERIODS * self.period_ns, MIN_GAP_S * NS)
        if self.period_ns:
            long = (step > limit) & runs
            self.gaps += int(long.sum())
            self.gap_ns += int(step[long].sum())
        self.last_row = int(time_ns[-1])
        low, high = int(time_ns.min()), int(time_ns.max())
        self.first = min(self.first, low) if self.rows else low
        self.last = max(self.last, high) if self.rows else high
        self.rows += len(time_ns)


@dataclass
class _Range:
    """Running facts of one channel's values."""

    samples: int = 0
    low: float = np.inf
    high: float = -np.inf

    def add(self, values: FloatArray) -> None:
        """Take in the next values."""
        valid = values[np.isfinite(values)]
        if len(valid):
            self.samples += len(valid)
            self.low = min(self.low, float(valid.min()))
            self.high = max(self.high, float(valid.max()))


@dataclass
class _Survey:
    """All groups and channels of one pass over the log."""

    clocks: dict[str, _Clock] = field(default_factory=dict)
    ranges: dict[str, _Range] = field(default_factory=dict)

    def add(self, chunk: Chunk) -> None:
        """Take in a chunk."""
        self.clocks.setdefault(chunk.group, _Clock()).add(chunk.time_ns)
        for name, values in chunk.columns.items():
            self.ranges.setdefault(name, _Range()).add(values)


def _fates(proposals: Mapping[str, tuple[Binding, ...]], drive: Drive | None) -> dict[str, _Fate]:
    """Channel -> the signals that it became (None where another channel ranks before it), and why."""
    chosen = {entry.signal: entry for entry in drive.record.mapped} if drive else {}
    fates: dict[str, _Fate] = {}
    for signal, bindings in proposals.items():
        entry = chosen.get(signal)
        for binding in bindings:
            taken = entry is not None and entry.channel == " + ".join(binding.channels)
            for name in binding.channels:
                before = fates.get(name, (None, ""))
                if entry is not None and taken and entry.used:
                    fates[name] = (signal if before[0] is None else f"{before[0]}, {signal}", binding.rule)
                elif before[0] is None:
                    fates[name] = (None, _why_not(signal, entry, taken, drive))
            if binding.sign_channel is not None and taken:
                fates.setdefault(binding.sign_channel, (None, f"the sign of {signal}"))
    return fates


def _why_not(signal: str, entry: MappedChannel | None, taken: bool, drive: Drive | None) -> str:
    """Why a channel that could be a signal is not."""
    if entry is None:
        return f"could be {signal}, but has fewer than two valid samples"
    if not taken:
        return f"could be {signal}, but {entry.channel} ranks before it"
    decisions = drive.record.decisions if drive else ()
    found = next((d.found for d in decisions if d.signal == signal and d.applied), "the checks left it out")
    return f"{signal}, left out: {found}"


def _report(info: ChannelInfo, survey: _Survey, fates: Mapping[str, _Fate]) -> ChannelReport:
    clock = survey.clocks.get(info.group, _Clock())
    seen = survey.ranges.get(info.name, _Range())
    signal, reason = fates.get(info.name, (None, ""))
    if info.kind == "number" and seen.samples == 0:
        reason = "no valid sample"
    elif not reason:
        reason = unmapped_reason(info)
    return ChannelReport(
        name=info.name,
        unit=info.unit,
        kind=info.kind,
        samples=seen.samples,
        rate_hz=clock.rate_hz(seen.samples) if info.kind == "number" else clock.rate_hz(clock.rows),
        gaps=clock.gaps,
        low=seen.low if seen.samples else None,
        high=seen.high if seen.samples else None,
        signal=signal,
        reason=reason,
    )


def _duration_s(survey: _Survey, drive: Drive | None) -> float:
    """How long the log runs: all its channels where the clock was never set, else what the drive's signals cover."""
    clocks = [clock for clock in survey.clocks.values() if clock.rows]
    if not clocks:
        return 0.0
    if any(clock.jumped for clock in clocks):
        return drive.record.duration_s if drive else max(clock.span_s for clock in clocks)
    return (max(clock.last for clock in clocks) - min(clock.first for clock in clocks)) / NS


def inspect_log(path: Path, options: LoadOptions, vehicle: Vehicle | None) -> Inspection:
    """Look at a whole log. Raises LogError where it cannot be read at all; a log that maps to nothing is no error."""

    def progress(done: int, total: int) -> None:
        options.progress(f"reading {path.name}", done / total if total else 0.0)

    opened = open_log(path, options, progress)
    channels = opened.reader.channels
    survey = _Survey()
    numbers = frozenset(info.name for info in channels if info.kind == "number")
    if numbers:
        for chunk in read_chunks(opened, numbers):
            survey.add(chunk)
    drive, problem = None, None
    try:
        drive = load_drive([path], options)
    except LogError as error:
        problem = error.problem + (f"; {error.hint}" if error.hint else "")
    proposals = propose(channels, options.map, options.radius)
    signals = drive.signals.keys() if drive else ()
    beside: dict[str, _Fate] = {name: (None, reason) for name, reason in reasons_beside(channels).items()}
    fate = beside | _fates(proposals, drive)
    return Inspection(
        path=path,
        format=opened.importer.title,
        status=opened.log.status,
        clock=opened.reader.clock,
        messages=opened.log.messages,
        duration_s=_duration_s(survey, drive),
        start_utc=drive.record.start_utc if drive else None,
        channels=tuple(_report(info, survey, fate) for info in channels),
        drive=drive,
        problem=problem,
        readiness=tuple(readiness(estimator, signals, vehicle) for estimator in estimators()),
        starter_map=starter_map(channels, proposals),
        rejected=dict(drive.record.rejected if drive else opened.log.rejected),
        notes=tuple(dict.fromkeys([*opened.log.notes, *(drive.record.notes if drive else ())])),
    )
