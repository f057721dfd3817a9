"""A drive whose rows lie on disk, to the store: surveyed, judged, written and recorded window by window."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from parsers.apart import apart_notes
from parsers.channels import IntArray
from parsers.checks.check import Findings, as_applied, decide
from parsers.drive import Decision, ImportRecord
from parsers.intake import Budget
from parsers.load import (
    Outcome,
    all_stated,
    all_taken,
    make_record,
    note_unused_databases,
    nothing_left,
    require_signals,
)
from parsers.log_hash import BackgroundHash
from parsers.merge import join_pieces
from parsers.opened_log import LoadOptions
from parsers.other_units import better, choice, swapped_entries, to_swap, with_other
from parsers.parquet_pages import DOUBLE, INT64
from parsers.parquet_write import Table, write_pieces
from parsers.pieces import Span
from parsers.read_log import Taken
from parsers.signals import SIGNALS
from parsers.store import group_table
from parsers.store_folder import Replacement
from parsers.strand_bounds import StrandBounds, bounds_of_strands
from parsers.strands import Cleaner, Strand, cleaned, make_cleaner, whole_signals
from parsers.survey import SpooledPart, survey_part
from parsers.time_figures import SharedFigures, TimeFigures
from parsers.timebase import NS, GapList, gaps_of_spans
from parsers.windows import Track, shifted_tracks, time_windows

_BLOCKS = 32
"""Units and signs of a long drive are judged on so many blocks of time, spread evenly over it."""


@dataclass(frozen=True)
class _Written:
    """What is known of a signal once its table is written."""

    figures: TimeFigures
    decisions: tuple[Decision, ...]


@dataclass(frozen=True)
class _Judged:
    """What is taken in the end, what the checks decided of it, and what is to be said of that."""

    strands: list[Strand]
    parts: list[SpooledPart]
    findings: Findings
    note: list[str]


@dataclass(frozen=True)
class LongDrive:
    """A drive whose rows lie on disk."""

    paths: Sequence[Path]
    options: LoadOptions
    folder: Path
    budget: Budget

    def convert(self, taken: list[Taken], digest: BackgroundHash) -> tuple[ImportRecord, int, list[Path]]:
        """Survey, judge, write, record: the record, how many signals there are, and the files."""
        self.options.progress("looking at what was read", 0.0)
        parts = [survey_part(taken.pop(0), self.budget.window) for _ in self.paths]
        note_unused_databases(parts, self.options)
        require_signals(parts, any(part.tracks for part in parts), self.options.map)
        joined = join_pieces([part.opened for part in parts], [part.tracks for part in parts], shifted_tracks)
        strands = [Strand(name, tuple(tracks)) for name, tracks in joined.pieces.items()]
        self.options.progress("checking signs and units", 0.0)
        judged = self._with_best_unit(strands, parts)
        strands, parts, findings, note = judged.strands, judged.parts, judged.findings, judged.note
        notes = [*joined.notes, *note, *_period_note(parts), *digest.notes()]
        with Replacement(self.folder) as tables:
            written = self._write(strands, findings, tables)
            spikes = [
                decision for s in strands if s.name in written for decision in written[s.name].decisions
            ]
            decisions = as_applied((*findings.units, *spikes, *findings.rest), fix=self.options.fix)
            figures = {name: each.figures for name, each in written.items() if each.figures.samples}
            if not figures:
                raise nothing_left(self.paths[0], decisions)
            start_ns = min(each.first for each in figures.values())
            notes += apart_notes({name: (each.first, each.last) for name, each in figures.items()})
            outcome = Outcome(
                parts=parts,
                left_out=joined.left_out,
                signals=set(figures),
                decisions=decisions,
                unchecked=findings.unchecked,
                notes=tuple(notes),
                start_ns=start_ns,
                end_ns=max(each.last for each in figures.values()),
                gaps=_gap_list(figures, start_ns),
                shifts_ns=joined.shifts_ns,
                turned=findings.turned(figures) if self.options.fix else (),
            )
            record = make_record(self.paths, outcome, digest.result())
            return record, len(figures), tables.commit(record)

    def _with_best_unit(self, strands: list[Strand], parts: list[SpooledPart]) -> _Judged:
        """What is judged; where an inertial unit is left out and the log holds another one that is right, with that."""
        stated, taken = all_stated(parts), all_taken(parts)
        findings, note = self._judge(strands, stated, taken)
        spares = parts[0].spares if len(parts) == 1 and self.options.fix else {}
        names = to_swap({strand.name: strand for strand in strands}, findings.left_out, spares)
        if names:
            other = {name: spares[name] for name in names}
            trial = [Strand(s.name, (other[s.name].piece,)) if s.name in names else s for s in strands]
            then, _ = self._judge(trial, *with_other(stated, taken, other))
            if better(findings.left_out, then.left_out, names):
                decisions = (*findings.units, *findings.rest)
                said = choice(decisions, findings.left_out, parts[0].mapped, other)
                part = replace(parts[0], mapped=swapped_entries(parts[0].mapped, other))
                return _Judged(trial, [part], replace(then, units=(said, *then.units)), note)
        return _Judged(strands, parts, findings, note)

    def _judge(
        self, strands: Sequence[Strand], stated: Mapping[str, bool], taken: Mapping[str, float]
    ) -> tuple[Findings, list[str]]:
        """What the checks decide, on as much of the drive as the budget allows; what is to be said of it."""
        tracks = [track for strand in strands for track in strand.tracks]
        spans, seen_ns = _evidence(tracks, self.budget)
        findings, _ = decide(whole_signals(strands, spans), stated, taken)
        findings = _confirmed(findings, strands)
        if seen_ns is None:
            return findings, []
        text = (
            f"the drive is too long to be kept in memory: units, signs and offsets were judged on {len(spans)} blocks "
            f"of it, {seen_ns / NS:.0f} s in all, spread evenly"
        )
        return findings, [text]

    def _write(
        self, strands: Sequence[Strand], findings: Findings, tables: Replacement
    ) -> dict[str, _Written]:
        """Write a table a rate group."""
        groups: dict[str, list[Strand]] = {}
        for strand in strands:
            if not (self.options.fix and strand.name in findings.left_out):
                factor = findings.factors.get(strand.name, 1.0)
                groups.setdefault(strand.group, []).append(Strand(strand.name, strand.tracks, factor))
        written: dict[str, _Written] = {}
        for number, (name, members) in enumerate(groups.items()):
            self.options.progress("writing", number / len(groups))
            part = tables.part()
            found = self._write_group(members, findings, part)
            written |= found
            longest = max((each.figures for each in found.values()), key=lambda each: each.samples)
            tables.name(part, name, longest.median_ns / NS)
        return written

    def _write_group(self, strands: Sequence[Strand], findings: Findings, part: Path) -> dict[str, _Written]:
        bounds = bounds_of_strands(strands, self.budget.window, findings.spans)
        windows = time_windows([track for s in strands for track in s.tracks], self.budget.window)
        cleaners = {s.name: make_cleaner(s, bounds[s.name].bounds, findings) for s in strands}
        figures = SharedFigures({s.name: s.usual_ns for s in strands})
        pieces = _pieces(strands, windows, cleaners, figures, fix=self.options.fix)
        kinds = {"time_ns": INT64} | {SIGNALS[s.name].column: DOUBLE for s in strands}
        write_pieces(pieces, part, kinds)
        return {
            name: _Written(figures.of(name), _decisions(cleaners[name], bounds[name])) for name in cleaners
        }


def _pieces(
    strands: Sequence[Strand],
    windows: Sequence[Span],
    cleaners: Mapping[str, Cleaner],
    figures: SharedFigures,
    *,
    fix: bool,
) -> Iterator[Table]:
    for signals, base in cleaned(strands, windows, cleaners, fix=fix):
        figures.add(base, {name: signal.time_ns for name, signal in signals.items()})
        table = group_table(list(signals.values()))
        if len(table["time_ns"]):
            yield table


def _decisions(cleaner: Cleaner, bounds: StrandBounds) -> tuple[Decision, ...]:
    return (bounds.doubt,) if bounds.doubt else cleaner.tally.decisions(cleaner.strand.name)


def _evidence(tracks: Sequence[Track], budget: Budget) -> tuple[list[Span], int | None]:
    """Windows on which the checks may judge, and how long they are in all; None for the whole drive."""
    every = time_windows(tracks, budget.evidence)
    if len(every) == 1:
        return every, None
    every = time_windows(tracks, max(budget.evidence // _BLOCKS, 1))
    count = min(_BLOCKS, len(every))
    chosen = [every[round((k + 0.5) * len(every) / count - 0.5)] for k in range(count)]
    longest = round(budget.evidence_s * NS / count)
    spans = [(start, min(stop, start + longest)) for start, stop in chosen]
    return spans, sum(stop - start for start, stop in spans)


def _confirmed(findings: Findings, strands: Sequence[Strand]) -> Findings:
    """Without the channels that stand still where the checks looked, but not elsewhere."""
    still = set(findings.wild) | {
        strand.name
        for strand in strands
        if len({value for track in strand.tracks for value in (track.facts.low, track.facts.high)}) == 1
    }
    wrong = findings.left_out - still
    rest = tuple(
        each for each in findings.rest if not (each.applied and each.kind == "range" and each.signal in wrong)
    )
    return replace(findings, left_out=findings.left_out & still, rest=rest)


def _period_note(parts: Sequence[SpooledPart]) -> list[str]:
    resolution = max(part.resolution_ns for part in parts)
    if resolution == 1:
        return []
    return [
        f"the drive is too long to be kept in memory: sample rates are from steps rounded to {resolution} ns"
    ]


def _gap_list(figures: Mapping[str, TimeFigures], start_ns: int) -> GapList:
    each = {id(figure): figure.gaps() for figure in figures.values()}
    spans: dict[str, tuple[IntArray, IntArray]] = {name: each[id(figure)] for name, figure in figures.items()}
    found = gaps_of_spans(spans, start_ns)
    return GapList(found.gaps, found.total + sum(f.dropped for f in figures.values()))
